/* Events: crossings of zero within a step, located by the method itself; see pk/events.h.
 *
 * Event functions are sampled on an interpolant of the step, which costs no step, or, where the
 * step is too long for it, at states from shorter steps (events_look.c). Samples only propose
 * times. Exact values of g are those at states that a second integrator, the scout, reaches from
 * the start of the step. A crossing lies between two such states with opposite signs of g.
 *
 * Reference: L. F. Shampine, S. Thompson, Event location for ordinary differential equations,
 * Comput. Math. Appl. 39 (2000) 43. */
#include <string.h>

#include <pk/keep.h>

#include "events.h"

enum { HALVINGS = 20 }; /* limit of steps towards a singularity, each by half of the time left */
enum { SHORTER = 17 };  /* limit of retries of a step, each 8 times shorter */
enum { FROM_REST = 3 }; /* their limit if all is 0 at its start, so that any step outgrows it */
#define GROWTH PK_C(64.0)
enum { ROUNDINGS = 16 }; /* limit, in units in the last place, of a value that counts as 0 */

static size_t lay_out(struct pk_events *e, const struct pk_problem *problem, pk_real *base)
{
    const struct pk_system *system = problem->system;
    const size_t n_q = pk_coordinates_of(problem);
    const size_t n = pk_count_of(problem),
                 switches = pk_system_switch_count(system, problem->params),
                 m = system->events.n + switches;
    const size_t list = PK_MOST_NODES * system->events.n + PK_MOST_TOGETHER * switches;
    pk_real *shapes, *params, *sides;
    /* clang-format off */
    const struct pk_slot slots[] = {
        {&shapes, (m * sizeof(struct pk_shape) + sizeof(pk_real) - 1) / sizeof(pk_real)},
        {&e->q0, n_q}, {&e->v0, n}, {&e->a0, n}, {&e->a1, n}, {&e->a_between, n},
        {&e->bend, n_q + n}, {&e->trial, n_q}, {&e->trial_v, n}, {&e->u, system->n_inputs},
        {&e->g, m * (PK_MOST_SAMPLES + 2)}, {&e->ends, 2 * m},
        {&e->list, PK_EVENT_ENTRY * list}, {&e->at_near, m}, {&e->at_last, m},
        {&e->held, system->events.n}, {&e->off, system->events.n}, {&e->fresh, switches},
        {&e->room, pk_impulse_size(system, n)},
        {&params, switches ? pk_params_reals(system) : 0},
        {&sides, system->switches.count ? switches : 0}};
    /* clang-format on */
    const size_t size = PK_LAY_OUT(base, slots);
    e->shapes = (struct pk_shape *)(void *)shapes;
    e->params = switches ? params : NULL;
    e->most_listed = list;
    if (base && switches)
        e->sides = system->switches.count
                       ? sides
                       : (pk_real *)(void *)((char *)params + system->switches.sides);
    return size * sizeof *base;
}

size_t pk_events_size(const struct pk_problem *problem, const struct pk_method *method)
{
    const size_t scout = pk_integrator_size(problem, method);
    struct pk_events e;
    return scout ? scout + lay_out(&e, problem, NULL) : 0;
}

enum pk_status pk_events_init(struct pk_events *events, const struct pk_integrator *it, void *block,
                              size_t block_size)
{
    memset(events, 0, sizeof *events);
    if (!it || !pk_ready(it) || !block)
        return it && it->status < 0 ? it->status : PK_BAD_ARGUMENT;
    struct pk_problem own = it->problem;
    const struct pk_problem *problem = &own;
    if (block_size < pk_events_size(problem, it->method) || (size_t)block % _Alignof(pk_real))
        return PK_BLOCK_TOO_SMALL;
    struct pk_options options = it->options;
    options.h_min = 0; /* a step to a crossing may be arbitrarily short */
    options.max_steps = 0;
    events->n_q = it->n_q;
    events->n = it->n;
    events->n_events = problem->system->events.n;
    events->n_switches = pk_system_switch_count(problem->system, problem->params);
    if (pk_events_count(events) == 0)
        return PK_DONE;
    const size_t scout = pk_integrator_size(problem, it->method);
    const int exact = (it->method->traits & PK_EXACT) != 0, dense = it->method->traits & PK_DENSE;
    events->proposes = dense && !exact; /* an exact flow has no cheap interpolant, only a series */
    events->dense = dense && it->method->dense_order >= it->method->order;
    pk_real *const own_block = (pk_real *)block + scout / sizeof(pk_real);
    memset(own_block, 0, lay_out(events, problem, own_block));
    if (events->n_switches) {
        memcpy(events->params, own.params, problem->system->params_size);
        if (problem->system->switches.count) {
            void *const at = (char *)events->params + problem->system->switches.sides;
            memcpy(at, &events->sides, sizeof events->sides);
        }
        own.params = events->params;
    }
    return pk_integrator_init(&events->scout, problem, it->method, &options, it->t, it->q, it->v,
                              block, scout);
}

/* Saves or restores the memory except the parameters at its end, which belong to the caller; but
 * the sides of switches among the parameters are saved. */
enum pk_status pk_events_keep(struct pk_events *e, struct pk_keep *k)
{
    struct pk_events shape;
    if (pk_events_count(e) == 0)
        return PK_DONE;
    const struct pk_problem *problem = &e->scout.problem;
    const size_t params = e->n_switches ? pk_params_reals(problem->system) * sizeof(pk_real) : 0;
    const size_t apart = problem->system->switches.count ? e->n_switches * sizeof *e->sides : 0;
    pk_keep_same(k, e->n_events);
    pk_keep_same(k, e->n_switches);
    pk_keep(k, e->shapes, lay_out(&shape, problem, NULL) - params - apart);
    pk_keep(k, e->sides, e->n_switches * sizeof *e->sides);
    PK_KEEP(k, e->doubts);
    PK_KEEP(k, e->count);
    PK_KEEP(k, e->switchings);
    PK_KEEP(k, e->tries);
    int *const flags[] = {&e->by_steps, &e->at_switch, &e->begun, &e->kept, &e->brief, &e->again};
    for (size_t i = 0; i < sizeof flags / sizeof *flags; i++)
        PK_KEEP(k, *flags[i]);
    PK_KEEP(k, e->left);
    PK_KEEP(k, e->tried);
    return pk_integrator_keep(&e->scout, k);
}

void pk_events_free(struct pk_events *events) { pk_integrator_free(&events->scout); }

static enum pk_status at_end(const struct pk_events *e, struct pk_integrator *it, int end,
                             const pk_real *q, const pk_real *v)
{
    pk_real *g = pk_events_end(e, end);
    pk_events_functions(e, it, end ? it->t : e->from, q, v, g);
    for (size_t k = 0; k < pk_events_count(e); k++)
        if (!pk_finite(g[k]))
            return pk_events_not_finite(it, k);
    for (size_t k = 0; k < e->n_events && !end && e->kept; k++)
        if (!(g[k] * e->held[k] >= 0) && pk_abs(g[k]) <= pk_abs(e->held[k]))
            g[k] = e->held[k] > 0 ? PK_TINY : -PK_TINY;
    return PK_DONE;
}

/* Returns by how much the function of limit k changes from the position q0 - d to q0 + d, or 0 if
 * the change is rounding. The function of a limit is linear in q. */
static pk_real gain(struct pk_events *e, const struct pk_integrator *it, size_t k, const pk_real *d)
{
    pk_real *g = pk_events_sample(e, PK_MOST_SAMPLES + 1), ends[2];
    for (int end = 0; end < 2; end++) {
        for (size_t i = 0; i < e->n_q; i++)
            e->trial[i] = end ? e->q0[i] + d[i] : e->q0[i] - d[i];
        pk_events_functions(e, it, it->t, e->trial, e->v0, g);
        ends[end] = g[k];
    }
    const pk_real rounding = ROUNDINGS * PK_EPS *
                             (pk_largest(e->q0, e->n_q) + pk_largest(d, e->n_q));
    return pk_abs(ends[1] - ends[0]) > rounding ? ends[1] - ends[0] : 0;
}

/* Returns whether a motion that starts on limit k moves beyond it: by its rate or, if that does not
 * change the limit's function, by its acceleration. */
static int leads_outwards(struct pk_events *e, const struct pk_integrator *it, size_t k,
                          int backwards)
{
    pk_real rise = gain(e, it, k, e->v0) * (backwards ? -1 : 1);
    if (!(rise < 0 || rise > 0) && pk_eval_acceleration(&e->scout, it->t, e->q0, e->v0, e->a0) >= 0)
        rise = gain(e, it, k, e->a0);
    return rise * (pk_real)it->problem.system->events.table[k].direction > 0;
}

/* Stops a run that starts beyond a limit, or starts on a limit (up to rounding) and moves outwards,
 * since such a run would not cross the limit. If a run that starts on a limit goes on, the rounding
 * error of its start is subtracted from then on (pk_events_functions()); the start then counts as
 * inside, and a later way out crosses the limit. */
static int stop_beyond_limit(struct pk_events *e, struct pk_integrator *it, int backwards)
{
    const struct pk_event *table = it->problem.system->events.table;
    pk_real *g = pk_events_end(e, 0);
    const pk_real rounding = ROUNDINGS * PK_EPS * pk_largest(e->q0, e->n_q) + PK_TINY;
    size_t first = e->n_events;
    for (size_t k = e->n_events; k-- > 0 && !e->begun;) {
        const pk_real outwards = (pk_real)table[k].direction;
        if (table[k].stop < 2)
            continue;
        const int on = pk_abs(g[k]) <= rounding;
        if (on ? leads_outwards(e, it, k, backwards) : g[k] * outwards > 0)
            first = k;
        if (on) {
            e->off[k] = pk_abs(g[k]) > PK_TINY ? g[k] : 0;
            g[k] = -outwards * PK_TINY;
        }
    }
    e->begun = 1;
    if (first == e->n_events)
        return 0;
    e->which = first;
    e->direction = table[first].direction;
    e->t = it->t;
    e->q = e->q0;
    e->v = e->v0;
    e->count++;
    if (e->found)
        e->found(e->context, e);
    it->event = first + 1;
    it->status = PK_STOPPED_EVENT;
    return 1;
}

/* Returns the rounding error of function k at the start of the step: its change if all numbers of
 * the state change by some units in the last place. */
static pk_real rounding(struct pk_events *e, const struct pk_integrator *it, size_t k)
{
    static const pk_real off[] = {1, -1, -1, 1, 1, -1, 1}; /* signs of the changes of numbers */
    enum { OFF = sizeof off / sizeof *off };
    const pk_real small = PK_C(1e-6);
    pk_real *g = pk_events_sample(e, PK_MOST_SAMPLES + 1);
    for (size_t i = 0; i < e->n_q; i++)
        e->trial[i] = e->q0[i] + small * off[i % OFF] * e->q0[i];
    for (size_t i = 0; i < e->n; i++)
        e->trial_v[i] = e->v0[i] + small * off[(i + 3) % OFF] * e->v0[i];
    pk_events_functions(e, it, e->from, e->trial, e->trial_v, g);
    return ROUNDINGS * PK_EPS / small * pk_abs(g[k] - pk_events_end(e, 0)[k]);
}

/* Returns whether an adaptive step is too long to resolve how a function began: it is much longer
 * than all time integrated before this step, and the function has grown very much in it. This may
 * happen in a first step from a state of zeros, where the scale of errors is from the run alone. */
static int outgrown(struct pk_events *e, const struct pk_integrator *it, int count)
{
    const pk_real *begin = pk_events_end(e, 0), *end = pk_events_end(e, 1);
    const pk_real h = pk_abs(it->t - e->from);
    int found = 0, at_rest = -1;
    if (pk_is_fixed(it->method) || h <= GROWTH * (it->own->progress.passed - h))
        return 0;
    /* After a switch, the value of its function is only the rounding error of 0. */
    if (e->at_switch || h <= 64 * PK_EPS * pk_abs(e->from))
        return 0;
    for (size_t k = 0; k < pk_events_count(e) && !found; k++) {
        if (!(pk_abs(begin[k]) > PK_TINY) && at_rest < 0)
            at_rest = !(pk_largest(e->q0, e->n_q) > 0) && !(pk_largest(e->v0, e->n) > 0);
        found = !(pk_abs(end[k]) <= GROWTH * pk_abs(begin[k])) &&
                (pk_abs(begin[k]) > PK_TINY ? pk_abs(begin[k]) > rounding(e, it, k)
                                            : at_rest && count < FROM_REST);
    }
    return found;
}

/* Undoes the last step, and forgets the error scale that this step has set. */
static enum pk_status take_back(struct pk_events *e, struct pk_integrator *it)
{
    it->own->progress.passed -= pk_abs(it->t - e->from);
    it->own->progress.longest = 0;
    it->count.steps--;
    it->count.rejections++;
    pk_scale_forget(it);
    return pk_integrator_reset(it, e->from, e->q0, e->v0);
}

static enum pk_status try_step(struct pk_events *e, struct pk_integrator *it, pk_real limit)
{
    it->event = 0;
    if (it->method->resolved && it->options.h > it->method->resolved(it)) {
        it->reason = PK_WHY(.value = it->method->resolved(it));
        return it->status = PK_REFUSED;
    }
    e->from = it->t;
    e->limit = limit;
    e->listed = 0;
    e->scout.options.h = it->options.h;
    pk_copy(e->q0, it->q, e->n_q);
    pk_copy(e->v0, it->v, e->n);
    /* no event is at the start of a step that crosses nothing */
    const int clear = pk_events_ahead(e, it);
    if (!clear && (at_end(e, it, 0, e->q0, e->v0) < 0 || stop_beyond_limit(e, it, limit < it->t)))
        return it->status;
    for (int count = 0;; count++) {
        if (pk_integrator_step(it, limit) != PK_DONE)
            return it->status;
        if (!(it->t < e->from || it->t > e->from)) /* no step: t was at `limit` */
            return it->status;
        if (clear && it->own->ahead->taken) {
            e->at_switch = 0;
            return it->status;
        }
        if (clear && at_end(e, it, 0, e->q0, e->v0) < 0)
            return it->status;
        const enum pk_status end = at_end(e, it, 1, it->q, it->v);
        if (end >= 0 && count == 0 && pk_switches_free(e, it))
            return it->status;
        if (count == SHORTER || !outgrown(e, it, count))
            return end < 0 ? end : pk_events_look(e, it);
        limit = e->from + (it->t - e->from) / 8;
        PK_TRY(take_back(e, it));
    }
}

/* Makes one step. If the side of a switch was guessed wrong, repeats it on the other side. */
static enum pk_status one_step(struct pk_events *e, struct pk_integrator *it, pk_real limit)
{
    enum pk_status status = pk_switches_settle(e, it);
    do {
        e->again = 0;
        if (status >= 0)
            status = try_step(e, it, limit);
    } while (e->again && status >= 0);
    return status;
}

/* Follows the motion up to a singularity, since events may come before it and the failed step has
 * no end. Each step covers half of the time left until the singularity. */
static enum pk_status towards_end(struct pk_events *e, struct pk_integrator *it)
{
    const enum pk_status ended = it->status;
    const struct pk_reason reason = it->reason;
    if (!pk_finite(reason.time) || !(pk_direction(it) * (reason.time - e->from) > 0) ||
        pk_integrator_reset(it, e->from, e->q0, e->v0) < 0) {
        it->own->ready = 0;
        return it->status = ended;
    }
    for (int count = 0; count < HALVINGS; count++) {
        const enum pk_status status = one_step(e, it, it->t + (reason.time - it->t) / 2);
        if (status == PK_STOPPED_EVENT)
            return status;
        if (status != PK_DONE)
            break;
    }
    it->own->ready = 0;
    it->event = 0;
    it->reason = reason;
    return it->status = ended;
}

enum pk_status pk_events_step(struct pk_events *e, struct pk_integrator *it, pk_real limit)
{
    const void *const given = it->problem.params;
    if (pk_events_count(e) == 0 || !pk_ready(it))
        return pk_integrator_step(it, limit);
    pk_switches_enter(e, it);
    enum pk_status status = one_step(e, it, limit);
    if (status == PK_SINGULAR_TIME || status == PK_SINGULAR_COORDINATES)
        status = towards_end(e, it);
    pk_switches_leave(e, it);
    it->problem.params = given;
    return status;
}

enum pk_status pk_events_to(struct pk_events *e, struct pk_integrator *it, pk_real t_end)
{
    do {
        const enum pk_status status = pk_events_step(e, it, t_end);
        if (status != PK_DONE)
            return status;
    } while (it->t < t_end || it->t > t_end);
    return PK_DONE;
}

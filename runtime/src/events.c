/* Events: crossings of zero within a step, located by the method itself; see pk/events.h.
 *
 * The functions of the events are looked at on an interpolant of the step, which costs no step, or
 * where a step is too long for it at states by shorter ones. It only proposes times: what is
 * believed is g at states that a second integrator, the scout, reaches from where the step began.
 * Between two such times with opposite signs lies a crossing.
 *
 * Reference: L. F. Shampine, S. Thompson, Event location for ordinary differential equations,
 * Comput. Math. Appl. 39 (2000) 43.
 */
#include <string.h>

#include "events.h"

enum { HALVINGS = 20 }; /* of what is left to a singularity: to a millionth of a step */

/* Samples are taken in proportion to the stages, for steps are as long as the stages are many. */
static int samples_of(const struct pk_method *method)
{
    const int wanted = 2 * method->stages;
    return wanted < 2 || wanted > PK_MOST_SAMPLES ? PK_MOST_SAMPLES : wanted;
}

static size_t reals(const struct pk_problem *problem, const struct pk_method *method)
{
    const size_t n = pk_system_count(problem->system, problem->params);
    const size_t m = problem->system->n_events;
    return 4 * n + problem->system->n_inputs + 2 * problem->system->n_quadratures +
           m * (size_t)(samples_of(method) + 2 + PK_EVENT_ENTRY * PK_MOST_NODES);
}

size_t pk_events_size(const struct pk_problem *problem, const struct pk_method *method)
{
    const size_t scout = pk_integrator_size(problem, method);
    return scout ? scout + reals(problem, method) * sizeof(pk_real) : 0;
}

enum pk_status pk_events_init(struct pk_events *events, const struct pk_integrator *it,
                              void *block, size_t block_size)
{
    memset(events, 0, sizeof *events);
    if (!it || !it->ready || !block)
        return it && it->status < 0 ? it->status : PK_BAD_ARGUMENT;
    const struct pk_problem *problem = &it->problem;
    if (block_size < pk_events_size(problem, it->method) || (size_t)block % _Alignof(pk_real))
        return PK_BLOCK_TOO_SMALL;
    struct pk_options options = it->options;
    options.h_min = 0; /* a step to a crossing may be as short as it is near */
    options.max_steps = 0;
    events->n = it->n;
    events->n_events = problem->system->n_events;
    if (events->n_events == 0)
        return PK_DONE;
    const size_t scout = pk_integrator_size(problem, it->method);
    events->samples = samples_of(it->method);
    events->dense = (it->method->traits & PK_DENSE) &&
                    it->method->dense_order >= it->method->order;
    events->q0 = (pk_real *)block + scout / sizeof(pk_real);
    events->v0 = events->q0 + it->n;
    events->trial = events->v0 + it->n;
    events->u = events->trial + 2 * it->n;
    events->g = events->u + problem->system->n_inputs;
    events->list = events->g + events->n_events * (size_t)(events->samples + 2);
    events->z0 = events->list + events->n_events * (size_t)(PK_EVENT_ENTRY * PK_MOST_NODES);
    memset(events->q0, 0, reals(problem, it->method) * sizeof(pk_real));
    return pk_integrator_init(&events->scout, problem, it->method, &options, it->t, it->q, it->v,
                              block, scout);
}

void pk_events_free(struct pk_events *events) { pk_integrator_free(&events->scout); }

void pk_events_functions(const struct pk_events *e, const struct pk_integrator *it, pk_real t,
                      const pk_real *q, const pk_real *v, pk_real *g)
{
    const struct pk_problem *p = &it->problem;
    if (p->system->n_inputs && p->input)
        p->input(p->context, t, e->u);
    p->system->event(p->params, t, q, v, e->u, g);
}

enum pk_status pk_events_not_finite(struct pk_integrator *it, size_t k)
{
    it->event = k + 1;
    return it->status = PK_NOT_FINITE;
}

static enum pk_status at_ends(const struct pk_events *e, struct pk_integrator *it, int j,
                              const pk_real *q, const pk_real *v)
{
    pk_real *g = pk_events_sample(e, j);
    pk_events_functions(e, it, it->t, q, v, g);
    for (size_t k = 0; k < e->n_events; k++)
        if (!pk_finite(g[k]))
            return pk_events_not_finite(it, k);
    return PK_DONE;
}

/* The motion at t within the step, by the method itself. */
enum pk_status pk_events_reach(struct pk_events *e, struct pk_integrator *it, pk_real t)
{
    struct pk_integrator *scout = &e->scout;
    const size_t bytes = e->n * sizeof *e->trial;
    if (!(t < it->t) && !(t > it->t)) {
        memcpy(e->trial, it->q, bytes);
        memcpy(e->trial + e->n, it->v, bytes);
        return PK_DONE;
    }
    e->tries++;
    if (e->dense)
        return pk_integrator_dense(it, t, e->trial, e->trial + e->n);
    pk_integrator_reset(scout, e->from, e->q0, e->v0);
    if (it->z && scout->status >= 0)
        pk_integrator_set_quadratures(scout, e->z0);
    if (scout->status >= 0 && (it->method->traits & PK_ADAPTIVE) &&
        (t < e->from || t > e->from))
        pk_integrator_set_step(scout, pk_abs(t - e->from));
    if (scout->status >= 0 && pk_integrator_to(scout, t) >= 0) {
        memcpy(e->trial, scout->q, bytes);
        memcpy(e->trial + e->n, scout->v, bytes);
        return PK_DONE;
    }
    it->where = scout->where;
    it->detail = scout->detail;
    it->condition = scout->condition;
    return it->status = scout->status;
}

/* The quadratures where the motion has just been followed to, e->t. */
static enum pk_status quadratures(struct pk_events *e, struct pk_integrator *it)
{
    const size_t m = it->problem.system->n_quadratures;
    pk_real *z = e->z0 + m;
    e->z = it->z ? z : NULL;
    if (!it->z)
        return PK_DONE;
    if (e->dense || (!(e->t < it->t) && !(e->t > it->t)))
        return pk_integrator_dense_quadratures(it, e->t, z);
    memcpy(z, e->scout.z, m * sizeof *z);
    return PK_DONE;
}

/* Some two units in the last place of t, on either side: a crossing is known no better. */
static pk_real width_of(const struct pk_events *e, const struct pk_integrator *it)
{
    return PK_C(4.0) * PK_EPS * pk_max(pk_abs(e->from), pk_abs(it->t));
}

/* The state just behind a crossing. A step of the core's methods gives the same each time, and that
 * has been seen to be behind; GSL's bsimp differs in the last digits, and is taken a little further. */
static enum pk_status behind(struct pk_events *e, struct pk_integrator *it, const pk_real *entry)
{
    const size_t k = (size_t)entry[1];
    const pk_real side = entry[2] * (pk_real)it->direction;
    const pk_real width = width_of(e, it);
    pk_real *g = pk_events_sample(e, e->samples + 1);
    for (int tries = 0; tries < 4; tries++) {
        e->t = pk_events_time(e, it, entry[0] + (pk_real)tries * width);
        if (pk_events_reach(e, it, e->t) < 0)
            return it->status;
        pk_events_functions(e, it, e->t, e->trial, e->trial + e->n, g);
        if (side * g[k] >= 0)
            break;
    }
    return quadratures(e, it);
}

/* Reports what was found, as far as the first event that stops and what is at the same time. */
static enum pk_status report(struct pk_events *e, struct pk_integrator *it)
{
    size_t stopped = 0;
    pk_real last = pk_abs(it->t - e->from);
    for (size_t i = 0; i < e->listed; i++) {
        const pk_real *entry = e->list + PK_EVENT_ENTRY * i;
        if (entry[0] > last)
            break;
        e->which = (size_t)entry[1];
        e->direction = (int)entry[2];
        if (behind(e, it, entry) < 0)
            return it->status;
        e->q = e->trial;
        e->v = e->trial + e->n;
        e->count++;
        int stop = it->problem.system->events[e->which].stop;
        if (e->found && e->found(e->context, e))
            stop = 1;
        if (it->status < 0) /* of dense output that found() asked for */
            return it->status;
        if (stop && !stopped) {
            stopped = e->which + 1;
            last = entry[0] + width_of(e, it);
        }
    }
    if (!stopped)
        return it->status = PK_DONE;
    if ((e->t < it->t || e->t > it->t) && pk_integrator_reset(it, e->t, e->q, e->v) < 0)
        return it->status;
    if (e->z)
        pk_integrator_set_quadratures(it, e->z);
    it->event = stopped;
    return it->status = PK_STOPPED_EVENT;
}

static enum pk_status one_step(struct pk_events *e, struct pk_integrator *it, pk_real limit)
{
    it->event = 0;
    if (it->method->resolved && it->options.h > it->method->resolved(it)) {
        it->detail = it->method->resolved(it);
        return it->status = PK_REFUSED;
    }
    e->from = it->t;
    e->listed = 0;
    e->scout.options.h = it->options.h;
    memcpy(e->q0, it->q, e->n * sizeof *e->q0);
    memcpy(e->v0, it->v, e->n * sizeof *e->v0);
    if (it->z)
        memcpy(e->z0, it->z, it->problem.system->n_quadratures * sizeof *e->z0);
    if (at_ends(e, it, 0, e->q0, e->v0) < 0 || pk_integrator_step(it, limit) != PK_DONE)
        return it->status;
    if (!(it->t < e->from || it->t > e->from)) /* the limit is here */
        return it->status;
    if (at_ends(e, it, e->samples, it->q, it->v) < 0 || pk_events_look(e, it) < 0)
        return it->status;
    for (size_t k = 0; k < e->n_events; k++)
        if (pk_events_seek(e, it, k) < 0)
            return it->status;
    return report(e, it);
}

/* A step that a singularity ends has no end to look at, and events may come before it. So the
 * motion is followed up to there, each step half of what is left. */
static enum pk_status towards_end(struct pk_events *e, struct pk_integrator *it)
{
    const enum pk_status ended = it->status;
    const pk_real detail = it->detail;
    const size_t where = it->where;
    if (!pk_finite(detail) || !((pk_real)it->direction * (detail - e->from) > 0) ||
        pk_integrator_reset(it, e->from, e->q0, e->v0) < 0) {
        it->ready = 0;
        return it->status = ended;
    }
    if (it->z)
        pk_integrator_set_quadratures(it, e->z0);
    for (int count = 0; count < HALVINGS; count++) {
        const enum pk_status status = one_step(e, it, it->t + (detail - it->t) / 2);
        if (status == PK_STOPPED_EVENT)
            return status;
        if (status != PK_DONE)
            break;
    }
    it->ready = 0;
    it->event = 0;
    it->where = where;
    it->detail = detail;
    return it->status = ended;
}

enum pk_status pk_events_step(struct pk_events *e, struct pk_integrator *it, pk_real limit)
{
    if (e->n_events == 0 || !it->ready)
        return pk_integrator_step(it, limit);
    const enum pk_status status = one_step(e, it, limit);
    return status == PK_SINGULAR_TIME || status == PK_SINGULAR_COORDINATES ? towards_end(e, it)
                                                                           : status;
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

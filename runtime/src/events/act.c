/* Values after events, and the modes of contacts, frictions and latches; see pk/act.h. impact.c
 * solves for impulses and multipliers. */
#include <math.h>

#include "act.h"
#include "events.h"

#define WRITTEN PK_C(1e-8) /* starts are written in few digits: a gap below this is closed */
/* a bounce below this fraction of the highest one, as its height goes, ends in rest */
#define LOW (64 * PK_EPS)
/* more than MOST changes within this fraction of the time lead nowhere */
#define CROWDED PK_C(1e-9)
enum { MOST = 10000 };
#define LONGER PK_C(8.0)
#define NEAR PK_C(1e4) /* so many roundings are from a zero that was found; farther is a jump */

static size_t lay_out(struct pk_actor *a, const struct pk_problem *problem, pk_real *base)
{
    const struct pk_system *system = problem->system;
    const size_t n = pk_count_of(problem), n_q = pk_coordinates_of(problem);
    const size_t e = system->contacts.n, c = system->constraints.n;
    pk_real *seen;
    /* clang-format off */
    const struct pk_slot slots[] = {
        {&seen, e * sizeof *a->seen / sizeof *seen}, {&a->happened, system->events.n},
        {&a->next, n_q + n + system->n_inputs}, {&a->before, n_q + n + system->n_inputs},
        {&a->values, 5 * e}, {&a->touches, e}, {&a->state, e}, {&a->idle, e}, {&a->floats, e},
        {&a->clings, e}, {&a->A, e ? c * c : 0}, {&a->b, c}, {&a->x, c},
        {&a->B, e ? c * (c + 1) : 0}, {&a->room, e ? pk_project_room(problem, n) : 0}};
    /* clang-format on */
    const size_t size = PK_LAY_OUT(base, slots);
    a->seen = (struct pk_contact_seen *)(void *)seen;
    a->n_q = n_q;
    a->n = n;
    return size;
}

size_t pk_actor_reals(const struct pk_problem *problem)
{
    struct pk_actor a;
    const struct pk_system *system = problem->system;
    return system->resets.n || system->contacts.n ? lay_out(&a, problem, NULL) : 0;
}

int pk_actor_note(struct pk_actor *a, const struct pk_events *events)
{
    const struct pk_system *system = a->system;
    const size_t k = events->which;
    int acts = 0;
    for (size_t i = 0; i < system->resets.n; i++)
        acts |= system->resets.table[i].event == k;
    for (size_t i = 0; i < system->contacts.n; i++)
        acts |= system->contacts.table[i].event == k || system->contacts.table[i].open == k;
    if (acts)
        a->happened[k] = 1;
    if (system->events.table[k].stop && !a->stopped)
        a->stopped = k + 1;
    a->acting |= acts;
    return acts;
}

/* The parts of a->next: the state and the inputs that are to follow. */
static pk_real *next_v(const struct pk_actor *a) { return a->next + a->n_q; }

static int happened(const struct pk_actor *a, size_t event)
{
    return event < a->system->events.n && a->happened[event] > 0;
}

/* Finds the contacts whose gap is closed. A gap that has just been found closed by its event is, and
 * one that was closed, unless values after an event have changed it. Fails at a constraint that
 * these values break. */
static enum pk_status touch(struct pk_actor *a, struct pk_integrator *it, struct rows *r,
                            pk_real within)
{
    for (size_t row = 0; row < a->system->constraints.n_holonomic; row++) {
        const size_t k = r->of[row];
        const struct pk_contact *x = k < a->system->contacts.n ? &a->system->contacts.table[k]
                                                               : NULL;
        const pk_real gap = r->w.phi[row], size = r->w.phi_size[row];
        if (!x || x->kind == PK_LATCH) {
            if ((!x || a->u[x->mode] > 0) && pk_abs(gap) > WRITTEN * size + NEAR * r->of_gap[row])
                return pk_fail_with(it, PK_OFF_CONSTRAINTS,
                                    PK_WHY(.kind = PK_REASON_ROW, .index = row, .value = gap));
            continue;
        }
        const int was = a->u[x->mode] > 0 || a->u[x->mode + 2] > 0;
        const int holds = happened(a, x->event) ||
                          (was && pk_abs(gap) <= WRITTEN * size + r->of_gap[row]);
        if (!holds && gap < -WRITTEN * size - r->of_gap[row]) {
            it->own->ready = 0;
            return pk_fail_with(it, PK_PENETRATES, PK_WHY(.index = k, .value = gap, .time = it->t));
        }
        a->touches[k] = holds || pk_abs(gap) <= within * size + r->of_gap[row];
    }
    return PK_DONE;
}

/* Changes the rates by impulses, if a closed gap still closes, or if a row that holds is left. */
static enum pk_status strike(struct pk_actor *a, struct pk_integrator *it, struct rows *r)
{
    int strikes = 0;
    for (size_t row = 0; row < r->w.c; row++) {
        const size_t k = r->of[row];
        const int contact = k < a->system->contacts.n &&
                            a->system->contacts.table[k].kind == PK_CONTACT;
        if (k < a->system->contacts.n && !contact && !(a->u[r->mode[row]] > 0))
            continue;
        if (contact ? a->touches[k] > 0 && r->w.rate[row] < 0 && !pk_act_still(r, row)
                    : a->system->contacts.modes[row] == 0 && !pk_act_still(r, row))
            strikes = 1;
        if (k < a->system->contacts.n && a->system->contacts.table[k].kind == PK_LATCH &&
            happened(a, a->system->contacts.table[k].event))
            strikes = 1;
    }
    return strikes ? pk_impact(a, it, r) : PK_DONE;
}

/* Returns whether contact k, which is closed and opens at this rate, is about to come to rest: its
 * next bounce would be lower than rounding. */
static int is_low(struct pk_actor *a, const struct rows *r, size_t k, pk_real t)
{
    const size_t row = a->system->contacts.table[k].row;
    const pk_real v = r->w.rate[row], down = -r->acceleration[row];
    struct pk_contact_seen *seen = &a->seen[k];
    if (!(down > 0))
        return 0;
    const pk_real height = v * v / (2 * down), flight = 2 * v / down;
    const pk_real low = LOW * pk_max(seen->highest, r->w.phi_size[row]);
    seen->highest = pk_max(seen->highest, height);
    if (!(height <= low))
        return 0;
    /* the flights that follow are a geometric series */
    const pk_real ratio = seen->flight > flight ? flight / seen->flight : 0;
    seen->rests = t + flight / (1 - ratio);
    return 1;
}

/* Notes the first time at which contact k, which does not stay closed, closes so slowly that it
 * would hardly pass 0, and opens by its acceleration or has none: rounding decides if it strikes. */
static void note_graze(struct pk_actor *a, const struct rows *r, size_t k, pk_real t)
{
    const size_t row = a->system->contacts.table[k].row;
    struct pk_contact_seen *seen = &a->seen[k];
    const pk_real passes = 2 * WRITTEN * r->w.phi_size[row] * r->acceleration[row];
    const int closes = a->touches[k] > 0 && !happened(a, a->system->contacts.table[k].open);
    if (closes && !pk_finite(seen->grazes) && r->before[row] * r->before[row] <= passes)
        seen->grazes = t;
}

/* Finds the modes that the accelerations allow, and writes them to the inputs. */
static enum pk_status settle(struct pk_actor *a, struct pk_integrator *it, struct rows *r)
{
    const size_t e = a->system->contacts.n;
    const struct pk_contact *table = a->system->contacts.table;
    int again = 1;
    for (size_t k = 0; k < e; k++)
        if (!(a->touches[k] > 0) || (r->w.rate[table[k].row] > 0 && !pk_act_still(r, table[k].row)))
            a->seen[k].rests = (pk_real)NAN;
    while (again) {
        again = 0;
        for (size_t k = 0; k < e; k++) {
            const size_t row = table[k].row;
            const int told = happened(a, table[k].open) ||
                             (table[k].kind == PK_FRICTION && happened(a, table[k].event));
            const int still = pk_abs(r->w.rate[row]) <= (told ? NEAR : 1) * r->of_rate[row];
            a->state[k] = table[k].kind == PK_CONTACT
                              ? a->touches[k] > 0 && (still || pk_finite(a->seen[k].rests))
                          : table[k].kind == PK_FRICTION && !still ? (r->w.rate[row] > 0 ? 2 : -2)
                                                                   : 1;
        }
        PK_TRY(pk_reactions(a, it, r));
        for (size_t k = 0; k < e; k++) {
            const int rises = table[k].kind == PK_CONTACT && a->touches[k] > 0 &&
                              r->w.rate[table[k].row] > 0 && !pk_act_still(r, table[k].row);
            if (rises && !pk_finite(a->seen[k].rests))
                again |= is_low(a, r, k, it->t);
        }
    }
    for (size_t k = 0; k < e; k++) {
        pk_real *u = a->next + a->n_q + a->n + table[k].mode;
        const size_t row = table[k].row;
        /* what floats on its bound would cross it by rounding all the time */
        const pk_real least = table[k].kind == PK_CONTACT ? r->of_gap[row] : r->of_rate[row];
        a->floats[k] = a->floats[k] > 0 ? -4 * least - PK_TINY : 0;
        if (table[k].kind == PK_LATCH)
            continue;
        u[0] = pk_abs(a->state[k] - 1) <= 0;
        u[2] = a->idle[k];
        if (table[k].kind == PK_FRICTION)
            u[1] = a->state[k] > 1 ? 1 : a->state[k] < 0 ? -1 : 0;
        else if (!(u[0] > 0 || u[2] > 0)) {
            a->seen[k].rests = (pk_real)NAN;
            note_graze(a, r, k, it->t);
        } else if (!pk_finite(a->seen[k].rests))
            a->seen[k].rests = it->t;
    }
    return PK_DONE;
}

/* What the projection leaves of rates that it takes away is rounding: these parts are at rest. */
static void rest(struct pk_actor *a, const struct rows *r)
{
    pk_real *v = next_v(a), most = 0;
    for (size_t k = 0; k < r->w.m; k++)
        most = pk_max(most, PK_F(sqrt)(pk_project_mass(&r->w, k)) * pk_abs(a->before[k]));
    for (size_t k = 0; k < r->w.m; k++)
        if (PK_F(sqrt)(pk_project_mass(&r->w, k)) * pk_abs(v[k]) <= 64 * PK_EPS * most)
            v[k] = 0;
}

/* Finds the motion after the state a->next: impulses, then modes. */
static enum pk_status contacts(struct pk_actor *a, struct pk_integrator *it, pk_real within)
{
    const struct pk_contact *table = a->system->contacts.table;
    struct rows r;
    pk_real *u = a->next + a->n_q + a->n;
    for (size_t k = 0; k < a->system->contacts.n; k++)
        if (table[k].kind == PK_LATCH) {
            const int on = happened(a, table[k].event), off = happened(a, table[k].open);
            u[table[k].mode] = on || (u[table[k].mode] > 0 && !off);
            if (off && !on && table[k].event < a->system->events.n)
                a->happened[table[k].event] = -1; /* it is 0, and may happen again */
        }
    pk_copy(a->u, u, a->system->n_inputs);
    PK_TRY(pk_act_rows(a, it, &r));
    PK_TRY(touch(a, it, &r, within));
    pk_copy(r.before, r.w.rate, r.w.c);
    PK_TRY(strike(a, it, &r));
    PK_TRY(settle(a, it, &r));
    pk_copy(a->u, u, a->system->n_inputs);
    pk_copy(a->before, next_v(a), a->n);
    PK_TRY(pk_constraint_project(it, it->t, a->next, next_v(a)));
    rest(a, &r);
    return PK_DONE;
}

/* The next step is as long as it would have been, since a first step is chosen too short. It is not
 * much longer than the time between changes, which dense output of a long step would not resolve. */
static enum pk_status go_on(struct pk_actor *a, struct pk_integrator *it)
{
    const pk_real since = pk_max(pk_abs(it->t - a->changed), CROWDED * pk_abs(it->t));
    a->changed = it->t;
    if (!a->events || !(a->events->tried > 0) || !(it->method->traits & PK_ADAPTIVE))
        return PK_DONE;
    return pk_integrator_set_step(it, pk_min(a->events->tried, LONGER * since));
}

/* The function of an event that gave values is 0 up to rounding, unless a value changed it, and so
 * is that of one that turns on a latch that has just been turned off. It goes on to the side to
 * which the new motion leads, and does not cross 0 on this way. */
static void leave(struct pk_actor *a, struct pk_integrator *it)
{
    const pk_real part = PK_C(1e-3);
    struct pk_events *e = a->events;
    const size_t n_q = a->n_q, n = a->n;
    int left = 0;
    if (!e || !(e->tried > 0))
        return;
    const pk_real h = part * (e->limit < it->t ? -e->tried : e->tried);
    pk_real *now = pk_events_sample(e, 0), *ahead = pk_events_sample(e, 1),
            *other = pk_events_sample(e, 2), *q = a->before;
    pk_events_functions(e, it, it->t, it->q, it->v, now);
    for (size_t k = 0; k < a->system->events.n; k++) {
        const pk_real rounding = pk_abs(e->held[k]);
        const int frees = a->happened[k] < 0, gave = a->system->resets.n && happened(a, k);
        if (!(gave || frees) || pk_abs(now[k]) > rounding)
            continue;
        if (!left && pk_eval_acceleration(it, it->t, it->q, it->v, e->a0) < 0)
            return;
        for (size_t i = 0; i < n && !left; i++)
            q[n_q + i] = it->v[i] + h * e->a0[i];
        for (size_t i = 0; i < n_q && !left; i++)
            q[i] = it->q[i] + h * (it->v[i] + q[n_q + i]) / 2;
        if (!left++)
            pk_events_functions(e, it, it->t + h, q, q + n_q, ahead);
        const pk_real way = ahead[k] - now[k];
        if (pk_abs(way) > (frees ? 0 : rounding))
            e->held[k] = way > 0 ? rounding : -rounding;
        if (!frees)
            continue;
        for (size_t i = 0; i < n_q; i++) /* it begins at rest, and is rounding for a while */
            q[i] = it->q[i] * (i % 2 ? 1 + part : 1 - part);
        pk_events_functions(e, it, it->t, q, it->v, other);
        e->off[k] = (way > 0 ? -64 : 64) * PK_EPS / part * pk_abs(other[k] - now[k]);
    }
    if (left)
        pk_switches_leave(e, it);
}

/* The functions of contacts and frictions are positive until they change, whatever rounding says
 * where a gap is 0. */
static void watch(struct pk_actor *a, const struct pk_integrator *it)
{
    const struct pk_part_contacts *all = &a->system->contacts;
    if (!a->events || !all->n)
        return;
    for (size_t k = 0; k < all->n; k++) {
        if (all->table[k].kind == PK_LATCH)
            continue;
        a->events->held[all->table[k].event] = a->events->held[all->table[k].open] = PK_INFINITY;
        a->events->off[all->table[k].event] = a->floats[k];
        a->events->off[all->table[k].open] = a->clings[k];
    }
    pk_switches_leave(a->events, it);
}

static enum pk_status change(struct pk_actor *a, struct pk_integrator *it, pk_real within)
{
    const struct pk_system *system = a->system;
    const size_t n_q = a->n_q, n = a->n;
    const size_t stopped = a->stopped;
    pk_real *old = a->before;
    pk_copy(a->next, it->q, n_q);
    pk_copy(next_v(a), it->v, n);
    pk_copy(a->next + n_q + n, a->u, system->n_inputs);
    for (size_t i = 0; i < system->resets.n; i++) {
        if (!happened(a, system->resets.table[i].event))
            continue;
        pk_copy(old, a->next, n_q + n + system->n_inputs);
        system->resets.table[i].next(a->params, it->t, old, old + n_q, old + n_q + n, a->next);
    }
    pk_copy(a->u, a->next + n_q + n, system->n_inputs);
    if (system->contacts.n)
        PK_TRY(contacts(a, it, within));
    else
        PK_TRY(pk_project_rates(it, a->next, next_v(a)));
    a->acting = 0;
    a->stopped = 0;
    PK_TRY(pk_integrator_reset(it, it->t, a->next, next_v(a)));
    leave(a, it);
    pk_zero(a->happened, system->events.n);
    watch(a, it);
    PK_TRY(go_on(a, it));
    it->event = stopped;
    return it->status = stopped ? PK_STOPPED_EVENT : PK_DONE;
}

/* At a kink the switches of the events know on which side the motion is, or begins. */
static enum pk_status change_at_kink(struct pk_actor *a, struct pk_integrator *it, pk_real within)
{
    const void *const given = it->problem.params;
    if (!a->events)
        return change(a, it, within);
    pk_switches_enter(a->events, it);
    enum pk_status status = within > 0 ? pk_switches_settle(a->events, it) : PK_DONE;
    a->params = it->problem.params;
    status = status < 0 ? status : change(a, it, within);
    a->params = it->problem.params = given;
    return it->status = status;
}

enum pk_status pk_actor_start(struct pk_actor *a, struct pk_integrator *it, pk_real *work)
{
    const struct pk_contact *table = a->system->contacts.table;
    pk_zero(work, lay_out(a, &it->problem, NULL));
    lay_out(a, &it->problem, work);
    a->work = work;
    a->order_t = (pk_real)NAN;
    a->changed = a->crowd_from = it->t;
    a->crowd = 0;
    a->acting = 0;
    a->stopped = 0;
    for (size_t k = 0; k < a->system->contacts.n; k++) {
        a->seen[k].rests = a->seen[k].last = a->seen[k].grazes = (pk_real)NAN;
        a->u[table[k].mode] = table[k].kind == PK_LATCH && table[k].flag;
        a->u[table[k].mode + 1] = a->u[table[k].mode + 2] = 0;
    }
    return it->status = a->system->contacts.n ? change_at_kink(a, it, WRITTEN) : PK_DONE;
}

enum pk_status pk_actor_run(struct pk_actor *a, struct pk_integrator *it)
{
    const pk_real passed = pk_abs(it->t - a->crowd_from);
    a->crowd += 1;
    if (passed > CROWDED * pk_abs(it->t))
        a->crowd = 0, a->crowd_from = it->t;
    if (a->crowd > MOST)
        return it->status =
                   pk_fail_with(it, PK_NO_PROGRESS,
                                PK_WHY(.kind = PK_REASON_CROWD, .value = a->crowd, .time = passed));
    return it->status = it->status == PK_OFF_CONSTRAINTS ? change_at_kink(a, it, 0)
                                                         : change(a, it, 0);
}

enum pk_status pk_actor_act(struct pk_actor *a, struct pk_integrator *it, enum pk_status status)
{
    const int kink = status == PK_OFF_CONSTRAINTS && a->system->contacts.n && a->events->at_switch;
    return kink || (status == PK_STOPPED_EVENT && a->acting) ? pk_actor_run(a, it) : status;
}

void pk_actor_keep(struct pk_actor *a, struct pk_keep *k)
{
    const struct pk_system *system = a->system;
    pk_keep(k, a->u, system->n_inputs * sizeof *a->u);
    pk_keep(k, a->seen, system->contacts.n * sizeof *a->seen);
    PK_KEEP(k, a->order_t);
    PK_KEEP(k, a->order_of);
    PK_KEEP(k, a->changed);
    PK_KEEP(k, a->crowd);
    PK_KEEP(k, a->crowd_from);
    PK_KEEP(k, a->most);
}

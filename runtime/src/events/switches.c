/* The side of zero on which each switch is held during a step, and its changes; see pk/events.h.
 *
 * A step uses the equations of one side throughout, even if its stages or its end lie on the other
 * side; events_report.c then cuts the step back to the zero. This keeps the order of the method.
 *
 * References: E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd
 * ed., Springer 1993, section II.6; for motions that stay on a zero (PK_SLIDING): A. F. Filippov,
 * Differential Equations with Discontinuous Righthand Sides, Kluwer 1988. */
#include <math.h>
#include <string.h>

#include "events.h"

/* A run fails with PK_SLIDING after MOST_BRIEF successive switchings, each within the fraction
 * SHORT of the attempted step or within some units in the last place of t, or after MOST_SLOW
 * switchings within the rounding of the time left. */
enum { MOST_BRIEF = 64, MOST_SLOW = 4096, MOST_AT_ONCE = 8 };
#define SHORT PK_F(sqrt)(PK_EPS)

void pk_switches_enter(struct pk_events *e, struct pk_integrator *it)
{
    const struct pk_system *system = it->problem.system;
    if (e->n_switches == 0)
        return;
    const size_t bytes = system->switches.count ? sizeof e->sides
                                                : e->n_switches * sizeof *e->sides;
    const size_t behind = system->switches.sides + bytes;
    char *const copy = (char *)e->params;
    const char *const given = (const char *)it->problem.params;
    memcpy(copy, given, system->switches.sides);
    memcpy(copy + behind, given + behind, system->params_size - behind);
    it->problem.params = e->params;
}

/* Returns whether the step starts where the last one ended, not at a state set by the caller. If
 * so, switches with an impulse keep their sides: at the zero the impulse is not applied yet, and a
 * motion that a barrier has turned back is just past the zero. */
static int goes_on(const struct pk_events *e, const struct pk_integrator *it)
{
    return e->kept && !(it->t < e->left) && !(it->t > e->left) &&
           !memcmp(e->trial, it->q, e->n_q * sizeof *e->trial) &&
           !memcmp(e->trial_v, it->v, e->n * sizeof *e->trial);
}

void pk_switches_leave(struct pk_events *e, const struct pk_integrator *it)
{
    e->kept = 1;
    e->left = it->t;
    pk_copy(e->trial, it->q, e->n_q);
    pk_copy(e->trial_v, it->v, e->n);
}

/* Returns whether switch k has no side, since its argument stays exactly 0. Its side is NaN then: 0
 * would mean that nothing has set it. */
static int is_free(const struct pk_events *e, size_t k)
{
    return !(e->sides[k] < 0 || e->sides[k] > 0);
}

/* Sets the sides of all switches. Repeats this until no side changes, since the argument of a
 * switch may contain other switches. */
enum pk_status pk_switches_settle(struct pk_events *e, struct pk_integrator *it)
{
    pk_real *x = pk_events_sample(e, PK_MOST_SAMPLES + 1), *ahead = pk_events_sample(e, 0);
    int changed = 1, reset = 0;
    e->kept = goes_on(e, it);
    if (e->n_switches == 0)
        return PK_DONE;
    if (it->own->direction != 0) { /* the sides were settled at the start of an earlier step */
        pk_zero(e->fresh, e->n_switches);
        return PK_DONE;
    }
    const pk_real way = (4 * PK_EPS * pk_largest(it->q, it->n_q) + PK_TINY) /
                        pk_max(pk_largest(it->v, it->n_q), PK_TINY);
    for (size_t round = 0; changed; round++) {
        if (round > e->n_switches + 1)
            return pk_fail(it, PK_SLIDING, 0);
        changed = 0;
        for (size_t i = 0; i < it->n_q; i++) /* by rounding ahead, where a motion leads */
            e->trial[i] = it->q[i] + way * it->v[i];
        pk_switches_values(e, it, it->t, e->trial, it->v, ahead);
        pk_switches_values(e, it, it->t, it->q, it->v, x);
        for (size_t k = 0; k < e->n_switches; k++) {
            /* An argument that stays 0 counts as positive, since step(0) = 1. */
            const pk_real was = e->sides[k];
            e->fresh[k] = 0;
            if (e->kept && pk_switches_impulse(it, k))
                continue;
            const pk_real zero = pk_switches_counted(it, k) ? PK_F(floor)(x[k]) : 0;
            e->fresh[k] = x[k] > zero || x[k] < zero ? 0 : 1;
            if (pk_switches_counted(it, k))
                e->sides[k] = 2 * zero + 1;
            else if (e->kept && e->fresh[k] > 0 && !(was <= 0 && was >= 0))
                continue; /* it has a side, or is free */
            else
                e->sides[k] = (e->fresh[k] > 0 ? ahead : x)[k] < 0 ? -1 : 1;
            changed |= !(e->sides[k] >= was && e->sides[k] <= was);
        }
        reset |= changed;
    }
    return reset ? pk_integrator_reset(it, it->t, it->q, it->v) : PK_DONE;
}

int pk_switches_free(struct pk_events *e, struct pk_integrator *it)
{
    const pk_real *begin = pk_events_end(e, 0) + e->n_events;
    const pk_real *end = pk_events_end(e, 1) + e->n_events;
    for (size_t k = 0; k < e->n_switches; k++) {
        const int stays = pk_abs(end[k]) <= PK_TINY;
        if (!(pk_abs(begin[k]) <= PK_TINY) || pk_switches_counted(it, k) ||
            pk_switches_impulse(it, k) || stays == is_free(e, k) || (stays && !(e->fresh[k] > 0)))
            continue;
        e->fresh[k] = 0;
        e->sides[k] = stays ? (pk_real)NAN : end[k] < 0 ? -1 : 1;
        e->again = 1;
    }
    if (e->again)
        pk_integrator_reset(it, e->from, e->q0, e->v0);
    return e->again;
}

int pk_switches_turn(struct pk_events *e, struct pk_integrator *it)
{
    const pk_real near = 2 * pk_events_width(e, it, pk_abs(it->t - e->from));
    for (size_t i = 0; i < e->listed && e->list[PK_EVENT_ENTRY * i] <= near; i++) {
        const size_t which = (size_t)e->list[PK_EVENT_ENTRY * i + 1];
        if (which < e->n_events || !(e->fresh[which - e->n_events] > 0))
            continue;
        e->fresh[which - e->n_events] = 0;
        if (pk_switches_counted(it, which - e->n_events))
            e->sides[which - e->n_events] -= 2;
        else
            e->sides[which - e->n_events] *= -1;
        e->again = 1;
    }
    if (!e->again || pk_integrator_reset(it, e->from, e->q0, e->v0) < 0)
        return e->again;
    return 1;
}

/* Returns the side of the piece into which counted switch k goes at e->t. */
static pk_real next_piece(const struct pk_events *e, const struct pk_integrator *it, size_t k)
{
    pk_real *x = pk_events_sample(e, 1);
    pk_switches_values(e, it, e->t, e->q, e->v, x);
    const pk_real n = PK_F(floor)(x[k]), side = 2 * n + 1;
    const int stays = !(side < e->sides[k]) && !(side > e->sides[k]);
    return stays && !(x[k] > n) ? side - 2 : side; /* it falls if it is just at the lower end */
}

enum pk_status pk_switches_pass(struct pk_events *e, struct pk_integrator *it, pk_real last,
                                pk_real attempted)
{
    const pk_real took = pk_abs(e->t - e->from);
    size_t which = 0, hit[MOST_AT_ONCE], hits = 0;
    pk_real to[MOST_AT_ONCE];
    for (size_t i = 0; i < e->listed && e->list[PK_EVENT_ENTRY * i] <= last; i++) {
        const pk_real *entry = e->list + PK_EVENT_ENTRY * i;
        if (entry[1] < (pk_real)e->n_events)
            continue;
        which = (size_t)entry[1] - e->n_events;
        const pk_real side = entry[2] * pk_direction(it);
        if (pk_switches_impulse(it, which) && hits < MOST_AT_ONCE)
            hit[hits] = which, to[hits++] = side;
        else if (!pk_switches_impulse(it, which))
            e->sides[which] = pk_switches_counted(it, which) ? next_piece(e, it, which) : side;
    }
    const int brief = took <= SHORT * attempted ||
                      took <= 64 * PK_EPS * pk_max(pk_abs(e->from), pk_abs(e->t));
    e->brief = e->at_switch && brief ? e->brief + 1 : 0;
    e->at_switch = 1;
    if (pk_abs(e->t - e->slow_from) > MOST_SLOW * PK_EPS * pk_abs(e->limit - e->t))
        e->slow = 0, e->slow_from = e->t;
    const int slides = e->brief >= MOST_BRIEF || ++e->slow >= MOST_SLOW;
    enum pk_status status = hits ? pk_impulse(e, it, hit, to, hits) : PK_DONE;
    const struct pk_reason reason = it->reason;
    if (status >= 0 && !slides)
        return PK_DONE;
    pk_integrator_reset(it, e->t, e->q, e->v);
    it->own->ready = 0;
    it->reason = status < 0 ? reason : PK_WHY(.index = which);
    return it->status = status < 0 ? status : PK_SLIDING;
}

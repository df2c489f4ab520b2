/* Reports the crossings of a step in order: calls the caller's functions, stops the run, or moves a
 * switch to its other side. */

#include <pk/constraint.h>

#include "events.h"

/* Computes the state just after a crossing. Methods of the runtime reproduce the state by which the
 * crossing was located; GSL's bsimp may differ in the last digits: a later time is then used. */
static enum pk_status behind(struct pk_events *e, struct pk_integrator *it, const pk_real *entry)
{
    const size_t k = (size_t)entry[1];
    const pk_real side = entry[2] * pk_direction(it);
    const pk_real width = pk_events_width(e, it, entry[0]);
    pk_real *g = pk_events_sample(e, PK_MOST_SAMPLES + 1);
    for (int tries = 0; tries < 4; tries++) {
        e->t = pk_events_time(e, it, entry[0] + (pk_real)tries * width);
        PK_TRY(pk_events_reach(e, it, e->t));
        pk_events_functions(e, it, e->t, e->trial, e->trial_v, g);
        if (side * g[k] >= 0)
            break;
    }
    return PK_DONE;
}

/* Reports one crossing by found() or switched(). Returns whether the run stops there. */
static int tell(struct pk_events *e, struct pk_integrator *it, const pk_real *entry)
{
    const size_t k = (size_t)entry[1];
    const int is_switch = k >= e->n_events;
    e->which = is_switch ? k - e->n_events : k;
    e->direction = (int)entry[2];
    if (behind(e, it, entry) < 0)
        return 0;
    e->q = e->trial;
    e->v = e->trial_v;
    if (is_switch) {
        e->switchings++;
        if (e->switched)
            e->switched(e->context, e);
        return 0;
    }
    e->count++;
    const int wanted = e->found && e->found(e->context, e);
    return wanted || it->problem.system->events.table[k].stop;
}

/* Stores the side of zero on which each event function is at the end of this step, for the start of
 * the next step: projection onto the constraints moves the state by rounding, and the same zero
 * could be crossed twice. */
static void hold(struct pk_events *e)
{
    const pk_real *g = pk_events_sample(e, PK_MOST_SAMPLES + 1);
    const pk_real *begin = pk_events_end(e, 0), *end = pk_events_end(e, 1);
    for (size_t k = 0; k < e->n_events; k++) {
        const pk_real rounding = PK_F(sqrt)(PK_EPS) * pk_max(pk_abs(begin[k]), pk_abs(end[k]));
        const pk_real side = g[k] > 0 || g[k] < 0 ? g[k] : -begin[k];
        e->held[k] = side < 0 ? -rounding : side > 0 ? rounding : 0;
    }
}

/* Returns whether there is an impulse at one of the listed switches that cross up to `last`. */
static int has_impulse(const struct pk_events *e, const struct pk_integrator *it, pk_real last)
{
    int found = 0;
    for (size_t i = 0; i < e->listed && e->list[PK_EVENT_ENTRY * i] <= last; i++) {
        const size_t k = (size_t)e->list[PK_EVENT_ENTRY * i + 1];
        found |= k >= e->n_events && pk_switches_impulse(it, k - e->n_events);
    }
    return found;
}

/* Reports the events whose functions jump across zero as switches move to their new sides: within
 * the step these functions are those of the old sides, and in the next one those of the new. A
 * change that is rounding is no jump. Returns the index of the last one that stops, plus 1. */
static size_t leap(struct pk_events *e, const struct pk_integrator *it)
{
    const pk_real *before = pk_events_sample(e, PK_MOST_SAMPLES + 1);
    const pk_real *begin = pk_events_end(e, 0), *end = pk_events_end(e, 1);
    pk_real *after = pk_events_sample(e, 0);
    size_t stopped = 0;
    pk_events_functions(e, it, e->t, e->q, e->v, after);
    for (size_t k = 0; k < e->n_events; k++) {
        const pk_real rounding = PK_F(sqrt)(PK_EPS) * pk_max(pk_abs(begin[k]), pk_abs(end[k]));
        const int rises = before[k] < 0 && after[k] >= 0, falls = before[k] > 0 && after[k] <= 0;
        const int wanted = it->problem.system->events.table[k].direction;
        const int direction = (rises - falls) * it->own->direction;
        if (direction == 0 || wanted * direction < 0 || !(pk_abs(after[k] - before[k]) > rounding))
            continue;
        e->which = k;
        e->direction = direction;
        e->count++;
        if ((e->found && e->found(e->context, e)) || it->problem.system->events.table[k].stop)
            stopped = k + 1;
    }
    return stopped;
}

/* Stops where constraint rows are linearly dependent: no integrator can start there. */
static void stay(const struct pk_events *e, struct pk_integrator *it)
{
    pk_copy(pk_state(it, PK_Q), e->q, it->n_q);
    pk_copy(pk_state(it, PK_V), e->v, it->n);
    it->t = it->last_t = e->t;
    it->own->ready = 0;
}

enum pk_status pk_events_report(struct pk_events *e, struct pk_integrator *it)
{
    const pk_real attempted = pk_abs(it->t - e->from);
    size_t stopped = 0, passed = 0;
    pk_real last = attempted;
    if (pk_switches_turn(e, it))
        return it->status;
    for (size_t i = 0; i < e->listed && e->list[PK_EVENT_ENTRY * i] <= last; i++) {
        const pk_real *entry = e->list + PK_EVENT_ENTRY * i;
        const int stop = tell(e, it, entry);
        if (it->status < 0) /* a step failed, or the dense output that found() asked for */
            return it->status;
        const int is_switch = entry[1] >= (pk_real)e->n_events;
        if ((stop || is_switch) && !stopped && !passed)
            last = entry[0] + pk_events_width(e, it, entry[0]);
        passed += (size_t)is_switch;
        if (stop && !stopped)
            stopped = e->which + 1;
    }
    if (!stopped && !passed)
        return it->status = PK_DONE;
    e->cut = 1;
    e->tried = attempted;
    hold(e);
    if (passed) {
        PK_TRY(pk_switches_pass(e, it, last, attempted));
        const size_t at_jump = has_impulse(e, it, last) ? 0 : leap(e, it);
        stopped = stopped ? stopped : at_jump;
    }
    if (!passed && pk_constraint_singular(it, e->t, e->q, e->v))
        stay(e, it);
    else if (passed || e->t < it->t || e->t > it->t)
        PK_TRY(pk_integrator_reset(it, e->t, e->q, e->v));
    it->event = stopped;
    return it->status = stopped ? PK_STOPPED_EVENT : PK_DONE;
}

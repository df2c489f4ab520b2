/* A unit in co-simulation: the runtime integrates from one communication point to the next. */
#include "unit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#ifndef UNIT_MOST_STEPS
/* Ten million steps take seconds. A call that needs more steps returns UNIT_DISCARD. */
#define UNIT_MOST_STEPS 10000000
#endif

static int cross(void *context, const struct pk_events *events)
{
    const struct unit *unit = (const struct unit *)context;
    unit_say(unit, UNIT_OK, "logEvents", "%s at t = %.17g",
             unit->system->events.table[events->which].what.name, events->t);
    return 0;
}

enum unit_status unit_said(struct unit *unit, enum unit_status status)
{
    char text[UNIT_LONGEST_TEXT];
    pk_integrator_reason(&unit->it, text, sizeof text);
    return unit_say(unit, status, status == UNIT_ERROR ? "logStatusError" : "logStatusDiscard",
                    "%s", text);
}

enum unit_status unit_integrator(struct unit *unit, double h, double t, const double *y)
{
    const struct pk_problem problem = unit_problem(unit);
    const struct pk_method *const method =
        unit->model->methods[(size_t)unit->settings[UNIT_METHOD]];
    const int fixed = !(method->traits & (PK_ADAPTIVE | PK_EXACT));
    struct pk_options options = pk_options_default();
    options.max_steps = 0;
    options.rtol = unit->settings[UNIT_RTOL];
    options.h = unit->settings[UNIT_STEP];
    if (options.h == 0)
        options.h = fixed || method->traits & PK_EXACT ? h : *unit->length;
    if (!unit->block || unit->it.method != method) {
        free(unit->block);
        free(unit->events_block);
        unit->block = calloc(1, pk_integrator_size(&problem, method) + 1);
        unit->events_block = calloc(1, pk_events_size(&problem, method) + 1);
    }
    if (!unit->block || !unit->events_block)
        return unit_say(unit, UNIT_ERROR, "logStatusError", "there is no memory");
    if (pk_integrator_init(&unit->it, &problem, method, &options, t, y, y + unit->n_q, unit->block,
                           pk_integrator_size(&problem, method)) < 0)
        return unit_said(unit, UNIT_ERROR);
    return UNIT_OK;
}

/* Initialises the integrator and event detection at the unit's state; h is the default step. */
static enum unit_status make_ready(struct unit *unit, double h)
{
    const enum unit_status status = unit_integrator(unit, h, *unit->time, unit->y);
    if (status != UNIT_OK)
        return status;
    if (pk_events_init(&unit->events, &unit->it, unit->events_block,
                       pk_events_size(&unit->it.problem, unit->it.method)) < 0)
        return unit_say(unit, UNIT_ERROR, "logStatusError", "events cannot be looked for");
    unit->events.found = cross;
    unit->events.context = unit;
    unit->ready = 1;
    return UNIT_OK;
}

enum unit_status unit_exit_initialization(struct unit *unit)
{
    int ends;
    enum unit_status status = unit_refresh(unit);
    if (status != UNIT_OK)
        return status;
    if (unit->co_simulation) { /* reports unusable settings before the first step */
        unit->busy = 1;        /* refuses calls of the importer from its callbacks */
        status = make_ready(unit, 1);
        unit->busy = 0;
        unit->ready = unit->ready && unit->settings[UNIT_STEP] > 0;
        *unit->mode = status == UNIT_OK ? UNIT_STEPPING : UNIT_INITIALIZATION;
        return status;
    }
    for (size_t k = 0; k < unit->n_switches; k++)
        unit->sides[k] = 0;
    for (size_t k = 0; k < unit->n_events; k++)
        unit->before[k] = 0;
    status = unit_update(unit, &ends);
    if (status == UNIT_OK)
        status = unit_bound_start(unit);
    if (status == UNIT_OK)
        *unit->mode = UNIT_EVENT;
    return status;
}

/* Copies the state of the integrator to the unit, and extrapolates the inputs to the time of the
 * integrator. */
static void take(struct unit *unit)
{
    *unit->time = unit->it.t;
    memcpy(unit->y, unit->it.q, unit->n_q * sizeof *unit->y);
    memcpy(unit_v(unit), unit->it.v, unit->n * sizeof *unit->y);
    unit_move_inputs(unit, unit->it.t);
    unit_forget(unit);
}

enum unit_status unit_step(struct unit *unit, double t, double length, struct unit_stepped *made)
{
    struct pk_integrator *const it = &unit->it;
    const double end = t + length;
    *made = (struct unit_stepped){*unit->time, 0, 0};
    if (!isfinite(end) || !(length >= 0))
        return unit_say(unit, UNIT_ERROR, "logStatusError",
                        "a step from t = %g of length %g is none that goes forward", t, length);
    if (fabs(t - *unit->time) > 1e-9 * (fabs(t) + length))
        return unit_say(unit, UNIT_ERROR, "logStatusError",
                        "the step begins at t = %.17g, but the unit is at t = %.17g", t,
                        *unit->time);
    enum unit_status status = unit_refresh(unit);
    if (status == UNIT_OK && unit->settings[UNIT_STEP] == 0 && length > 0 && unit->ready &&
        !(it->method->traits & PK_ADAPTIVE) && it->options.h != length)
        unit->ready = 0; /* the default step is the communication step */
    if (status == UNIT_OK && length > 0 && !unit->ready)
        status = make_ready(unit, length);
    if (status != UNIT_OK || length == 0)
        return status;
    for (long steps = 0; !pk_integrator_is_at(it, end); steps++) {
        if (steps == UNIT_MOST_STEPS)
            return unit_say(unit, UNIT_DISCARD, "logStatusDiscard",
                            "%ld steps did not reach t = %g: the unit is at t = %.17g", steps, end,
                            *unit->time);
        const enum pk_status found = pk_events_step(&unit->events, it, end);
        take(unit);
        made->t = it->t;
        if (found == PK_STOPPED_EVENT) {
            made->ends = 1;
            return UNIT_OK;
        }
        if (found != PK_DONE) {
            unit->ready = 0;
            return unit_said(unit, UNIT_DISCARD);
        }
        if (it->t - it->last_t > 0 && !pk_integrator_is_at(it, end))
            *unit->length = it->t - it->last_t;
        if (unit->stepped && unit->stepped(unit, it->t)) {
            made->early = !pk_integrator_is_at(it, end);
            if (made->early)
                return UNIT_OK;
        }
    }
    *unit->time = made->t = end;
    return UNIT_OK;
}

enum unit_status unit_early(const struct unit *unit)
{
    return unit_say(unit, UNIT_DISCARD, "logStatusDiscard",
                    "the event %s ends the motion at t = %g",
                    unit->system->events.table[unit->it.event - 1].what.name, *unit->time);
}

/* An FMU instance in model exchange: the importer integrates. The branches of the equations'
 * switches (abs, step, min, max) are constant between events, so that the importer integrates
 * smooth equations. */
#include "unit.h"

#include <math.h>
#include <string.h>

static double sign(double x) { return x > 0 ? 1 : x < 0 ? -1 : 0; }

/* Returns whether switch k is counted: its side is then 2 n + 1 (struct pk_system). */
static int counted(const struct unit *unit, size_t k)
{
    const struct pk_system *s = unit->system;
    return PK_SYSTEM_HAS(s, counted) && s->counted && s->counted[k];
}

/* Sets unit->sides to the signs of the switching functions. If a switching function is 0, its side
 * remains as it is. */
static enum unit_status take_sides(struct unit *unit)
{
    const struct pk_system *s = unit->system;
    unit_functions(unit);
    for (size_t k = 0; k < unit->n_switches; k++) {
        const double x = unit->indicators[unit->n_events + k];
        const double side = counted(unit, k) ? 2 * floor(x) + 1 : sign(x);
        const double old = unit->sides[k];
        if (side == 0 || side == old)
            continue;
        if (old != 0 && s->switches.impulses && s->switches.impulses[k])
            return unit_say(
                unit, UNIT_ERROR, "logStatusError",
                "rates jump where %s changes its sign, at t = %g: the unit does that in "
                "co-simulation, not in model exchange",
                s->switches.names[k].name, *unit->time);
        unit->sides[k] = side;
    }
    unit_hold_sides(unit);
    unit_forget(unit);
    return UNIT_OK;
}

/* Logs events that have occurred since the last call; sets *ends if one of them ends the motion. */
static void cross(struct unit *unit, int *ends)
{
    const struct pk_event *table = unit->system->events.table;
    unit_functions(unit);
    for (size_t k = 0; k < unit->n_events; k++) {
        const double now = sign(unit->indicators[k]), before = unit->before[k];
        if (before != 0 && now != before) {
            const int direction = before < 0 ? 1 : -1;
            if (!table[k].direction || table[k].direction == direction) {
                unit_say(unit, UNIT_OK, "logEvents", "%s at t = %.17g", table[k].what.name,
                         *unit->time);
                *ends |= table[k].stop;
            }
        }
        if (now != 0)
            unit->before[k] = now;
    }
}

/* Projects the state onto the constraints before the importer changes parameters in event mode. */
enum unit_status unit_enter_event(struct unit *unit)
{
    *unit->mode = UNIT_EVENT;
    const enum unit_status status = unit_refresh(unit);
    return status == UNIT_OK ? unit_bound_return(unit) : status;
}

enum unit_status unit_update(struct unit *unit, int *ends)
{
    *ends = 0;
    enum unit_status status = unit_refresh(unit);
    if (status == UNIT_OK && *unit->mode == UNIT_EVENT)
        status = unit_bound_return(unit);
    if (status == UNIT_OK)
        cross(unit, ends);
    return status == UNIT_OK ? take_sides(unit) : status;
}

enum unit_status unit_completed(struct unit *unit, int *event)
{
    unit_functions(unit);
    for (size_t k = 0; k < unit->n_events; k++)
        if (unit->before[k] == 0) /* the event function was 0 at the start: not a crossing */
            unit->before[k] = sign(unit->indicators[k]);
    return unit_bound_off(unit, event);
}

enum unit_status unit_set_time(struct unit *unit, double t)
{
    if (!isfinite(t))
        return unit_say(unit, UNIT_ERROR, "logStatusError", "the time is not finite");
    *unit->time = t;
    unit_forget(unit);
    return UNIT_OK;
}

/* Fails unless n, the number of values given, is `wanted`; otherwise calls unit_refresh(). */
static enum unit_status right(struct unit *unit, const void *values, size_t n, size_t wanted)
{
    if (n == wanted && (values || !n))
        return unit_refresh(unit);
    return unit_say(unit, UNIT_ERROR, "logStatusError", "%zu numbers are given, not %zu",
                    values ? n : 0, wanted);
}

enum unit_status unit_set_states(struct unit *unit, const double *x, size_t n)
{
    enum unit_status status = right(unit, x, n, unit->n_x);
    if (status != UNIT_OK)
        return status;
    for (size_t i = 0; i < n; i++)
        if (!isfinite(x[i]))
            return unit_say(unit, UNIT_DISCARD, "logStatusDiscard",
                            "state %zu is not finite at t = %g", i, *unit->time);
    memcpy(unit->y, x, n * sizeof *x);
    unit_forget(unit);
    return UNIT_OK;
}

enum unit_status unit_get_states(struct unit *unit, double *x, size_t n)
{
    const enum unit_status status = right(unit, x, n, unit->n_x);
    if (status == UNIT_OK)
        memcpy(x, unit->y, n * sizeof *x);
    return status;
}

enum unit_status unit_derivatives(struct unit *unit, double *rates, size_t n)
{
    enum unit_status status = right(unit, rates, n, unit->n_x);
    if (status == UNIT_OK)
        status = unit_rates(unit);
    if (status != UNIT_OK)
        return status;
    memcpy(rates, unit_v(unit), unit->n_q * sizeof *rates);
    memcpy(rates + unit->n_q, unit->values[PK_HOST_ACCELERATIONS], unit->n * sizeof *rates);
    return UNIT_OK;
}

enum unit_status unit_indicators(struct unit *unit, double *values, size_t n)
{
    enum unit_status status = right(unit, values, n, unit->n_events + unit->n_switches);
    if (status == UNIT_OK)
        status = unit_functions(unit);
    if (status == UNIT_OK && n)
        memcpy(values, unit->indicators, n * sizeof *values);
    for (size_t k = 0; status == UNIT_OK && k < unit->n_switches; k++)
        if (counted(unit, k)) { /* positive between n and n + 1, negative elsewhere */
            const double off = values[unit->n_events + k] - unit->sides[k] / 2;
            values[unit->n_events + k] = 0.25 - off * off;
        }
    return status;
}

/* A unit in model exchange with constraints or unit quaternions. An importer knows neither, and its
 * states drift off the constraints. If the drift after a step exceeds a multiple of the tolerance,
 * the unit requests an event, and projects the state onto the constraints. The runtime's
 * integrator serves only for its projection. It is initialised at the anchor, the last state that
 * satisfied the constraints. */
#include "unit.h"

#include <math.h>
#include <string.h>

#include <pk/constraint.h>

/* indices into unit->anchor of: a flag whether a projection moved the state, the time, the first
 * component of the state */
enum { MOVED, TIME, PLACE };

int unit_bound(const struct unit *unit)
{
    return !unit->co_simulation &&
           (unit->system->constraints.n > 0 || pk_system_rotations(unit->system, unit->params) > 0);
}

size_t unit_anchor_size(const struct unit *unit)
{
    return unit_bound(unit) ? PLACE + unit->n_x + unit->n_inputs : 0;
}

/* Initialises the integrator at the anchor, the last time and state that the importer has set. Fails if the anchor violates the constraints, as it may
 * after a change of parameters. */
static enum unit_status begin(struct unit *unit)
{
    const double *const at = unit->anchor + PLACE;
    enum unit_status status;
    if (unit->ready)
        return UNIT_OK;
    unit->given = at + unit->n_x;
    status = unit_integrator(unit, 1, unit->anchor[TIME], at);
    unit->given = NULL;
    unit->ready = status == UNIT_OK;
    return status;
}

static void anchor(struct unit *unit, const double *y)
{
    unit->anchor[TIME] = *unit->time;
    memcpy(unit->anchor + PLACE, y, unit->n_x * sizeof *y);
    memcpy(unit->anchor + PLACE + unit->n_x, unit->inputs, unit->n_inputs * sizeof *y);
}

enum unit_status unit_bound_start(struct unit *unit)
{
    if (!unit_bound(unit))
        return UNIT_OK;
    anchor(unit, unit->y);
    return begin(unit);
}

/* The largest tolerated drift, in units of rtol. A larger drift causes an event, and importers
 * restart after an event with short steps of low order. With CVode, the energy of a double pendulum
 * of rods drifts by 7e-3 if MOST_OFF is 100, by 5e-2 if it is 1, and by 0.17 without such
 * events. */
static const double MOST_OFF = 100;

/* Returns whether the states a and b differ by more than MOST_OFF rtol (1 + |b|) in some
 * component. */
static int apart(const struct unit *unit, const double *a, const double *b)
{
    double most = 0;
    for (size_t i = 0; i < unit->n_x; i++)
        most = fmax(most, fabs(a[i] - b[i]) / (1 + fabs(b[i])));
    return most > MOST_OFF * unit->settings[UNIT_RTOL];
}

/* Writes the projected state to unit->near. Sets *off to whether the projected state differs from
 * the current state by more than the tolerated drift. */
static enum unit_status look(struct unit *unit, int *off)
{
    *off = 0;
    const enum unit_status status = begin(unit);
    if (status != UNIT_OK)
        return status;
    memcpy(unit->near, unit->y, unit->n_x * sizeof *unit->y);
    const enum pk_status found =
        pk_constraint_project(&unit->it, *unit->time, unit->near, unit->near + unit->n_q);
    if (found < 0) {
        unit->ready = 0;
        unit->it.status = found;
        unit->it.t = *unit->time;
        return unit_said(unit, UNIT_ERROR);
    }
    *off = apart(unit, unit->y, unit->near);
    return UNIT_OK;
}

enum unit_status unit_bound_off(struct unit *unit, int *off)
{
    *off = 0;
    return unit_bound(unit) ? look(unit, off) : UNIT_OK;
}

enum unit_status unit_bound_return(struct unit *unit)
{
    int off;
    if (!unit_bound(unit))
        return UNIT_OK;
    const enum unit_status status = look(unit, &off);
    if (status != UNIT_OK)
        return status;
    anchor(unit, unit->near);
    if (off) {
        memcpy(unit->y, unit->near, unit->n_x * sizeof *unit->y);
        unit->anchor[MOVED] = 1;
        unit_forget(unit);
    }
    return UNIT_OK;
}

int unit_moved(struct unit *unit)
{
    const int moved = unit_bound(unit) && unit->anchor[MOVED] != 0;
    if (moved)
        unit->anchor[MOVED] = 0;
    return moved;
}

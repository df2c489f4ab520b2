/* The action of a run with one degree of freedom, at the start and at rows. The action at a row is
 * that of the orbit with the energy of this row, if t in L is held constant. If L depends slowly on
 * t, the action is an adiabatic invariant. */

#include "parts.h"

enum { ROWS = 200 };

static struct pk_action action_at(struct pk_run *run, pk_real t, const pk_real *q, const pk_real *v,
                                  pk_real *u)
{
    struct pk_action found;
    if (run->problem.input)
        run->problem.input(run->problem.context, t, u);
    pk_action_find(&found, &run->problem, t, q, v, u);
    return found;
}

/* Writes rows [t, action, period] until the kind of the orbit changes, as from libration to
 * rotation. */
static void rows(struct pk_run *run, struct diagnostics *d, enum pk_orbit orbit, pk_real *u)
{
    const size_t count = d->n_rows < ROWS ? d->n_rows : ROWS;
    struct json *j = &d->json;
    struct pk_drift drift;
    struct pk_action at = {.orbit = orbit};
    pk_drift_init(&drift);
    json_open(j, "rows", '[');
    for (size_t k = 0; k < count && at.orbit == orbit; k++) {
        const pk_real *x = diagnose_row(d, k, count); /* the row: t, then q, then v */
        at = action_at(run, x[0], x + 1, x + 2, u);
        if (run_stopped(run, (double)k / (double)count))
            break;
        const int same = at.orbit == orbit;
        const pk_real numbers[] = {x[0], same ? at.action : PK_INFINITY,
                                   same ? at.period : PK_INFINITY};
        json_numbers(j, NULL, numbers, 3);
        if (same)
            pk_drift_update(&drift, x[0], at.action);
    }
    json_close(j, ']');
    json_text(j, "changes", at.orbit == orbit ? NULL : pk_orbit_text(at.orbit));
    report_drift(j, "drift", "action", &drift);
}

void diagnose_action(struct pk_run *run, struct diagnostics *d)
{
    const struct settings *s = &run->settings;
    pk_real *u = memory_take(&run->memory, run->problem.system->n_inputs, sizeof *u);
    const struct pk_action found = action_at(run, 0, s->q, s->v, u);
    const int periodic = found.orbit <= PK_ORBIT_ROTATION;
    const int turns = found.orbit == PK_ORBIT_ROTATION;
    const pk_real lo = turns ? s->q[0] : found.lo, hi = turns ? s->q[0] + 2 * PK_PI : found.hi;
    const int kinked = periodic && diagnose_kink(run, &lo, &hi);
    const size_t coordinates = pk_system_coordinates(run->problem.system, s->params);
    char reason[200];
    if (diagnose_not_free(run->problem.system))
        strcpy(reason, diagnose_not_free(run->problem.system));
    else if (found.orbit == PK_ORBIT_SEVERAL && run->problem.system->n_first_order)
        snprintf(reason, sizeof reason,
                 "coordinates and states: %zu and %zu; it is of one coordinate and no states%s",
                 coordinates, s->n - coordinates,
                 coordinates ? ": name it alone, in a scene whose reductions leave that" : "");
    else if (kinked)
        strcpy(reason,
               "the equations have a kink (abs, min, max, step) on its way, across which its "
               "sums do not hold");
    else if (found.orbit == PK_ORBIT_SEVERAL)
        snprintf(reason, sizeof reason,
                 "%zu coordinates: it is of one degree of freedom; name it alone, in a scene whose "
                 "reductions leave one",
                 s->n);
    else
        snprintf(reason, sizeof reason, "%s", pk_orbit_text(found.orbit));
    const enum pk_status status = kinked || found.orbit >= PK_ORBIT_SEVERAL ? PK_REFUSED : PK_DONE;
    if (diagnose_told(d, status, reason, NULL)) {
        struct json *j = &d->json;
        const int swings = found.orbit == PK_ORBIT_LIBRATION;
        json_text(j, "orbit", pk_orbit_text(found.orbit));
        json_reals(j, {"action", periodic ? found.action : PK_INFINITY},
                   {"period", periodic ? found.period : PK_INFINITY},
                   {"frequency", periodic ? 2 * PK_PI / found.period : PK_INFINITY},
                   {"error", periodic ? found.error : PK_INFINITY},
                   {"lo", swings ? found.lo : PK_INFINITY},
                   {"hi", swings ? found.hi : PK_INFINITY});
        json_integer(j, "nodes", found.nodes);
        json_flag(j, "held", !(run->problem.system->facts & PK_AUTONOMOUS));
        json_flag(j, "of_forces", !(run->problem.system->facts & PK_VARIATIONAL));
        if (periodic && d->rows)
            rows(run, d, found.orbit, u);
    }
}

/* The action of a run with one degree of freedom, at the start and at rows. The action at a row is
 * that of the orbit with the energy of this row, if t in L is held constant. If L depends slowly on
 * t, the action is an adiabatic invariant. */

#include "parts.h"

enum { ROWS = 200 };

static struct action action_at(struct pk_run *run, pk_real t, const pk_real *q, const pk_real *v,
                               pk_real *u)
{
    struct action found;
    if (run->problem.input)
        run->problem.input(run->problem.context, t, u);
    action_find(&found, &run->problem, t, q, v, u);
    return found;
}

/* Writes rows [t, action, period] until the kind of the orbit changes, as to rotation. */
static void rows(struct diagnostics *d, enum orbit orbit, pk_real *u)
{
    const size_t count = d->n_rows < ROWS ? d->n_rows : ROWS;
    struct json *j = &d->json;
    struct pk_drift drift;
    struct action at = {.orbit = orbit};
    pk_drift_init(&drift);
    json_open(j, "rows", '[');
    for (size_t k = 0; k < count && at.orbit == orbit; k++) {
        const pk_real *x = diagnose_row(d, k, count); /* the row: t, then q, then v */
        at = action_at(d->run, x[0], x + 1, x + 2, u);
        if (run_stopped(d->run, (double)k / (double)count))
            break;
        const int same = at.orbit == orbit;
        json_numbers(
            j, NULL,
            (const pk_real[]){x[0], same ? at.action : PK_INFINITY, same ? at.period : PK_INFINITY},
            3);
        if (same)
            pk_drift_update(&drift, x[0], at.action);
    }
    json_close(j, ']');
    json_text(j, "changes", at.orbit == orbit ? NULL : orbit_text(at.orbit));
    report_drift(j, "drift", "action", &drift);
}

void diagnose_action(struct diagnostics *d)
{
    const struct settings *s = &d->run->settings;
    const struct pk_system *system = d->run->problem.system;
    pk_real *u = memory_take(&d->run->memory, system->n_inputs, sizeof *u);
    const struct action found = action_at(d->run, 0, s->q, s->v, u);
    const int swings = found.orbit == LIBRATION, turns = found.orbit == ROTATION;
    const int periodic = swings || turns;
    const pk_real lo = turns ? s->q[0] : found.lo, hi = turns ? s->q[0] + 2 * PK_PI : found.hi;
    const int kinked = periodic && diagnose_kink(d->run, &lo, &hi);
    const size_t coordinates = settings_coordinates(s);
    const char *reason = diagnose_not_free(system);
    char several[200];
    if (system->n_first_order)
        snprintf(several, sizeof several,
                 "coordinates and states: %zu and %zu; it is of one coordinate and no states%s",
                 coordinates, s->n - coordinates,
                 coordinates ? ": name it alone, in a scene whose reductions leave that" : "");
    else
        snprintf(several, sizeof several,
                 "%zu coordinates: it is of one degree of freedom; name it alone, in a scene whose "
                 "reductions leave one",
                 s->n);
    if (!reason)
        reason = kinked ? "the equations have a kink (abs, min, max, step) on its way, across "
                          "which its sums do not hold"
                 : found.orbit == SEVERAL ? several
                                          : orbit_text(found.orbit);
    if (!diagnose_told(d, kinked || found.orbit >= SEVERAL ? PK_REFUSED : PK_DONE, reason, NULL))
        return;
    struct json *j = &d->json;
    json_text(j, "orbit", orbit_text(found.orbit));
    json_reals(j, {"action", periodic ? found.action : PK_INFINITY},
               {"period", periodic ? found.period : PK_INFINITY},
               {"frequency", periodic ? 2 * PK_PI / found.period : PK_INFINITY},
               {"error", periodic ? found.error : PK_INFINITY},
               {"lo", swings ? found.lo : PK_INFINITY}, {"hi", swings ? found.hi : PK_INFINITY});
    json_integer(j, "nodes", found.nodes);
    json_flag(j, "held", !(system->facts & PK_AUTONOMOUS));
    json_flag(j, "of_forces", !(system->facts & PK_VARIATIONAL));
    if (periodic && d->rows)
        rows(d, found.orbit, u);
}

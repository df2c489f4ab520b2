/* Drifts of constants of the motion: energy, momenta of cyclic coordinates, declared constants. */
#include "observers.h"

#define LARGE PK_C(0.1) /* relative drift that counts as large */

/* Drifts are measured at each of the first ALL steps, and later so rarely that this adds 5 % to the
 * time of the steps: one measurement costs about three evaluations of the forces. */
enum { ALL = 1024, STEPS_BY_ONE = 60 };

void drift_begin(struct pk_run *run, const struct pk_problem *problem)
{
    const size_t size = pk_monitor_size(problem);
    if (run->settings.asked.watch < 0 && !run->settings.asked.n_drifts)
        return;
    if (!run->monitor_block)
        run->monitor_block = memory_take(&run->memory, size, 1);
    pk_monitor_init(&run->monitor, problem, run->monitor_block, size);
    run->monitor.has_energy |= expect_uses_h(run);
}

static void step(struct pk_run *run, const struct moment *at)
{
    const struct pk_counters *count = &run->it.count;
    run->looked = run->monitor_block && count->steps >= run->look_at;
    if (!run->looked)
        return;
    pk_monitor_update(&run->monitor, at->t, at->q, at->v);
    if (count->steps >= ALL && !run->settings.asked.n_drifts)
        run->look_at = count->steps + STEPS_BY_ONE * count->steps / (count->evaluations + 1);
}

static void end(struct pk_run *run)
{
    const int looked = run->looked;
    run->look_at = 0;
    if (!looked && run->monitor_block)
        step(run, &run->now);
}

void report_drift(struct json *j, const char *key, const char *name, const struct pk_drift *drift)
{
    pk_real exponent, spread;
    const enum pk_growth growth = pk_drift_growth(drift, &exponent, &spread);
    /* A bounded drift may still be large. */
    const int far = growth == PK_GROWTH_BOUNDED && pk_drift_max(drift) > LARGE;
    json_open(j, key, '{');
    json_text(j, "name", name);
    json_reals(j, {"max", pk_drift_max(drift)}, {"final", pk_drift_final(drift)},
               {"slope", pk_drift_slope(drift)});
    /* max, final and slope are relative to `scale`. If that is round-off, the drift is too. */
    json_reals(j, {"scale", drift->scale}, {"first", drift->first}, {"exponent", exponent},
               {"spread", spread});
    json_text(j, "growth", far ? "off by more than a tenth" : pk_growth_text(growth));
    json_close(j, '}');
}

static void report(const struct pk_run *run, struct json *j)
{
    const struct pk_system *system = run->problem.system;
    const struct pk_monitor *m = &run->monitor;
    json_open(j, "drifts", '[');
    if (m->has_energy)
        report_drift(j, NULL, "energy", &m->energy);
    for (size_t i = 0; m->momenta && i < run->settings.n; i++)
        if (system->cyclic && system->cyclic[i])
            report_drift(j, NULL, system->momenta[i].name, &m->momenta[i]);
    for (size_t i = 0; m->conserved && i < system->n_conserved; i++)
        report_drift(j, NULL, system->conserved[i].name, &m->conserved[i]);
    json_close(j, ']');
}

/* The monitor of an ensemble is not saved, since it starts anew for each member. */
static void keep(struct pk_run *run, struct pk_keep *k)
{
    if (run->monitor_block && !run->settings.asked.members)
        pk_monitor_keep(&run->monitor, k);
    PK_KEEP(k, run->look_at);
    PK_KEEP(k, run->looked);
}

const struct observer drift_observer = {.step = step, .end = end, .report = report, .keep = keep};

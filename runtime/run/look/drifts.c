/* Drifts of what is constant: the energy, momenta of cyclic coordinates, the author's claims. */
#include "drifts.h"

#include "../base/json.h"
#include "expect.h"
#include "observer.h"

#define LARGE PK_C(0.1) /* a drift, of its scale */

void drift_begin(struct run *run, const struct pk_problem *problem)
{
    const size_t size = pk_monitor_size(problem);
    if (!run->monitor_block)
        run->monitor_block = memory_take(&run->memory, size, 1);
    pk_monitor_init(&run->monitor, problem, run->monitor_block, size);
    run->monitor.has_energy |= expect_uses_h(run);
}

static void step(struct run *run, const struct moment *at)
{
    if (run->monitor_block)
        pk_monitor_update(&run->monitor, at->t, at->q, at->v);
}

void report_drift(FILE *file, const char *name, const struct pk_drift *drift)
{
    fputs("{\"name\": ", file);
    report_text(file, name);
    fputs(", \"max\": ", file);
    report_real(file, pk_drift_max(drift));
    fputs(", \"final\": ", file);
    report_real(file, pk_drift_final(drift));
    fputs(", \"slope\": ", file);
    report_real(file, pk_drift_slope(drift));
    /* What the three are relative to: where it is round-off, so is the drift. */
    fputs(", \"scale\": ", file);
    report_real(file, drift->scale);
    pk_real exponent, spread;
    const enum pk_growth growth = pk_drift_growth(drift, &exponent, &spread);
    fputs(", \"first\": ", file);
    report_real(file, drift->first);
    fputs(", \"exponent\": ", file);
    report_real(file, exponent);
    fputs(", \"spread\": ", file);
    report_real(file, spread);
    fputs(", \"growth\": ", file);
    /* That a drift grows no more does not make it small. */
    const int far = growth == PK_GROWTH_BOUNDED && pk_drift_max(drift) > LARGE;
    report_text(file, far ? "off by more than a tenth" : pk_growth_text(growth));
    fputs("}", file);
}

static void report(const struct run *run, FILE *file)
{
    const struct pk_system *system = run->problem.system;
    const struct pk_monitor *m = &run->monitor;
    int first = 1;
    fputs("  \"drifts\": [", file);
    if (m->has_energy) {
        report_drift(file, "energy", &m->energy);
        first = 0;
    }
    for (size_t i = 0; m->momenta && i < run->settings.n; i++)
        if (system->cyclic && system->cyclic[i]) {
            fputs(first ? "" : ", ", file);
            first = 0;
            report_drift(file, system->momenta[i].name, &m->momenta[i]);
        }
    for (size_t i = 0; m->conserved && i < system->n_conserved; i++) {
        fputs(first ? "" : ", ", file);
        first = 0;
        report_drift(file, system->conserved[i].name, &m->conserved[i]);
    }
    fputs("]", file);
}

const struct observer drift_observer = {.step = step, .report = report};

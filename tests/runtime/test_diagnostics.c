/* Drifts against their definitions, on data with known answers and on a run. */
#include "fixture.h"

static void definitions(void)
{
    struct pk_drift d;
    pk_drift_init(&d);
    CU_ASSERT(pk_drift_max(&d) == 0 && pk_drift_slope(&d) == 0);
    for (int i = 0; i <= 1000; i++) { /* X = 4 + t/8 + wiggle */
        const double t = 1e6 + 0.01 * i;
        pk_drift_update(&d, t, 4 + (t - 1e6) / 8 + 1e-3 * (i % 2));
    }
    CU_ASSERT(fabs(pk_drift_max(&d) - 1.25 / 5.25) < 1e-3);
    CU_ASSERT(fabs(pk_drift_final(&d) - 1.25 / 5.25) < 1e-9);
    CU_ASSERT(fabs(pk_drift_slope(&d) - 0.125 / 5.25) < 1e-6);
    pk_drift_init(&d);
    pk_drift_update_scaled(&d, 0, 0.0, 2);
    pk_drift_update_scaled(&d, 1, -1.0, 8);
    CU_ASSERT(pk_drift_max(&d) == 0.125 && pk_drift_final(&d) == -0.125);
    pk_drift_update(&d, 2, (double)NAN); /* must show */
    CU_ASSERT(!(pk_drift_max(&d) <= 1));
    pk_drift_update(&d, 3, 2.0); /* and go on to show */
    CU_ASSERT(!(pk_drift_max(&d) <= 1));
    pk_drift_init(&d); /* whatever its scale */
    pk_drift_update_scaled(&d, 0, 1.0, 8);
    pk_drift_update_scaled(&d, 1, (double)NAN, 8);
    pk_drift_update_scaled(&d, 2, 2.0, 8);
    CU_ASSERT(!(pk_drift_max(&d) <= 1));
    pk_drift_init(&d); /* nor may an infinite scale divide a drift to nothing */
    pk_drift_update_scaled(&d, 0, 1.0, (double)INFINITY);
    pk_drift_update_scaled(&d, 1, 2.0, 1);
    CU_ASSERT(!(pk_drift_max(&d) <= 1));
}

static void monitor(void)
{
    static struct fixture f;
    static const unsigned char cyclic[] = {1, 0};
    struct pk_system system = kepler_system;
    struct pk_monitor m;
    double block[200];
    system.cyclic = cyclic; /* a false claim, to see that drifts are seen */
    fixture_set(&f, &system);
    f.options.rtol = f.options.atol = 1e-9;
    fixture_init(&f, "dop853");
    CU_ASSERT_FATAL(pk_monitor_size(&f.problem) <= sizeof block);
    CU_ASSERT(pk_monitor_init(&m, &f.problem, block, 8) == PK_BLOCK_TOO_SMALL);
    CU_ASSERT(pk_monitor_init(&m, &f.problem, block, pk_monitor_size(&f.problem)) == PK_DONE);
    pk_monitor_update(&m, 0, f.it.q, f.it.v);
    while (f.it.t < 20) {
        CU_ASSERT_FATAL(pk_integrator_step(&f.it, 20) == PK_DONE);
        pk_monitor_update(&m, f.it.t, f.it.q, f.it.v);
    }
    CU_ASSERT(m.has_energy);
    const double e = pk_drift_max(&m.energy), l = pk_drift_max(&m.conserved[0]);
    printf("\n    Kepler, dop853 at 1e-9: energy %.1e, angular momentum %.1e", e, l);
    CU_ASSERT(e > 1e-13 && e < 1e-7);
    CU_ASSERT(l > 1e-13 && l < 1e-7);
    CU_ASSERT(pk_drift_max(&m.momenta[0]) > 0.5);
    CU_ASSERT(m.momenta[1].samples == 0);
    f.problem.system = &driven_system;
    CU_ASSERT(pk_monitor_init(&m, &f.problem, block, sizeof block) == PK_DONE && !m.has_energy);
}

void add_diagnostics(void)
{
    CU_pSuite suite = CU_add_suite("diagnostics", NULL, NULL);
    CU_add_test(suite, "definitions", definitions);
    CU_add_test(suite, "monitor", monitor);
}

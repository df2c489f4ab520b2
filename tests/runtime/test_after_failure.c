/* After a step that failed, nothing of it is left: no dense output of a mixture of two steps, and
 * who goes on from the last valid state with another step goes on as from a new start there.
 */
#include "fixture.h"

static struct fixture f;

TEST("no dense output")
{
    static const char *const names[] = {"dopri5", "dop853", "gauss"};
    for (int i = 0; i < 3; i++) {
        double q, v;
        CU_ASSERT(fixture_run(&f, &folded_system, names[i], 0, 0.5) == PK_DONE);
        const double inside = (f.it.last_t + f.it.t) / 2;
        CU_ASSERT(pk_integrator_dense(&f.it, inside, &q, &v) == PK_DONE && q > f.q0[0]);
        const enum pk_status status = pk_integrator_to(&f.it, 10);
        CU_ASSERT(status < 0);
        const double t = f.it.t, last = f.it.q[0];
        q = v = 2.385;
        CU_ASSERT(pk_integrator_dense(&f.it, t, &q, &v) == PK_BAD_ARGUMENT);
        CU_ASSERT(q == 2.385 && v == 2.385);
        CU_ASSERT(pk_integrator_step(&f.it, 10) == status); /* tried again, it fails again */
        CU_ASSERT(f.it.t == t && f.it.q[0] == last);
    }
}

/* `broken` is no number from t = 1.25 on: a step over it fails, a shorter one up to it does not. */
TEST("going on")
{
    static struct fixture fresh;
    static const char *const names[] = {"verlet", "yoshida4", "rk4",   "gauss2",   "gauss8",
                                        "dopri5", "dop853",   "gauss", "gsl_rk8pd"};
    for (int i = 0; i < 9; i++) {
        const int adaptive = i >= 5;
        fixture_set(&f, &broken_system);
        f.params.limit = 1.25;
        f.options.h = adaptive ? 0 : 0.2;
        f.options.atol = f.options.rtol;
        fixture_start(&f, names[i], 0);
        CU_ASSERT(pk_integrator_to(&f.it, 2) < 0 && f.it.t > 0.5);
        fixture_set(&fresh, &broken_system);
        fresh.params.limit = 1.25;
        fresh.options.h = 0.01;
        fresh.options.atol = f.options.atol;
        fresh.q0[0] = f.it.q[0];
        fresh.v0[0] = f.it.v[0];
        const struct pk_method *m = fresh.it.method = f.it.method;
        CU_ASSERT(pk_integrator_init(&fresh.it, &fresh.problem, m, &fresh.options, f.it.t, fresh.q0,
                                     fresh.v0, fresh.block,
                                     pk_integrator_size(&fresh.problem, m)) == PK_DONE);
        CU_ASSERT(pk_integrator_set_step(&f.it, 0.01) == PK_DONE);
        const double end = f.it.t + (adaptive ? -0.3 : 0.03); /* back, or nearer to the end */
        CU_ASSERT(pk_integrator_to(&f.it, end) == PK_DONE);
        CU_ASSERT(pk_integrator_to(&fresh.it, end) == PK_DONE);
        CU_ASSERT(fabs(f.it.q[0] - fresh.it.q[0]) < 1e-14 * (1 + fabs(f.it.q[0])));
        CU_ASSERT(fabs(f.it.v[0] - fresh.it.v[0]) < 1e-14 * (1 + fabs(f.it.v[0])));
        pk_integrator_free(&f.it);
        pk_integrator_free(&fresh.it);
    }
}

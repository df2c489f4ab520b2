/* Measured order on the nonlinear pendulum (a linear one super-converges), and with explicit time
 * and M(q, v); tolerance against error. Dense output: test_dense.c and test_tables.c.
 */
#include "fixture.h"

static struct fixture f;

/* All of the core up to order 6; above it errors reach round-off too soon, and quad/order.c goes
 * on. Of GSL's those that have an order. */
TEST("fixed steps on the pendulum")
{
    int found = 0;
    for (size_t i = 0; pk_method_at(i); i++) {
        const struct pk_method *m = pk_method_at(i);
        if (m->order > 6 || (m->traits & (PK_EXACT | PK_JETS)))
            continue;
        const double p = fixture_order_beside(&pendulum_system, m, 2, 3e-13, "gauss4", 4000);
        printf("\n    %-16s order %d, measured %.3f", m->name, m->order, p);
        CU_ASSERT(fabs(p - m->order) < 0.15);
        found++;
    }
    CU_ASSERT(found >= 18);
}

TEST("order of GSL's")
{
    for (size_t i = 0; pk_gsl_method_at(i); i++) {
        const struct pk_method *m = pk_gsl_method_at(i);
        if (!m->order)
            continue;
        const double p = fixture_order_beside(&pendulum_system, m, 2, 3e-13, "gauss4", 4000);
        printf("\n    %-16s order %d, measured %.3f", m->name, m->order, p);
        /* GSL is of double alone, and order 8 at round-off before its slope has settled. */
        CU_ASSERT(fabs(p - m->order) < (m->order < 8 ? 0.15 : 0.45));
    }
}

TEST("explicit time")
{
    /* Verlet keeps its order only if its kicks are at the right times. */
    for (size_t i = 0; pk_method_at(i); i++) {
        const struct pk_method *m = pk_method_at(i);
        if (m->order > 6 || (m->needs & (PK_AUTONOMOUS | PK_AFFINE)) ||
            !(m->traits & PK_SYMPLECTIC))
            continue;
        const double p = fixture_order_beside(&driven_system, m, 3, 3e-13, "gauss4", 4000);
        printf("\n    driven, %-16s measured %.3f", m->name, p);
        CU_ASSERT(fabs(p - m->order) < 0.15);
    }
    double q, v;
    driven_exact(3, &q, &v);
    CU_ASSERT(fixture_run(&f, &driven_system, "gauss4", 0.003, 3) == PK_DONE);
    CU_ASSERT(fixture_distance(&f, &q, &v) < 1e-13);
    CU_ASSERT(fixture_run(&f, &driven_system, "verlet", 0.003, 3) == PK_DONE);
    CU_ASSERT(fixture_distance(&f, &q, &v) > 1e-9);
}

TEST("M(q) and M(v)")
{
    static const struct pk_system *const systems[] = {&double_pendulum_system, &relativistic_system,
                                                      &forced_system};
    static const char *const names[] = {"rk4",      "gauss1",   "gauss2",   "gauss3",
                                        "lobatto2", "lobatto3", "lobatto4", "radau5"};
    for (size_t s = 0; s < 3; s++)
        for (size_t i = 0; i < 8; i++) {
            const double p = fixture_order_beside(systems[s], pk_method_find(names[i]), 1, 3e-13,
                                                  "gauss4", 4000);
            printf("\n    %s, %-7s measured %.3f", systems[s]->name, names[i], p);
            CU_ASSERT(fabs(p - pk_method_find(names[i])->order) < 0.15);
        }
}

TEST("error follows the tolerance")
{
    static const char *const names[] = {"dopri5",    "dop853",      "gsl_rkf45",
                                        "gsl_rk8pd", "gsl_msadams", "gsl_msbdf"};
    double q[2], v[2];
    CU_ASSERT(fixture_run(&f, &pendulum_system, "gauss4", 0.002, 10) == PK_DONE);
    memcpy(q, f.it.q, sizeof *q);
    memcpy(v, f.it.v, sizeof *v);
    for (size_t i = 0; i < 6; i++) {
        double tol[8], error[8], last = 1;
        int count = 0;
        for (double t = 1e-4; t > 5e-12; t /= 10) {
            CU_ASSERT(fixture_run(&f, &pendulum_system, names[i], t, 10) == PK_DONE);
            CU_ASSERT(f.it.t == 10);
            tol[count] = t;
            error[count] = fixture_distance(&f, q, v);
            CU_ASSERT(error[count] > 0 && error[count] < 2e4 * t);
            last = error[count++];
            pk_integrator_free(&f.it);
        }
        const double slope = fit_slope(tol, error, count);
        printf("\n    %-11s error ~ tol^%.2f, %.1e at tol 1e-11", names[i], slope, last);
        CU_ASSERT(slope > 0.75 && slope < 1.2);
    }
}

/* GSL's bsimp: extrapolates so far that its errors are far below any tolerance, and says nothing
 * of it; so it is only that they stay there. */
TEST("extrapolation")
{
    static const struct pk_system *const systems[] = {&pendulum_system, &driven_system,
                                                      &double_pendulum_system};
    for (size_t s = 0; s < 3; s++) {
        double q[2], v[2];
        CU_ASSERT(fixture_run(&f, systems[s], "gauss4", 0.002, 4) == PK_DONE);
        memcpy(q, f.it.q, f.it.n * sizeof *q);
        memcpy(v, f.it.v, f.it.n * sizeof *v);
        CU_ASSERT(fixture_run(&f, systems[s], "gsl_bsimp", 1e-8, 4) == PK_DONE);
        const double e = fixture_distance(&f, q, v);
        printf("\n    gsl_bsimp, %s: %.1e at 1e-8, %lu steps", systems[s]->name, e,
               f.it.count.steps);
        CU_ASSERT(e > 0 && e < 1e-5 && f.it.count.steps < 60 && f.it.count.jacobians > 0);
        pk_integrator_free(&f.it);
    }
}

/* q'' = -1e6 q + cos 3t near its slow solution: with the right Jacobian implicit methods take the
 * forcing's steps, explicit ones the oscillator's. */
TEST("stiff")
{
    static const char *const names[] = {"gsl_msbdf", "gsl_bsimp", "gsl_rk8pd", "gsl_msadams"};
    for (int i = 0; i < 4; i++) {
        fixture_set(&f, &driven_system);
        f.params.g = 1e6;
        f.q0[0] = 1e-6, f.v0[0] = 0;
        f.options.rtol = 0, f.options.atol = 1e-5;
        fixture_start(&f, names[i], 0);
        CU_ASSERT(pk_integrator_to(&f.it, 5) == PK_DONE);
        printf("\n    %s: %lu steps", names[i], f.it.count.steps);
        CU_ASSERT(i < 2 ? f.it.count.steps < 50 : f.it.count.steps > 500);
        CU_ASSERT(fabs(f.it.q[0] - cos(15) / (1e6 - 9)) < 1e-5);
        pk_integrator_free(&f.it);
    }
}

/* Hamilton's principle: stationary along a motion and nowhere else, a minimum up to the first
 * conjugate point, which oscillator and circular orbit have in closed form.
 */
#include <stdlib.h>

#include "fixture.h"

static const double PI = 3.14159265358979323846;
static double block[1 << 20];

static enum pk_status find(struct pk_least_action *found, struct fixture *f, const char *method,
                           double step, double time, size_t panels, size_t modes)
{
    const struct pk_method *m = pk_method_find(method);
    f->options.h = m->traits & PK_ADAPTIVE ? 0 : step;
    f->options.rtol = f->options.atol = 1e-14;
    CU_ASSERT_FATAL(pk_least_action_size(&f->problem, m, panels, modes) <= sizeof block);
    return pk_least_action_find(found, &f->problem, m, &f->options, 0, f->q0, f->v0, time, panels,
                                modes, block, sizeof block);
}

/* lambda_k = 1 - (omega T/(k pi))^2, conjugate points at each half period, S = [q v]/2. */
TEST("an oscillator's second variation")
{
    enum { MODES = 20 };
    struct pk_least_action found;
    struct fixture f;
    double lambda[MODES], lowest[MODES], x[MODES] = {0};
    fixture_set(&f, &oscillator_system);
    f.params.g = 4;
    CU_ASSERT_FATAL(find(&found, &f, "gauss", 0, 10, 64, MODES) == PK_DONE);
    CU_ASSERT_DOUBLE_EQUAL(found.action, (found.it.q[0] * found.it.v[0] - 0.7 * 0.2) / 2, 1e-12);
    CU_ASSERT(fabs(found.action) > 0.01 && found.slope < 1e-11);
    CU_ASSERT_EQUAL_FATAL(found.n_conjugate, 6);
    for (int k = 1; k <= 6; k++)
        CU_ASSERT_DOUBLE_EQUAL(found.conjugate[k - 1], k * PI / 2, 1e-10);
    CU_ASSERT_FATAL(pk_gsl_least_action(&found, MODES, lambda, lowest) == PK_DONE);
    for (int k = 1; k <= MODES; k++)
        CU_ASSERT_DOUBLE_EQUAL(lambda[k - 1], 1 - pow(20 / (k * PI), 2), 1e-11);
    /* Its L is of second degree: along the lowest mode S has no other term. */
    for (int k = 0; k < MODES; k++)
        x[k] = 0.5 * lowest[k];
    CU_ASSERT_DOUBLE_EQUAL(pk_least_action_at(&found, x) - found.action, lambda[0] / 8, 1e-11);
    CU_ASSERT(pk_gsl_least_action(&found, MODES / 2, lambda, NULL) == PK_DONE);
    CU_ASSERT_DOUBLE_EQUAL(lambda[0], 1 - pow(20 / PI, 2), 1e-11);
    pk_least_action_free(&found);

    /* A minimum just before a half period, none just behind it. */
    for (int behind = 0; behind < 2; behind++) {
        CU_ASSERT_FATAL(find(&found, &f, "gauss", 0, PI / 2 + (behind ? 1e-3 : -1e-3), 16, 8) ==
                        PK_DONE);
        CU_ASSERT_EQUAL(found.n_conjugate, (size_t)behind);
        CU_ASSERT(pk_gsl_least_action(&found, 8, lambda, NULL) == PK_DONE);
        CU_ASSERT((lambda[0] < 0) == behind && lambda[1] > 0);
    }
}

/* A path that no motion takes is not stationary: rk4 at a long step. */
TEST("what is no motion is not stationary")
{
    struct pk_least_action found;
    struct fixture f;
    fixture_set(&f, &pendulum_system);
    CU_ASSERT_FATAL(find(&found, &f, "gauss", 0, 3, 32, 8) == PK_DONE);
    CU_ASSERT(found.slope < 1e-12);
    fixture_set(&f, &pendulum_system);
    CU_ASSERT_FATAL(find(&found, &f, "euler", 0.01, 3, 32, 8) == PK_DONE);
    CU_ASSERT(found.slope > 1e-3);
}

/* f(t) = 8 (1 - cos t) - 3 t sin t, the determinant of W. H. Clohessy and R. S. Wiltshire's
 * displacements from a circular orbit (J. Aerosp. Sci. 27 (1960) 653): 0 at 2 pi, and later. */
static double displaced(double t) { return 8 * (1 - cos(t)) - 3 * t * sin(t); }

TEST("conjugate points of a circular orbit")
{
    struct pk_least_action found;
    struct fixture f;
    double lambda[32], lo = 8.5, hi = 9.2;
    for (int k = 0; k < 60; k++) {
        const double middle = (lo + hi) / 2;
        if (displaced(lo) * displaced(middle) <= 0)
            hi = middle;
        else
            lo = middle;
    }
    fixture_set(&f, &kepler_system);
    f.params.g = 1;
    f.q0[0] = 1, f.q0[1] = 0;
    f.v0[0] = 0, f.v0[1] = 1;
    CU_ASSERT_FATAL(find(&found, &f, "dop853", 0, 9.5, 64, 16) == PK_DONE);
    CU_ASSERT_EQUAL_FATAL(found.n_conjugate, 2);
    CU_ASSERT_DOUBLE_EQUAL(found.conjugate[0], 2 * PI, 1e-8);
    CU_ASSERT_DOUBLE_EQUAL(found.conjugate[1], hi, 1e-8);
    CU_ASSERT(hi > 8.7 && hi < 8.9);
    CU_ASSERT_DOUBLE_EQUAL(found.action, 1.5 * 9.5, 1e-10); /* T - V = 1/2 + 1 */
    CU_ASSERT_FATAL(pk_gsl_least_action(&found, 16, lambda, NULL) == PK_DONE);
    CU_ASSERT(lambda[1] < 0 && lambda[2] > 0);
    pk_least_action_free(&found);
}

/* To second order in the neighbour: what is left falls by 8 as it is halved. M depends on q here.
 */
TEST("neighbours to second order")
{
    enum { MODES = 6, M = 2 * MODES };
    struct pk_least_action found;
    struct fixture f;
    double left[2];
    fixture_set(&f, &double_pendulum_system);
    CU_ASSERT_FATAL(find(&found, &f, "gauss", 0, 1.3, 32, MODES) == PK_DONE);
    for (int half = 0; half < 2; half++) {
        double a[M], expected = found.action;
        for (int i = 0; i < M; i++)
            a[i] = (half ? 5e-4 : 1e-3) * cos(2.3 * i + 0.4);
        for (int i = 0; i < M; i++)
            for (int j = 0; j < M; j++)
                expected += a[i] * found.C[i * M + j] * a[j] / 2;
        left[half] = pk_least_action_at(&found, a) - expected;
    }
    CU_ASSERT(fabs(left[0]) > 1e-10);
    CU_ASSERT_DOUBLE_EQUAL(left[0] / left[1], 8, 0.2);
}

TEST("refusals")
{
    struct pk_least_action found;
    struct fixture f;
    double lambda[8];
    struct pk_system forced = oscillator_system;
    fixture_set(&f, &forced);
    CU_ASSERT(find(&found, &f, "rk4", 0.1, 1, 8, 4) == PK_DONE);
    forced.facts &= ~(unsigned)PK_VARIATIONAL;
    CU_ASSERT(find(&found, &f, "rk4", 0.1, 1, 8, 4) == PK_REFUSED);
    CU_ASSERT(pk_gsl_least_action(&found, 4, lambda, NULL) == PK_BAD_ARGUMENT);
    fixture_set(&f, &oscillator_system);
    CU_ASSERT(find(&found, &f, "rk4", 0.1, -1, 8, 4) == PK_BAD_ARGUMENT);
    CU_ASSERT(pk_least_action_find(&found, &f.problem, pk_method_find("rk4"), &f.options, 0, f.q0,
                                   f.v0, 1, 8, 4, block, 8) == PK_BLOCK_TOO_SMALL);
    CU_ASSERT(pk_least_action_size(&f.problem, pk_method_find("rk4"), 0, 4) == 0);
}

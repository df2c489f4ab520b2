/* Hamilton's principle: stationary along a motion and nowhere else, a minimum up to the first
 * conjugate point, which oscillator and circular orbit have in closed form.
 */
#include "../../runtime/run/diagnose/motion.h"
#include "fixture.h"

static const double PI = 3.14159265358979323846;
static struct memory memory;

static enum pk_status find(struct least_action *found, struct fixture *f, const char *method,
                           double step, double time, size_t panels, size_t modes)
{
    struct motion m = {.problem = &f->problem,
                       .method = pk_method_find(method),
                       .options = f->options,
                       .end = time,
                       .q = f->q0,
                       .v = f->v0,
                       .memory = &memory};
    m.options.h = m.method->traits & PK_ADAPTIVE ? 0 : step;
    m.options.rtol = m.options.atol = 1e-14;
    return least_action_find(found, &m, panels, modes);
}

/* Returns whether the eigenvalues of `modes` modes are found. */
static int modes_of(const struct least_action *found, size_t modes, double *lambda, double *lowest)
{
    enum pk_status status;
    size_t below = 0;
    const size_t negative = least_action_eigenvalues(found, modes, lambda, lowest, &status);
    while (below < modes * found->n && lambda[below] < 0)
        below++;
    return status == PK_DONE && below == negative;
}

/* lambda_k = 1 - (omega T/(k pi))^2, conjugate points at each half period, S = [q v]/2. */
TEST("an oscillator's second variation")
{
    enum { MODES = 20 };
    struct least_action found;
    struct fixture f;
    double lambda[MODES], lowest[MODES], x[MODES] = {0};
    fixture_set(&f, &oscillator_system);
    f.params.g = 4;
    CU_ASSERT_FATAL(find(&found, &f, "gauss", 0, 10, 64, MODES) == PK_DONE);
    CU_ASSERT_DOUBLE_EQUAL(
        found.action,
        (found.variation.motion.it.q[0] * found.variation.motion.it.v[0] - 0.7 * 0.2) / 2, 1e-12);
    CU_ASSERT(fabs(found.action) > 0.01 && found.slope < 1e-11);
    CU_ASSERT_EQUAL_FATAL(found.n_conjugate, 6);
    for (int k = 1; k <= 6; k++)
        CU_ASSERT_DOUBLE_EQUAL(found.conjugate[k - 1], k * PI / 2, 1e-10);
    CU_ASSERT_FATAL(modes_of(&found, MODES, lambda, lowest));
    for (int k = 1; k <= MODES; k++)
        CU_ASSERT_DOUBLE_EQUAL(lambda[k - 1], 1 - pow(20 / (k * PI), 2), 1e-11);
    /* Its L is of second degree: along the lowest mode S has no other term. */
    for (int k = 0; k < MODES; k++)
        x[k] = 0.5 * lowest[k];
    CU_ASSERT_DOUBLE_EQUAL(least_action_at(&found, x) - found.action, lambda[0] / 8, 1e-11);
    CU_ASSERT(modes_of(&found, MODES / 2, lambda, lowest));
    CU_ASSERT_DOUBLE_EQUAL(lambda[0], 1 - pow(20 / PI, 2), 1e-11);
    memory_end(&memory);

    /* A minimum just before a half period, none just behind it. */
    for (int behind = 0; behind < 2; behind++) {
        CU_ASSERT_FATAL(find(&found, &f, "gauss", 0, PI / 2 + (behind ? 1e-3 : -1e-3), 16, 8) ==
                        PK_DONE);
        CU_ASSERT_EQUAL(found.n_conjugate, (size_t)behind);
        CU_ASSERT(modes_of(&found, 8, lambda, lowest));
        CU_ASSERT((lambda[0] < 0) == behind && lambda[1] > 0);
    }
}

/* A path that no motion takes is not stationary: rk4 at a long step. */
TEST("what is no motion is not stationary")
{
    struct least_action found;
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
    struct least_action found;
    struct fixture f;
    double lambda[32], lowest[32], lo = 8.5, hi = 9.2;
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
    CU_ASSERT_FATAL(modes_of(&found, 16, lambda, lowest));
    CU_ASSERT(lambda[1] < 0 && lambda[2] > 0);
    memory_end(&memory);
}

/* To second order in the neighbour: what is left falls by 8 as it is halved. M depends on q here.
 */
TEST("neighbours to second order")
{
    enum { MODES = 6, M = 2 * MODES };
    struct least_action found;
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
        left[half] = least_action_at(&found, a) - expected;
    }
    CU_ASSERT(fabs(left[0]) > 1e-10);
    CU_ASSERT_DOUBLE_EQUAL(left[0] / left[1], 8, 0.2);
}

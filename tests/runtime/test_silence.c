/* Never silent, continued: numbers that must not come out of a start, an option or a parameter
 * that was refused; limits of round-off; and step control, which no final state shows.
 */
#include <limits.h>

#include "fixture.h"

#include "core/internal.h"

static struct fixture f;

static const char *reason(void)
{
    static char text[400];
    CU_ASSERT(pk_integrator_reason(&f.it, text, sizeof text) > 0);
    return text;
}

/* A refusal stands, although the caller did not look at it. */
TEST("a refused start")
{
    double q, v;
    fixture_set(&f, &pendulum_system);
    f.options.h = 0.1;
    f.q0[0] = (double)NAN;
    CU_ASSERT(fixture_init(&f, "rk4") == PK_BAD_ARGUMENT);
    CU_ASSERT(pk_integrator_to(&f.it, 1) == PK_BAD_ARGUMENT && f.it.t == 0);
    CU_ASSERT(says(&f.it, "start"));
    CU_ASSERT(pk_integrator_set_step(&f.it, 0.1) == PK_BAD_ARGUMENT);
    CU_ASSERT(pk_integrator_dense(&f.it, 0, &q, &v) == PK_BAD_ARGUMENT);
    f.q0[0] = 2.385;
    CU_ASSERT(pk_integrator_reset(&f.it, 0, f.q0, f.v0) == PK_DONE);
    CU_ASSERT(pk_integrator_to(&f.it, 1) == PK_DONE && f.it.t == 1);
    CU_ASSERT(pk_integrator_reset(&f.it, (double)INFINITY, f.q0, f.v0) == PK_BAD_ARGUMENT);
    CU_ASSERT(pk_integrator_to(&f.it, 2) == PK_BAD_ARGUMENT && f.it.t == 1);
    CU_ASSERT(pk_integrator_reset(&f.it, 0, NULL, f.v0) == PK_BAD_ARGUMENT);
}

TEST("options out of range")
{
    static const double nan = (double)NAN, inf = (double)INFINITY;
    struct {
        const char *method;
        struct pk_options o;
        enum pk_status status;
    } row[24];
    int count = 0;
    fixture_set(&f, &pendulum_system);
    f.options.h = 0.1;
#define ROW(name, field, value, want) \
    row[count].method = name;         \
    row[count].o = f.options;         \
    row[count].o.field = value;       \
    row[count++].status = want
    ROW("rk4", h, -0.1, PK_BAD_ARGUMENT);
    ROW("rk4", h, inf, PK_BAD_ARGUMENT);
    ROW("rk4", h, 1e3, PK_DONE); /* longer than the span: one step that ends there */
    ROW("dop853", h, nan, PK_BAD_ARGUMENT);
    ROW("dop853", h, 1e3, PK_DONE);
    ROW("dop853", rtol, nan, PK_BAD_ARGUMENT);
    ROW("dop853", rtol, inf, PK_BAD_ARGUMENT);
    ROW("dopri5", atol, inf, PK_BAD_ARGUMENT);
    ROW("dopri5", atol, -0.5, PK_BAD_ARGUMENT);
    ROW("dopri5", h_min, nan, PK_BAD_ARGUMENT);
    ROW("dopri5", h_max, nan, PK_BAD_ARGUMENT);
    ROW("dopri5", h_max, -1, PK_BAD_ARGUMENT);
    ROW("dopri5", h_max, inf, PK_DONE);
    ROW("gauss2", newton_tol, inf, PK_BAD_ARGUMENT);
    ROW("gauss2", newton_tol, nan, PK_BAD_ARGUMENT);
    ROW("gauss2", newton_tol, 1e-9, PK_DONE);
    ROW("gauss2", max_iterations, -5, PK_BAD_ARGUMENT);
    ROW("gauss2", max_iterations, INT_MAX, PK_BAD_ARGUMENT);
    ROW("gauss2", iteration, (enum pk_iteration)7, PK_BAD_ARGUMENT);
    ROW("gsl_rk8pd", rtol, inf, PK_BAD_ARGUMENT);
#undef ROW
    for (int i = 0; i < count; i++) {
        f.options = row[i].o;
        CU_ASSERT(fixture_init(&f, row[i].method) == row[i].status);
        CU_ASSERT(pk_integrator_to(&f.it, 1) == row[i].status);
        CU_ASSERT(row[i].status < 0 ? strlen(reason()) > 20 : f.it.t == 1);
        pk_integrator_free(&f.it);
    }
    fixture_set(&f, &pendulum_system); /* GSL's steppers know h_min too */
    f.options.h_min = 0.9;
    fixture_start(&f, "gsl_rk8pd", 1e-12);
    CU_ASSERT(pk_integrator_to(&f.it, 20) == PK_STEP_UNDERFLOW);
    pk_integrator_free(&f.it);
}

/* A model whose prepare() hoists: limit = 2 g. */
static int hoisting(void *params)
{
    struct test_params *p = (struct test_params *)params;
    p->limit = 2 * p->g;
    if (!(p->g > 0))
        return PK_FAILED(PK_FAILURE_PARAMETER, 0);
    return p->g < 1e300 ? 0 : PK_FAILED(PK_FAILURE_DERIVED, 0);
}

TEST("parameters")
{
    struct pk_system system = pendulum_system;
    system.prepare = hoisting;
    fixture_set(&f, &system);
    f.options.h = 0.1;
    CU_ASSERT(fixture_init(&f, "rk4") == PK_BAD_ARGUMENT); /* never prepared */
    CU_ASSERT(says(&f.it, "prepare()"));
    CU_ASSERT(pk_integrator_to(&f.it, 1) == PK_BAD_ARGUMENT);
    system.prepare(&f.params);
    CU_ASSERT(fixture_init(&f, "rk4") == PK_DONE && pk_integrator_to(&f.it, 1) == PK_DONE);
    f.params.g = 3; /* changed without prepare(): seen by a reset */
    CU_ASSERT(pk_integrator_reset(&f.it, 0, f.q0, f.v0) == PK_BAD_ARGUMENT);
    f.params.g = -3;
    CU_ASSERT(fixture_init(&f, "rk4") == PK_OUT_OF_BOUNDS);
    CU_ASSERT(says(&f.it, "bounds: g"));
    f.params.g = 1e301;
    CU_ASSERT(fixture_init(&f, "rk4") == PK_OUT_OF_BOUNDS);
    CU_ASSERT(says(&f.it, "follows"));
    f.problem.params = NULL;
    CU_ASSERT(fixture_init(&f, "rk4") == PK_BAD_ARGUMENT);
}

/* A start from rest without absolute tolerance; a coordinate that is all but nothing. */
TEST("no absolute tolerance")
{
    static const char *const names[] = {"dopri5", "dop853", "gauss"};
    for (int i = 0; i < 3; i++) {
        fixture_set(&f, &pendulum_system);
        f.v0[0] = 0;
        f.options.atol = 0;
        fixture_start(&f, names[i], 0);
        CU_ASSERT(pk_integrator_to(&f.it, 1) == PK_DONE && f.it.count.steps < 60);
    }
}

TEST("round-off of time")
{
    static const char *const names[] = {"dopri5", "dop853", "gauss"};
    for (int i = 0; i < 3; i++) {
        fixture_set(&f, &broken_system); /* no number past 1, and the end 2 ulp past it */
        f.params.limit = 1;
        fixture_start(&f, names[i], 0);
        CU_ASSERT(pk_integrator_to(&f.it, 1 - 1e-15) == PK_DONE);
        f.it.own->h = 1e-16; /* as many rejections would leave it */
        CU_ASSERT(pk_integrator_to(&f.it, 1 + 4e-16) < 0 && f.it.t <= 1);
        fixture_open(&f, &pendulum_system, names[i], 0);
        CU_ASSERT(pk_integrator_to(&f.it, 5e-324) == PK_DONE && f.it.count.steps == 1);
        CU_ASSERT(pk_integrator_to(&f.it, 1) == PK_DONE);
        const unsigned long before = f.it.count.steps;
        f.it.own->h = 1e-18;
        CU_ASSERT(pk_integrator_to(&f.it, 1 + 4e-16) == PK_DONE);
        CU_ASSERT(f.it.count.steps == before + 1);
        f.options.rtol = 1e-300; /* not to be met: the step is at fault, not the motion */
        f.options.atol = 0;
        fixture_start(&f, names[i], 0);
        /* gauss, whose estimate does not see round-off, stops at 2 PK_EPSILON. */
        CU_ASSERT(pk_integrator_to(&f.it, 1) == (i < 2 ? PK_STEP_UNDERFLOW : PK_DONE));
    }
}

/* The interpolant asks the kernels once more; what is no number must not pass. */
TEST("dense output")
{
    double q, v;
    fixture_open(&f, &broken_system, "dop853", 0);
    CU_ASSERT(pk_integrator_step(&f.it, 1) == PK_DONE);
    f.params.limit = -1;
    CU_ASSERT(pk_integrator_dense(&f.it, f.it.t / 2, &q, &v) == PK_NOT_FINITE);
}

/* A pivot that is rounding is no pivot: .1 * .9 - .3 * .3 is 1e-17, not 0. */
TEST("a pivot lost in rounding")
{
    double A[] = {0.1, 0.3, 0.3, 0.9 + 1e-16}, B[] = {2, 1, 1, 1};
    CU_ASSERT(A[3] - A[1] * A[1] / A[0] < 16 * DBL_EPSILON);
    CU_ASSERT(pk_ldl_factor(A, 2) == 2);
    CU_ASSERT(pk_ldl_factor(B, 2) == 0 && B[3] == 0.5);
}

/* An M that is not positive: how far, by methods of the core and GSL's alike. */
TEST("condition of M")
{
    static const char *const names[] = {"rk4",       "dop853",    "gauss",
                                        "gsl_rkf45", "gsl_rk8pd", "gsl_msadams"};
    for (int i = 0; i < 6; i++) {
        fixture_set(&f, &folded_system);
        f.options.h = 0.01;
        f.q0[0] = f.params.limit + 1; /* M = -1 */
        fixture_start(&f, names[i], 0);
        CU_ASSERT(pk_integrator_step(&f.it, 1) == PK_SINGULAR_MASS);
        CU_ASSERT(f.it.reason.index == 0 && f.it.reason.value < -0.999 &&
                  f.it.reason.value > -1.001);
        pk_integrator_free(&f.it);
    }
}

/* After a sliver of a step the next one is not predicted from it: it costs what a first step
 * costs, which has no prediction either, and not a fall back to full Newton. */
TEST("after a sliver of a step")
{
    static const struct {
        const struct pk_system *system;
        const char *method;
        double sliver;
    } rows[] = {{&double_pendulum_system, "gauss4", 2e-6},
                {&stiffening_system, "gauss8", 2e-6},
                {&stiffening_system, "gauss8", 2e-14},
                {&stiffening_system, "gauss", 2e-6},
                {&stiffening_system, "gauss", 2e-14}};
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        fixture_set(&f, rows[k].system);
        f.options.h = 0.02;
        fixture_start(&f, rows[k].method, 0);
        CU_ASSERT(pk_integrator_step(&f.it, 1) == PK_DONE);
        const unsigned long first = f.it.count.evaluations;
        CU_ASSERT(pk_integrator_to(&f.it, 0.2) == PK_DONE);
        CU_ASSERT(pk_integrator_to(&f.it, 0.2 + rows[k].sliver) == PK_DONE);
        const unsigned long before = f.it.count.evaluations;
        CU_ASSERT(pk_integrator_step(&f.it, 1) == PK_DONE);
        printf(" %s %lu evaluations, at first %lu;", rows[k].method,
               f.it.count.evaluations - before, first);
        CU_ASSERT(f.it.count.evaluations - before <= first + 30 && f.it.count.rejections == 0);
    }
}

/* A reset leaves nothing of before: the same numbers as a new integrator's. */
TEST("a reset is a fresh start")
{
    static const char *const names[] = {"verlet", "rk4",    "dop853", "gauss1",
                                        "gauss4", "gauss8", "gauss"};
    static struct fixture g;
    for (int i = 0; i < 7; i++) {
        fixture_set(&f, &kepler_system);
        f.options.h = 0.01;
        f.options.atol = f.options.rtol; /* the scale that a motion has shown stays */
        g = f;
        g.problem.params = &g.params;
        CU_ASSERT(fixture_init(&f, names[i]) == PK_DONE && fixture_init(&g, names[i]) == PK_DONE);
        CU_ASSERT(pk_integrator_to(&f.it, 3) == PK_DONE);
        if (f.it.count.steps % 2 == 0) /* an odd number: the two blocks have changed places */
            CU_ASSERT(pk_integrator_step(&f.it, 4) == PK_DONE);
        CU_ASSERT(pk_integrator_reset(&f.it, 0, f.q0, f.v0) == PK_DONE);
        CU_ASSERT(pk_integrator_to(&f.it, 2) == PK_DONE && pk_integrator_to(&g.it, 2) == PK_DONE);
        CU_ASSERT(memcmp(f.it.q, g.it.q, 2 * sizeof *f.q0) == 0);
        CU_ASSERT(memcmp(f.it.v, g.it.v, 2 * sizeof *f.v0) == 0);
    }
}

static void constant_push(void *context, double t, double *u)
{
    (void)t;
    u[0] = *(const double *)context;
}

/* q = q0 + v0 t + u t^2/2 and v = v0 + u t by 1e5 additions: exact to an ulp or two only when both
 * sums are compensated and the weights of a step add up to it. Without a push every step of a plain
 * sum is rounded the same way. */
TEST("compensated sums")
{
    static const char *const names[] = {"rk4",    "gauss1", "gauss2", "gauss3", "gauss4",
                                        "gauss5", "gauss7", "gauss8", "gauss8", "gauss"};
    struct pk_system general = pushed_system; /* gauss8 by Newton's method */
    general.facts &= ~(unsigned)PK_SEPARABLE;
    for (int k = 0; k < 2; k++) {
        double push = k ? 0.3 : 0, plain_q = 0.7, plain_v = 0.2;
        const double end_q = 2000.7 + push * 5e7, end_v = 0.2 + push * 1e4;
        for (int i = 0; i < 10; i++) {
            fixture_set(&f, i == 7 ? &general : &pushed_system);
            f.problem.input = constant_push;
            f.problem.context = &push;
            f.options.h = f.options.h_max = 0.1;
            fixture_start(&f, names[i], 0);
            CU_ASSERT(pk_integrator_to(&f.it, 1e4) == PK_DONE);
            CU_ASSERT(f.it.count.steps >= 99990 && f.it.count.steps <= 100010);
            const double q = fabs(f.it.q[0] / end_q - 1), v = fabs(f.it.v[0] / end_v - 1);
            printf("\n    %s: %.1e of q, %.1e of v", names[i], q, v);
            CU_ASSERT(q < 5e-16 && v < 5e-16);
        }
        for (int i = 0; i < 100000; i++) {
            plain_q += 0.1 * plain_v + 0.1 * 0.1 * push / 2;
            plain_v += 0.1 * push;
        }
        plain_q = fabs(plain_q / end_q - 1), plain_v = fabs(plain_v / end_v - 1);
        printf("\n    plain sums: %.1e of q, %.1e of v", plain_q, plain_v);
        CU_ASSERT(plain_q > 2e-15 && (k == 0 || plain_v > 2e-15));
    }
}

/* Backward as forward: adaptive and fixed methods return to their start. */
TEST("backward")
{
    static const char *const names[] = {"dopri5",    "dop853",    "gsl_rk8pd", "gsl_msadams",
                                        "gsl_rkf45", "gsl_msbdf", "gsl_bsimp", "gauss",
                                        "radau",     "rk4"};
    for (int i = 0; i < 10; i++) {
        fixture_open(&f, &kepler_system, names[i], i == 9 ? 1e-3 : 1e-11);
        CU_ASSERT(pk_integrator_to(&f.it, 5) == PK_DONE);
        CU_ASSERT(fixture_distance(&f, f.q0, f.v0) > 0.1);
        CU_ASSERT(pk_integrator_to(&f.it, -0.7) == PK_DONE && f.it.t == -0.7);
        CU_ASSERT(pk_integrator_to(&f.it, 0) == PK_DONE);
        const double d = fixture_distance(&f, f.q0, f.v0);
        printf(" %s %.1e", names[i], d);
        CU_ASSERT(d > 0 && d < 1e-6);
        pk_integrator_free(&f.it);
    }
}

/* Of any number in any place, whichever way the loop goes over it. */
TEST("what is not finite is seen")
{
    double x[21];
    for (size_t n = 0; n <= 21; n++) {
        for (size_t i = 0; i < n; i++)
            x[i] = (double)i - 7;
        CU_ASSERT(pk_all_finite(x, n));
        for (size_t i = 0; i < n; i++) {
            const double before = x[i];
            x[i] = i % 2 ? (double)NAN : -(double)INFINITY;
            CU_ASSERT(!pk_all_finite(x, n));
            x[i] = before;
        }
    }
}

/* The scale of tolerances comes from the motion: the same motion in other units, by every adaptive
 * method; what begins at rest, at an equilibrium or with a jump. */
#include "fixture.h"

static struct fixture f;

static const char *const methods[] = {"gauss",     "dop853",    "dopri5",
                                      "gsl_rkf45", "gsl_rk8pd", "gsl_msadams"};

/* A Duffing oscillator in units: x'' = -x - g x^3, of q = x limit. */
static int duffing(ARGS, double *a)
{
    const double unit = ((const struct test_params *)params)->limit, x = q[0] / unit;
    (void)t, (void)v, (void)u;
    a[0] = -(x + x * x * x) * unit;
    return 0;
}

/* At rest to t = 1, then drawn to unit. */
static int waits(ARGS, double *a)
{
    const double unit = ((const struct test_params *)params)->limit;
    (void)v, (void)u;
    a[0] = t < 1 ? 0 : unit - q[0];
    return 0;
}

/* A cart that only what is left of sin(pi) pushes. */
static int balances(ARGS, double *a)
{
    UNUSED;
    a[0] = 9.81 * sin(q[1]);
    a[1] = -9.81 * sin(q[1]) * cos(q[1]);
    return 0;
}

static double end(const struct pk_system *system, const char *method, double unit, double x0,
                  double t)
{
    fixture_set(&f, system);
    f.options.rtol = 1e-10;
    f.params.limit = unit;
    f.q0[0] = x0 * unit;
    f.v0[0] = 0;
    fixture_start(&f, method, 0);
    CU_ASSERT(pk_integrator_to(&f.it, t) == PK_DONE);
    const double x = f.it.q[0] / unit;
    pk_integrator_free(&f.it);
    return x;
}

TEST("units")
{
    static const double sizes[] = {1e-90, 1e-15, 1e-3, 1e6, 1e15};
    const struct pk_system system = free_point(duffing), late = free_point(waits);
    for (size_t m = 0; m < sizeof methods / sizeof *methods; m++) {
        const double one = end(&system, methods[m], 1, 0.9, 20);
        const double tight = end(&system, "dop853", 1, 0.9, 20);
        CU_ASSERT(fabs(one - tight) < 2e-7 && fabs(tight) > 1e-3);
        for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++)
            CU_ASSERT(fabs(end(&system, methods[m], sizes[k], 0.9, 20) - one) < 1e-7);
        if (m == 0) /* gauss wants what is smooth */
            continue;
        for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++)
            CU_ASSERT(fabs(end(&late, methods[m], sizes[k], 0, 6) - (1 - cos(5))) < 1e-4);
    }
}

TEST("an absolute tolerance")
{
    const struct pk_system system = free_point(duffing);
    fixture_set(&f, &system);
    f.params.limit = 1e-15;
    f.options.rtol = f.options.atol = 1e-10; /* who says so loses 1e-15 */
    f.q0[0] = 0.9e-15, f.v0[0] = 0;
    CU_ASSERT(fixture_init(&f, "dop853") == PK_DONE && pk_integrator_to(&f.it, 20) == PK_DONE);
    const double lost = f.it.q[0] / 1e-15;
    CU_ASSERT(fabs(lost - end(&system, "dop853", 1, 0.9, 20)) > 1e-2);
}

TEST("an equilibrium but for rounding")
{
    struct pk_system system = *(&kepler_system);
    system.acceleration = balances;
    system.lanes = NULL, system.steppers = NULL;
    for (size_t m = 0; m < 4; m++) {
        fixture_set(&f, &system);
        f.q0[0] = 0, f.q0[1] = acos(-1), f.v0[0] = f.v0[1] = 0;
        fixture_start(&f, methods[m], 0);
        CU_ASSERT(pk_integrator_to(&f.it, 8) == PK_DONE);
        CU_ASSERT(f.it.count.steps + f.it.count.rejections < 3000);
        printf(" %s %lu", methods[m], f.it.count.steps);
        pk_integrator_free(&f.it);
    }
}

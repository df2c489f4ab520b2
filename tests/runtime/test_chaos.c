/* Lyapunov exponents and reversal of the double pendulum (REGIMES D2, D3), coarse enough for every
 * day; the figures to three digits are in tests/long.
 */
#include "fixture.h"

static double memory[1 << 13];

static struct pk_lyapunov exponent(double angle, const char *name, double rtol, double t_end)
{
    static struct test_params params;
    static struct pk_lyapunov l;
    const double q[] = {angle, angle}, v[] = {0, 0};
    double_pendulum_system.defaults(&params);
    const struct pk_problem problem = {.system = &double_pendulum_system, .params = &params};
    struct pk_options options = pk_options_default();
    options.rtol = options.atol = options.h = rtol;
    const struct pk_method *method = pk_method_find(name);
    CU_ASSERT_FATAL(pk_lyapunov_size(&problem, method) <= sizeof memory);
    CU_ASSERT_FATAL(pk_lyapunov_init(&l, &problem, method, &options, 0, q, v, t_end / 1000, memory,
                                     sizeof memory) == PK_DONE);
    for (int k = 0; k < 1000; k++)
        CU_ASSERT_FATAL(pk_lyapunov_step(&l) == PK_DONE);
    return l;
}

TEST("Lyapunov exponents of the double pendulum")
{
    static const struct {
        double angle, lambda;
    } rows[] = {{1.57079632679489661923, 0.926}, {2, 1.343}, {3, 1.005}};
    double error;
    for (int k = 0; k < 3; k++) {
        const struct pk_lyapunov l = exponent(rows[k].angle, "dop853", 1e-8, 1000);
        const double lambda = pk_lyapunov_exponent(&l, &error), megno = pk_lyapunov_megno(&l);
        printf("\n    from rest at %.4g: lambda = %.4f +- %.4f, megno %.1f", rows[k].angle, lambda,
               error, megno);
        CU_ASSERT(error > 0.01 && error < 0.05 && fabs(lambda - rows[k].lambda) < 4 * error);
        CU_ASSERT(pk_lyapunov_motion(&l) == PK_CHAOTIC);
        CU_ASSERT(fabs(megno / (lambda * 500) - 1) < 0.2);
    }
    const struct pk_lyapunov l = exponent(0.5, "dop853", 1e-8, 3000);
    const double lambda = pk_lyapunov_exponent(&l, &error), megno = pk_lyapunov_megno(&l);
    printf("\n    from .5: %.1e +- %.1e, megno %.3f", lambda, error, megno);
    CU_ASSERT(fabs(lambda) > 1e-5 && lambda < 1e-3 && pk_lyapunov_motion(&l) == PK_REGULAR);
    CU_ASSERT(fabs(megno - 2) < 0.5);
    /* A symplectic method at a fixed step sees the same, an explicit one of too long steps not. */
    const struct pk_lyapunov fixed = exponent(2, "gauss4", 0.05, 500);
    CU_ASSERT(fabs(pk_lyapunov_exponent(&fixed, &error) - 1.343) < 4 * error && error < 0.05);
    CU_ASSERT(fabs(fixed.it.t - 500) < 1e-9 && fixed.it.count.steps == 10000);
}

/* An inverted oscillator: exactly sqrt(-g); and an upright one, which has none. */
TEST("Lyapunov exponents in closed form")
{
    struct pk_system oscillator = oscillator_system;
    struct test_params params = {.g = -2.385};
    const double q[] = {1e-9}, v[] = {0};
    const struct pk_problem problem = {.system = &oscillator, .params = &params};
    struct pk_options options = pk_options_default();
    struct pk_lyapunov l;
    double error = 0;
    oscillator.prepare = NULL; /* which wants g > 0 */
    options.rtol = options.atol = 1e-10;
    CU_ASSERT_FATAL(pk_lyapunov_init(&l, &problem, pk_method_find("dop853"), &options, 0, q, v, 2,
                                     memory, sizeof memory) == PK_DONE);
    CU_ASSERT(pk_lyapunov_motion(&l) == PK_UNDECIDED && pk_lyapunov_exponent(&l, &error) == 0);
    CU_ASSERT(!(error < 1e300));
    for (int k = 0; k < 100; k++) /* e^309: the displacement is renewed, the motion is not */
        CU_ASSERT(pk_lyapunov_step(&l) == PK_DONE);
    CU_ASSERT(fabs(pk_lyapunov_exponent(&l, &error) - sqrt(2.385)) < 1e-8 && error < 1e-8);
    CU_ASSERT(pk_lyapunov_motion(&l) == PK_CHAOTIC);
    const double still[] = {0};
    CU_ASSERT_FATAL(pk_lyapunov_init(&l, &problem, pk_method_find("dop853"), &options, 0, still, v,
                                     500, memory, sizeof memory) == PK_DONE);
    for (int k = 0; k < 20; k++) /* a block in which it grows by e^772, past the largest number */
        CU_ASSERT(pk_lyapunov_step(&l) == PK_DONE);
    CU_ASSERT(fabs(pk_lyapunov_exponent(&l, &error) - sqrt(2.385)) < 1e-8);
    params.g = 2.385;
    CU_ASSERT_FATAL(pk_lyapunov_init(&l, &problem, pk_method_find("dop853"), &options, 0, q, v, 2,
                                     memory, sizeof memory) == PK_DONE);
    for (int k = 0; k < 1000; k++)
        CU_ASSERT(pk_lyapunov_step(&l) == PK_DONE);
    CU_ASSERT(fabs(pk_lyapunov_exponent(&l, &error)) < 1e-3);
    CU_ASSERT(pk_lyapunov_motion(&l) == PK_REGULAR);
    CU_ASSERT(fabs(pk_lyapunov_megno(&l)) < 1);
    oscillator.linear = NULL;
    CU_ASSERT(pk_lyapunov_init(&l, &problem, pk_method_find("dop853"), &options, 0, q, v, 2, memory,
                               sizeof memory) == PK_REFUSED);
    CU_ASSERT(pk_lyapunov_step(&l) < 0);
}

static struct pk_reversal there_and_back(double angle, const char *name, double h, double t_end,
                                         double threshold)
{
    static struct test_params params;
    struct pk_integrator it;
    struct pk_reversal r;
    const double q[] = {angle, angle}, v[] = {0, 0};
    double_pendulum_system.defaults(&params);
    const struct pk_problem problem = {.system = &double_pendulum_system, .params = &params};
    struct pk_options options = pk_options_default();
    options.h = h;
    const struct pk_method *method = pk_method_find(name);
    CU_ASSERT_FATAL(pk_reversal_size(&problem, method) <= sizeof memory);
    CU_ASSERT_FATAL(pk_reversal_find(&r, &it, &problem, method, &options, 0, q, v, t_end, threshold,
                                     memory, sizeof memory) == PK_DONE);
    return r;
}

TEST("there and back")
{
    const struct pk_reversal lost = there_and_back(acos(0), "gauss1", 0.01, 60, 1e-3);
    const struct pk_reversal kept = there_and_back(0.5, "gauss1", 0.01, 60, 1e-3);
    const struct pk_reversal rk4 = there_and_back(0.5, "rk4", 0.01, 60, 1e-3);
    printf("\n    midpoint, h = .01: lost between %.2f and %.2f s; a regular orbit returns within "
           "%.1e, by rk4 %.1e",
           lost.horizon_lo, lost.horizon_hi, kept.at[kept.count - 1].absolute,
           rk4.at[rk4.count - 1].absolute);
    CU_ASSERT(lost.passed && lost.horizon_lo > 28 && lost.horizon_hi < 50);
    CU_ASSERT(lost.horizon_hi < 1.07 * lost.horizon_lo);
    CU_ASSERT(!kept.passed && kept.count == 13 && fabs(kept.at[12].t - 60) < 1e-12);
    CU_ASSERT(kept.at[12].absolute > 0 && kept.at[12].absolute < 2e-13);
    CU_ASSERT(rk4.at[12].absolute > 1e3 * kept.at[12].absolute);
    for (size_t i = 0; i + 1 < kept.count; i++) { /* whole steps, each time twice the last */
        CU_ASSERT(fabs(kept.at[i + 1].t - 2 * kept.at[i].t) < 0.011);
        CU_ASSERT(fabs(remainder(kept.at[i].t, 0.01)) < 1e-12);
    }
}

/* Lyapunov exponents and reversal of the double pendulum (REGIMES D2, D3), coarse enough for every
 * day; the figures to three digits are in tests/long.
 */
#include "../../runtime/run/diagnose/motion.h"
#include "fixture.h"

static struct memory memory;

static struct motion motion_from(const struct pk_problem *problem, const char *method,
                                 const double *q, const double *v, double end)
{
    return (struct motion){.problem = problem,
                           .method = pk_method_find(method),
                           .options = pk_options_default(),
                           .end = end,
                           .q = q,
                           .v = v,
                           .memory = &memory};
}

static struct growth exponent(double angle, const char *name, double rtol, double t_end,
                              unsigned long *steps)
{
    static struct test_params params;
    static struct lyapunov l;
    const double q[] = {angle, angle}, v[] = {0, 0};
    double_pendulum_system.defaults(&params);
    const struct pk_problem problem = {.system = &double_pendulum_system, .params = &params};
    struct motion m = motion_from(&problem, name, q, v, t_end);
    m.options.rtol = m.options.atol = m.options.h = rtol;
    CU_ASSERT_FATAL(lyapunov_begin(&l, &m, t_end / 1000) == PK_DONE);
    for (int k = 0; k < 1000; k++)
        CU_ASSERT_FATAL(lyapunov_step(&l) == PK_DONE);
    CU_ASSERT(fabs(l.variation.motion.it.t - t_end) < 1e-9);
    *steps = l.variation.motion.it.count.steps;
    return lyapunov_growth(&l);
}

TEST("Lyapunov exponents of the double pendulum")
{
    static const struct {
        double angle, lambda;
    } rows[] = {{1.57079632679489661923, 0.926}, {2, 1.343}, {3, 1.005}};
    unsigned long steps;
    for (int k = 0; k < 3; k++) {
        const struct growth l = exponent(rows[k].angle, "dop853", 1e-8, 1000, &steps);
        const double lambda = l.exponent, error = l.error, megno = l.megno;
        printf("\n    from rest at %.4g: lambda = %.4f +- %.4f, megno %.1f", rows[k].angle, lambda,
               error, megno);
        CU_ASSERT(error > 0.01 && error < 0.05 && fabs(lambda - rows[k].lambda) < 4 * error);
        CU_ASSERT(l.kind == CHAOTIC);
        CU_ASSERT(fabs(megno / (lambda * 500) - 1) < 0.2);
    }
    const struct growth l = exponent(0.5, "dop853", 1e-8, 3000, &steps);
    printf("\n    from .5: %.1e +- %.1e, megno %.3f", l.exponent, l.error, l.megno);
    CU_ASSERT(fabs(l.exponent) > 1e-5 && l.exponent < 1e-3 && l.kind == REGULAR);
    CU_ASSERT(fabs(l.megno - 2) < 0.5);
    /* A symplectic method at a fixed step sees the same, an explicit one of too long steps not. */
    const struct growth fixed = exponent(2, "gauss4", 0.05, 500, &steps);
    CU_ASSERT(fabs(fixed.exponent - 1.343) < 4 * fixed.error && fixed.error < 0.05);
    CU_ASSERT(steps == 10000);
    memory_end(&memory);
}

/* An inverted oscillator: exactly sqrt(-g); and an upright one, which has none. */
TEST("Lyapunov exponents in closed form")
{
    struct pk_system oscillator = oscillator_system;
    struct test_params params = {.g = -2.385};
    const double q[] = {1e-9}, v[] = {0};
    const struct pk_problem problem = {.system = &oscillator, .params = &params};
    struct motion m = motion_from(&problem, "dop853", q, v, 2000);
    struct lyapunov l;
    oscillator.prepare = NULL; /* which wants g > 0 */
    m.options.rtol = m.options.atol = 1e-10;
    CU_ASSERT_FATAL(lyapunov_begin(&l, &m, 2) == PK_DONE);
    struct growth found = lyapunov_growth(&l);
    CU_ASSERT(found.kind == UNDECIDED && found.exponent == 0 && !(found.error < 1e300));
    for (int k = 0; k < 100; k++) /* e^309: the displacement is renewed, the motion is not */
        CU_ASSERT(lyapunov_step(&l) == PK_DONE);
    found = lyapunov_growth(&l);
    CU_ASSERT(fabs(found.exponent - sqrt(2.385)) < 1e-8 && found.error < 1e-8);
    CU_ASSERT(found.kind == CHAOTIC);
    const double still[] = {0};
    m.q = still;
    CU_ASSERT_FATAL(lyapunov_begin(&l, &m, 500) == PK_DONE);
    for (int k = 0; k < 20; k++) /* a block in which it grows by e^772, past the largest number */
        CU_ASSERT(lyapunov_step(&l) == PK_DONE);
    CU_ASSERT(fabs(lyapunov_growth(&l).exponent - sqrt(2.385)) < 1e-8);
    params.g = 2.385;
    m.q = q;
    CU_ASSERT_FATAL(lyapunov_begin(&l, &m, 2) == PK_DONE);
    for (int k = 0; k < 1000; k++)
        CU_ASSERT(lyapunov_step(&l) == PK_DONE);
    found = lyapunov_growth(&l);
    CU_ASSERT(fabs(found.exponent) < 1e-3 && found.kind == REGULAR && fabs(found.megno) < 1);
    oscillator.linear = NULL;
    CU_ASSERT(lyapunov_begin(&l, &m, 2) == PK_REFUSED);
    memory_end(&memory);
}

static struct reversal there_and_back(double angle, const char *name, double h, double t_end,
                                      double threshold)
{
    static struct test_params params;
    struct reversal r;
    const double q[] = {angle, angle}, v[] = {0, 0};
    double_pendulum_system.defaults(&params);
    const struct pk_problem problem = {.system = &double_pendulum_system, .params = &params};
    struct motion m = motion_from(&problem, name, q, v, t_end);
    m.options.h = h;
    CU_ASSERT_FATAL(reversal_find(&r, &m, threshold) == PK_DONE);
    pk_integrator_free(&m.it);
    return r;
}

TEST("there and back")
{
    const struct reversal lost = there_and_back(acos(0), "gauss1", 0.01, 60, 1e-3);
    const struct reversal kept = there_and_back(0.5, "gauss1", 0.01, 60, 1e-3);
    const struct reversal rk4 = there_and_back(0.5, "rk4", 0.01, 60, 1e-3);
    printf("\n    midpoint, h = .01: lost between %.2f and %.2f s; a regular orbit returns within "
           "%.1e, by rk4 %.1e",
           lost.horizon_lo, lost.horizon_hi, kept.at[kept.count - 1].error,
           rk4.at[rk4.count - 1].error);
    CU_ASSERT(lost.passed && lost.horizon_lo > 28 && lost.horizon_hi < 50);
    CU_ASSERT(lost.horizon_hi < 1.07 * lost.horizon_lo);
    CU_ASSERT(!kept.passed && kept.count == 13 && fabs(kept.at[12].t - 60) < 1e-12);
    CU_ASSERT(kept.at[12].error > 0 && kept.at[12].error < 2e-13);
    CU_ASSERT(rk4.at[12].error > 1e3 * kept.at[12].error);
    for (size_t i = 0; i + 1 < kept.count; i++) { /* whole steps, each time twice the last */
        CU_ASSERT(fabs(kept.at[i + 1].t - 2 * kept.at[i].t) < 0.011);
        CU_ASSERT(fabs(remainder(kept.at[i].t, 0.01)) < 1e-12);
    }
    memory_end(&memory);
}

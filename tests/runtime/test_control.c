/* Step control of the embedded methods: the formula step by step, and whole runs against the
 * counts of the published codes. Reference: E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary
 * Differential Equations I, II.0 (0.1)-(0.2) for the orbit, II.4 and II.5 for the control.
 */
#include <pk/step/state.h>
#include <stdlib.h>

#include "fixture.h"

static struct fixture f;

static const double period = 17.0652165601579625588917206249;

/* h_new = h / clamp(err^alpha / err_old^beta / safety), rejected steps by err alone. */
TEST("the formula, step by step")
{
    static const struct {
        const char *name;
        double k, beta, shrink, grow;
    } row[] = {{"dopri5", 5, 0.04, 0.2, 10}, {"dop853", 8, 0, 0.333, 6}};
    for (int i = 0; i < 2; i++) {
        const double alpha = 1 / row[i].k - 0.75 * row[i].beta;
        double old = 1e-4, sizes[4000];
        int checked = 0, rejected = 0;
        fixture_open(&f, &arenstorf_system, row[i].name, 1e-7);
        for (int count = 0; f.it.t < period; count++) {
            const unsigned long before = f.it.count.rejections;
            const double planned = f.it.own->h;
            CU_ASSERT_FATAL(count < 4000 && pk_integrator_step(&f.it, period) == PK_DONE);
            const double h = f.it.t - f.it.last_t, err = f.it.own->error;
            CU_ASSERT(err <= 1);
            double fac = pow(err, alpha) / pow(old, row[i].beta) / 0.9;
            fac = fmin(1 / row[i].shrink, fmax(1 / row[i].grow, fac));
            const int again = f.it.count.rejections > before;
            const double next = again ? fmin(h / fac, h) : h / fac;
            if (f.it.t < period && count) {
                CU_ASSERT(fabs(f.it.own->h / next - 1) < 1e-9);
                CU_ASSERT(again ? h < planned : fabs(h / planned - 1) < 1e-9);
                checked++;
                rejected += again;
            }
            old = fmax(err, 1e-4);
            sizes[count] = h;
        }
        CU_ASSERT(checked > 30 && rejected > 3 && sizes[0] > 0);
    }
}

/* DR_DOPRI5's own output: fcn 1442, step 240, accepted 216, rejected 22 after the first step. */
TEST("a published run")
{
    CU_ASSERT(fixture_run(&f, &arenstorf_system, "dopri5", 1e-7, period) == PK_DONE);
    printf("\n    Arenstorf, dopri5 at 1e-7: %lu steps, %lu rejected, %lu evaluations, end %.1e",
           f.it.count.steps, f.it.count.rejections, f.it.count.evaluations,
           fixture_distance(&f, f.q0, f.v0));
    CU_ASSERT(f.it.count.steps + f.it.count.rejections == 240);
    CU_ASSERT(f.it.count.evaluations == 1442);
    fixture_set(
        &f, &arenstorf_system); /* scipy's DOP853, the same formulas: 84 accepted, 36 rejected */
    fixture_start(&f, "dop853", 1e-7);
    CU_ASSERT(pk_integrator_to(&f.it, period) == PK_DONE);
    printf(", dop853 at 1e-7: %lu + %lu", f.it.count.steps, f.it.count.rejections);
    CU_ASSERT(labs((long)f.it.count.steps - 84) <= 3);
    CU_ASSERT(fixture_run(&f, &arenstorf_system, "dop853", 1e-13, period) == PK_DONE);
    const double end = fixture_distance(&f, f.q0, f.v0);
    printf(", dop853 at 1e-13: %lu steps, end %.1e", f.it.count.steps, end);
    CU_ASSERT(end > 1e-13 && end < 1e-8);
}

/* A row just ahead cuts a step short; the next one is as long as if it had not. */
TEST("a step cut short")
{
    static const char *const names[] = {"dopri5", "dop853", "gauss"};
    for (int i = 0; i < 3; i++) {
        fixture_open(&f, &pendulum_system, names[i], 0);
        for (int k = 0; k < 10; k++)
            CU_ASSERT(pk_integrator_step(&f.it, 1e3) == PK_DONE);
        const double planned = f.it.own->h;
        CU_ASSERT(pk_integrator_to(&f.it, f.it.t + planned / 1000) == PK_DONE);
        CU_ASSERT(f.it.own->h >= planned);
    }
}

/* HNW II.4: h0 = .01 |y|/|y'|, then h1 with h1^k max(|y'|, |y''|) = .01, in the tolerance's norm.
 */
TEST("the first step")
{
    const double tol = 1e-5, q = 2.385, v = 0.13, a = -sin(q);
    const double sq = tol + tol * q, sv = tol + tol * v;
    const double d0 = hypot(q / sq, v / sv) / sqrt(2.0), d1 = hypot(v / sq, a / sv) / sqrt(2.0);
    const double h0 = 0.01 * d0 / d1;
    const double d2 = hypot(h0 * a / sq, (-sin(q + h0 * v) - a) / sv) / sqrt(2.0) / h0;
    const double h1 = fmin(100 * h0, pow(0.01 / fmax(d1, d2), 0.2));
    fixture_open(&f, &pendulum_system, "dopri5", tol);
    CU_ASSERT(pk_integrator_step(&f.it, 1e3) == PK_DONE && f.it.count.rejections == 0);
    CU_ASSERT(fabs(f.it.t / h1 - 1) < 1e-9 && fabs(h0 / h1 - 1) > 0.1);
}

/* v' = -v/(1 - t)^2: dopri5's steps are some 3.3 (1 - t)^2 long, so that t = 1 is never reached. */
static int creeps(ARGS, double *a)
{
    UNUSED;
    a[0] = -1 - v[0] / ((1 - t) * (1 - t));
    return 0;
}

/* At rest to t = 100, then in steps some 1e-5 of it. */
static int wakes(ARGS, double *a)
{
    UNUSED;
    a[0] = t < 100 ? 0 : -1e6 * (q[0] + 1e-3);
    return 0;
}

/* Forces that are noise, under tolerances that ask for fourteen digits: errors that no step makes
 * smaller. */
static int noisy(ARGS, double *a)
{
    const double x = 43758.5453 * sin(1e6 * t + 78.233e3 * q[0] + 12.9898e3 * v[0]);
    UNUSED;
    a[0] = -q[0] - (x - floor(x));
    return 0;
}

TEST("noise")
{
    static const char *const methods[] = {"gauss", "dop853", "dopri5", "gsl_rkf45", "gsl_rk8pd"};
    char text[640];
    struct pk_system system = free_point(noisy);
    for (size_t m = 0; m < sizeof methods / sizeof *methods; m++) {
        fixture_set(&f, &system);
        f.options.rtol = 0, f.options.atol = 1e-14;
        fixture_start(&f, methods[m], 0);
        const enum pk_status status = pk_integrator_to(&f.it, 1000);
        pk_integrator_reason(&f.it, text, sizeof text);
        printf("\n    %-11s t = %.3g after %lu + %lu: %s", methods[m], f.it.t, f.it.count.steps,
               f.it.count.rejections, text);
        CU_ASSERT(status == PK_NO_PROGRESS || status == PK_STEP_UNDERFLOW);
        CU_ASSERT(f.it.count.steps + f.it.count.rejections < 1u << 20);
        pk_integrator_free(&f.it);
    }
}

/* A run that gets nowhere ends, and says since when; hard ones that get somewhere do not. */
TEST("progress")
{
    struct pk_system system = free_point(creeps);
    CU_ASSERT(fixture_run(&f, &system, "dopri5", 0, 3) == PK_NO_PROGRESS);
    CU_ASSERT(f.it.t < 1 && f.it.t > 1 - 1e-5 && f.it.count.steps < 1u << 20);
    const double reached = f.it.t;
    CU_ASSERT(says(&f.it, "nowhere") && says(&f.it, "last valid time"));
    f.options.max_steps = 1ul << 40; /* who asks for more steps gets them */
    fixture_start(&f, "dopri5", 0);
    CU_ASSERT(pk_integrator_steps(&f.it, 3, 200000) == PK_DONE && f.it.t > reached);

    f.options.max_steps = 0;
    system.acceleration = wakes;
    fixture_set(&f, &system);
    f.q0[0] = f.v0[0] = 0;
    fixture_start(&f, "dopri5", 0);
    CU_ASSERT(pk_integrator_steps(&f.it, 1e4, 300000) == PK_DONE && f.it.t < 1000);
    static const struct pk_system *const hard[] = {&arenstorf_system, &kepler_system};
    for (int i = 0; i < 2; i++) {
        fixture_set(&f, hard[i]);
        f.options.rtol = f.options.atol = 1e-13;
        if (i)
            f.v0[0] *= 0.1, f.v0[1] *= 0.1; /* e = .99 and more */
        fixture_start(&f, "dopri5", 0);
        CU_ASSERT(pk_integrator_steps(&f.it, 1e9, 300000) == PK_DONE && f.it.t > 1);
    }
}

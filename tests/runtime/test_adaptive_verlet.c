/* The reversible variable step of adaptive_verlet: bounded energy errors where a naive choice of
 * the step drifts, the way back up to rounding, ends and rows that leave the sequence of steps as
 * it is, and what it cannot follow.
 */
#include "fixture.h"

static struct fixture f;

static const char name[] = "adaptive_verlet";

/* Kepler, mu = a = 1, from pericentre, first step x r^1.5. */
static void kepler_set(struct fixture *one, double e, double x)
{
    fixture_set(one, &kepler_system);
    one->q0[0] = 1 - e, one->q0[1] = 0;
    one->v0[0] = 0, one->v0[1] = sqrt((1 + e) / (1 - e));
    one->options.h = x * pow(1 - e, 1.5);
}

static double energy_error(double e)
{
    const struct pk_system *system = f.problem.system;
    (void)e;
    return fabs(system->energy(&f.params, 0, f.it.q, f.it.v, NULL) + 0.5);
}

/* e = .8, h = .05 r^1.5: within .0014318, to the digits given after 10 and 100 orbits; Verlet whose
 * step is .05 r^1.5 of where it is drifts .0034 and .0138. */
TEST("energy stays")
{
    for (int orbits = 10; orbits <= 100; orbits *= 10) {
        const double end = 2 * acos(-1) * orbits;
        double worst = 0, naive = 0;
        kepler_set(&f, 0.8, 0.05);
        fixture_start(&f, name, 0);
        while (f.it.t < end) {
            CU_ASSERT_FATAL(pk_integrator_step(&f.it, 2 * end) == PK_DONE);
            worst = fmax(worst, energy_error(0.8));
        }
        const unsigned long steps = f.it.count.steps;
        kepler_set(&f, 0.8, 0.05);
        fixture_start(&f, "verlet", 0);
        while (f.it.t < end) {
            const double r = hypot(f.it.q[0], f.it.q[1]);
            pk_integrator_set_step(&f.it, 0.05 * pow(r, 1.5));
            CU_ASSERT_FATAL(pk_integrator_step(&f.it, 2 * end) == PK_DONE);
            naive = energy_error(0.8);
        }
        printf("\n    %d orbits: %lu steps, energy within %.7f, naive %.4f in %lu", orbits, steps,
               worst, naive, f.it.count.steps);
        CU_ASSERT(worst > 0.0014 && worst < 0.0014318);
        CU_ASSERT(fabs(naive / (orbits == 10 ? 0.0034 : 0.0138) - 1) < 0.2);
    }
}

/* Forth and back over the same points, also where it stopped and looked aside on the way. */
TEST("the way back")
{
    kepler_set(&f, 0.8, 0.05);
    fixture_start(&f, name, 0);
    for (int i = 0; i < 600; i++) {
        double q[2], v[2];
        CU_ASSERT_FATAL(pk_integrator_step(&f.it, 1e9) == PK_DONE);
        if (i % 7 == 0)
            CU_ASSERT(pk_integrator_to(&f.it, f.it.t + 3e-4) == PK_DONE);
        if (i % 5 == 0)
            CU_ASSERT(pk_integrator_dense(&f.it, (f.it.last_t + f.it.t) / 2, q, v) == PK_DONE);
    }
    CU_ASSERT(fixture_distance(&f, f.q0, f.v0) > 0.1);
    CU_ASSERT(pk_integrator_to(&f.it, 0) == PK_DONE && f.it.t == 0);
    const double d = fixture_distance(&f, f.q0, f.v0);
    printf(" %.1e", d);
    CU_ASSERT(d > 0 && d < 1e-10);
}

/* Rows at any times, by landing or dense output: the sequence of steps is the same, and rows are
 * as accurate as steps. */
TEST("rows leave the steps as they are")
{
    static struct fixture plain, landed, exact;
    double worst = 0, q[2], v[2];
    kepler_set(&plain, 0.5, 0.05);
    fixture_start(&plain, name, 0);
    kepler_set(&landed, 0.5, 0.05);
    fixture_start(&landed, name, 0);
    for (int row = 1; row <= 50; row++) {
        const double t = 0.237 * row;
        CU_ASSERT(pk_integrator_to(&landed.it, t) == PK_DONE && landed.it.t == t);
        while (plain.it.t < t)
            CU_ASSERT_FATAL(pk_integrator_step(&plain.it, 1e9) == PK_DONE);
        CU_ASSERT(pk_integrator_dense(&plain.it, t, q, v) == PK_DONE);
        CU_ASSERT(fixture_distance(&landed, q, v) < 1e-13);
        fixture_exact(&exact, &kepler_system, landed.q0, landed.v0, t, 400);
        worst = fmax(worst, fixture_distance(&exact, q, v));
        if (row == 3)
            CU_ASSERT(worst > 1e-6);
    }
    CU_ASSERT(worst < 0.05);
    const double end = plain.it.t;
    CU_ASSERT(pk_integrator_step(&landed.it, 1e9) == PK_DONE);
    CU_ASSERT(landed.it.t == end);
    CU_ASSERT(fixture_distance(&landed, plain.it.q, plain.it.v) == 0);
}

/* Without a step the tolerance is that of the local frequency. */
TEST("by tolerance")
{
    fixture_set(&f, &oscillator_system);
    f.options.rtol = 1e-4;
    fixture_start(&f, name, 0);
    CU_ASSERT_FATAL(pk_integrator_step(&f.it, 1e9) == PK_DONE);
    CU_ASSERT(fabs(f.it.t - sqrt(24e-4)) < 1e-14);
    const double frequency = 2 * asin(f.it.t / 2) / f.it.t;
    CU_ASSERT(fabs((frequency - 1) / 1e-4 - 1) < 0.01);
}

TEST("what it cannot follow")
{
    fixture_set(&f, &pendulum_system); /* da/dq = -g cos q passes 0 */
    f.options.h = 0.05;
    fixture_start(&f, name, 0);
    CU_ASSERT(pk_integrator_to(&f.it, 100) == PK_STEP_UNDERFLOW);
    CU_ASSERT(says(&f.it, "a largest step") && f.it.t > 1 && f.it.t < 10);
    f.options.h_max = 0.1;
    fixture_start(&f, name, 0);
    CU_ASSERT(pk_integrator_to(&f.it, 100) == PK_DONE);
    CU_ASSERT(f.it.count.steps > 1000 && f.it.count.steps < 2400); /* between h and h_max */

    fixture_set(&f, &pendulum_system); /* and there nothing says how long a step may be */
    f.q0[0] = acos(0);
    f.params.g = 1;
    f.options.h = 0.05;
    CU_ASSERT(fixture_init(&f, name) == PK_DONE); /* cos(pi/2) is 6e-17 in double */
    CU_ASSERT(pk_integrator_to(&f.it, 100) == PK_STEP_UNDERFLOW);
    CU_ASSERT(fixture_run(&f, &driven_system, name, 1e-4, 1) == PK_REFUSED);
}

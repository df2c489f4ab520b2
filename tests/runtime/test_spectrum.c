/* Frequencies: of sums of cosines, of a pendulum at a large swing (REGIMES P1), of the double
 * pendulum at a small one (D1).
 */
#include "fixture.h"

enum { COUNT = 4000 };
static double x[COUNT];

static struct pk_spectrum spectrum_of(size_t count, double dt, size_t lines)
{
    struct pk_spectrum s;
    CU_ASSERT_FATAL(pk_gsl_spectrum(&s, x, count, dt, lines) == PK_DONE);
    return s;
}

TEST("sums of cosines")
{
    /* One without a companion, two close ones, a small one beside large ones; a mean and a rate. */
    static const struct pk_line given[] = {{1, 0.7, 0.3, 0},
                                           {1.41421356237309505, 0.2, -2, 0},
                                           {1.45, 0.05, 1.1, 0},
                                           {4.25, 1e-6, -0.4, 0}};
    const double dt = 0.31, pi = acos(-1);
    for (int j = 0; j < COUNT; j++) {
        x[j] = 2.385 - 0.013 * dt * j;
        for (int k = 0; k < 4; k++)
            x[j] += given[k].amplitude * cos(given[k].frequency * dt * j + given[k].phase);
    }
    const struct pk_spectrum s = spectrum_of(COUNT, dt, 6);
    CU_ASSERT(fabs(s.mean - 2.385) < 1e-9 && fabs(s.rate + 0.013) < 1e-11);
    CU_ASSERT(s.count >= 4 && s.residual < 1e-12);
    CU_ASSERT(fabs(s.nyquist - pi / dt) < 1e-12);
    CU_ASSERT(fabs(s.resolution - 4 * pi / (dt * (COUNT - 1))) < 1e-12);
    for (int k = 0; k < 4; k++) {
        CU_ASSERT(fabs(s.lines[k].frequency - given[k].frequency) < 1e-9);
        CU_ASSERT(fabs(s.lines[k].amplitude / given[k].amplitude - 1) < 1e-6);
        CU_ASSERT(fabs(s.lines[k].phase - given[k].phase) < 1e-6);
        CU_ASSERT(s.lines[k].error < 1e-8);
        CU_ASSERT(fabs(s.lines[k].frequency - given[k].frequency) <= 2 * s.lines[k].error + 1e-14);
    }
    /* Two that the time cannot tell apart: fewer lines, and a residual that says so. */
    for (int j = 0; j < 500; j++)
        x[j] = cos(dt * j) + 0.5 * cos(1.02 * dt * j);
    const struct pk_spectrum blurred = spectrum_of(500, dt, 4);
    CU_ASSERT(blurred.resolution > 0.08);
    CU_ASSERT(blurred.residual > 1e-4 || blurred.lines[0].error > 1e-4);
}

TEST("single lines")
{
    const double dt = 0.31;
    for (double phase = 0; phase < 6; phase += 0.7) { /* whatever the phase */
        for (int j = 0; j < COUNT; j++)
            x[j] = cos(1.1 * dt * j + phase);
        CU_ASSERT(fabs(spectrum_of(COUNT, dt, 1).lines[0].frequency - 1.1) < 1e-12);
    }
    for (int j = 0; j < COUNT; j++)
        x[j] = 0.2 * cos(1.1 * dt * j) + cos(4.25 * dt * j);
    const struct pk_spectrum s = spectrum_of(COUNT, dt, 2); /* the larger first */
    CU_ASSERT(s.lines[0].amplitude > 0.9 && fabs(s.lines[0].frequency - 4.25) < 1e-12);
    CU_ASSERT(fabs(s.lines[1].frequency - 1.1) < 1e-12);
    CU_ASSERT(spectrum_of(150, dt, 2).lines[0].error < 1e-9); /* from halves below the least */
}

TEST("refusals")
{
    struct pk_spectrum s;
    memset(x, 0, sizeof x);
    CU_ASSERT(pk_gsl_spectrum(&s, x, 50, 0.1, 4) == PK_BAD_ARGUMENT);
    CU_ASSERT(pk_gsl_spectrum(&s, x, 500, 0, 4) == PK_BAD_ARGUMENT);
    CU_ASSERT(pk_gsl_spectrum(&s, x, 500, 0.1, 4) == PK_DONE && s.count == 0);
    x[77] = (double)NAN;
    CU_ASSERT(pk_gsl_spectrum(&s, x, 500, 0.1, 4) == PK_NOT_FINITE);
}

/* COUNT samples dt apart of coordinate 0. */
static void sampled(const struct pk_system *system, const double *q, double dt)
{
    static struct fixture f;
    fixture_set(&f, system);
    memcpy(f.q0, q, system->n * sizeof *q);
    memset(f.v0, 0, sizeof f.v0);
    f.options.rtol = f.options.atol = 1e-13;
    f.options.atol = 1e-18;
    fixture_start(&f, "dop853", 0);
    for (int j = 0; j < COUNT; j++) {
        CU_ASSERT_FATAL(pk_integrator_to(&f.it, j * dt) == PK_DONE);
        x[j] = f.it.q[0];
    }
}

TEST("pendulums")
{
    const double right_angle[] = {1.57079632679489661923}, small[] = {1e-6, 0.7e-6};
    sampled(&pendulum_system, right_angle, 0.25);
    const struct pk_spectrum s = spectrum_of(COUNT, 0.25, 5);
    printf("\n    pendulum at 90 degrees: period ratio %.10f, 3 w: %.1e, residual %.1e",
           1 / s.lines[0].frequency, s.lines[1].frequency / s.lines[0].frequency - 3, s.residual);
    CU_ASSERT(fabs(1 / s.lines[0].frequency - 1.1803405990) < 2e-10 && s.lines[0].error > 0);
    CU_ASSERT(fabs(s.lines[1].frequency / s.lines[0].frequency - 3) < 1e-9);
    CU_ASSERT(s.lines[1].amplitude > 1e-3 * s.lines[0].amplitude);
    sampled(&double_pendulum_system, small, 0.1);
    const struct pk_spectrum d = spectrum_of(COUNT, 0.1, 2);
    printf("\n    double pendulum, small swings: %.10f +- %.0e, %.10f +- %.0e, residual %.1e",
           d.lines[0].frequency, d.lines[0].error, d.lines[1].frequency, d.lines[1].error,
           d.residual);
    const double slow = fabs(d.lines[0].frequency - 2.3971993979);
    const double fast = fabs(d.lines[1].frequency - 5.7873512980);
    CU_ASSERT(slow < 1e-10 && fast < 1e-10 && d.lines[0].error > 0 && d.lines[0].error < 1e-9);
    /* Twenty times fewer periods know less. */
    const struct pk_spectrum brief = spectrum_of(COUNT / 20, 0.1, 2);
    CU_ASSERT(brief.lines[1].error > 3 * d.lines[1].error);
}

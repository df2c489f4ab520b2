/* Which solution of an implicit step's equations is taken (runtime/src/implicit/branch.c), and what
 * is said where it is not the one of short steps. Prediction L14: the midpoint rule on a pendulum
 * at rest upright has one solution iff h omega <= 2, three at 2.01, seven at 6.
 */
#include "fixture.h"

#include "implicit/gauss.h"

static struct fixture f;

static const char *reason(void)
{
    static char text[400];
    CU_ASSERT(pk_integrator_reason(&f.it, text, sizeof text) > 0);
    return text;
}

/* G(y) of the midpoint rule, y the coordinate at the stage: y = q0 + h v0/2 - (h omega)^2/4 sin y.
 * */
static double midpoint(double y, double q0, double v0, double h)
{
    return y - q0 - h * v0 / 2 + h * h / 4 * sin(y);
}

/* All its roots, by signs and bisection. */
static int roots(double q0, double v0, double h, double *root)
{
    const double reach = h * h / 4 + 1, middle = q0 + h * v0 / 2;
    int count = 0;
    for (double y = middle - reach; y < middle + reach; y += 0.01037) {
        double lo = y, hi = y + 0.01037;
        if ((midpoint(lo, q0, v0, h) > 0) == (midpoint(hi, q0, v0, h) > 0))
            continue;
        for (int i = 0; i < 60; i++) {
            const double at = (lo + hi) / 2;
            if ((midpoint(at, q0, v0, h) > 0) == (midpoint(lo, q0, v0, h) > 0))
                lo = at;
            else
                hi = at;
        }
        CU_ASSERT_FATAL(count < 9);
        root[count++] = lo;
    }
    return count;
}

/* One step of gauss1 from that guess of V: its status, and the y at which it ended. */
static enum pk_status from_guess(double q0, double v0, double h, double *y)
{
    fixture_set(&f, &pendulum_system);
    f.q0[0] = q0;
    f.v0[0] = v0;
    fixture_start(&f, "gauss1", h);
    struct pk_gauss_work w = pk_gauss_parts(&f.it);
    f.it.own->h = h;
    pk_gauss_set_step(&f.it, &w, h);
    w.V[0] = (*y - q0) * 2 / h;
    const enum pk_status status = f.it.status = pk_gauss_solve(&f.it, &w);
    *y = w.Q[0];
    return status;
}

/* Every root satisfies the equations; from each the one of short steps is found, or it is said that
 * this one does not come so far. */
TEST("all roots of the midpoint rule")
{
    static const struct {
        double q0, v0, h;
        int roots, right; /* number of the right one; -1: none */
    } rows[] = {{3.141592653589793, 0, 1.998, 1, 0},
                {3.141592653589793, 0, 2.01, 3, -1},
                {3.141592653589793, 0, 6, 7, -1},
                {1.2, 0, 6, 5, 2},
                {-1.7, 0.4, 6, 5, 2},
                {2.385, 0.13, 1.9, 1, 0}};
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        double root[9];
        const int count = roots(rows[k].q0, rows[k].v0, rows[k].h, root);
        CU_ASSERT(count == rows[k].roots);
        for (int i = 0; i < count; i++) {
            double y = root[i];
            const enum pk_status status = from_guess(rows[k].q0, rows[k].v0, rows[k].h, &y);
            if (rows[k].right < 0) {
                CU_ASSERT(status == PK_AMBIGUOUS_STEP);
                CU_ASSERT(fabs(f.it.reason.value - 2) < 2e-3); /* where the solutions part */
            } else {
                CU_ASSERT(status == PK_DONE);
                CU_ASSERT(fabs(y - root[rows[k].right]) < 1e-12);
            }
        }
    }
}

/* The same by whole runs; the reason says how long a step may be. */
TEST("upright: L14")
{
    fixture_set(&f, &pendulum_system);
    f.q0[0] = acos(-1);
    f.v0[0] = 0;
    fixture_start(&f, "gauss1", 6);
    CU_ASSERT(pk_integrator_to(&f.it, 12) == PK_AMBIGUOUS_STEP && f.it.t == 0);
    CU_ASSERT(f.it.q[0] == f.q0[0] && f.it.v[0] == 0);
    CU_ASSERT(says(&f.it, "several solutions") && says(&f.it, "not to 6:"));
    printf("\n    %s", reason());
    for (int above = 0; above < 2; above++) {
        pk_integrator_reset(&f.it, 0, f.q0, f.v0);
        pk_integrator_set_step(&f.it, above ? 2.002 : 1.998);
        CU_ASSERT(pk_integrator_step(&f.it, 1e3) == (above ? PK_AMBIGUOUS_STEP : PK_DONE));
    }
    /* Past both limits, 2/5.787 and 2/2.397, the determinant of Newton's matrix is positive again.
     * */
    fixture_set(&f, &double_pendulum_system);
    f.q0[0] = f.q0[1] = acos(-1);
    f.v0[0] = f.v0[1] = 0;
    fixture_start(&f, "gauss1", 0.9);
    CU_ASSERT(pk_integrator_to(&f.it, 9) == PK_AMBIGUOUS_STEP);
    CU_ASSERT(fabs(f.it.reason.value - 2 / 5.7873512980) < 4e-4);
    /* An adaptive method cuts its step instead. gamma of A, 3 stages, is .27489: h < 3.6378. */
    fixture_set(&f, &pendulum_system);
    f.q0[0] = acos(-1);
    f.v0[0] = 0;
    fixture_start(&f, "radau", 0);
    double longest = 0;
    while (f.it.t < 40) {
        CU_ASSERT_FATAL(pk_integrator_step(&f.it, 40) == PK_DONE);
        longest = fmax(longest, f.it.t - f.it.last_t);
    }
    CU_ASSERT(longest > 1 && longest < 3.6378);
    fixture_start(&f, "radau5", 4);
    CU_ASSERT(pk_integrator_to(&f.it, 8) == PK_AMBIGUOUS_STEP);
    CU_ASSERT(fabs(f.it.reason.value - 3.6378342) < 4e-3);
}

/* Stiffness without a second solution is not stopped, and costs little: the matrix stays. */
TEST("convex stiffness")
{
    static const char *const names[] = {"gauss1", "gauss2", "gauss3", "gauss4",
                                        "gauss6", "gauss8", "radau5", "radau9"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        CU_ASSERT(fixture_run(&f, &oscillator_system, names[i], 100, 1000) == PK_DONE);
        CU_ASSERT(f.it.count.steps == 10 && f.it.count.jacobians > 0);
        const unsigned long made = f.it.count.jacobians;
        if (i < 6) { /* Radau's motion dies out, and with it the scale that its iteration ends by */
            CU_ASSERT(pk_integrator_to(&f.it, 21000) == PK_DONE);
            CU_ASSERT(f.it.count.jacobians == made);
        }
    }
    /* Stiffer and stiffer with the deflection, h omega to 12: convex, so that there is one. */
    CU_ASSERT(fixture_run(&f, &stiffening_system, "gauss1", 5, 500) == PK_DONE);
}

/* Steps at which nothing is in doubt cost no derivative but Newton's. */
TEST("nothing in doubt")
{
    CU_ASSERT(fixture_run(&f, &double_pendulum_system, "gauss4", 0.02, 10) == PK_DONE);
    CU_ASSERT(f.it.count.jacobians == 4 * f.it.count.factorisations + 1); /* one at the start */
}

/* Newton's says how far it came: the rates of L = -sqrt(1 - v^2) must stay below 1. */
TEST("no convergence")
{
    fixture_open(&f, &double_pendulum_system, "gauss4", 0.5);
    CU_ASSERT(pk_integrator_to(&f.it, 100) < 0);
    CU_ASSERT(f.it.reason.value > 0.1 && f.it.reason.value < 0.5);
    CU_ASSERT(says(&f.it, "make the step shorter"));
}

/* M indefinite at an inner stage alone: in the first step, and where the matrix was kept. */
TEST("M indefinite inside a step")
{
    static const struct {
        const char *method;
        double c;
    } rows[] = {{"gauss1", 0.5},          {"gauss3", 0.5},   {"gauss4", 0.3300094782},
                {"gauss8", 0.5917173212}, {"lobatto3", 0.5}, {"radau5", 0.6449489743},
                {"radau9", 0.2768430136}};
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++)
        for (int step = 0; step < 8; step += 7) {
            fixture_set(&f, &dipping_system);
            f.params.limit = step + rows[k].c;
            fixture_start(&f, rows[k].method, 1);
            CU_ASSERT(pk_integrator_to(&f.it, 10) == PK_SINGULAR_MASS);
            CU_ASSERT(f.it.t == step && fabs(f.it.reason.time - f.params.limit) < 1e-9);
            CU_ASSERT(f.it.v[0] == f.v0[0] && f.it.reason.value < -0.999);
        }
    /* Between the stages nothing is asked. */
    fixture_set(&f, &dipping_system);
    f.params.limit = 0.9;
    fixture_start(&f, "gauss1", 1);
    CU_ASSERT(pk_integrator_to(&f.it, 10) == PK_DONE);
}

static double norm_of(const double *X, size_t n)
{
    double numbers[9], x[3], y[3];
    struct pk_gauss_work w = {.s = 1, .places = n, .x = x, .y = y, .other = {.border = n}};
    pk_band_lay_out(&w.other, numbers);
    memcpy(numbers, X, n * n * sizeof *X);
    return pk_gauss_norm(&w, NULL);
}

/* The norm sees through rows that take and do not give, one after the other, and units, and stays
 * above the spectral radius of |X|. */
TEST("a norm for any units")
{
    static const double sink[9] = {0.1, 0, 0, 700, 0, 0, 40, -700, 0.1};
    static const double turning[9] = {0, 0.5, 0, 0, 0, 2, -0.512, 0, 0}; /* cube: 0.512 */
    static const double units[4] = {0.3, 1e4, -2e-5, 0.2}; /* 0.25 + sqrt(0.0025 + 0.2) */
    static const double broken[4] = {0.3, NAN, 0, 0.2};
    const double found = norm_of(turning, 3), of_units = norm_of(units, 2);
    CU_ASSERT(norm_of(sink, 3) <= 0.3);
    CU_ASSERT(found >= 0.8 - 1e-12 && found < 0.87);
    CU_ASSERT(of_units >= 0.7 - 1e-12 && of_units < 0.75);
    CU_ASSERT(isnan(norm_of(broken, 2)));
}

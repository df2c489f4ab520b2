/* What symplectic and symmetric methods promise: bounded energy over long runs with M(q), the
 * symplectic form kept by the step map in (q, p), reversal; each with a method that fails it.
 */
#include <pk/step/state.h>
#include "fixture.h"

static double energy_drift(const char *method, double h, double t_end, double *slope)
{
    static struct fixture f;
    struct pk_drift drift;
    pk_drift_init(&drift);
    fixture_set(&f, &double_pendulum_system);
    f.q0[0] = 0.5, f.q0[1] = 0.5, f.v0[0] = f.v0[1] = 0;
    fixture_start(&f, method, h);
    while (f.it.t < t_end) {
        CU_ASSERT_FATAL(pk_integrator_step(&f.it, t_end) == PK_DONE);
        const struct pk_system *s = f.problem.system;
        pk_drift_update(&drift, f.it.t, s->energy(&f.params, f.it.t, f.it.q, f.it.v, f.it.own->u));
    }
    *slope = pk_drift_slope(&drift) * t_end;
    return pk_drift_max(&drift);
}

TEST("energy of the double pendulum over 1e5 steps")
{
    double slope, slope4;
    const double gauss = energy_drift("gauss2", 0.02, 2000, &slope); /* 1e5 steps */
    const double rk4 = energy_drift("rk4", 0.02, 2000, &slope4);
    printf("\n    1e5 steps: gauss2 max %.2e trend %.1e, rk4 max %.2e trend %.1e", gauss, slope,
           rk4, slope4);
    CU_ASSERT(gauss > 1e-12 && gauss < 1e-5);
    CU_ASSERT(fabs(slope) < 0.02 * gauss);
    CU_ASSERT(rk4 > 10 * gauss && fabs(slope4) > 0.5 * rk4);
}

/* Start in (q, p): v by solving M v = p, then one run, then p again. */
static void map(const char *method, const double *z, double *out, double h, int steps)
{
    static struct fixture f;
    double M[4], pdot[2];
    const struct pk_system *s = &double_pendulum_system;
    fixture_set(&f, s);
    memcpy(f.q0, z, 2 * sizeof *z);
    s->mass(&f.params, 0, z, z, NULL, M);
    const double det = M[0] * M[3] - M[1] * M[2];
    f.v0[0] = (M[3] * z[2] - M[1] * z[3]) / det;
    f.v0[1] = (M[0] * z[3] - M[2] * z[2]) / det;
    f.options.h = f.options.h_max = h;
    f.options.rtol = f.options.atol = 1e10; /* adaptive: a fixed step, its equations solved */
    f.options.newton_tol = strcmp(method, "gauss") == 0 ? 1e-15 : 0;
    fixture_start(&f, method, 0);
    CU_ASSERT_FATAL(pk_integrator_to(&f.it, h * steps) == PK_DONE);
    CU_ASSERT(f.it.count.steps == (unsigned long)steps);
    memcpy(out, f.it.q, 2 * sizeof *out);
    s->canonical(&f.params, 0, f.it.q, f.it.v, NULL, out + 2, pdot);
    if (f.it.p) /* v belongs to p to round-off */
        CU_ASSERT(fabs(out[2] - f.it.p[0]) < 1e-13 && fabs(out[3] - f.it.p[1]) < 1e-13);
}

/* max |D^T J D - J| of the map's derivative D by differences of fourth order. */
static double symplectic_defect(const char *method, double h)
{
    static const double z[] = {1.3, -0.9, 1.1, -0.4}, e = 2e-3;
    double D[4][4], worst = 0;
    for (int j = 0; j < 4; j++) {
        double out[4][4];
        static const double shift[] = {-2, -1, 1, 2}, w[] = {1, -8, 8, -1};
        for (int k = 0; k < 4; k++) {
            double x[4];
            memcpy(x, z, sizeof x);
            x[j] += shift[k] * e;
            map(method, x, out[k], h, 2);
        }
        for (int i = 0; i < 4; i++) {
            D[i][j] = 0;
            for (int k = 0; k < 4; k++)
                D[i][j] += w[k] * out[k][i] / (12 * e);
        }
    }
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) {
            double form = 0;
            for (int k = 0; k < 2; k++)
                form += D[k][i] * D[k + 2][j] - D[k + 2][i] * D[k][j];
            worst = fmax(worst, fabs(form - (i + 2 == j ? 1 : 0) + (j + 2 == i ? 1 : 0)));
        }
    return worst;
}

TEST("the step map is symplectic in (q, p)")
{
    const double rk4 = symplectic_defect("rk4", 0.2);
    printf("\n    symplectic defect: rk4 %.1e", rk4);
    CU_ASSERT(rk4 > 1e-4);
    for (int s = 1; s <= 8; s++) {
        char name[] = "gauss0";
        name[5] = (char)('0' + s);
        const double defect = symplectic_defect(name, 0.2);
        printf(", %s %.1e", name, defect);
        CU_ASSERT(defect > 0 && defect < 2e-8); /* of the differences, e^4 */
    }
    /* The adaptive form, in (q, q'), is not where M varies: as large as its error a step. */
    const double adaptive = symplectic_defect("gauss", 0.3),
                 eight = symplectic_defect("gauss8", 0.3);
    printf("; at h = .3 gauss8 %.1e, gauss %.1e", eight, adaptive);
    CU_ASSERT(eight < 2e-8 && adaptive > 100 * eight);
}

static double reversal(const struct pk_system *system, const char *method)
{
    static struct fixture f;
    fixture_open(&f, system, method, 0.01);
    CU_ASSERT(pk_integrator_to(&f.it, 2) == PK_DONE);
    CU_ASSERT(f.it.q[0] != f.q0[0]);
    CU_ASSERT(pk_integrator_to(&f.it, 0) == PK_DONE);
    CU_ASSERT(f.it.t == 0 && f.it.count.steps == 400);
    return fixture_distance(&f, f.q0, f.v0);
}

TEST("reversal")
{
    for (size_t i = 0; pk_method_at(i); i++) {
        const unsigned traits = pk_method_at(i)->traits;
        const struct pk_system *system = traits & PK_EXACT ? &oscillator_system : &pendulum_system;
        if ((traits & PK_SYMMETRIC) && !(traits & PK_ADAPTIVE))
            CU_ASSERT(reversal(system, pk_method_at(i)->name) < 1e-13);
    }
    CU_ASSERT(reversal(&double_pendulum_system, "gauss2") < 1e-12);
    CU_ASSERT(reversal(&pendulum_system, "symplectic_euler") > 1e-4);
    CU_ASSERT(reversal(&double_pendulum_system, "rk4") > 1e-10);
}

TEST("compensated sums")
{
    /* Kepler, e = .6: angular momentum is exact for Verlet but for round-off, whose random walk
     * of 1e5 plain sums would reach some 3e-14. */
    static struct fixture f;
    fixture_set(&f, &kepler_system);
    f.options.h = 1e-3;
    fixture_init(&f, "verlet");
    CU_ASSERT(pk_integrator_to(&f.it, 100) == PK_DONE);
    double plain[4] = {f.q0[0], f.q0[1], f.v0[0], f.v0[1]}, a[2];
    kepler_system.acceleration(&f.params, 0, plain, plain + 2, NULL, a);
    for (int step = 0; step < 100000; step++) {
        for (int i = 0; i < 2; i++)
            plain[2 + i] += 0.0005 * a[i];
        for (int i = 0; i < 2; i++)
            plain[i] += 0.001 * plain[2 + i];
        kepler_system.acceleration(&f.params, 0, plain, plain + 2, NULL, a);
        for (int i = 0; i < 2; i++)
            plain[2 + i] += 0.0005 * a[i];
    }
    const double l0 = 0.4 * 2.0;
    const double l = fabs(f.it.q[0] * f.it.v[1] - f.it.q[1] * f.it.v[0] - l0);
    const double worse = fabs(plain[0] * plain[3] - plain[1] * plain[2] - l0);
    printf("\n    angular momentum after 1e5 Verlet steps: %.1e, plain sums %.1e", l, worse);
    CU_ASSERT(l < 1.2e-15);
    CU_ASSERT(worse > 2 * l && worse > 2e-15);
}

/* Energy of Kepler, e = .6, over 600 periods, seen at the start's phase so that the method's own
 * wave drops out: a random walk below 1e-14. Rounded h a_ij, or iterations that end at round-off,
 * make it a slope: 9e-17 a period by gauss4. gauss8 has its stages in the lanes. */
TEST("round-off of Gauss is a random walk")
{
    static const struct {
        const char *method;
        int steps;
        double tol;
    } rows[] = {{"gauss4", 200, 0}, {"gauss8", 50, 0}, {"gauss4", 200, 1e-9}};
    static struct fixture f;
    double slope[3], worst[3];
    for (int k = 0; k < 3; k++) {
        struct pk_drift drift;
        pk_drift_init(&drift);
        fixture_set(&f, &kepler_system);
        f.options.h = 2 * acos(-1) / rows[k].steps;
        f.options.newton_tol = rows[k].tol;
        fixture_start(&f, rows[k].method, 0);
        for (int turn = 0; turn < 600; turn++) {
            for (int i = 0; i < rows[k].steps; i++)
                CU_ASSERT_FATAL(pk_integrator_step(&f.it, 1e9) == PK_DONE);
            pk_drift_update_scaled(&drift, turn,
                                   kepler_system.energy(&f.params, 0, f.it.q, f.it.v, NULL), 0.5);
        }
        slope[k] = fabs(pk_drift_slope(&drift));
        worst[k] = pk_drift_max(&drift);
        printf("\n    %s, iterations ended at %g: %.1e a period, max %.1e", rows[k].method,
               rows[k].tol, slope[k], worst[k]);
    }
    for (int k = 0; k < 2; k++)
        CU_ASSERT(worst[k] > 0 && worst[k] < 2e-14 && slope[k] < 3e-17);
    CU_ASSERT(slope[2] > 10 * slope[0]);
}

TEST("Newton converges as Newton")
{
    /* A wrong Jacobian still converges, only slower: so count (2.3 and 4.0 or more). */
    static struct fixture f;
    CU_ASSERT(fixture_run(&f, &double_pendulum_system, "gauss2", 0.01, 5) == PK_DONE);
    const double each = (double)f.it.count.iterations / (double)f.it.count.steps;
    fixture_set(&f, &double_pendulum_system);
    f.options.h = 0.01;
    f.options.iteration = PK_FIXED_POINT; /* the matrix without its derivatives */
    fixture_start(&f, "gauss2", 0);
    CU_ASSERT(pk_integrator_to(&f.it, 5) == PK_DONE);
    const double slow = (double)f.it.count.iterations / (double)f.it.count.steps;
    printf("\n    iterations a step: Newton %.2f, fixed-point %.2f", each, slow);
    CU_ASSERT(each > 1 && each < 3 && slow > 4);
}

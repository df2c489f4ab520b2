/* Lobatto IIIA-IIIB pairs and Radau IIA: their tables, Verlet as the first of the pairs, energy
 * over long times, decay, and the adaptive one on stiff systems.
 */
#include "fixture.h"
#include "core/tableau.h"

static struct fixture f;

struct table {
    int stages;
    double c[5], b[5];
};

/* a_ij of q and of p. */
static struct table tables_of(const char *name, double a[5][5], double a_p[5][5])
{
    const struct pk_gauss *table = (const struct pk_gauss *)pk_method_find(name)->table;
    const int s = table->stages;
    struct table t = {.stages = s};
    double mu[25];
    pk_collocation(table, t.c, t.b, mu);
    for (int i = 0; i < s; i++)
        for (int j = 0; j < s; j++) {
            a[i][j] = mu[i * s + j] * t.b[j];
            a_p[i][j] = table->conjugate ? t.b[j] * (1 - mu[j * s + i]) : a[i][j];
        }
    return t;
}

/* The largest defect of sum_j a_ij c_j^(k-1) = c_i^k / k, k = 1 .. order: C(order). */
static double defect_c(const struct table *t, double a[5][5], int order)
{
    double worst = 0;
    for (int k = 1; k <= order; k++)
        for (int i = 0; i < t->stages; i++) {
            double sum = 0;
            for (int j = 0; j < t->stages; j++)
                sum += a[i][j] * pow(t->c[j], k - 1);
            worst = fmax(worst, fabs(sum - pow(t->c[i], k) / k));
        }
    return worst;
}

/* B(order): sum b_i c_i^(k-1) = 1/k. D(order): sum_i b_i c_i^(k-1) a_ij = b_j (1 - c_j^k) / k. */
static double defect_b(const struct table *t, int order)
{
    double worst = 0;
    for (int k = 1; k <= order; k++) {
        double sum = 0;
        for (int i = 0; i < t->stages; i++)
            sum += t->b[i] * pow(t->c[i], k - 1);
        worst = fmax(worst, fabs(sum - 1.0 / k));
    }
    return worst;
}

static double defect_d(const struct table *t, double a[5][5], int order)
{
    double worst = 0;
    for (int k = 1; k <= order; k++)
        for (int j = 0; j < t->stages; j++) {
            double sum = 0;
            for (int i = 0; i < t->stages; i++)
                sum += t->b[i] * pow(t->c[i], k - 1) * a[i][j];
            worst = fmax(worst, fabs(sum - t->b[j] * (1 - pow(t->c[j], k)) / k));
        }
    return worst;
}

/* Butcher's simplifying assumptions, which give the orders (Hairer, Wanner II, IV.5; GNI II.1.4),
 * hold so far and no further. B, C, D of Radau IIA: 2s-1, s, s-1; IIIA: 2s-2, s, s-2; IIIB: ..,
 * s-2, s. */
TEST("tables")
{
    static const char *const names[] = {"radau5", "radau9", "lobatto2", "lobatto3", "lobatto4"};
    for (int m = 0; m < 5; m++) {
        const struct pk_method *method = pk_method_find(names[m]);
        const int radau = m < 2;
        double a[5][5], a_p[5][5], pair = 0, mirror = 0;
        const struct table table = tables_of(names[m], a, a_p), *t = &table;
        const int s = t->stages;
        CU_ASSERT(method->stages == s && method->order == (radau ? 2 * s - 1 : 2 * s - 2));
        CU_ASSERT(defect_b(t, method->order) < 1e-14 && defect_b(t, method->order + 1) > 1e-6);
        CU_ASSERT(defect_c(t, a, s) < 1e-15 && defect_c(t, a, s + 1) > 1e-4);
        const int d = radau ? s - 1 : s - 2;
        CU_ASSERT(defect_d(t, a, d) < 1e-14 && defect_d(t, a, d + 1) > 1e-5);
        if (!radau) {
            CU_ASSERT(defect_c(t, a_p, s - 2) < 1e-15 && defect_c(t, a_p, s - 1) > 1e-3);
            CU_ASSERT(defect_d(t, a_p, s) < 1e-15 && defect_d(t, a_p, s + 1) > 1e-5);
        }
        for (int i = 0; i < s; i++)
            for (int j = 0; j < s; j++) {
                const int ii = s - 1 - i, jj = s - 1 - j;
                pair =
                    fmax(pair, fabs(t->b[i] * a_p[i][j] + t->b[j] * a[j][i] - t->b[i] * t->b[j]));
                mirror = fmax(mirror, fabs(a[ii][jj] + a[i][j] - t->b[j]));
                mirror = fmax(mirror, fabs(a_p[ii][jj] + a_p[i][j] - t->b[j]));
            }
        CU_ASSERT(method->traits & PK_SYMPLECTIC ? pair < 1e-15 : pair > 1e-3);
        CU_ASSERT(method->traits & PK_SYMMETRIC ? mirror < 1e-15 : mirror > 0.01);
        CU_ASSERT(!radau == !!(method->traits & PK_SYMPLECTIC));
    }
}

/* Two stages on a separable system are Verlet; on M(q) they are not, and it is refused there. */
TEST("lobatto2 is Verlet")
{
    static struct fixture v;
    for (int k = 0; k < 2; k++) {
        const struct pk_system *system = k ? &kepler_system : &pendulum_system;
        CU_ASSERT(fixture_run(&f, system, "lobatto2", 0.05, 20) == PK_DONE);
        CU_ASSERT(fixture_run(&v, system, "verlet", 0.05, 20) == PK_DONE);
        CU_ASSERT(fixture_distance(&f, v.it.q, v.it.v) < 3e-13);
        CU_ASSERT(fixture_run(&v, system, "gauss1", 0.05, 20) == PK_DONE);
        CU_ASSERT(fixture_distance(&f, v.it.q, v.it.v) > 1e-4);
    }
    CU_ASSERT(fixture_run(&v, &double_pendulum_system, "verlet", 0.05, 1) == PK_REFUSED);
    CU_ASSERT(fixture_run(&f, &double_pendulum_system, "lobatto2", 0.05, 1) == PK_DONE);
}

/* Energy of the double pendulum over 2e4 steps: bounded for the pairs, not for Radau. */
TEST("energy over long times")
{
    static const struct {
        const char *method;
        double most, slope; /* of the drift, per unit of time */
    } rows[] = {{"lobatto2", 0.02, 2e-6},
                {"lobatto3", 5e-4, 1e-7},
                {"lobatto4", 1e-5, 2e-9},
                {"radau5", 1, 1}};
    for (int k = 0; k < 4; k++) {
        struct pk_drift drift;
        pk_drift_init(&drift);
        fixture_open(&f, &double_pendulum_system, rows[k].method, 0.02);
        for (int i = 0; i < 20000; i++) {
            CU_ASSERT_FATAL(pk_integrator_step(&f.it, 1e9) == PK_DONE);
            pk_drift_update_scaled(
                &drift, f.it.t, double_pendulum_system.energy(&f.params, 0, f.it.q, f.it.v, NULL),
                30);
        }
        const double most = pk_drift_max(&drift), slope = pk_drift_slope(&drift);
        printf("\n    %s: %.1e, %.1e a second", rows[k].method, most, slope);
        CU_ASSERT(most > 1e-9 && most < rows[k].most && fabs(slope) < rows[k].slope);
        if (k == 3) /* not bounded: a straight line */
            CU_ASSERT(fabs(slope) > 1e-7 && fabs(slope * f.it.t) > most / 2);
    }
}

/* L-stable: what is infinitely fast is gone after one step; A-stable alone keeps it for ever. */
TEST("L-stable")
{
    static const struct {
        const char *method;
        double least, most;
    } rows[] = {
        {"radau5", 0, 1e-3}, {"radau9", 0, 1e-3}, {"gauss2", 0.9, 1.1}, {"gauss3", 0.9, 1.1}};
    for (int k = 0; k < 4; k++) {
        fixture_set(&f, &damped_system); /* spread decays by exp(-5000 t), or stays */
        f.params.g = 1e12;
        f.params.limit = 1e9;
        f.q0[1] = 1;
        f.v0[1] = 2;
        fixture_start(&f, rows[k].method, 1e-1);
        CU_ASSERT(pk_integrator_step(&f.it, 10) == PK_DONE);
        if (k < 2) /* p is that of the last stage: from the sum of stiff forces it errs by 1e-8 */
            CU_ASSERT(f.it.p[1] == f.it.v[1] && f.it.p[0] == f.it.v[0]);
        const double left = fabs(f.it.v[1] - f.it.v[0]) / 2;
        CU_ASSERT(left >= rows[k].least && left < rows[k].most);
        CU_ASSERT(fabs(f.it.v[1] + f.it.v[0] - 2) < 0.2); /* momentum is not what decays */
    }
}

/* Final error of radau against its tolerance, and what it costs where explicit methods creep. */
TEST("stiff")
{
    static const struct {
        const struct pk_system *system;
        double t;
        int stiff;
    } rows[] = {{&van_der_pol_system, 400, 1},
                {&damped_system, 10, 1},
                {&double_pendulum_system, 3, 0},
                {&forced_system, 4, 0},
                {&relativistic_system, 10, 0}};
    static struct fixture e;
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        double tol[8], error[8];
        int count = 0;
        CU_ASSERT(fixture_run(&e, rows[k].system, k ? "radau9" : "dop853",
                              k ? rows[k].t / 1000 : 1e-12, rows[k].t) == PK_DONE);
        for (double x = 1e-4; x > 5e-11; x /= 10) {
            CU_ASSERT(fixture_run(&f, rows[k].system, "radau", x, rows[k].t) == PK_DONE);
            CU_ASSERT(f.it.t == rows[k].t);
            tol[count] = x;
            error[count] = fixture_distance(&f, e.it.q, e.it.v);
            CU_ASSERT(error[count] > 0 && error[count] < 50 * x);
            count++;
        }
        const double slope = fit_slope(tol, error, count);
        printf("\n    %s: error ~ tol^%.2f, %.1e at 1e-10", rows[k].system->name, slope,
               error[count - 1]);
        CU_ASSERT(slope > 0.7 && slope < 1.1);
        if (!rows[k].stiff)
            continue;
        CU_ASSERT(fixture_run(&f, rows[k].system, "radau", 1e-6, rows[k].t) == PK_DONE);
        const double error_radau = fixture_distance(&f, e.it.q, e.it.v);
        CU_ASSERT(fixture_run(&e, rows[k].system, "dopri5", 1e-3, rows[k].t) == PK_DONE);
        const double ratio = (double)e.it.count.evaluations / (double)f.it.count.evaluations;
        printf("; dopri5 at 1e-3 evaluates %.0f times as often as radau at 1e-6", ratio);
        CU_ASSERT(ratio > 100);
        CU_ASSERT(fixture_distance(&e, f.it.q, f.it.v) > 10 * error_radau);
    }
}

/* A longest step, an input, a singular end, no tolerance for what is not there. */
TEST("control")
{
    double q, v;
    fixture_set(&f, &driven_system);
    driven_exact(7, &q, &v);
    f.options.rtol = f.options.atol = 1e-10;
    f.options.h_max = 0.2;
    fixture_start(&f, "radau", 0);
    while (f.it.t < 7) {
        CU_ASSERT_FATAL(pk_integrator_step(&f.it, 7) == PK_DONE);
        CU_ASSERT(f.it.t - f.it.last_t <= 0.2 * 1.0101);
    }
    CU_ASSERT(fixture_distance(&f, &q, &v) < 1e-8);
    CU_ASSERT(pk_integrator_dense(&f.it, 1, &q, &v) == PK_BAD_ARGUMENT);

    CU_ASSERT(fixture_run(&f, &folded_system, "radau", 0, 10) == PK_SINGULAR_MASS);
    CU_ASSERT(fabs(f.it.t - 0.55 * 2 / 3 / 0.2) < 0.02);
    CU_ASSERT(fixture_run(&f, &broken_system, "radau", 0, 10) == PK_NOT_FINITE && f.it.t < 1.25 &&
              f.it.t > 1.2);
    fixture_set(&f, &pendulum_system);
    f.options.atol = 0;
    f.v0[0] = 0;
    fixture_start(&f, "radau", 0);
    CU_ASSERT(pk_integrator_to(&f.it, 5) == PK_DONE && f.it.count.steps < 300);
    f.options.h_min = 0.5;
    fixture_start(&f, "radau", 0);
    CU_ASSERT(pk_integrator_to(&f.it, 5) == PK_STEP_UNDERFLOW);
}

/* Quadratures beside the pendulum: their order is their method's; what stops, fails, is output
 * between steps or taken up again has the right ones.
 */
#include <stdlib.h>

#include "fixture.h"

#define ARGS const void *params, pk_real t, const pk_real *q, const pk_real *v, const pk_real *u

enum { MANY = 2 };

/* One of the position, as an angle's rate in a reduced system; one of all that there is. */
static void rates(ARGS, pk_real *z)
{
    (void)params, (void)u;
    z[0] = (2 - cos(q[0])) / (1.5 + cos(q[0] / 4));
    z[1] = q[0] * q[0] * v[0] + t * v[0] * v[0];
}

static void starts(const void *params, pk_real *z)
{
    z[0] = 3;
    z[1] = ((const struct test_params *)params)->g;
}

static const struct pk_quantity names[] = {{"phi", "", ""}, {"area,2", "", ""}};

static struct pk_system carrying(const struct pk_system *of)
{
    struct pk_system system = *of;
    system.quadratures.n = MANY;
    system.quadratures.names = names;
    system.quadratures.rates = rates;
    system.quadratures.start = starts;
    return system;
}

/* The pendulum and z from its usual start, in long double, by a Runge-Kutta method of its own. */
static void exact(double T, double *z)
{
    const int steps = (int)(4000 * T) + 1000;
    const long double h = (long double)T / steps;
    long double y[4] = {(long double)2.385, (long double)0.13, 3, 1}, k[4][4], x[4];
    for (int step = 0; step < steps; step++) {
        for (int s = 0; s < 4; s++) {
            const long double part = s == 0 ? 0 : s == 3 ? h : h / 2, t = step * h + part;
            for (int i = 0; i < 4; i++)
                x[i] = s ? y[i] + part * k[s - 1][i] : y[i];
            k[s][0] = x[1];
            k[s][1] = -sinl(x[0]);
            k[s][2] = (2 - cosl(x[0])) / (1.5L + cosl(x[0] / 4));
            k[s][3] = x[0] * x[0] * x[1] + t * x[1] * x[1];
        }
        for (int i = 0; i < 4; i++)
            y[i] += h / 6 * (k[0][i] + 2 * k[1][i] + 2 * k[2][i] + k[3][i]);
    }
    z[0] = (double)y[2];
    z[1] = (double)y[3];
    z[MANY] = (double)y[0]; /* and q */
}

static double missed(const struct fixture *f, const double *z)
{
    return fmax(fabs(f->it.z[0] - z[0]), fabs(f->it.z[1] - z[1]));
}

/* Slope of the finest five errors above round-off; quad/order.c goes on above order 6. */
static void order(void)
{
    const struct pk_system system = carrying(&pendulum_system);
    static struct fixture f;
    double z[MANY + 1];
    int found = 0;
    exact(2, z);
    for (size_t i = 0; pk_method_at(i); i++) {
        const struct pk_method *m = pk_method_at(i);
        double h[60], error[60];
        int count = 0;
        CU_ASSERT((m->traits & PK_QUADRATURE ? 1 : 0) == (m->stage != NULL));
        if (!m->stage || m->order > 6)
            continue;
        for (double steps = 4; steps < 20000 && count < 60; steps = ceil(steps * 1.25)) {
            fixture_set(&f, &system);
            f.options.h = f.options.h_max = 2 / steps;
            if (m->traits & PK_ADAPTIVE)
                f.options.rtol = f.options.atol = 1e10, f.options.newton_tol = 1e-14;
            if (fixture_init(&f, m->name) < 0 || pk_integrator_to(&f.it, 2) < 0)
                continue;
            const double e = missed(&f, z);
            if (e < 1e-12)
                break;
            h[count] = 2 / steps;
            error[count++] = e;
        }
        CU_ASSERT_FATAL(count >= 5);
        const double slope = fit_slope(h + count - 5, error + count - 5, 5);
        printf("\n    %-8s order %d, of z %.3f", m->name, m->order, slope);
        CU_ASSERT(fabs(slope - m->order) < (strcmp(m->name, "dopri5") ? 0.1 : 0.3)); /* HNW II.5 */
        found++;
    }
    CU_ASSERT(found == 20);
}

static void tight(void)
{
    static const char *const names_of[] = {"gauss", "dop853", "dopri5", "gauss6", "gauss8"};
    const struct pk_system system = carrying(&pendulum_system);
    static struct fixture f;
    double z[MANY + 1];
    exact(20, z);
    for (int k = 0; k < 5; k++) {
        CU_ASSERT(fixture_run(&f, &system, names_of[k], k < 3 ? 1e-13 : 0.05, 20) == PK_DONE);
        const double error = missed(&f, z), of_q = fabs(f.it.q[0] - z[MANY]);
        printf("\n    %-8s of z %.1e, of q %.1e", names_of[k], error, of_q);
        CU_ASSERT(error < (k < 3 ? 2e-10 : 1e-13) && error < 200 * of_q + 2e-14);
    }
    CU_ASSERT(fixture_run(&f, &system, "gauss", 1e-4, 20) == PK_DONE);
    CU_ASSERT(missed(&f, z) > 1e-10);
}

static void refused(void)
{
    static const char *const others[] = {"verlet", "adaptive_verlet", "gsl_rk8pd"};
    const struct pk_system system = carrying(&pendulum_system);
    static struct fixture f;
    char reason[200];
    for (int k = 0; k < 3; k++) {
        CU_ASSERT(fixture_run(&f, &system, others[k], 0.01, 1) == PK_REFUSED);
        pk_integrator_reason(&f.it, reason, sizeof reason);
        CU_ASSERT(strstr(reason, "carries no quadratures, and pendulum has phi") != NULL);
    }
    CU_ASSERT(fixture_run(&f, &pendulum_system, "gauss", 1e-9, 1) == PK_DONE && !f.it.z);
    CU_ASSERT(pk_integrator_set_quadratures(&f.it, f.q0) == PK_BAD_ARGUMENT);
}

/* Between the ends of steps; a step taken back; other values; the same again after a reset. */
static void between(void)
{
    static const char *const dense[] = {"gauss", "dop853"};
    const struct pk_system system = carrying(&pendulum_system);
    static struct fixture f;
    double z[MANY + 1], at[MANY];
    for (int k = 0; k < 2; k++) {
        fixture_set(&f, &system);
        f.options.rtol = f.options.atol = 1e-10;
        CU_ASSERT_FATAL(fixture_init(&f, dense[k]) == PK_DONE);
        while (f.it.t < 1.5)
            CU_ASSERT_FATAL(pk_integrator_step(&f.it, 10) == PK_DONE);
        for (int part = 0; part <= 4; part++) {
            const double t = part == 4 ? f.it.t : f.it.last_t + part * (f.it.t - f.it.last_t) / 4;
            exact(t, z);
            for (int again = 0; again < 2; again++)
                CU_ASSERT(pk_integrator_dense_quadratures(&f.it, t, at) == PK_DONE);
            CU_ASSERT(fabs(at[0] - z[0]) < 1e-9 && fabs(at[1] - z[1]) < 1e-9);
        }
        CU_ASSERT(at[0] == f.it.z[0] && at[1] == f.it.z[1]);
        CU_ASSERT(pk_integrator_dense_quadratures(&f.it, f.it.t * 1.01, at) == PK_BAD_ARGUMENT);
    }
    exact(2, z);
    CU_ASSERT(fixture_run(&f, &system, "gauss4", 0.01, 1) == PK_DONE);
    CU_ASSERT(pk_integrator_reset(&f.it, 1, f.it.q, f.it.v) == PK_DONE);
    CU_ASSERT(pk_integrator_to(&f.it, 2) == PK_DONE && missed(&f, z) < 1e-12);
    CU_ASSERT(pk_integrator_to(&f.it, 0) == PK_DONE);
    CU_ASSERT(fabs(f.it.z[0] - 3) < 1e-12 && fabs(f.it.z[1] - 1) < 1e-12);
    const double other[] = {1, -1};
    CU_ASSERT(pk_integrator_set_quadratures(&f.it, other) == PK_DONE);
    CU_ASSERT(pk_integrator_to(&f.it, 2) == PK_DONE);
    CU_ASSERT(fabs(f.it.z[0] + 2 - z[0]) < 1e-12 && fabs(f.it.z[1] + 2 - z[1]) < 1e-12);
}

/* A step whose quadrature is no number fails, and z is what it was. */
static void broken(ARGS, pk_real *z)
{
    (void)params, (void)q, (void)v, (void)u;
    z[0] = sqrt(1.25 - t);
    z[1] = 1;
}

static void failure(void)
{
    struct pk_system system = carrying(&pendulum_system);
    static struct fixture f;
    system.quadratures.rates = broken;
    CU_ASSERT(fixture_run(&f, &system, "gauss2", 0.1, 2) == PK_NOT_FINITE);
    CU_ASSERT(f.it.count.steps == 12 && fabs(f.it.z[1] - 2.2) < 1e-14);
    CU_ASSERT(fabs(f.it.z[0] - 3 - (pow(1.25, 1.5) - pow(0.05, 1.5)) / 1.5) < 1e-5);
}

/* Rates that vary faster than the pendulum does: integrals over full periods in closed form. */
static void hasty(ARGS, pk_real *z)
{
    (void)params, (void)q, (void)v, (void)u;
    z[0] = 1 / (1 + 0.9 * cos(15 * t));
    z[1] = 1 + cos(40 * t);
}

static void ending(ARGS, pk_real *z)
{
    (void)params, (void)q, (void)v, (void)u;
    z[0] = 1 / ((1.25 - t) * (1.25 - t));
    z[1] = 1;
}

static void control(void)
{
    static const char *const methods[] = {"gauss", "dop853", "dopri5", "radau"};
    static struct fixture f;
    struct pk_system system = carrying(&pendulum_system);
    const double T = 4 * acos(-1.0);
    for (int k = 0; k < 4; k++) {
        system.quadratures.rates = hasty;
        CU_ASSERT(fixture_run(&f, &system, methods[k], 1e-9, T) == PK_DONE);
        const double of_0 = fabs(f.it.z[0] - 3 - T / sqrt(0.19)), of_1 = fabs(f.it.z[1] - 1 - T);
        printf("\n    %-8s of hasty z %.1e, %.1e", methods[k], of_0, of_1);
        CU_ASSERT(of_0 < 2e-6 && of_1 < 2e-6 && f.it.count.rejections > 0);
        system.quadratures.rates = ending;
        CU_ASSERT(fixture_run(&f, &system, methods[k], 1e-9, 2) == PK_STEP_UNDERFLOW);
        CU_ASSERT(f.it.t < 1.25 && f.it.t > 1.2499);
    }
}

static struct {
    int count;
    double t[8], z[8];
} seen;

static int found(void *context, const struct pk_events *events)
{
    (void)context;
    seen.t[seen.count] = events->t;
    seen.z[seen.count++] = events->z[1];
    return seen.count == 2;
}

static void lowest(ARGS, pk_real *g)
{
    (void)params, (void)t, (void)v, (void)u;
    g[0] = q[0];
}

static void events(void)
{
    static const struct pk_event event[] = {{{"lowest", "", ""}, 0, 0}};
    static const char *const methods[] = {"gauss", "gauss4", "rk4", "dop853"};
    static struct fixture f;
    static double block[8192];
    struct pk_system system = carrying(&pendulum_system);
    struct pk_events watched;
    double z[MANY + 1];
    system.events.n = 1;
    system.events.table = event;
    system.events.values = lowest;
    for (int k = 0; k < 4; k++) {
        fixture_set(&f, &system);
        f.options.h = k == 0 || k == 3 ? 0 : 0.01;
        f.options.rtol = f.options.atol = 1e-11;
        CU_ASSERT_FATAL(fixture_init(&f, methods[k]) == PK_DONE);
        CU_ASSERT_FATAL(pk_events_init(&watched, &f.it, block, sizeof block) == PK_DONE);
        watched.found = found;
        seen.count = 0;
        CU_ASSERT(pk_events_to(&watched, &f.it, 20) == PK_STOPPED_EVENT && seen.count == 2);
        for (int i = 0; i < 2; i++) {
            exact(seen.t[i], z);
            CU_ASSERT(fabs(seen.z[i] - z[1]) < (k == 2 ? 1e-6 : 1e-9));
        }
        CU_ASSERT(f.it.t == seen.t[1] && f.it.z[1] == seen.z[1]);
        CU_ASSERT(pk_events_to(&watched, &f.it, seen.t[1] + 0.5) == PK_DONE);
        exact(f.it.t, z);
        CU_ASSERT(missed(&f, z) < (k == 2 ? 1e-6 : 1e-9));
    }
}

/* Members of an ensemble, whose quadratures start where their parameters say. */
static void members(void)
{
    const struct pk_system system = carrying(&pendulum_system);
    struct test_params params[2];
    double q0[2] = {2.385, 2.385}, v0[2] = {0.13, 0.13}, t[2] = {1, 2}, q[4], v[4], z[8], last[2];
    double end[MANY + 1];
    size_t done[2];
    enum pk_status status[2];
    system.defaults(&params[0]);
    system.defaults(&params[1]);
    struct pk_ensemble e = {.system = &system,
                            .method = pk_method_find("rk4"),
                            .members = 2,
                            .options = pk_options_default(),
                            .params = params,
                            .q0 = q0,
                            .v0 = v0,
                            .rows = 2,
                            .t = t,
                            .q = q,
                            .v = v,
                            .z = z,
                            .done = done,
                            .last_t = last,
                            .status = status};
    e.options.h = 0.001;
    const size_t size = pk_ensemble_size(&e);
    void *block = malloc(size);
    CU_ASSERT_FATAL(block && pk_ensemble_run(&e, 0, 2, block, size) == PK_DONE);
    for (int row = 0; row < 2; row++) {
        exact(t[row], end);
        for (int member = 0; member < 2; member++)
            CU_ASSERT(fabs(z[4 * member + 2 * row + 1] - end[1]) < 1e-10);
    }
    free(block);
}

void add_quadrature(void)
{
    CU_pSuite suite = CU_add_suite("quadrature", NULL, NULL);
    CU_add_test(suite, "order", order);
    CU_add_test(suite, "tight tolerances", tight);
    CU_add_test(suite, "refused", refused);
    CU_add_test(suite, "step control", control);
    CU_add_test(suite, "between steps, back, reset", between);
    CU_add_test(suite, "failure", failure);
    CU_add_test(suite, "events", events);
    CU_add_test(suite, "ensembles", members);
}

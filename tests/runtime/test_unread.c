/* States that nothing reads, as angles that a reduction has left out, beside the pendulum: their
 * order is their method's, and an adaptive method keeps its tolerance in them too.
 */
#include <stdlib.h>

#include "fixture.h"

static struct fixture f;

enum { UNREAD = 2, ALL = 3 };

/* One of the position, as an angle's rate in a reduced system; one of all that there is. */
static void slow(double t, double q, double v, double *rate)
{
    rate[0] = (2 - cos(q)) / (1.5 + cos(q / 4));
    rate[1] = q * q * v + t * v * v;
}

/* What varies faster than the pendulum does: integrals over full periods in closed form. */
static void hasty(double t, double q, double v, double *rate)
{
    (void)q, (void)v;
    rate[0] = 1 / (1 + 0.9 * cos(15 * t));
    rate[1] = 1 + cos(40 * t);
}

static void ending(double t, double q, double v, double *rate)
{
    (void)q, (void)v;
    rate[0] = 1 / ((1.25 - t) * (1.25 - t));
    rate[1] = 1;
}

static void (*rates)(double, double, double, double *) = slow;

static void force(ARGS, pk_real *out)
{
    pendulum_system.force(params, t, q, v, u, out);
    rates(t, q[0], v[0], out + 1);
}
static int acceleration(ARGS, pk_real *a)
{
    force(params, t, q, v, u, a);
    return 0;
}
static void mass(ARGS, pk_real *M)
{
    UNUSED;
    for (int i = 0; i < ALL * ALL; i++)
        M[i] = i % (ALL + 1) == 0;
}
static void canonical(ARGS, pk_real *p, pk_real *pdot)
{
    memcpy(p, v, ALL * sizeof *p);
    force(params, t, q, v, u, pdot);
}
/* Without the rates: what nothing reads takes Newton's method nowhere else. */
static void jacobian(ARGS, pk_real *p_q, pk_real *pdot_q, pk_real *pdot_v)
{
    memset(p_q, 0, ALL * ALL * sizeof *p_q);
    memset(pdot_q, 0, ALL * ALL * sizeof *pdot_q);
    memset(pdot_v, 0, ALL * ALL * sizeof *pdot_v);
    pendulum_system.jacobian(params, t, q, v, u, p_q, pdot_q, pdot_v);
}
static void start(const void *params, pk_real *q, pk_real *v)
{
    memset(q, 0, ALL * sizeof *q);
    pendulum_system.start(params, q, v);
    v[1] = 3, v[2] = 1;
}

static struct pk_system carrying(void)
{
    static const struct pk_quantity names[] = {{"x", "", ""}, {"phi", "", ""}, {"area", "", ""}};
    struct pk_system system = pendulum_system;
    system.facts &= PK_MASS_CONSTANT | PK_MASS_DIAGONAL | PK_QUADRATIC | PK_SMOOTH;
    system.n = ALL, system.n_first_order = system.n_unread = UNREAD;
    system.coordinates = system.rates = system.momenta = names;
    system.cyclic = NULL;
    system.acceleration = acceleration, system.mass = mass, system.force = force;
    system.canonical = canonical, system.jacobian = jacobian, system.start = start;
    system.gradient = NULL, system.lanes = NULL, system.members = NULL, system.linear = NULL;
    system.steppers = NULL, system.block_steppers = NULL, system.fast = NULL;
    return system;
}

/* From its usual start, in long double, by a Runge-Kutta method of its own: q and the states. */
static void exact(double T, double *x)
{
    const int steps = (int)(4000 * T) + 1000;
    const long double h = (long double)T / steps;
    long double y[4] = {(long double)2.385, (long double)0.13, 3, 1}, k[4][4], z[4];
    for (int step = 0; step < steps; step++) {
        for (int s = 0; s < 4; s++) {
            const long double part = s == 0 ? 0 : s == 3 ? h : h / 2, t = step * h + part;
            for (int i = 0; i < 4; i++)
                z[i] = s ? y[i] + part * k[s - 1][i] : y[i];
            k[s][0] = z[1];
            k[s][1] = -sinl(z[0]);
            k[s][2] = (2 - cosl(z[0])) / (1.5L + cosl(z[0] / 4));
            k[s][3] = z[0] * z[0] * z[1] + t * z[1] * z[1];
        }
        for (int i = 0; i < 4; i++)
            y[i] += h / 6 * (k[0][i] + 2 * k[1][i] + 2 * k[2][i] + k[3][i]);
    }
    x[0] = (double)y[0], x[1] = (double)y[2], x[2] = (double)y[3];
}

static double missed(const double *v, const double *x)
{
    return fmax(fabs(v[1] - x[1]), fabs(v[2] - x[2]));
}

static double off(const struct fixture *of, const double *x) { return missed(of->it.v, x); }

/* quad/order.c goes on above order 6. */
TEST("order")
{
    const struct pk_system system = carrying();
    double x[ALL];
    int found = 0;
    exact(2, x);
    for (size_t i = 0; pk_method_at(i); i++) {
        const struct pk_method *m = pk_method_at(i);
        if (m->order > 6 || m->traits & (PK_EXACT | PK_LINEAR | PK_JETS) ||
            m->needs & PK_MASS_CONSTANT)
            continue;
        const double slope = fixture_order(&system, m, 2, 1e-12, off, x);
        printf("\n    %-8s order %d, of states %.3f", m->name, m->order, slope);
        CU_ASSERT(fabs(slope - m->order) < (strcmp(m->name, "dopri5") ? 0.1 : 0.3)); /* HNW II.5 */
        found++;
    }
    CU_ASSERT(found == 21);
}

TEST("tight tolerances")
{
    static const char *const names_of[] = {"gauss", "dop853", "dopri5", "gauss6", "gauss8"};
    const struct pk_system system = carrying();
    double x[ALL];
    exact(20, x);
    for (int k = 0; k < 5; k++) {
        CU_ASSERT(fixture_run(&f, &system, names_of[k], k < 3 ? 1e-13 : 0.05, 20) == PK_DONE);
        const double error = missed(f.it.v, x), of_q = fabs(f.it.q[0] - x[0]);
        printf("\n    %-8s of states %.1e, of q %.1e", names_of[k], error, of_q);
        CU_ASSERT(error < (k < 3 ? 2e-10 : 1e-13) && error < 200 * of_q + 2e-14);
    }
    CU_ASSERT(fixture_run(&f, &system, "gauss", 1e-4, 20) == PK_DONE);
    CU_ASSERT(missed(f.it.v, x) > 1e-10);
}

/* Between the ends of steps, as exact as the tolerance. */
TEST("between steps")
{
    static const char *const dense[] = {"gauss", "dop853"};
    const struct pk_system system = carrying();
    double x[ALL], q[ALL], v[ALL];
    for (int k = 0; k < 2; k++) {
        fixture_open(&f, &system, dense[k], 1e-10);
        while (f.it.t < 1.5)
            CU_ASSERT_FATAL(pk_integrator_step(&f.it, 10) == PK_DONE);
        for (int part = 0; part <= 4; part++) {
            const double t = part == 4 ? f.it.t : f.it.last_t + part * (f.it.t - f.it.last_t) / 4;
            exact(t, x);
            CU_ASSERT(pk_integrator_dense(&f.it, t, q, v) == PK_DONE);
            CU_ASSERT(missed(v, x) < (k ? 1e-7 : 1e-9));
        }
    }
}

/* States whose rounding is as large as the last corrections do not keep Newton's iteration at work. */
TEST("large ones")
{
    const struct pk_system system = carrying();
    unsigned long count[2];
    for (int k = 0; k < 2; k++) {
        fixture_set(&f, &system);
        f.options.h = 0.01;
        f.v0[1] = k ? 1e5 : 3;
        fixture_start(&f, "gauss4", 0);
        CU_ASSERT(pk_integrator_to(&f.it, 20) == PK_DONE);
        count[k] = f.it.count.iterations;
    }
    printf("\n    %lu iterations, %lu where one is large", count[0], count[1]);
    CU_ASSERT(count[0] < 7000 && count[1] < 7000);
}

TEST("step control")
{
    static const char *const methods[] = {"gauss", "dop853", "dopri5", "radau"};
    const struct pk_system system = carrying();
    const double T = 4 * acos(-1.0);
    for (int k = 0; k < 4; k++) {
        rates = hasty;
        CU_ASSERT(fixture_run(&f, &system, methods[k], 1e-9, T) == PK_DONE);
        const double of_0 = fabs(f.it.v[1] - 3 - T / sqrt(0.19)), of_1 = fabs(f.it.v[2] - 1 - T);
        printf("\n    %-8s of hasty states %.1e, %.1e", methods[k], of_0, of_1);
        CU_ASSERT(of_0 < 2e-6 && of_1 < 2e-6 && f.it.count.rejections > 0);
        rates = ending;
        CU_ASSERT(fixture_run(&f, &system, methods[k], 1e-9, 2) == PK_STEP_UNDERFLOW);
        CU_ASSERT(f.it.t < 1.25 && f.it.t > 1.2499);
    }
    rates = slow;
}

/* Newton's equations without them: the same steps, with fewer unknowns. */
TEST("left out of Newton's equations")
{
    static const char *const methods[] = {"gauss1", "gauss4", "lobatto3", "radau5", "radau"};
    for (size_t k = 0; k < sizeof methods / sizeof *methods; k++) {
        double end[2][ALL + 1];
        unsigned long count[2];
        for (int all = 0; all < 2; all++) {
            struct pk_system system = carrying();
            system.n_unread = all ? 0 : UNREAD;
            CU_ASSERT(fixture_run(&f, &system, methods[k], k < 4 ? 0.02 : 1e-9, 7) == PK_DONE);
            memcpy(end[all], f.it.v, ALL * sizeof(double));
            end[all][ALL] = f.it.q[0];
            count[all] = f.it.count.iterations + 10 * f.it.count.rejections;
        }
        for (int i = 0; i <= ALL; i++)
            CU_ASSERT(fabs(end[0][i] - end[1][i]) < (k < 4 ? 1e-12 : 1e-8));
        CU_ASSERT(count[0] <= count[1]);
        printf("\n    %-8s %lu, %lu with all", methods[k], count[0], count[1]);
    }
}

static struct {
    int count;
    double t[8], x[8];
} seen;

static int found(void *context, const struct pk_events *events)
{
    (void)context;
    seen.t[seen.count] = events->t;
    seen.x[seen.count++] = events->v[2];
    return seen.count == 2;
}

static void lowest(ARGS, pk_real *g)
{
    UNUSED;
    g[0] = q[0];
}

TEST("events")
{
    static const struct pk_event event[] = {{{"lowest", "", ""}, 0, 0}};
    static const char *const methods[] = {"gauss", "gauss4", "rk4", "dop853"};
    static double block[8192];
    struct pk_system system = carrying();
    struct pk_events watched;
    double x[ALL];
    system.events = (struct pk_part_events){.n = 1, .table = event, .values = lowest};
    for (int k = 0; k < 4; k++) {
        fixture_set(&f, &system);
        f.options.h = k == 0 || k == 3 ? 0 : 0.01;
        f.options.rtol = f.options.atol = 1e-11;
        fixture_start(&f, methods[k], 0);
        CU_ASSERT_FATAL(pk_events_init(&watched, &f.it, block, sizeof block) == PK_DONE);
        watched.found = found;
        seen.count = 0;
        CU_ASSERT(pk_events_to(&watched, &f.it, 20) == PK_STOPPED_EVENT && seen.count == 2);
        for (int i = 0; i < 2; i++) {
            exact(seen.t[i], x);
            CU_ASSERT(fabs(seen.x[i] - x[2]) < (k == 2 ? 1e-6 : 1e-9));
        }
        CU_ASSERT(f.it.t == seen.t[1] && f.it.v[2] == seen.x[1]);
        CU_ASSERT(pk_events_to(&watched, &f.it, seen.t[1] + 0.5) == PK_DONE);
        exact(f.it.t, x);
        CU_ASSERT(missed(f.it.v, x) < (k == 2 ? 1e-6 : 1e-9));
    }
}

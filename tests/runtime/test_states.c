/* States, x' = g(t, q, v, x), in v: each method has its order on them, and what stands in q beside
 * them, their integrals, changes no bit of a motion and no step.
 */
#include "../../runtime/run/diagnose/motion.h"
#include "fixture.h"

static struct fixture f;

/* The Brusselator from its usual start, in long double, by a Runge-Kutta method of its own. */
static void exact(double T, double *x)
{
    const int steps = (int)(4000 * T);
    const long double h = (long double)T / steps;
    long double y[2] = {1.5L, 3}, k[4][2], z[2];
    for (int step = 0; step < steps; step++) {
        for (int s = 0; s < 4; s++) {
            for (int i = 0; i < 2; i++)
                z[i] = s ? y[i] + (s == 3 ? h : h / 2) * k[s - 1][i] : y[i];
            k[s][0] = 1 + z[0] * z[0] * z[1] - 4 * z[0];
            k[s][1] = 3 * z[0] - z[0] * z[0] * z[1];
        }
        for (int i = 0; i < 2; i++)
            y[i] += h / 6 * (k[0][i] + 2 * k[1][i] + 2 * k[2][i] + k[3][i]);
    }
    x[0] = (double)y[0], x[1] = (double)y[1];
}

static double off(const struct fixture *one, const double *x)
{
    return fmax(fabs(one->it.v[0] - x[0]), fabs(one->it.v[1] - x[1]));
}

TEST("order on a nonlinear pair of states")
{
    double x[2];
    int found = 0;
    exact(2, x);
    for (size_t i = 0; pk_method_at(i); i++) {
        const struct pk_method *m = pk_method_at(i);
        if (m->order > 6 || m->traits & (PK_EXACT | PK_JETS) || m->needs & PK_MASS_CONSTANT)
            continue;
        const double slope = fixture_order(&brusselator_system, m, 2, 1e-12, off, x);
        printf("\n    %-8s order %d, of states %.3f", m->name, m->order, slope);
        /* dopri5's error of order 5 is small here: its slope has not settled */
        CU_ASSERT(slope > m->order - 0.2 && slope < m->order + 0.8);
        found++;
    }
    CU_ASSERT(found >= 13);
}

/* To t = 12 with the last states' integrals at `integral` where it starts: what it has come to. */
static enum pk_status moved(const struct pk_system *system, const char *method, double integral,
                            double *out)
{
    fixture_set(&f, system);
    f.options.h = 0.02;
    f.options.rtol = f.options.atol = 1e-7;
    for (size_t i = system->n - system->n_first_order; i < system->n; i++)
        f.q0[i] = integral;
    enum pk_status status = fixture_init(&f, method);
    if (f.it.method && f.it.method->traits & PK_ADAPTIVE) {
        pk_integrator_free(&f.it);
        f.options.h = 0, status = fixture_init(&f, method); /* a first step of its own */
    }
    if (status >= 0)
        status = pk_integrator_to(&f.it, 12);
    if (status >= 0) {
        out[0] = f.it.v[0], out[1] = f.it.v[1];
        out[2] = (double)f.it.count.steps, out[3] = (double)f.it.count.evaluations;
        out[4] = system->n_first_order < system->n ? f.it.q[0] : 0;
    }
    pk_integrator_free(&f.it);
    return status;
}

TEST("their integrals are seen by nobody")
{
    static const struct pk_system *const systems[] = {&brusselator_system, &maxwell_system};
    int found = 0;
    for (size_t k = 0; k < 2; k++)
        for (size_t i = 0; fixture_method(i); i++) {
            const char *name = fixture_method(i)->name;
            double at0[5], far[5];
            const enum pk_status status = moved(systems[k], name, 0, at0);
            CU_ASSERT(moved(systems[k], name, 1e9, far) == status);
            if (status == PK_REFUSED)
                continue;
            CU_ASSERT(status == PK_DONE);
            const int same = memcmp(at0, far, sizeof far) == 0;
            if (!same)
                printf("\n    %s: v %.17g and %.17g, %g and %g steps", name, at0[0], far[0], at0[2],
                       far[2]);
            CU_ASSERT(same);
            found++;
        }
    printf("\n    %d runs alike to the last bit", found);
    CU_ASSERT(found >= 2 * 24);
}

static struct motion motion_from(const struct fixture *of, const char *method, double end)
{
    static struct memory memory;
    memory_end(&memory);
    return (struct motion){.problem = &of->problem,
                           .method = pk_method_find(method),
                           .options = of->options,
                           .end = end,
                           .q = of->q0,
                           .v = of->v0,
                           .memory = &memory};
}

/* There and back, the integrals' own round-off is nobody's. */
TEST("there and back")
{
    struct reversal r[2];
    for (int k = 0; k < 2; k++) {
        fixture_set(&f, &maxwell_system);
        f.options.h = 0.01;
        f.q0[1] = k ? 1e9 : 0;
        struct motion m = motion_from(&f, "gauss6", 1);
        CU_ASSERT(reversal_find(&r[k], &m, 0.01) == PK_DONE);
        pk_integrator_free(&m.it);
    }
    CU_ASSERT(r[0].count > 5 && r[0].count == r[1].count);
    CU_ASSERT(r[0].at[r[0].count - 1].error > 0);
    CU_ASSERT(memcmp(r[0].at, r[1].at, r[0].count * sizeof *r[0].at) == 0);
}

/* x' = -x beside faster decays: no displacement of an integral stays and looks like a neutral one.
 */
TEST("Lyapunov exponent")
{
    fixture_set(&f, &maxwell_system);
    f.q0[0] = 1e-3, f.v0[1] = 1e-3;     /* linear: eigenvalues of s^3 + s^2 + 10.81 s + 9.81 */
    const double expected = -0.0429345; /* the real part of the pair */
    f.options.rtol = f.options.atol = 1e-10;
    const struct motion m = motion_from(&f, "dop853", 200);
    struct lyapunov l;
    CU_ASSERT_FATAL(lyapunov_begin(&l, &m, 0.2) == PK_DONE);
    for (int k = 0; k < 1000; k++)
        CU_ASSERT_FATAL(lyapunov_step(&l) == PK_DONE);
    const double exponent = lyapunov_growth(&l).exponent;
    printf("\n    exponent %.6f, of the linear system %.6f", exponent, expected);
    CU_ASSERT(fabs(exponent - expected) < 5e-4);
    pk_integrator_free(&l.variation.motion.it);
}

/* There are no momenta, so there is no form that a step could keep. */
TEST("no symplectic form")
{
    struct stepmap map;
    fixture_set(&f, &brusselator_system);
    const struct motion m = motion_from(&f, "rk4", 1);
    CU_ASSERT(stepmap_begin(&map, &m) == PK_REFUSED);
    CU_ASSERT(fixture_run(&f, &brusselator_system, "verlet", 0.1, 1) == PK_REFUSED);
}

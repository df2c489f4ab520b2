/* Variational steps where textbook methods are known to be them: the implicit midpoint rule,
 * Verlet; and what they do of steps that are too long for one solution, or for an iteration by M.
 */
#include "fixture.h"

static double apart(const struct pk_system *system, const char *a, const char *b, double h)
{
    static struct fixture f, g;
    CU_ASSERT(fixture_run(&f, system, a, h, 20 * h) == PK_DONE);
    CU_ASSERT(fixture_run(&g, system, b, h, 20 * h) == PK_DONE);
    return fixture_distance(&f, g.it.q, g.it.v);
}

/* lie_midpoint is gauss1 in (q, p) for any M, rattle is Verlet where the system is separable. */
TEST("the midpoint rule and Verlet")
{
    static const struct {
        const struct pk_system *system;
        double h;
    } rows[] = {{&pendulum_system, 0.3},     {&double_pendulum_system, 0.1},
                {&relativistic_system, 0.3}, {&forced_system, 0.3},
                {&stiffening_system, 0.3},   {&kepler_system, 0.1},
                {&van_der_pol_system, 0.05}};
    for (int i = 0; i < 7; i++) {
        const double same = apart(rows[i].system, "lie_midpoint", "gauss1", rows[i].h);
        const double other = apart(rows[i].system, "lie_midpoint", "rattle", rows[i].h);
        printf("\n    %-15s from gauss1 %.1e, from rattle %.1e", rows[i].system->name, same, other);
        CU_ASSERT(same < 1e-11 && other > 1e-6);
    }
    static const struct pk_system *const separable[] = {&pendulum_system, &kepler_system,
                                                        &driven_system};
    static const char *const pairs[][2] = {
        {"rattle", "verlet"}, {"rattle4", "suzuki4"}, {"rattle6", "kahan_li6"}};
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            const double same = apart(separable[i], pairs[k][0], pairs[k][1], 0.1);
            CU_ASSERT(same < 1e-12 && apart(separable[i], pairs[k][0], "rk4", 0.1) > same);
        }
}

/* Steps that have several solutions: Kepler's from the pericentre, a rod turned by more than a
 * right angle. It is said, never guessed, and from where on: a step of nearly that is made. */
TEST("several solutions")
{
    static struct fixture f;
    static const struct {
        const struct pk_system *system;
        const char *method;
        double h;
    } rows[] = {{&kepler_system, "lie_midpoint", 2.2},
                {&kepler_system, "lie_midpoint", 25},
                {&rod_system, "rattle", 5},
                {&rods_system, "lie_midpoint", 2.5},
                {&rods_system, "rattle6", 3}};
    for (int i = 0; i < 5; i++) {
        fixture_open(&f, rows[i].system, rows[i].method, rows[i].h);
        const enum pk_status status = pk_integrator_step(&f.it, 1e9);
        CU_ASSERT(status == PK_NO_CONVERGENCE || status == PK_AMBIGUOUS_STEP);
        CU_ASSERT(says(&f.it, ": make the step shorter"));
        CU_ASSERT(f.it.t == 0 && memcmp(f.it.q, f.q0, f.it.n * sizeof *f.q0) == 0);
        const double longest = f.it.reason.value;
        printf("\n    %s by %s: up to %.4g, not %g", rows[i].system->name, rows[i].method, longest,
               rows[i].h);
        CU_ASSERT(longest > 0.01 && longest < rows[i].h);
        if (i == 4) /* of parts, the others may be too long still */
            continue;
        fixture_start(&f, rows[i].method, 0.9 * longest);
        CU_ASSERT(pk_integrator_step(&f.it, 1e9) == PK_DONE);
        CU_ASSERT(fabs(fixture_energy(&f)) < 100);
    }
}

/* h omega = 100: by Newton's method, in the midpoint rule's closed form; by M alone it is refused.
 */
TEST("stiff")
{
    static struct fixture f;
    const double y = 100, h = 0.1;
    for (int i = 0; i < 2; i++) {
        fixture_set(&f, &oscillator_system);
        f.params.g = y * y / (h * h);
        f.options.iteration = i ? PK_FIXED_POINT : PK_NEWTON;
        fixture_start(&f, "lie_midpoint", h);
        const enum pk_status status = pk_integrator_step(&f.it, 1e9);
        if (i) {
            CU_ASSERT(status == PK_NO_CONVERGENCE && says(&f.it, "use Newton's"));
            continue;
        }
        const double c = (1 - y * y / 4) / (1 + y * y / 4), s = h / (1 + y * y / 4);
        CU_ASSERT(status == PK_DONE);
        CU_ASSERT(fabs(f.it.q[0] - (c * f.q0[0] + s * f.v0[0])) < 1e-13);
        CU_ASSERT(f.it.count.jacobians > 0);
    }
    CU_ASSERT(fixture_run(&f, &oscillator_system, "lie_midpoint", 0.1, 1) == PK_DONE);
    CU_ASSERT(f.it.count.jacobians == 0);
}

/* Kepler, e = .6: angular momentum, exact for both but for round-off, whose random walk of 1e5
 * plain sums reaches 2e-15 and more. */
TEST("compensated sums of momenta")
{
    static struct fixture f;
    static const char *const names[] = {"rattle", "lie_midpoint"};
    for (int i = 0; i < 2; i++) {
        fixture_open(&f, &kepler_system, names[i], 1e-3);
        double most = 0;
        for (int k = 0; k < 100000; k++) {
            CU_ASSERT_FATAL(pk_integrator_step(&f.it, 1e9) == PK_DONE);
            const double *q = f.it.q, *v = f.it.v;
            most = fmax(most, fabs(q[0] * v[1] - q[1] * v[0] - 0.4 * 2.0));
        }
        printf("\n    angular momentum over 1e5 steps of %s: %.1e", names[i], most);
        CU_ASSERT(most > 0 && most < 1.2e-15);
    }
}

/* Inputs, a limit off the grid, and a reset: each step is that of a fresh start there. */
TEST("from anywhere")
{
    static struct fixture f, g;
    CU_ASSERT(fixture_run(&f, &jointed_system, "rattle4", 0.03, 0.1) == PK_DONE && f.it.t == 0.1);
    fixture_set(&g, &jointed_system);
    memcpy(g.q0, f.it.q, f.it.n * sizeof *g.q0);
    memcpy(g.v0, f.it.v, f.it.n * sizeof *g.v0);
    fixture_start(&g, "rattle4", 0.03);
    CU_ASSERT(pk_integrator_to(&g.it, 0.5) == PK_DONE && pk_integrator_to(&f.it, 0.6) == PK_DONE);
    const double same = fixture_distance(&f, g.it.q, g.it.v);
    CU_ASSERT(same < 1e-13);
    CU_ASSERT(pk_integrator_reset(&f.it, 0, f.q0, f.v0) == PK_DONE);
    CU_ASSERT(pk_integrator_to(&f.it, 0.1) == PK_DONE);
    CU_ASSERT(fixture_distance(&f, g.q0, g.v0) < 1e-15);
    /* The momenta that it carries belong to the rates. */
    double p[FIXTURE_N], pdot[FIXTURE_N];
    jointed_system.unconstrained(&f.params, f.it.t, f.it.q, f.it.v, NULL, p, pdot);
    for (size_t i = 0; i < 10; i++)
        CU_ASSERT(fabs(p[i] - f.it.p[i]) < 1e-15);
}

/* phi = sin(x + a) - y/2 - sin a: terms that cancel at 0. */
static void slot(ARGS, double *phi)
{
    UNUSED;
    phi[0] = sin(q[0] + 0.3) - q[1] / 2 - sin(0.3);
}
static void slot_rows(ARGS, double *J, double *residual)
{
    UNUSED;
    J[0] = cos(q[0] + 0.3), J[1] = -0.5;
    residual[0] = J[0] * v[0] + J[1] * v[1];
}

static void slot_terms(ARGS, double *phi_size, double *rate_size)
{
    UNUSED;
    const double slope = fabs(cos(q[0] + 0.3)), x = fabs(q[0]) + 0.3;
    phi_size[0] = slope * x + fabs(sin(q[0] + 0.3)) + fabs(q[1]) / 2 + sin(0.3);
    rate_size[0] = (slope + x) * fabs(v[0]) + fabs(v[1]) / 2;
}

/* From rest where all coordinates are 0: down the slot, energy v^2/2 + y. */
TEST("from rest at 0")
{
    static struct pk_system system;
    static struct fixture f;
    static const double h[] = {0.01, 1e-3, 1e-4};
    system = rod_system;
    system.constraints.values = slot;
    system.constraints.jacobian = slot_rows;
    system.constraints.scale = slot_terms;
    for (int i = 0; i < 6; i++)
        for (int k = 0; k < 3; k++) {
            fixture_set(&f, &system);
            memset(f.q0, 0, sizeof f.q0);
            memset(f.v0, 0, sizeof f.v0);
            fixture_start(&f, bound_methods[i], h[k]);
            CU_ASSERT_FATAL(pk_integrator_to(&f.it, 0.2) == PK_DONE);
            const double *q = f.it.q, *v = f.it.v;
            const double lost = fabs((v[0] * v[0] + v[1] * v[1]) / 2 + f.params.g * q[1]);
            CU_ASSERT(q[1] < -1e-3 && lost < (i % 3 ? 1e-11 : 1e-2 * h[k] * h[k] + 1e-15));
            CU_ASSERT(fabs(sin(q[0] + 0.3) - q[1] / 2 - sin(0.3)) < 2e-16);
        }
}

/* 0.3 x = 0.7 y: from rest at 0, where phi has no terms, x is moved by y alone. */
static void tie(ARGS, double *phi)
{
    UNUSED;
    phi[0] = 0.3 * q[0] - 0.7 * q[1];
}
static void tie_rows(ARGS, double *J, double *residual)
{
    UNUSED;
    J[0] = 0.3, J[1] = -0.7;
    residual[0] = J[0] * v[0] + J[1] * v[1];
}
static void tie_terms(ARGS, double *phi_size, double *rate_size)
{
    UNUSED;
    phi_size[0] = 0.3 * fabs(q[0]) + 0.7 * fabs(q[1]);
    rate_size[0] = 0.3 * fabs(v[0]) + 0.7 * fabs(v[1]);
}
TEST("moved by others")
{
    static struct pk_system system;
    static struct fixture f;
    system = rod_system;
    system.constraints.values = tie;
    system.constraints.jacobian = tie_rows;
    system.constraints.scale = tie_terms;
    for (int i = 0; i < BOUND_VARIATIONAL; i++) {
        fixture_set(&f, &system);
        memset(f.q0, 0, sizeof f.q0);
        memset(f.v0, 0, sizeof f.v0);
        fixture_start(&f, bound_methods[i], 0.01);
        CU_ASSERT(pk_integrator_to(&f.it, 1) == PK_DONE &&
                  fabs(f.it.q[0] + 0.21 / 0.58 / 2) < 1e-14);
        CU_ASSERT(f.it.count.jacobians == 0);
    }
}

/* A loose tolerance is one of rates alone; and a step after one of hardly any is like any other. */
TEST("a loose tolerance")
{
    static struct fixture f;
    for (int i = 0; i < BOUND_VARIATIONAL; i++) {
        fixture_set(&f, &rods_system);
        f.options.newton_tol = 1e-3;
        fixture_start(&f, bound_methods[i], 0.1);
        CU_ASSERT(pk_integrator_to(&f.it, 1) == PK_DONE);
        CU_ASSERT(fixture_residuals(&f).position_relative < 3e-15);
        CU_ASSERT(fixture_run(&f, &rods_system, bound_methods[i], 0.1, 1e-15) == PK_DONE);
        CU_ASSERT(pk_integrator_to(&f.it, 0.1) == PK_DONE && f.it.count.jacobians == 0);
    }
}

/* From rest at 0 on circles of radius 5 limit, whose numbers round phi by far more than x and y do.
 */
TEST("numbers of phi")
{
    static struct fixture f;
    static const double limits[] = {1.0 / 3, 100, 1e4}, h[] = {1e-2, 1e-3, 1e-4, 1e-5};
    for (int r = 0; r < 3; r++) {
        double lost = 0, off = 0;
        for (int i = 0; i < BOUND_VARIATIONAL; i++)
            for (int k = 0; k < 4; k++) {
                fixture_set(&f, &circle_system);
                f.params.limit = limits[r];
                fixture_start(&f, bound_methods[i], h[k]);
                CU_ASSERT_FATAL(pk_integrator_to(&f.it, 2000 * h[k]) == PK_DONE);
                CU_ASSERT(f.it.count.jacobians == 0);
                CU_ASSERT(f.it.v[1] < -h[k]);
                lost = fmax(lost, fabs(fixture_energy(&f) / f.it.q[1]));
                off = fmax(off, fixture_residuals(&f).position_relative);
            }
        printf("\n    radius %.4g: energy %.1e, phi %.1e", 5 * limits[r], lost, off);
        CU_ASSERT(off < 1e-15 && lost < 1e-4);
    }
}

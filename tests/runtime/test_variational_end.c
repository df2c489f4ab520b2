/* Rates from momenta at the end of a variational step, and the return to J v + j0 = 0: what they
 * are judged by, and what they fail of.
 */
#include "fixture.h"

static struct fixture f;

static enum pk_status go(const struct pk_system *system, const char *method, double h)
{
    fixture_start(&f, method, h);
    CU_ASSERT(f.problem.system == system);
    return pk_integrator_to(&f.it, 1000 * h);
}

/* From rest in fields beside whose momenta the rates are small. */
TEST("momenta of a field")
{
    for (int i = 0; i < BOUND_VARIATIONAL; i++)
        for (double limit = 1; limit < 1e7; limit *= 100) {
            fixture_set(&f, &swift_system);
            f.params.limit = limit;
            f.v0[0] = f.v0[1] = 0;
            CU_ASSERT(go(&swift_system, bound_methods[i], 1e-4) == PK_DONE);
            const double lost = fabs(fixture_energy(&f) - (1 - 0.8));
            CU_ASSERT(f.it.v[0] < -1e-3 && lost < (i % 3 ? 1e-13 + 1e-16 * limit : 1e-6));
            CU_ASSERT(fixture_residuals(&f).rate_relative < 3e-15);
        }
}

/* M is factored once a step where it does not depend on the rates, else until they are found. */
TEST("factorisations")
{
    const struct pk_system *const systems[] = {&rods_system, &swift_system};
    for (int i = 0; i < 2; i++) {
        fixture_set(&f, systems[i]);
        CU_ASSERT(go(systems[i], "rattle", 0.01) == PK_DONE);
        const unsigned long made = f.it.count.factorisations, steps = f.it.count.steps;
        CU_ASSERT(i ? made > 2 * steps && made < 5 * steps : made == steps + 1);
    }
}

/* A rod whose J v is summed with a number that is taken away again, of which its terms tell. */
static void spread_rows(ARGS, double *J, double *residual)
{
    UNUSED;
    J[0] = 2 * q[0], J[1] = 2 * q[1];
    residual[0] = (1e6 + J[0]) * v[0] + J[1] * v[1] - 1e6 * v[0];
}
static void spread_terms(ARGS, double *phi_size, double *rate_size)
{
    UNUSED;
    phi_size[0] = 2;
    rate_size[0] = 2e6 * fabs(v[0]) + 2 * fabs(v[1]);
}
TEST("terms of rates")
{
    static struct pk_system system;
    system = rod_system;
    system.constraints.jacobian = spread_rows;
    system.constraints.scale = spread_terms;
    for (int i = 0; i < BOUND_VARIATIONAL; i++) {
        fixture_set(&f, &system);
        CU_ASSERT(go(&system, bound_methods[i], 1e-3) == PK_DONE);
        CU_ASSERT(fabs(f.it.q[0] * f.it.v[0] + f.it.q[1] * f.it.v[1]) < 1e-9);
    }
}

/* A body on an axle: rates across it are rounding beside its spin. */
static void axle(ARGS, double *phi)
{
    UNUSED;
    phi[0] = 2 * (v[4] * v[6] + v[3] * v[5]); /* e_x . R e_z */
    phi[1] = 2 * (v[5] * v[6] - v[3] * v[4]);
}
static void axle_rows(ARGS, double *J, double *residual)
{
    const double w = v[3], x = v[4], y = v[5], z = v[6];
    UNUSED;
    memset(J, 0, 14 * sizeof *J);
    J[0] = -2 * (x * y - w * z), J[1] = 1 - 2 * (y * y + z * z); /* R (omega x e_z) */
    J[7] = -(1 - 2 * (x * x + z * z)), J[8] = 2 * (x * y + w * z);
    residual[0] = J[0] * v[0] + J[1] * v[1];
    residual[1] = J[7] * v[0] + J[8] * v[1];
}
static void axle_terms(ARGS, double *phi_size, double *rate_size)
{
    UNUSED;
    for (int i = 0; i < 2; i++) {
        phi_size[i] = 2;
        rate_size[i] = 2 * (fabs(v[0]) + fabs(v[1]));
    }
}
TEST("beside a spin")
{
    static struct pk_system system;
    system = free_body_system;
    system.constraints.n = system.constraints.n_holonomic = 2;
    system.constraints.names = rods_system.constraints.names;
    system.constraints.values = axle;
    system.constraints.jacobian = axle_rows;
    system.constraints.scale = axle_terms;
    for (int i = 0; i < BOUND_VARIATIONAL; i++) {
        fixture_set(&f, &system);
        memset(f.v0, 0, sizeof f.v0);
        f.v0[2] = 1, f.v0[3] = 0.6, f.v0[6] = 0.8;
        CU_ASSERT(go(&system, bound_methods[i], 1e-2) == PK_DONE);
        CU_ASSERT(fabs(f.it.v[2] - 1) < 1e-14 && fabs(f.it.v[0]) + fabs(f.it.v[1]) < 1e-14);
    }
}

/* Rows x and x + s(t) y, which at t = 1 are the same within rounding, at rest at 0. */
#define LEFT (1 - t + 1e-9)
static void closing(ARGS, double *phi)
{
    UNUSED;
    phi[0] = q[0];
    phi[1] = q[0] + LEFT * q[1];
}
static void closing_rows(ARGS, double *J, double *residual)
{
    UNUSED;
    J[0] = J[2] = 1, J[1] = 0, J[3] = LEFT;
    residual[0] = v[0];
    residual[1] = v[0] + LEFT * v[1] - q[1];
}
TEST("rows that come to depend on each other")
{
    static struct pk_system system;
    system = twice_system;
    system.constraints.values = closing;
    system.constraints.jacobian = closing_rows;
    for (int i = 0; i < BOUND_VARIATIONAL; i += 3) {
        fixture_set(&f, &system);
        memset(f.q0, 0, sizeof f.q0);
        memset(f.v0, 0, sizeof f.v0);
        fixture_start(&f, bound_methods[i], 0.125);
        CU_ASSERT(pk_integrator_to(&f.it, 1) == PK_NO_PROJECTION && f.it.t == 0.875);
        CU_ASSERT(says(&f.it, "again depends on rod"));
    }
}

/* L = v^2/2 + |v|/2 - q: there are no momenta between -1/2 and 1/2. */
static void gap_canonical(ARGS, double *p, double *pdot)
{
    UNUSED;
    p[0] = v[0] + (v[0] > 0 ? 0.5 : -0.5);
    pdot[0] = -1;
}
TEST("no rates of these momenta")
{
    static struct pk_system system;
    system = oscillator_system;
    system.facts &= ~(unsigned)PK_QUADRATIC;
    system.canonical = gap_canonical;
    fixture_set(&f, &system);
    f.q0[0] = 0, f.v0[0] = 0.1;
    fixture_start(&f, "rattle", 0.15);
    CU_ASSERT(pk_integrator_step(&f.it, 1) == PK_NO_CONVERGENCE);
    CU_ASSERT(says(&f.it, "that of the rates from the momenta, after a correction of "));
}

/* What is said where a singularity vanishes: of the motion, of its expression alone, or of the
 * step. */
#include "fixture.h"

static struct fixture f;

/* The force of V = -sin(x)/x, written with its divisions. */
static int removable(ARGS, double *a)
{
    UNUSED;
    a[0] = cos(q[0]) / q[0] - sin(q[0]) / (q[0] * q[0]);
    return 0;
}

/* Of V = -2 sqrt(x): a division by a root, no more than a^2 = 1/x. */
static int by_a_root(ARGS, double *a)
{
    UNUSED;
    a[0] = -1 / sqrt(q[0]);
    return 0;
}

/* Of V = -asin(x), no number beyond x = 1. */
static int to_the_arc_s_end(ARGS, double *a)
{
    UNUSED;
    a[0] = 1 / sqrt(1 - q[0] * q[0]);
    return 0;
}

static void of_arc(ARGS, double *out)
{
    UNUSED;
    out[0] = 1 - q[0] * q[0];
}

static struct pk_system guarded(acceleration_function *acceleration)
{
    static const struct pk_singularity x[] = {{{"x", "", ""}, PK_SINGULARITY_DIVISOR}};
    static const struct pk_singularity arc[] = {{{"1 - x^2", "", ""}, PK_SINGULARITY_ARC}};
    if (acceleration == to_the_arc_s_end)
        return guarded_point(acceleration, arc, of_arc);
    return guarded_point(acceleration, x, first_coordinate);
}

/* r^2 = 1 + t^2 never vanishes; a step of 4 that comes from r = 5.1 by r' = -.98 passes r = 0. */
TEST("a step too long")
{
    struct pk_system system = guarded(radial_acceleration);
    static const char *const names[] = {"euler", "rk2", "symplectic_euler"};
    for (int i = 0; i < 3; i++) {
        fixture_set(&f, &system);
        f.params.limit = 1;
        f.q0[0] = sqrt(1 + 5.03 * 5.03);
        f.v0[0] = -5.03 / f.q0[0];
        fixture_start(&f, names[i], 8);
        CU_ASSERT(pk_integrator_step(&f.it, 16) == PK_STEP_TOO_LONG && f.it.t == 0);
        CU_ASSERT(says(&f.it, "from t = 0 to 8 passes x = 0"));
        /* It is the step that failed: shorter ones go on. */
        CU_ASSERT(pk_integrator_set_step(&f.it, 0.01) == PK_DONE);
        CU_ASSERT(pk_integrator_to(&f.it, 10.06) == PK_DONE);
        CU_ASSERT(fabs(f.it.q[0] - f.q0[0]) < 0.1);
        /* A motion that does end there ends there for such a step too. */
        f.params.limit = 0;
        fixture_start(&f, names[i], 0);
        CU_ASSERT(pk_integrator_step(&f.it, 16) == PK_SINGULAR_TIME);
        CU_ASSERT(fabs(f.it.reason.time + f.q0[0] / f.v0[0]) < 1e-9);
    }
}

/* Where the quotient has a limit the expression ends, and this is said; the motion is not gone on
 * with. Where it has none, nothing of the kind is said. */
TEST("expression or motion")
{
    static const char *const names[] = {"rk4", "verlet", "dop853", "gsl_rk8pd", "gauss"};
    static acceleration_function *const forces[] = {removable, radial_acceleration, by_a_root};
    for (int k = 0; k < 3; k++) {
        struct pk_system system = guarded(forces[k]);
        for (int i = 0; i < 5; i++)
            for (double v = 0.5; v < 3; v += 0.5) {
                fixture_set(&f, &system);
                f.params.limit =
                    1e-4; /* of the radial one: it comes as near as 1e-4 and turns back */
                f.q0[0] = 1;
                f.v0[0] = -v;
                f.options.h = 0.01;
                f.options.rtol = f.options.atol = 1e-3;
                fixture_start(&f, names[i], 0);
                const enum pk_status status = pk_integrator_to(&f.it, 4);
                CU_ASSERT(k == 1 || status == PK_SINGULAR_TIME);
                CU_ASSERT((says(&f.it, "write it without the division")) == (k == 0));
                pk_integrator_free(&f.it);
            }
    }
}

/* Steps that shrink as far as round-off lets them end where longer ones do, by the same status. */
TEST("at the end of asin")
{
    struct pk_system system = guarded(to_the_arc_s_end);
    static const char *const names[] = {"rk4", "dopri5", "dop853", "gsl_rk8pd", "gauss"};
    for (int i = 0; i < 5; i++)
        for (double tol = 1e-3; tol > 1e-13; tol /= 10) {
            fixture_set(&f, &system);
            f.q0[0] = 0.1;
            f.v0[0] = 0;
            f.options.h = 0.01;
            f.options.rtol = f.options.atol = tol;
            fixture_start(&f, names[i], 0);
            CU_ASSERT(pk_integrator_to(&f.it, 10) == PK_SINGULAR_TIME);
            CU_ASSERT(fabs(f.it.reason.time - 1.3005755) < 1e-4);
            pk_integrator_free(&f.it);
        }
}

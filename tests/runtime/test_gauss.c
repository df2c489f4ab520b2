/* The adaptive Gauss method, and gauss8 in the lanes: what their sources promise. Orders are in
 * quad/order.c, dense output is in test_dense.c, with the other methods' what every method must
 * keep.
 */
#include "fixture.h"

static struct fixture f;

static const double start_q[] = {1.3, -0.9}, start_v[] = {0.2, 0.4};

TEST("error follows the tolerance")
{
    static const struct pk_system *const systems[] = {&pendulum_system, &double_pendulum_system,
                                                      &kepler_system, &relativistic_system};
    static struct fixture e, d;
    for (size_t s = 0; s < 4; s++) {
        double tol[8], error[8], worse = 0;
        int count = 0;
        fixture_set(&f, systems[s]);
        fixture_exact(&e, systems[s], f.q0, f.v0, 5, 2000);
        for (double t = 1e-5; t > 5e-12; t /= 10) {
            CU_ASSERT(fixture_run(&f, systems[s], "gauss", t, 5) == PK_DONE && f.it.t == 5);
            CU_ASSERT(fixture_run(&d, systems[s], "dop853", t, 5) == PK_DONE);
            tol[count] = t;
            error[count] = fixture_distance(&f, e.it.q, e.it.v);
            worse = fmax(worse, error[count] / fixture_distance(&d, e.it.q, e.it.v));
            CU_ASSERT(error[count] > 0 && error[count] < 1e4 * t);
            count++;
        }
        const double slope = fit_slope(tol, error, count);
        printf("\n    %s: error ~ tol^%.2f, %.1e at tol 1e-11, of dop853's at most %.1f",
               systems[s]->name, slope, error[count - 1], worse);
        CU_ASSERT(slope > 0.75 && slope < 1.25 && worse < 60);
    }
}

static void ramp(void *context, pk_real t, pk_real *u)
{
    u[0] = *(const double *)context * t * t * t;
}

/* Explicit time, rates in the forces, an input: each would be lost unseen in a wrong lane. */
TEST("time, rates and inputs")
{
    static struct fixture e;
    double q, v, slope = 2.385;
    driven_exact(7, &q, &v);
    CU_ASSERT(fixture_run(&f, &driven_system, "gauss", 1e-12, 7) == PK_DONE);
    CU_ASSERT(fixture_distance(&f, &q, &v) < 1e-10);
    fixture_set(&f, &forced_system);
    fixture_exact(&e, &forced_system, f.q0, f.v0, 4, 1000);
    CU_ASSERT(fixture_run(&f, &forced_system, "gauss", 1e-12, 4) == PK_DONE);
    CU_ASSERT(fixture_distance(&f, e.it.q, e.it.v) < 1e-10);
    fixture_set(&f, &pushed_system);
    f.problem.input = ramp;
    f.problem.context = &slope;
    fixture_start(&f, "gauss", 0);
    CU_ASSERT(pk_integrator_to(&f.it, 3) == PK_DONE);
    CU_ASSERT(fabs(f.it.v[0] - f.v0[0] - slope * 81 / 4) < 1e-8);
    double row_q, row_v;
    const double t = (f.it.last_t + f.it.t) / 2;
    CU_ASSERT(pk_integrator_dense(&f.it, t, &row_q, &row_v) == PK_DONE);
    CU_ASSERT(fabs(row_v - f.v0[0] - slope * t * t * t * t / 4) < 1e-8);
}

/* Lane kernels that fail in one lane or another and leave nothing of use in it. */
static unsigned long long failing_lanes(const void *params, const double *t, const double *q,
                                        const double *v, const double *u, double *a)
{
    const unsigned fails = (unsigned)(fabs(q[7]) * 1e3) % 8;
    for (unsigned l = 0; l < 8; l++)
        if (l == fails)
            a[l] = 1e6;
        else
            pendulum_system.acceleration(params, t[l], q + l, v + l, u, a + l);
    return 1ull << fails;
}

/* A lane that fails is asked again alone: to the bit as if it had not. */
TEST("lanes that fail")
{
    static struct fixture e;
    struct pk_system failing = pendulum_system, scalar = pendulum_system;
    failing.steppers = scalar.steppers = NULL;
    failing.lanes = failing_lanes;
    CU_ASSERT(fixture_run(&e, &scalar, "gauss", 1e-9, 5) == PK_DONE);
    fixture_set(&f, &failing);
    f.options.rtol = f.options.atol = 1e-9;
    f.options.max_steps = 100;
    fixture_start(&f, "gauss", 0);
    CU_ASSERT(pk_integrator_to(&f.it, 5) == PK_DONE);
    CU_ASSERT(f.it.count.evaluations > e.it.count.evaluations);
    CU_ASSERT(fixture_distance(&f, e.it.q, e.it.v) == 0);
}

TEST("refused across a kink")
{
    struct pk_system kinked = pendulum_system;
    kinked.facts &= ~(unsigned)PK_SMOOTH;
    fixture_set(&f, &kinked);
    CU_ASSERT(fixture_init(&f, "gauss") == PK_REFUSED);
    CU_ASSERT(says(&f.it, "abs, min, max or step") && says(&f.it, "dop853"));
    fixture_start(&f, "dop853", 0);
}

/* A system that is stiff at its tolerance: q'' = -1e6 q + cos 3 t near its slow motion. */
TEST("held back, and no convergence")
{
    fixture_set(&f, &driven_system);
    f.params.g = 1e6;
    f.q0[0] = 1 / (1e6 - 9);
    f.v0[0] = 0;
    fixture_start(&f, "gauss", 1e-3);
    CU_ASSERT(pk_integrator_to(&f.it, 1) == PK_DONE);
    CU_ASSERT(f.it.count.held > f.it.count.steps / 2);
    CU_ASSERT(fabs(f.it.q[0] - cos(3.0) / (1e6 - 9)) < 1e-3);
    CU_ASSERT(fixture_run(&f, &pendulum_system, "gauss", 1e-10, 10) == PK_DONE);
    CU_ASSERT(f.it.count.held < f.it.count.steps / 4);
    /* An iteration that never converges is said, at once and where; the state stays. */
    fixture_set(&f, &double_pendulum_system);
    f.options.max_iterations = 1;
    f.options.newton_tol = 1e-14;
    f.options.h_min = 1e-3;
    fixture_start(&f, "gauss", 0);
    CU_ASSERT(pk_integrator_to(&f.it, 1) == PK_STEP_UNDERFLOW && f.it.t == 0);
    CU_ASSERT(fixture_distance(&f, start_q, start_v) == 0 && f.it.count.rejections > 2);
}

/* No start may fail or be wrong in silence. */
TEST("random starts")
{
    static struct fixture d;
    double worst = 0;
    unsigned long long seed = 2385;
    for (int k = 0; k < 300; k++) {
        double x[4];
        for (int i = 0; i < 4; i++) {
            seed = seed * 6364136223846793005ull + 1442695040888963407ull;
            x[i] = ((double)(seed >> 11) / 9007199254740992.0 - 0.5) * 6;
        }
        for (int i = 0; i < 2; i++) {
            struct fixture *one = i ? &d : &f;
            fixture_set(one, &double_pendulum_system);
            memcpy(one->q0, x, 2 * sizeof *x);
            memcpy(one->v0, x + 2, 2 * sizeof *x);
            fixture_start(one, i ? "dop853" : "gauss", i ? 1e-13 : 1e-9);
            CU_ASSERT(pk_integrator_to(&one->it, 2) == PK_DONE);
        }
        worst = fmax(worst, fixture_distance(&f, d.it.q, d.it.v));
    }
    printf("\n    300 starts at 1e-9, t = 2: error at most %.1e", worst);
    CU_ASSERT(worst > 1e-10 && worst < 1e-5);
}

/* A first iterate, predicted from a step that converged well, must not pass unseen for the last:
 * starts where the steps grow or turn sharply, at tolerances that one iterate could seem to meet.
 * With a predicted rate without its floor (PK_GAUSS_RATE_LEAST) they come out wrong by .07 to 3. */
TEST("the first iterate is none to end with")
{
    static const struct {
        const struct pk_system *system;
        double tol, t, q[2], v[2];
    } rows[] = {{&pendulum_system, 1e-2, 8, {-0.9}, {1.22}},
                {&double_pendulum_system, 5e-4, 3, {-2.9, 2.46}, {-2.58, 0.82}},
                {&kepler_system, 5e-4, 3, {2.75, 3.37}, {-3.06, -3.67}},
                {&kepler_system, 1e-5, 3, {2.75, 3.37}, {-3.06, -3.67}}};
    static struct fixture d;
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        for (int i = 0; i < 2; i++) {
            struct fixture *one = i ? &d : &f;
            fixture_set(one, rows[k].system);
            memcpy(one->q0, rows[k].q, sizeof rows[k].q);
            memcpy(one->v0, rows[k].v, sizeof rows[k].v);
            fixture_start(one, i ? "dop853" : "gauss", i ? 1e-13 : rows[k].tol);
            CU_ASSERT(pk_integrator_to(&one->it, rows[k].t) == PK_DONE);
        }
        const double error = fixture_distance(&f, d.it.q, d.it.v);
        printf("\n    %s at %.0e: %.1e", rows[k].system->name, rows[k].tol, error);
        CU_ASSERT(error > 0 && error < 50 * rows[k].tol);
    }
}

/* gauss8 in the lanes against Newton's method on the same equations in (q, p), also at steps too
 * long for fixed points, which then grow, be it to what is no number. */
TEST("gauss8 in the lanes")
{
    static const struct {
        const struct pk_system *system;
        double h, until;
        int lanes;
    } rows[] = {{&pendulum_system, 0.4, 20, 1},
                {&oscillator_system, 12, 36, 0},
                {&stiffening_system, 0.4, 20, 1},
                {&stiffening_system, 1.7, 17, 0}};
    static struct fixture e;
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        struct pk_system general = *rows[k].system;
        general.facts &= ~(unsigned)PK_SEPARABLE;
        fixture_set(&f, rows[k].system);
        fixture_set(&e, &general);
        fixture_start(&f, "gauss8", rows[k].h);
        fixture_start(&e, "gauss8", rows[k].h);
        CU_ASSERT(pk_integrator_to(&f.it, rows[k].until) == PK_DONE);
        CU_ASSERT(pk_integrator_to(&e.it, rows[k].until) == PK_DONE);
        CU_ASSERT((f.it.count.jacobians == 0) == rows[k].lanes && e.it.count.jacobians > 0);
        printf("\n    %s, h = %g: %.1e from Newton's", rows[k].system->name, rows[k].h,
               fixture_distance(&f, e.it.q, e.it.v));
        CU_ASSERT(fixture_distance(&f, e.it.q, e.it.v) < 2e-13);
        CU_ASSERT(fabs(f.it.p[0] - f.it.v[0]) < 1e-14);
    }
}

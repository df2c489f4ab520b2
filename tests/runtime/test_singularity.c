/* Where the equations end: a collision, a chart's pole, through every kind of method, and not where
 * a motion only passes near. Without singularities a fixed step steps over each of them.
 */
#include "../../runtime/run/diagnose/motion.h"
#include "fixture.h"

static struct fixture f;

static const double FALL = 1.1107207345395915; /* pi/(2 sqrt 2): from rest at 1, mu = 1 */

static void distance(ARGS, double *out)
{
    UNUSED;
    out[0] = 1 + q[0] * q[0]; /* one that stays */
    out[1] = sqrt(q[0] * q[0] + q[1] * q[1]);
}

static const struct pk_singularity kepler_singularities[] = {
    {{"1 + x^2", "", ""}, PK_SINGULARITY_COORDINATES}, {{"r", "", ""}, PK_SINGULARITY_DIVISOR}};

static struct pk_system guarded_kepler(void)
{
    struct pk_system system = kepler_system;
    system.singularities =
        (struct pk_part_singularities){.n = 2, .table = kepler_singularities, .values = distance};
    return system;
}

static const struct {
    const char *name;
    double h;
} methods[] = {{"euler", 1e-3},  {"rk4", 1e-2},      {"symplectic_euler", 1e-3},
               {"verlet", 1e-2}, {"verlet", 0.1},    {"yoshida4", .01},
               {"gauss1", 1e-2}, {"gauss4", 1e-2},   {"gauss8", 1e-2},
               {"dopri5", 0},    {"dop853", 0},      {"gauss", 0},
               {"gsl_rk8pd", 0}, {"gsl_msadams", 0}, {"gsl_msbdf", 0},
               {"gsl_bsimp", 0}, {"rk3", 1e-2},      {"kahan_li8", 1e-2}};
enum { METHODS = sizeof methods / sizeof *methods };

static void skew_start(void)
{
    f.q0[0] = 0.6;
    f.q0[1] = 0.8;
    f.v0[0] = f.v0[1] = 0;
}

TEST("collision")
{
    struct pk_system system = guarded_kepler();
    for (int i = 0; i < METHODS; i++) {
        double q[2], v[2], t;
        fixture_set(&f, &system);
        skew_start();
        fixture_start(&f, methods[i].name, methods[i].h);
        enum pk_status status;
        do {
            t = f.it.t;
            memcpy(q, f.it.q, sizeof q);
            memcpy(v, f.it.v, sizeof v);
            status = pk_integrator_step(&f.it, 3);
        } while (status == PK_DONE && f.it.t < 3);
        CU_ASSERT(status == PK_SINGULAR_TIME && f.it.reason.index == 1);
        CU_ASSERT(fabs(f.it.reason.time - FALL) < (methods[i].h > 0 ? 10 * methods[i].h : 1e-6));
        CU_ASSERT(f.it.t == t && memcmp(q, f.it.q, sizeof q) == 0);
        CU_ASSERT(memcmp(v, f.it.v, sizeof v) == 0 && t > 0.9);
        CU_ASSERT(says(&f.it, "end here: r vanishes at t = 1.1"));
        /* Nothing more comes of it, but a new start. */
        CU_ASSERT(pk_integrator_step(&f.it, 3) == PK_SINGULAR_TIME && f.it.t == t);
        CU_ASSERT(pk_integrator_dense(&f.it, t, q, v) == PK_SINGULAR_TIME);
        CU_ASSERT(pk_integrator_steps(&f.it, 3, 7) == PK_SINGULAR_TIME && f.it.t == t);
        CU_ASSERT(pk_integrator_reset(&f.it, 0, f.q0, f.v0) == PK_DONE);
        CU_ASSERT(pk_integrator_to(&f.it, 0.5) == PK_DONE && f.it.t == 0.5);
        pk_integrator_free(&f.it);
    }
}

/* Adaptive steps at a loose tolerance are long enough to step over it too. */
TEST("collision at loose tolerances")
{
    struct pk_system system = guarded_kepler();
    static const char *const names[] = {"dopri5",    "dop853",    "gauss",
                                        "gsl_rkf45", "gsl_rk8pd", "gsl_bsimp"};
    for (int i = 0; i < 6; i++)
        for (double tol = 1e-4; tol < 0.5; tol *= 10) {
            fixture_set(&f, &system);
            f.q0[0] = 1, f.q0[1] = f.v0[0] = f.v0[1] = 0;
            fixture_start(&f, names[i], tol);
            CU_ASSERT(pk_integrator_to(&f.it, 3) == PK_SINGULAR_TIME && f.it.reason.index == 1);
            CU_ASSERT(f.it.t < f.it.reason.time + 1e-9 && fabs(f.it.reason.time - FALL) < 1e-3);
            pk_integrator_free(&f.it);
            f.q0[0] = 1.9; /* e = .9 from the far end: no more than near */
            f.v0[1] = sqrt(1 / 19.);
            fixture_start(&f, names[i], 0);
            CU_ASSERT(pk_integrator_to(&f.it, 4) == PK_DONE && f.it.t == 4);
            pk_integrator_free(&f.it);
        }
}

/* What would have come out. */
TEST("stepped over without")
{
    for (int i = 0; i < 6; i++) {
        fixture_set(&f, &kepler_system);
        skew_start();
        fixture_start(&f, methods[i].name, methods[i].h);
        CU_ASSERT(pk_integrator_to(&f.it, 3) == PK_DONE && isfinite(f.it.q[0]));
    }
}

/* Past the centre at a distance b with speed v, by steps of up to h v/b = 1. */
TEST("near pass")
{
    struct pk_system system = guarded_kepler();
    static const char *const names[] = {"verlet", "rk4", "yoshida4", "euler"};
    for (int i = 0; i < 4; i++)
        for (double part = 0.1; part < 1.1; part += 0.45) {
            fixture_set(&f, &system);
            f.q0[0] = 1.9, f.q0[1] = 0; /* e = .9, from the far end; b = .1, v = sqrt 19 */
            f.v0[0] = 0, f.v0[1] = sqrt(1 / 19.);
            fixture_start(&f, names[i], part * 0.1 / sqrt(19.));
            CU_ASSERT(pk_integrator_to(&f.it, 4) == PK_DONE && f.it.t == 4);
        }
}

static const struct pk_singularity pole_singularity[] = {
    {{"r", "", ""}, PK_SINGULARITY_COORDINATES}};

static struct pk_system polar(void)
{
    return guarded_point(radial_acceleration, pole_singularity, first_coordinate);
}

TEST("pole of a chart")
{
    struct pk_system system = polar();
    static const double parts[] = {0.1, 0.5, 1, 3};
    for (int i = 0; i < 4; i++) { /* |Delta E/E| at most .24 up to 1: it passes; by 3 too */
        fixture_set(&f, &system);
        f.params.limit = 1; /* b = v = 1, from x = -5.03 */
        f.q0[0] = sqrt(1 + 5.03 * 5.03);
        f.v0[0] = -5.03 / f.q0[0];
        fixture_start(&f, "verlet", parts[i]);
        CU_ASSERT(pk_integrator_to(&f.it, 9) == PK_DONE && f.it.q[0] > 1);
    }
    f.params.limit = 0; /* through the pole, where nothing but the chart ends */
    f.q0[0] = 5.03;
    f.v0[0] = -1;
    for (int i = 0; i < METHODS; i++) {
        if (strncmp(methods[i].name, "gauss", 5) == 0 && methods[i].name[5])
            continue; /* in (q, p), of which this system has the oscillator's */
        f.options.h = methods[i].h;
        fixture_start(&f, methods[i].name, 0);
        CU_ASSERT(pk_integrator_to(&f.it, 9) == PK_SINGULAR_COORDINATES);
        CU_ASSERT(fabs(f.it.reason.time - 5.03) < 1e-9 && f.it.t < 5.03);
        CU_ASSERT(says(&f.it, "coordinates are singular here: r vanishes at t = 5.0"));
        pk_integrator_free(&f.it);
    }
    f.q0[0] = 0; /* a start there is no start */
    fixture_start(&f, "rk4", 0.1);
    CU_ASSERT(pk_integrator_step(&f.it, 1) == PK_SINGULAR_COORDINATES && f.it.t == 0);
}

/* A force that ends at t = 1, whatever the motion: its singularity is zero at the last trial step.
 */
static int closing_acceleration(ARGS, double *a)
{
    UNUSED;
    a[0] = -q[0] - 1 / ((t - 1) * (t - 1));
    return 0;
}

static void until_one(ARGS, double *out)
{
    UNUSED;
    out[0] = t - 1;
}

static const struct pk_singularity time_singularity[] = {
    {{"t - 1", "", ""}, PK_SINGULARITY_DIVISOR}};

/* The time is always one of the step that failed. */
TEST("when it vanishes")
{
    struct pk_system system = polar();
    system.acceleration = closing_acceleration;
    system.singularities.table = time_singularity;
    system.singularities.values = until_one;
    int singular = 0;
    for (int i = 0; i < METHODS; i++)
        for (double tol = 1e-9; tol < 0.2; tol *= methods[i].h > 0 ? 1e9 : 10) {
            if (strncmp(methods[i].name, "gauss", 5) == 0 && methods[i].name[5])
                continue;
            fixture_set(&f, &system);
            f.options.h = methods[i].h > 0 ? 0.3 : 0;
            f.options.rtol = f.options.atol = tol;
            fixture_start(&f, methods[i].name, 0);
            const enum pk_status status = pk_integrator_to(&f.it, 3);
            CU_ASSERT(status < 0 && f.it.t < 1);
            if (status == PK_SINGULAR_TIME) { /* else steps underflow closer to it than is told */
                CU_ASSERT(fabs(f.it.reason.time - 1) < 1e-9);
                singular++;
            }
            pk_integrator_free(&f.it);
        }
    CU_ASSERT(singular > 20);
}

/* The size of a singularity does not matter, though products of two be too small for a number. */
static void tiny_distance(ARGS, double *out)
{
    distance(params, t, q, v, u, out);
    out[0] *= 1e-200;
    out[1] *= 1e-200;
}

TEST("tiny")
{
    struct pk_system system = guarded_kepler();
    system.singularities.values = tiny_distance;
    for (int i = 0; i < METHODS; i++) {
        fixture_set(&f, &system);
        f.q0[0] = 1, f.q0[1] = f.v0[0] = 0, f.v0[1] = 1;
        fixture_start(&f, methods[i].name, methods[i].h);
        CU_ASSERT(pk_integrator_to(&f.it, 3) == PK_DONE);
        pk_integrator_free(&f.it);
        skew_start();
        fixture_start(&f, methods[i].name, 0);
        CU_ASSERT(pk_integrator_to(&f.it, 3) == PK_SINGULAR_TIME && f.it.reason.index == 1);
        pk_integrator_free(&f.it);
    }
}

/* Members of an ensemble end where each does alone. */
TEST("members")
{
    static double block[30000];
    struct pk_system system = guarded_kepler();
    const double q0[6] = {0.6, 0.8, 1, 0, 0.3, 0.4}, v0[6] = {0, 0, 0, 1, 0, 0}, times[] = {0.3, 2};
    double q[12], v[12], last[3];
    struct test_params params[3];
    size_t done[3];
    enum pk_status status[3];
    fixture_set(&f, &system);
    params[0] = params[1] = params[2] = f.params;
    f.options.h = 0.01;
    const struct pk_ensemble e = {.system = &system,
                                  .method = pk_method_find("rk4"),
                                  .options = f.options,
                                  .members = 3,
                                  .params = params,
                                  .q0 = q0,
                                  .v0 = v0,
                                  .rows = 2,
                                  .t = times,
                                  .q = q,
                                  .v = v,
                                  .done = done,
                                  .last_t = last,
                                  .status = status};
    CU_ASSERT_FATAL(pk_ensemble_size(&e) <= sizeof block);
    CU_ASSERT(pk_ensemble_run(&e, 0, 3, block, sizeof block) == PK_SINGULAR_TIME);
    CU_ASSERT(status[0] == PK_SINGULAR_TIME && done[0] == 1 && fabs(last[0] - FALL) < 0.02);
    CU_ASSERT(status[1] == PK_DONE && done[1] == 2);
    CU_ASSERT(status[2] == PK_SINGULAR_TIME && fabs(last[2] - FALL * sqrt(0.125)) < 0.02);
}

/* With displacements along the motion it ends as without. */
TEST("with displacements")
{
    static struct variation variation;
    static struct memory memory;
    struct pk_system system = guarded_kepler();
    fixture_set(&f, &system);
    const struct motion m = {.problem = &f.problem,
                             .method = pk_method_find("rk4"),
                             .options = f.options,
                             .q = f.q0,
                             .v = f.v0,
                             .memory = &memory};
    f.q0[0] = 0.6, f.q0[1] = 0.8;
    f.v0[0] = f.v0[1] = 0;
    CU_ASSERT_FATAL(variation_init(&variation, &m, 1) == PK_DONE);
    variation.Q[2] = 1;
    variation.motion.options.h = 0.01;
    CU_ASSERT_FATAL(motion_begin(&variation.motion) == PK_DONE);
    const struct pk_integrator *it = &variation.motion.it;
    CU_ASSERT(pk_integrator_to(&variation.motion.it, 3) == PK_SINGULAR_TIME);
    CU_ASSERT(fabs(it->reason.time - FALL) < 0.01 && it->t < FALL);
    memory_end(&memory);
}

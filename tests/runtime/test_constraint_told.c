/* Constraints: the forces that keep them, what bad ones and starts off good ones are told, and
 * states between steps.
 */
#include "fixture.h"

static struct fixture f;

static void of_family(const void *params, enum pk_range_of of, size_t k, struct pk_range *range)
{
    (void)params, (void)of;
    *range = (struct pk_range){k ? 5 : 1, k ? 3 : 1, k == 1};
}

static size_t four(const void *params, int holonomic)
{
    (void)params, (void)holonomic;
    return 4;
}

/* A name in too little room: its length is that of the whole, as snprintf() returns it. */
TEST("names of rows in little room")
{
    static const struct pk_quantity of[] = {{"lambda_rod", "", ""}, {"lambda_link", "", ""}};
    const struct pk_system system = {.families.range = of_family,
                                     .constraints.count = four,
                                     .constraints.n_declared = 2,
                                     .constraints.names = of};
    for (size_t size = 0; size < 10; size++) {
        char text[10] = "?????????";
        CU_ASSERT(pk_constraint_name(&system, NULL, 2, size ? text : NULL, size) == 7);
        CU_ASSERT(!size || (strncmp(text, "link[6]", size - 1) == 0 && strlen(text) < size));
    }
}

/* Of the rod: the pull 2 lambda r is what keeps it, 2 lambda = g y - v^2. */
TEST("multipliers")
{
    static double room[256];
    double lambda;
    CU_ASSERT_FATAL(fixture_run(&f, &rod_system, "rattle", 0.01, 2) == PK_DONE);
    CU_ASSERT(pk_constraint_multipliers(&f.problem, f.it.t, f.it.q, f.it.v, &lambda, room,
                                        sizeof room) == PK_DONE);
    const double *v = f.it.v, exact = (f.it.q[1] - v[0] * v[0] - v[1] * v[1]) / 2;
    CU_ASSERT(fabs(lambda - exact) < 1e-14 && fabs(exact) > 0.1);
    CU_ASSERT(pk_constraint_multipliers(&f.problem, 0, f.it.q, f.it.v, &lambda, room, 8) ==
              PK_BLOCK_TOO_SMALL);
    char name[20];
    CU_ASSERT(pk_constraint_name(&rod_system, NULL, 0, name, sizeof name) == 3);
    CU_ASSERT(strcmp(name, "rod") == 0);
}

/* Both numbers are of the row that is off most beside its terms; what a kernel is missing is told.
 */
TEST("residuals")
{
    static double room[4096];
    struct pk_residuals found;
    fixture_set(&f, &rods_system);
    const double q[4] = {100, 0, 100.000001, 0}, v[4] = {0, 0, 1e-3, 1};
    CU_ASSERT(pk_constraint_residuals(&f.problem, 0, q, v, &found, room, sizeof room) == PK_DONE);
    double phi[2];
    rods_system.constraints.values(f.problem.params, 0, q, v, NULL, phi);
    CU_ASSERT(found.position == fabs(phi[found.position_row]) && found.position_relative > 1e-3);
    CU_ASSERT(found.position_row < 2 && found.rate_row < 2 && found.rate > 0);
    static struct pk_system system;
    system = rod_system;
    system.constraints.scale = NULL;
    fixture_set(&f, &system);
    CU_ASSERT(fixture_begin(&f, "rk4", 0.01) == PK_REFUSED);
    CU_ASSERT(says(&f.it, "the kernel residual_scale"));
}

static double shrinking_phi;
static void shrinking(ARGS, double *phi)
{
    UNUSED;
    phi[0] = q[0] * q[0] + q[1] * q[1] - 1 + shrinking_phi * t;
}
/* A rod that is longer from t = 1 on, which its equations know nothing of. */
static void lengthened(ARGS, double *phi)
{
    UNUSED;
    phi[0] = q[0] * q[0] + q[1] * q[1] - 1 - 0.25 * (1 + tanh((t - 1) / 1e-3));
}
static void crossing(ARGS, double *phi)
{
    UNUSED;
    phi[0] = q[0] * q[1];
}
static void crossing_rows(ARGS, double *J, double *residual)
{
    UNUSED;
    J[0] = q[1], J[1] = q[0];
    residual[0] = J[0] * v[0] + J[1] * v[1];
}
static int forceless(ARGS, double *a)
{
    UNUSED;
    a[0] = a[1] = 0;
    return q[0] * q[0] + q[1] * q[1] > 1e-20 ? 0 : PK_FAILED(PK_FAILURE_CONSTRAINT, 0);
}

/* The same with a state beside it, z' = x^2. */
static void three_rows(ARGS, double *J, double *residual)
{
    crossing_rows(params, t, q, v, u, J, residual);
    J[2] = 0;
}
static int squares(ARGS, double *a)
{
    a[2] = q[0] * q[0];
    return forceless(params, t, q, v, u, a);
}
static void ones(ARGS, double *M)
{
    UNUSED;
    for (int i = 0; i < 9; i++)
        M[i] = i % 4 == 0;
}
static void as_they_are(ARGS, double *p, double *pdot)
{
    squares(params, t, q, v, u, pdot);
    memcpy(p, v, 3 * sizeof *p);
}

/* What bad constraints, and starts off good ones, are told. */
TEST("refusals of constraints")
{
    static struct pk_system system;
    static const char *const by[] = {"rk4", "gauss", "rattle", "lie_midpoint", "gauss4"};
    for (int i = 0; i < 5; i++) {
        fixture_set(&f, &rod_system);
        f.q0[0] = 0.61;
        CU_ASSERT(fixture_begin(&f, by[i], 0.01) == PK_OFF_CONSTRAINTS);
        CU_ASSERT(says(&f.it, "the start, or an event, breaks a constraint: rod by 0.0121"));
        fixture_set(&f, &rod_system);
        f.v0[0] = 0.81;
        CU_ASSERT(fixture_begin(&f, by[i], 0.01) == PK_OFF_CONSTRAINTS);
        CU_ASSERT(says(&f.it, "rod, as rates go, by 0.012"));
        CU_ASSERT(pk_integrator_step(&f.it, 1) == PK_OFF_CONSTRAINTS); /* it stands */
        f.q0[0] = 0.6 + 1e-10, f.v0[0] = 0.8;
        CU_ASSERT(fixture_begin(&f, by[i], 0.01) == PK_DONE); /* rounding of a start */
        CU_ASSERT(fixture_residuals(&f).position_relative < 3e-16);
        CU_ASSERT(f.it.q[0] < f.q0[0] && fabs(f.it.q[0] - 0.6) < 1e-10);

        fixture_set(&f, &twice_system);
        CU_ASSERT(fixture_begin(&f, by[i], 0.01) == PK_NO_PROJECTION);
        CU_ASSERT(says(&f.it, "again depends on rod"));
        f.params.limit = 0.5;
        CU_ASSERT(fixture_begin(&f, by[i], 0.01) == PK_OFF_CONSTRAINTS);
        CU_ASSERT(says(&f.it, "again by 0.5; and again depends on rod"));
    }
    fixture_set(&f, &ball_system);
    f.v0[0] += 0.1;
    CU_ASSERT(fixture_begin(&f, "gauss", 1e-9) == PK_OFF_CONSTRAINTS);
    CU_ASSERT(says(&f.it, "contact.x, as rates go, by 0.1"));

    /* A constraint that ends: no point is on it after t = 1. */
    system = rod_system;
    system.constraints.values = shrinking;
    shrinking_phi = 1;
    static const char *const ends[] = {"rk4", "dopri5", "gauss2"};
    for (int i = 0; i < 3; i++) {
        CU_ASSERT(fixture_run(&f, &system, ends[i], i == 1 ? 1e-3 : 0.01, 3) == PK_NO_PROJECTION);
        CU_ASSERT(says(&f.it, "the constraints cannot be fulfilled here: "));
        CU_ASSERT(says(&f.it, "rod"));
        CU_ASSERT(f.it.t < 1.01); /* its equations know nothing of it: fixed steps end at once */
        CU_ASSERT(i != 1 || (f.it.t > 0.9999 && f.it.count.rejections > 3));
    }
    CU_ASSERT(fixture_run(&f, &system, "rattle", 0.01, 3) < 0 && f.it.t < 1.01);

    /* A projection longer than a step's error: steps of 100 tolerances of it, or the end. */
    system.constraints.values = lengthened;
    CU_ASSERT(fixture_run(&f, &system, "dopri5", 1e-5, 2) == PK_DONE);
    CU_ASSERT(f.it.count.steps > 200 && f.it.count.rejections > 5);
    CU_ASSERT(fixture_run(&f, &system, "rk4", 0.2, 2) == PK_NO_PROJECTION && f.it.t < 1.01);

    /* Where two branches cross, x y = 0, J vanishes. */
    system = rod_system;
    system.constraints.values = crossing;
    system.constraints.jacobian = crossing_rows;
    system.acceleration = forceless;
    fixture_set(&f, &system);
    f.q0[0] = -0.5, f.q0[1] = 0, f.v0[0] = 1, f.v0[1] = 0;
    CU_ASSERT(fixture_begin(&f, "rk4", 0.125) == PK_DONE);
    CU_ASSERT(pk_integrator_to(&f.it, 1) == PK_DONE); /* along its own */
    CU_ASSERT(fabs(f.it.q[0] - 0.5) < 1e-14 && fabs(f.it.q[1]) < 1e-14);
    static const struct pk_quantity names[] = {{"x", "", ""}, {"y", "", ""}, {"z", "", ""}};
    system.n = 3, system.n_first_order = 1; /* a state goes on too, at ends of steps and between */
    system.coordinates = system.rates = system.momenta = names;
    system.constraints.jacobian = three_rows;
    system.acceleration = squares, system.mass = system.inertia = ones;
    system.canonical = system.unconstrained = as_they_are;
    static const char *const both[] = {"rk4", "dop853"};
    for (int i = 0; i < 2; i++) {
        double q[3], v[3];
        f.q0[2] = f.v0[2] = 0;
        fixture_start(&f, both[i], i ? 1e-9 : 0.125);
        while (f.it.t < 1) {
            CU_ASSERT_FATAL(pk_integrator_step(&f.it, 1) == PK_DONE);
            CU_ASSERT(fabs(f.it.v[2] - (pow(f.it.q[0], 3) + 0.125) / 3) < 1e-14);
            const double t = (f.it.t + f.it.last_t) / 2, x = t - 0.5;
            if (i)
                CU_ASSERT(pk_integrator_dense(&f.it, t, q, v) == PK_DONE &&
                          fabs(v[2] - (x * x * x + 0.125) / 3) < 1e-14);
        }
    }
    system = rod_system;
    system.constraints.values = crossing;
    system.constraints.jacobian = crossing_rows;
    system.acceleration = forceless;
    f.q0[0] = 0; /* there is no start there */
    CU_ASSERT(fixture_begin(&f, "rattle", 0.125) == PK_NO_PROJECTION);

    /* Kernels that a model was compiled without. */
    system = rod_system;
    system.inertia = NULL;
    fixture_set(&f, &system);
    CU_ASSERT(fixture_begin(&f, "rk4", 0.1) == PK_REFUSED && says(&f.it, "the kernel inertia"));
    system = rod_system;
    system.unconstrained = NULL;
    fixture_set(&f, &system);
    CU_ASSERT(fixture_begin(&f, "rk4", 0.1) == PK_DONE);
    CU_ASSERT(fixture_begin(&f, "rattle", 0.1) == PK_REFUSED &&
              says(&f.it, "the kernel unconstrained"));
}

static void lowest(ARGS, double *g)
{
    UNUSED;
    g[0] = q[0];
}

/* Between steps too: dense output, and events, by every method; and an ensemble's members. */
TEST("between steps")
{
    static const struct pk_event at[] = {{{"lowest", "", ""}, 0, 1}};
    static struct pk_system system;
    static double room[1 << 16];
    static const char *const dense[] = {"gauss", "dop853", "dopri5"};
    for (int i = 0; i < 3; i++) {
        double q[4], v[4], worst = 0;
        fixture_open(&f, &rods_system, dense[i], 1e-6);
        while (f.it.t < 3) {
            CU_ASSERT_FATAL(pk_integrator_step(&f.it, 3) == PK_DONE);
            const double t = (f.it.t + f.it.last_t) / 2;
            CU_ASSERT(pk_integrator_dense(&f.it, t, q, v) == PK_DONE);
            worst = fmax(worst, fabs(q[0] * q[0] + q[1] * q[1] - 1));
            worst = fmax(worst, fabs(q[0] * v[0] + q[1] * v[1]));
        }
        CU_ASSERT(worst < 2e-15);
    }
    system = rod_system;
    system.events = (struct pk_part_events){.n = 1, .table = at, .values = lowest};
    double when[BOUND_METHODS];
    for (int i = 0; i < BOUND_METHODS; i++) {
        struct pk_events events;
        fixture_set(&f, &system);
        f.v0[0] = -0.8, f.v0[1] = -0.6; /* swinging in */
        CU_ASSERT_FATAL(fixture_begin(&f, bound_methods[i], i < BOUND_FIXED ? 0.01 : 1e-9) ==
                        PK_DONE);
        CU_ASSERT_FATAL(pk_events_init(&events, &f.it, room, sizeof room) == PK_DONE);
        CU_ASSERT(pk_events_to(&events, &f.it, 20) == PK_STOPPED_EVENT);
        when[i] = f.it.t;
        CU_ASSERT(fixture_residuals(&f).position_relative < 3e-15);
        CU_ASSERT(fixture_residuals(&f).rate_relative < 3e-15 && fabs(f.it.q[0]) < 1e-13);
        pk_events_free(&events);
        pk_integrator_free(&f.it);
    }
    for (int i = 0; i < BOUND_METHODS; i++)
        CU_ASSERT(when[i] > 0.2 &&
                  fabs(when[i] - when[BOUND_GAUSS]) < (i % 3 || i > 3 ? 1e-7 : 1e-4));

    struct test_params params[3];
    double q0[3][2], v0[3][2], q[3][2], v[3][2], last[3];
    size_t done[3];
    enum pk_status status[3];
    for (int i = 0; i < 3; i++) {
        fixture_set(&f, &rod_system);
        params[i] = f.params;
        memcpy(q0[i], f.q0, sizeof q0[i]);
        v0[i][0] = (1 + i) * f.v0[0], v0[i][1] = (1 + i) * f.v0[1];
    }
    const double t = 2;
    struct pk_ensemble e = {.system = &rod_system, .method = pk_method_find("rk4"), .members = 3};
    e.options = pk_options_default();
    e.options.h = 0.01;
    e.params = params, e.q0 = q0[0], e.v0 = v0[0], e.rows = 1, e.t = &t, e.q = q[0], e.v = v[0];
    e.done = done, e.last_t = last, e.status = status;
    CU_ASSERT(pk_ensemble_run(&e, 0, 3, room, sizeof room) == PK_DONE);
    for (int i = 0; i < 3; i++)
        CU_ASSERT(fabs(q[i][0] * q[i][0] + q[i][1] * q[i][1] - 1) < 1e-15);
    CU_ASSERT(fixture_run(&f, &rod_system, "rk4", 0.01, 2) == PK_DONE);
    CU_ASSERT(memcmp(f.it.q, q[0], sizeof q[0]) == 0 && memcmp(f.it.v, v[0], sizeof v[0]) == 0);
}

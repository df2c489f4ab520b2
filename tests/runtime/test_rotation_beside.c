/* Rotations: through the upright, starts that are no rotations, ensembles, states and events.
 */
#include <stdlib.h>

#include "fixture.h"

static struct fixture f;

static const char *const steps[] = {"lie_midpoint", "lie_midpoint4", "lie_midpoint6",
                                    "rattle",       "rattle4",       "rattle6",
                                    "rkmk4",        "rk4",           "gauss2"};
enum { STEPS = sizeof steps / sizeof *steps, VARIATIONAL = 6 };

/* Through theta = 0, where Euler's angles end: the axis of a sleeping top that falls and rises. */
TEST("through the upright")
{
    for (int i = 0; i < STEPS; i++) {
        double lowest = 1, back = -1, E0;
        fixture_set(&f, &top_system);
        const double start[] = {1.0, 0, 1, 1, 0, 0, 0};
        memcpy(f.v0, start, sizeof start);
        fixture_start(&f, steps[i], 0.01);
        E0 = fixture_energy(&f);
        for (int k = 0; k < 800; k++) {
            CU_ASSERT_FATAL(pk_integrator_step(&f.it, 1e9) == PK_DONE);
            const double *Q = f.it.v + 3, c = 1 - 2 * (Q[1] * Q[1] + Q[2] * Q[2]);
            lowest = fmin(lowest, c);
            back = lowest < 0 ? fmax(back, c) : back;
        }
        CU_ASSERT(lowest < -0.5 && back > 0.99);
        CU_ASSERT(fabs(fixture_energy(&f) - E0) < (i % 3 && i < 6 ? 1e-4 : 5e-3));
    }
}

/* A start whose quaternion is no unit is refused; one of rounding is made one. */
TEST("unit quaternions")
{
    fixture_set(&f, &top_system);
    f.v0[4] = 0.61;
    CU_ASSERT(fixture_begin(&f, "rk4", 0.01) == PK_OFF_CONSTRAINTS);
    CU_ASSERT(says(&f.it, "the quaternion of R is not of unit length, by 0.00603"));
    CU_ASSERT(pk_integrator_step(&f.it, 1) == PK_OFF_CONSTRAINTS);
    f.v0[4] = 0.6 + 1e-10;
    CU_ASSERT(fixture_begin(&f, "rk4", 0.01) == PK_DONE);
    CU_ASSERT(fixture_residuals(&f).norm < 1e-15);
    /* Without projection rk4 leaves it. */
    static struct pk_system loose;
    loose = free_body_system;
    CU_ASSERT(fixture_run(&f, &loose, "rk4", 0.1, 100) == PK_DONE);
    CU_ASSERT(fixture_residuals(&f).norm < 1e-15);
    loose.n_rotations = 0;
    CU_ASSERT(fixture_run(&f, &loose, "rk4", 0.1, 100) == PK_DONE);
    f.problem.system = &free_body_system;
    CU_ASSERT(fixture_residuals(&f).norm > 1e-8);
}

/* Members in lanes are normalised as one alone is, to the bit. */
TEST("ensembles of bodies")
{
    enum { MEMBERS = 11, ROWS = 2, N = 7 };
    static struct test_params params[MEMBERS];
    static double q0[MEMBERS][N], v0[MEMBERS][N], q[MEMBERS][ROWS][N], v[MEMBERS][ROWS][N];
    static const char *const names[] = {"rk4", "dop853", "rkmk4", "lie_midpoint"};
    const double t[ROWS] = {1, 3};
    for (int m = 0; m < 4; m++) {
        size_t done[MEMBERS];
        double last[MEMBERS];
        enum pk_status status[MEMBERS];
        for (size_t i = 0; i < MEMBERS; i++) {
            fixture_set(&f, &free_body_system);
            params[i] = f.params;
            memcpy(v0[i], f.v0, sizeof v0[i]);
            v0[i][0] += 0.1 * (double)i;
        }
        v0[3][5] = 0.9; /* no unit */
        struct pk_ensemble e = {.system = &free_body_system, .method = pk_method_find(names[m])};
        e.options = pk_options_default();
        e.options.h = 0.05;
        e.members = MEMBERS, e.params = params, e.q0 = q0[0], e.v0 = v0[0], e.rows = ROWS, e.t = t;
        e.q = q[0][0], e.v = v[0][0], e.done = done, e.last_t = last, e.status = status;
        void *block = aligned_alloc(64, pk_ensemble_size(&e));
        CU_ASSERT(pk_ensemble_run(&e, 0, MEMBERS, block, pk_ensemble_size(&e)) ==
                  PK_OFF_CONSTRAINTS);
        free(block);
        for (size_t i = 0; i < MEMBERS; i++) {
            CU_ASSERT(status[i] == (i == 3 ? PK_OFF_CONSTRAINTS : PK_DONE));
            if (i == 3 || m == 1) /* dop853 alone has no fixed step */
                continue;
            fixture_set(&f, &free_body_system);
            memcpy(f.v0, v0[i], sizeof v0[i]);
            CU_ASSERT(fixture_begin(&f, names[m], 0.05) == PK_DONE);
            for (size_t r = 0; r < ROWS; r++) {
                CU_ASSERT(pk_integrator_to(&f.it, t[r]) == PK_DONE);
                CU_ASSERT(memcmp(f.it.v, v[i][r], sizeof v[i][r]) == 0);
            }
        }
        for (size_t i = 0; i < MEMBERS; i++)
            for (size_t r = 0; r < ROWS && i != 3; r++) {
                const double *Q = v[i][r] + 3;
                CU_ASSERT(fabs(Q[0] * Q[0] + Q[1] * Q[1] + Q[2] * Q[2] + Q[3] * Q[3] - 1) < 2e-15);
            }
    }
}

/* A step so long that the square of a quaternion's norm overflows is no motion, alone or in lanes.
 */
TEST("an attitude that is lost")
{
    double t = 1e45, q[2][7], last[2], v0[2][7] = {{0}}, v[2][7];
    size_t done[2];
    enum pk_status status[2];
    struct test_params params[2];
    for (int i = 0; i < 2; i++) {
        fixture_set(&f, &free_body_system);
        params[i] = f.params;
        v0[i][0] = i ? 1e-300 : 1, v0[i][3] = 1;
    }
    memset(f.v0, 0, sizeof f.v0);
    memcpy(f.v0, v0[0], sizeof v0[0]);
    fixture_start(&f, "rk4", t);
    CU_ASSERT(pk_integrator_to(&f.it, t) == PK_NOT_FINITE);
    CU_ASSERT(f.it.t == 0 && f.it.v[3] == 1);
    struct pk_ensemble e = {.system = &free_body_system, .method = pk_method_find("rk4")};
    const double q0[2][7] = {{0}};
    e.options = pk_options_default();
    e.options.h = t;
    e.members = 2, e.params = params, e.q0 = q0[0], e.v0 = v0[0], e.rows = 1, e.t = &t;
    e.q = q[0], e.v = v[0], e.done = done, e.last_t = last, e.status = status;
    void *block = aligned_alloc(64, pk_ensemble_size(&e));
    CU_ASSERT(pk_ensemble_run(&e, 0, 2, block, pk_ensemble_size(&e)) == PK_NOT_FINITE);
    free(block);
    CU_ASSERT(status[0] == PK_NOT_FINITE && done[0] == 0 && last[0] == 0);
    CU_ASSERT(status[1] == PK_DONE && v[1][3] == 1); /* beside it one goes on */
}

static void turning(ARGS, double *g)
{
    UNUSED;
    g[0] = v[0];
}

/* A state to the method's own order, and events by steps of the method itself. */
TEST("states and events")
{
    static const struct pk_event crossing[] = {{{"turns", "", ""}, 0, 1}};
    static struct pk_system system;
    CU_ASSERT_FATAL(fixture_run(&f, &metered_system, "gauss6", 0.01, 2) == PK_DONE);
    const double exact = f.it.v[7];
    for (int i = 0; i < VARIATIONAL + 1; i++) {
        double h[2], error[2];
        for (int k = 0; k < 2; k++) {
            h[k] = (i < VARIATIONAL && i % 3 ? 0.2 : 0.02) / (1 + k);
            CU_ASSERT_FATAL(fixture_run(&f, &metered_system, steps[i], h[k], 2) == PK_DONE);
            error[k] = fabs(f.it.v[7] - exact);
        }
        const double p = log(error[0] / error[1]) / log(2);
        printf("\n    %-13s of a state %.2f", steps[i], p);
        CU_ASSERT(fabs(p - pk_method_find(steps[i])->order) < 0.3);
    }
    system = free_body_system;
    system.events = (struct pk_part_events){.n = 1, .table = crossing, .values = turning};
    static double room[1 << 16];
    double when[STEPS];
    for (int i = 0; i < STEPS; i++) {
        struct pk_events events;
        fixture_open(&f, &system, steps[i], 0.01);
        CU_ASSERT_FATAL(pk_events_size(&f.problem, f.it.method) <= sizeof room);
        CU_ASSERT_FATAL(pk_events_init(&events, &f.it, room, sizeof room) == PK_DONE);
        CU_ASSERT(pk_events_to(&events, &f.it, 20) == PK_STOPPED_EVENT);
        when[i] = f.it.t;
        CU_ASSERT(fabs(f.it.v[0]) < 1e-13 && fixture_residuals(&f).norm < 1e-15);
    }
    for (int i = 0; i < STEPS; i++)
        CU_ASSERT(when[i] > 1 && fabs(when[i] - when[6]) < (i % 3 ? 1e-6 : 1e-3));
}

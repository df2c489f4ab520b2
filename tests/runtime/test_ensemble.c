/* Ensembles: every member as it comes out alone, to the bit, by every route, in any company and in
 * any number of threads; and members that fail, alone.
 */
#define _POSIX_C_SOURCE 200809L

#include <stdatomic.h>
#include <stdlib.h>
#include <time.h>

#include "fixture.h"

enum { MEMBERS = 150, ROWS = 3 }; /* neither a whole number of blocks nor of lanes */

/* An ensemble and all its memory. Member i has a start and parameters of its own. */
struct crowd {
    struct pk_ensemble e;
    struct pk_system system;
    struct test_params params[MEMBERS];
    double q0[2 * MEMBERS], v0[2 * MEMBERS], u[MEMBERS], t[ROWS];
    double q[2 * MEMBERS * ROWS], v[2 * MEMBERS * ROWS], last_t[MEMBERS];
    size_t done[MEMBERS];
    enum pk_status status[MEMBERS];
    double block[1 << 16];
};

/* How a member gets its acceleration: compiled in, by eight lanes, or by itself. */
enum route { OWN, LANES, SCALAR };

static void crowd_set(struct crowd *c, const struct pk_system *system, enum route route,
                      const char *method, double h)
{
    static const double t[ROWS] = {0.5, 1.1, 1.25};
    memset(c, 0, sizeof *c);
    c->system = *system;
    if (route != OWN)
        c->system.block_steppers = NULL, c->system.steppers = NULL;
    if (route == SCALAR)
        c->system.members = NULL;
    for (size_t i = 0; i < MEMBERS; i++) {
        system->defaults(&c->params[i]);
        c->params[i].g *= 1 + 1e-3 * (double)i;
        system->prepare(&c->params[i]);
        system->start(&c->params[i], c->q0 + i * system->n, c->v0 + i * system->n);
        c->q0[i * system->n] += 0.002385 * (double)i;
        c->u[i] = 0.3 - 0.01 * (double)i;
    }
    memcpy(c->t, t, sizeof t);
    c->e = (struct pk_ensemble){.system = &c->system,
                                .method = pk_method_find(method),
                                .options = pk_options_default(),
                                .members = MEMBERS,
                                .params = c->params,
                                .q0 = c->q0,
                                .v0 = c->v0,
                                .u = c->u,
                                .rows = ROWS,
                                .t = c->t,
                                .q = c->q,
                                .v = c->v,
                                .done = c->done,
                                .last_t = c->last_t,
                                .status = c->status};
    c->e.options.h = h;
    CU_ASSERT_FATAL(pk_ensemble_size(&c->e) > 0);
    CU_ASSERT_FATAL(2 * pk_ensemble_size(&c->e) <= sizeof c->block);
}

static void member_input(void *context, double t, double *u)
{
    (void)t;
    *u = *(const double *)context;
}

/* Member i by pk_integrator: rows made, q and v of them. */
static enum pk_status alone(struct crowd *c, size_t i, double *q, double *v, size_t *rows)
{
    static double block[8192];
    const size_t n = c->system.n;
    struct pk_integrator it;
    struct pk_problem problem = {.system = &c->system, .params = &c->params[i]};
    problem.input = member_input;
    problem.context = &c->u[i];
    enum pk_status status = pk_integrator_init(&it, &problem, c->e.method, &c->e.options, 0,
                                               c->q0 + i * n, c->v0 + i * n, block, sizeof block);
    for (*rows = 0; *rows < ROWS && status == PK_DONE;) {
        status = pk_integrator_to(&it, c->t[*rows]);
        if (status == PK_DONE) {
            memcpy(q + *rows * n, it.q, n * sizeof *q);
            memcpy(v + *rows * n, it.v, n * sizeof *v);
            ++*rows;
        }
    }
    return status;
}

/* Members that differ from what they are alone. */
static int strangers(struct crowd *c)
{
    const size_t n = c->system.n;
    int found = 0;
    for (size_t i = 0; i < MEMBERS; i++) {
        double q[2 * ROWS], v[2 * ROWS];
        size_t rows;
        const enum pk_status status = alone(c, i, q, v, &rows);
        const size_t at = i * ROWS * n;
        found += status != c->status[i] || rows != c->done[i] ||
                 memcmp(q, c->q + at, rows * n * sizeof *q) != 0 ||
                 memcmp(v, c->v + at, rows * n * sizeof *v) != 0;
    }
    return found;
}

static const struct {
    const struct pk_system *system;
    const char *method;
    double h;
} cases[] = {{&double_pendulum_system, "rk4", 0.01},
             {&double_pendulum_system, "euler", 0.01},
             {&pushed_system, "rk4", 0.01},
             {&forced_system, "rk4", 0.01},
             {&driven_system, "verlet", 0.01},
             {&driven_system, "yoshida4", 0.01},
             {&pendulum_system, "symplectic_euler", 0.01},
             {&double_pendulum_system, "rk3", 0.01},
             {&driven_system, "blanes_moan6", 0.05},
             {&driven_system, "kahan_li8", 0.05},
             {&pendulum_system, "adaptive_verlet", 0.01},
             {&double_pendulum_system, "gauss2", 0.05},
             {&double_pendulum_system, "dop853", 0},
             {&kepler_system, "dopri5", 0}};

/* Rows that are no whole number of steps: by lanes and one by one, with and without momenta, each
 * is what a step aside of one integrator is, and the steps are what they are without rows. */
TEST("rows between steps")
{
    static const struct {
        const struct pk_system *system;
        const char *method;
    } of[] = {{&pendulum_system, "rk4"},
              {&driven_system, "yoshida4"},
              {&pendulum_system, "verlet"},
              {&double_pendulum_system, "gauss2"},
              {&pushed_system, "rk4"}};
    static struct crowd c, other;
    for (size_t k = 0; k < sizeof of / sizeof *of; k++)
        for (int route = OWN; route <= SCALAR; route++) {
            static double block[2][8192];
            struct pk_integrator it, aside;
            const size_t n = of[k].system->n, i = 5;
            size_t row = 0;
            crowd_set(&c, of[k].system, (enum route)route, of[k].method, 0.07);
            const struct pk_problem problem = {.system = &c.system,
                                               .params = &c.params[i],
                                               .input = member_input,
                                               .context = &c.u[i]};
            CU_ASSERT(pk_ensemble_run(&c.e, 0, MEMBERS, c.block, sizeof c.block) == PK_DONE);
            for (int side = 0; side < 2; side++)
                pk_integrator_init(side ? &aside : &it, &problem, c.e.method, &c.e.options, 0,
                                   c.q0 + i * n, c.v0 + i * n, block[side], sizeof *block);
            while (it.t < 1.25) {
                CU_ASSERT_FATAL(pk_integrator_step(&it, 1.25) == PK_DONE);
                for (; row < ROWS && c.t[row] <= it.t; row++) {
                    const double *q = c.q + (i * ROWS + row) * n, *v = c.v + (i * ROWS + row) * n;
                    CU_ASSERT(pk_integrator_aside(&it, &aside, c.t[row]) == PK_DONE);
                    const double *to_q = c.t[row] < it.t ? aside.q : it.q;
                    CU_ASSERT(memcmp(q, to_q, n * sizeof *q) == 0);
                    CU_ASSERT(memcmp(v, c.t[row] < it.t ? aside.v : it.v, n * sizeof *v) == 0);
                    CU_ASSERT(row + 1 == ROWS || memcmp(q, it.q, n * sizeof *q) != 0);
                }
            }
            CU_ASSERT(it.count.steps == 18 && row == ROWS);
            crowd_set(&other, of[k].system, (enum route)route, of[k].method, 0.07);
            other.e.rows = 1;
            other.e.t = other.t + ROWS - 1;
            CU_ASSERT(pk_ensemble_run(&other.e, 0, MEMBERS, other.block, sizeof c.block) ==
                      PK_DONE);
            for (size_t m = 0; m < MEMBERS; m++)
                CU_ASSERT(memcmp(other.q + m * n, c.q + (m * ROWS + ROWS - 1) * n, n * 8) == 0);
        }
}

TEST("each member as alone, to the bit")
{
    static struct crowd c;
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++)
        for (int route = OWN; route <= SCALAR; route++) {
            crowd_set(&c, cases[k].system, (enum route)route, cases[k].method, cases[k].h);
            CU_ASSERT(pk_ensemble_run(&c.e, 0, MEMBERS, c.block, sizeof c.block) == PK_DONE);
            CU_ASSERT(strangers(&c) == 0);
            CU_ASSERT(c.q[0] != c.q[ROWS * c.system.n]); /* members are not all the same */
            c.q[7 * ROWS * c.system.n] *= 1 + 1e-15;
            CU_ASSERT(strangers(&c) == 1);
        }
}

/* dop853 at a fixed step: of order 8 against an adaptive run, and the same by each route. */
TEST("dop853 at fixed steps")
{
    static struct crowd c, exact;
    static double q[2 * MEMBERS * ROWS];
    double error[2] = {0, 0};
    crowd_set(&exact, &double_pendulum_system, OWN, "dop853", 0);
    exact.e.options.rtol = exact.e.options.atol = 1e-14;
    CU_ASSERT(!pk_ensemble_fixed(&exact.e));
    CU_ASSERT(pk_ensemble_run(&exact.e, 0, MEMBERS, exact.block, sizeof exact.block) == PK_DONE);
    for (int half = 0; half < 2; half++)
        for (int route = OWN; route <= SCALAR; route++) {
            crowd_set(&c, &double_pendulum_system, (enum route)route, "dop853",
                      half ? 0.025 : 0.05);
            CU_ASSERT(pk_ensemble_fixed(&c.e));
            CU_ASSERT(pk_ensemble_run(&c.e, 0, MEMBERS, c.block, sizeof c.block) == PK_DONE);
            for (size_t i = 0; i < 2 * MEMBERS * ROWS; i++)
                error[half] = fmax(error[half], fabs(c.q[i] - exact.q[i]));
            if (route == OWN)
                memcpy(q, c.q, sizeof q);
            CU_ASSERT(memcmp(q, c.q, sizeof q) == 0);
        }
    printf("\n    dop853 at .05: %.1e, at .025: %.1e", error[0], error[1]);
    CU_ASSERT(error[1] > 1e-12 && log2(error[0] / error[1]) > 6.5 && error[0] < 1e-4);
}

/* Any thread count, any grouping: the same bits. */
TEST("any threads, any company")
{
    static struct crowd c, other;
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        crowd_set(&c, cases[k].system, OWN, cases[k].method, cases[k].h);
        CU_ASSERT(pk_ensemble_run(&c.e, 0, MEMBERS, c.block, sizeof c.block) == PK_DONE);
        for (size_t threads = 1; threads <= 4; threads += 3) {
            static double block[1 << 18];
            crowd_set(&other, cases[k].system, OWN, cases[k].method, cases[k].h);
            CU_ASSERT(pk_ensemble_run_threads(&other.e, threads, block, sizeof block) == PK_DONE);
            CU_ASSERT(memcmp(c.q, other.q, sizeof c.q) == 0);
            CU_ASSERT(memcmp(c.v, other.v, sizeof c.v) == 0);
        }
        crowd_set(&other, cases[k].system, OWN, cases[k].method, cases[k].h);
        for (size_t first = 0; first < MEMBERS; first += 7) /* lanes shifted, blocks padded */
            pk_ensemble_run(&other.e, first, MEMBERS - first < 7 ? MEMBERS - first : 7, other.block,
                            sizeof other.block);
        CU_ASSERT(memcmp(c.q, other.q, sizeof c.q) == 0 && c.q[5] != 0);
    }
}

/* Whether the reason of a member has this in it, and results stay as they are. */
static int is_told(struct crowd *c, size_t i, const char *part)
{
    const struct crowd before = *c;
    char text[512], last[64];
    pk_ensemble_reason(&c->e, i, c->block, sizeof c->block, text, sizeof text);
    snprintf(last, sizeof last, "; last valid time %.17g", c->last_t[i]);
    return strstr(text, part) && (c->last_t[i] == 0 || strstr(text, last)) &&
           memcmp(&before.status, &c->status, sizeof c->status) == 0 &&
           memcmp(&before.done, &c->done, sizeof c->done) == 0 &&
           memcmp(&before.last_t, &c->last_t, sizeof c->last_t) == 0 &&
           memcmp(&before.q, &c->q, sizeof c->q) == 0;
}

TEST("members fail alone")
{
    static struct crowd c;
    static const char *const methods[] = {"rk4", "dop853"};
    for (int k = 0; k < 4; k++)
        for (int route = OWN; route <= SCALAR; route++) {
            /* M = limit - q: singular on the way for two members; one may not start at all. */
            crowd_set(&c, k < 2 ? &folded_system : &broken_system, (enum route)route,
                      methods[k % 2], k % 2 ? 0 : 0.01);
            for (size_t i = 0; i < MEMBERS; i++)
                c.params[i].limit = 9;
            c.params[3].limit = k < 2 ? 0.9 : 0.7;
            c.params[0].limit = k < 2 ? 1.0 : 0.9; /* later than 3, whose lane follows it */
            c.v0[20] = k < 2 ? 1e200 : 0.2;        /* M is no number since q is none */
            c.params[149].limit = 1.2;
            c.params[70].g = -1; /* out of bounds */
            c.v0[77] = (double)NAN;
            const enum pk_status status =
                pk_ensemble_run(&c.e, 0, MEMBERS, c.block, sizeof c.block);
            CU_ASSERT(status == (k < 2 ? PK_SINGULAR_MASS : PK_NOT_FINITE));
            CU_ASSERT(c.last_t[3] < c.last_t[0]);
            CU_ASSERT(c.status[20] == (k < 2 ? PK_NOT_FINITE : PK_DONE));
            CU_ASSERT(c.status[3] == status && c.status[70] == PK_OUT_OF_BOUNDS);
            CU_ASSERT(c.status[77] == PK_BAD_ARGUMENT && c.done[77] == 0);
            CU_ASSERT(c.last_t[3] > 0.1 && c.last_t[3] < 1.25 && c.done[3] < ROWS);
            size_t arrived = 0;
            for (size_t i = 0; i < MEMBERS; i++)
                arrived += c.status[i] == PK_DONE && c.done[i] == ROWS;
            CU_ASSERT(arrived == MEMBERS - (k < 2 ? 6u : 5u));
            CU_ASSERT(strangers(&c) == 0); /* the others are not touched by it */
            CU_ASSERT(is_told(&c, 3, k < 2 ? "singular" : "finite"));
            CU_ASSERT(is_told(&c, 70, "parameter") && is_told(&c, 77, "argument"));
        }
}

static void distance(ARGS, double *out)
{
    UNUSED;
    out[0] = sqrt(q[0] * q[0] + q[1] * q[1]);
}

/* Members that fall into the centre, seen lane by lane: without singularities all of them arrive.
 */
TEST("singularities are watched in lanes")
{
    static const struct pk_singularity centre = {{"r", "", ""}, PK_SINGULARITY_DIVISOR};
    static const char *const methods[] = {"verlet", "rk4"};
    static struct crowd c;
    for (int guarded = 0; guarded < 2; guarded++)
        for (int k = 0; k < 6; k++) {
            crowd_set(&c, &kepler_system, (enum route)(k % 3), methods[k / 3], 0.01);
            c.system.singularities = (struct pk_part_singularities){
                .n = (size_t)guarded, .table = &centre, .values = distance};
            c.v0[2 * 3 + 1] = c.v0[2 * 64 + 1] = c.v0[2 * 149 + 1] = 0;
            c.q0[2 * 64] = 0.8;                /* falls later, between rows */
            c.q0[2 * 5] = c.q0[2 * 5 + 1] = 0; /* starts there */
            CU_ASSERT(pk_ensemble_run(&c.e, 0, MEMBERS, c.block, sizeof c.block) ==
                      (guarded ? PK_SINGULAR_TIME : PK_NOT_FINITE));
            CU_ASSERT(c.status[5] == (guarded ? PK_SINGULAR_TIME : PK_NOT_FINITE));
            CU_ASSERT(c.status[149] == (guarded ? PK_SINGULAR_TIME : PK_DONE));
            CU_ASSERT(!guarded || (c.last_t[3] > 0.2 && c.last_t[3] < c.last_t[64]));
            CU_ASSERT(!guarded || (c.last_t[64] > 0.6 && c.last_t[64] < 0.8 && c.done[64] == 1));
            CU_ASSERT(strangers(&c) == 0);
        }
}

static void to_the_fold(ARGS, double *out)
{
    (void)t, (void)v, (void)u;
    out[0] = ((const struct test_params *)params)->limit - q[0];
}

/* M is singular where a singularity vanishes: the singularity is the reason. */
TEST("singularities know why a member failed")
{
    static const struct pk_singularity fold = {{"limit - q", "", ""}, PK_SINGULARITY_COORDINATES};
    static struct crowd c;
    for (int route = OWN; route <= SCALAR; route++) {
        crowd_set(&c, &folded_system, (enum route)route, "rk4", 0.01);
        c.system.singularities =
            (struct pk_part_singularities){.n = 1, .table = &fold, .values = to_the_fold};
        for (size_t i = 0; i < MEMBERS; i++)
            c.params[i].limit = i % 50 == 3 ? 0.9 : 9;
        CU_ASSERT(pk_ensemble_run(&c.e, 0, MEMBERS, c.block, sizeof c.block) ==
                  PK_SINGULAR_COORDINATES);
        CU_ASSERT(c.status[53] == PK_SINGULAR_COORDINATES && strangers(&c) == 0);
        CU_ASSERT(is_told(&c, 53, "limit - q"));
    }
}

static atomic_int asked;

static int ask(void *context)
{
    (void)context;
    ++asked;
    return 0;
}

/* Lasts until the first thread has asked for a stop, 5 s at most; in the first thread 5 ms. */
static void wait_for_asking(void *late, size_t i)
{
    (void)i;
    for (int ms = 0; ms < (pk_thread() ? 5000 : 5); ms++) {
        nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
        if (asked)
            return;
    }
    if (pk_thread())
        *(int *)late = 1;
}

/* The first thread alone can see SIGTERM, so it must not sleep while the others work. */
TEST("the first thread asks while others work")
{
    int late = 0;
    const struct pk_options options = {.stop = ask};
    pk_parallel(2, 2, wait_for_asking, &late, &options);
    CU_ASSERT(!late && (asked || pk_ensemble_threads() == 1));
}

static int after_a_while(void *context)
{
    int *calls = (int *)context;
    return ++*calls > 12;
}

TEST("refusals")
{
    static struct crowd c;
    int calls = 0;
    crowd_set(&c, &double_pendulum_system, OWN, "verlet", 0.1);
    CU_ASSERT(pk_ensemble_run(&c.e, 0, MEMBERS, c.block, sizeof c.block) == PK_REFUSED);
    CU_ASSERT(c.done[0] == 0);
    crowd_set(&c, &double_pendulum_system, OWN, "rk4", 0.1);
    CU_ASSERT(pk_ensemble_run(&c.e, 0, MEMBERS + 1, c.block, sizeof c.block) == PK_BAD_ARGUMENT);
    CU_ASSERT(pk_ensemble_run(&c.e, 0, 1, c.block, 64) == PK_BLOCK_TOO_SMALL);
    CU_ASSERT(pk_ensemble_run_threads(&c.e, 0, c.block, 64) == PK_BLOCK_TOO_SMALL);
    CU_ASSERT(pk_ensemble_run(&c.e, 0, 1, NULL, sizeof c.block) == PK_BAD_ARGUMENT);
    c.e.options.max_steps = 7;
    CU_ASSERT(pk_ensemble_run(&c.e, 0, MEMBERS, c.block, sizeof c.block) == PK_TOO_MANY_STEPS);
    CU_ASSERT(c.done[9] == 1 && c.last_t[9] > 0.5 && strangers(&c) == 0);
    CU_ASSERT(pk_ensemble_run_threads(&c.e, 2, c.block, sizeof c.block) == PK_TOO_MANY_STEPS);
    c.e.options.max_steps = 0;
    c.e.options.stop = after_a_while;
    c.e.options.context = &calls;
    /* After 12 steps, one by one and in lanes. */
    for (size_t count = 1; count <= MEMBERS; count += MEMBERS - 1, calls = 0) {
        CU_ASSERT(pk_ensemble_run(&c.e, 0, count, c.block, sizeof c.block) == PK_STOPPED_USER);
        CU_ASSERT(c.status[0] == PK_STOPPED_USER && fabs((double)c.last_t[0] - 1.2) < 1e-6);
    }
}

/* Events: times against closed forms, the trajectory left alone, stops, failures. */
#include <stdlib.h>

#include "event_watch.h"

/* Period of a pendulum of theta'' = -sin theta: 2 pi / agm(1, cos(amplitude/2)). */
static double period(double amplitude)
{
    double a = 1, b = cos(amplitude / 2);
    for (int k = 0; k < 40 && a != b; k++) {
        const double mean = (a + b) / 2;
        b = sqrt(a * b);
        a = mean;
    }
    return 2 * acos(-1) / a;
}

static void watch_pendulum(struct watch *w, event_function *g, double degrees)
{
    watch_set(w, &pendulum_system, g, 1);
    w->f.params.g = 1;
    w->system.prepare(&w->f.params);
    w->f.q0[0] = degrees * acos(-1) / 180;
    w->f.v0[0] = 0;
}

/* REGIMES P1: periods over those of small swings, from rest to rest on the same side; also across
 * the lowest point, which is a quarter of a period earlier. */
TEST("periods of the pendulum")
{
    const double degrees[] = {90, 170, 179, 179.9};
    const double ratio[] = {1.1803405990, 2.4393627197, 3.9010651604, 5.3668671090};
    static struct watch w;
    for (int k = 0; k < 4; k++) {
        const double amplitude = degrees[k] * acos(-1) / 180, T = period(amplitude);
        CU_ASSERT_DOUBLE_EQUAL(T / (2 * acos(-1)), ratio[k], 6e-11);
        for (int m = 0; m < 3; m++) {
            const char *const method[] = {"gauss", "dop853", "gauss8"};
            watch_pendulum(&w, at_rest, degrees[k]);
            w.declared[0].direction = -1;
            watch_init(&w, method[m], m < 2 ? 1e-14 : 0.05);
            CU_ASSERT(pk_events_to(&w.events, &w.f.it, 1.1 * T) == PK_DONE);
            CU_ASSERT_EQUAL_FATAL(w.count, 1);
            /* What errors of the start and of rounding grow to: their growth is exp(T/2). */
            const double bound = 2e-15 * T * exp(T / 2);
            CU_ASSERT(fabs(w.t[0] - T) < bound && bound < 1e-3 * T);
            CU_ASSERT(fabs(w.f.it.t - w.t[0]) > 0.01);
            watch_free(&w);
        }
    }
}

/* Every method: the time of the lowest point, as accurate as the method; the crossing of its own
 * map to the last digits; a state behind it. */
TEST("every method")
{
    static struct watch w;
    const double T = period(1.5);
    size_t core = 0;
    while (pk_method_at(core))
        core++;
    for (size_t i = 0; pk_method_at(i) || pk_gsl_method_at(i - core); i++) {
        const struct pk_method *m = i < core ? pk_method_at(i) : pk_gsl_method_at(i - core);
        const int adaptive = (m->traits & PK_ADAPTIVE) != 0;
        if (m->traits & (PK_EXACT | PK_JETS)) /* test_exponential.c, tests/runs/test_taylor.py */
            continue;
        watch_pendulum(&w, at_zero, 1.5 * 180 / acos(-1));
        watch_init(&w, m->name, adaptive ? 1e-10 : 0.01);
        CU_ASSERT(pk_events_to(&w.events, &w.f.it, T) == PK_DONE);
        CU_ASSERT_EQUAL(w.count, 2);
        const double bound = adaptive ? 1e-7 : m->order == 1 ? 0.05 : m->order == 2 ? 1e-4 : 1e-6;
        for (int k = 0; k < 2; k++) {
            const double error = fabs(w.t[k] - (0.25 + 0.5 * k) * T);
            CU_ASSERT(error < bound);
            /* gsl_bsimp's way to the same time in another step differs by rounding. */
            const double behind = k ? w.q[k] : -w.q[k], rounding = i < core ? 0 : 2e-15;
            CU_ASSERT(behind >= -rounding && w.direction[k] == (k ? 1 : -1));
            CU_ASSERT(fabs(w.q[k]) < 2e-14); /* |v| < 1.4, t < 6 */
        }
        CU_ASSERT(m->order != 1 || fabs(w.t[0] - 0.25 * T) > 1e-4);
        watch_free(&w);
    }
}

/* The order of the method shows in the times of events. */
TEST("times have the method's order")
{
    static struct watch w;
    double h[5], error[5];
    for (int k = 0; k < 5; k++) {
        h[k] = 0.2 / (1 << k);
        watch_pendulum(&w, at_zero, 80);
        watch_init(&w, "rk4", h[k]);
        CU_ASSERT(pk_events_to(&w.events, &w.f.it, 10) == PK_DONE);
        error[k] = fabs(w.t[2] - 1.25 * period(80 * acos(-1) / 180));
    }
    CU_ASSERT_DOUBLE_EQUAL(fit_slope(h, error, 5), 4, 0.3);
}

/* Another step on the way: crossings are those of the new step's map. */
TEST("a changed step")
{
    static struct watch w;
    double t[2];
    for (int k = 0; k < 2; k++) {
        watch_pendulum(&w, at_zero, 80);
        watch_init(&w, "rk4", k ? 0.2 : 0.05);
        CU_ASSERT(pk_integrator_set_step(&w.f.it, 0.2) == PK_DONE);
        CU_ASSERT(pk_events_to(&w.events, &w.f.it, 10) == PK_DONE);
        t[k] = w.t[2];
    }
    CU_ASSERT(t[0] == t[1] && fabs(t[0] - 1.25 * period(80 * acos(-1) / 180)) > 1e-6);
}

/* Locating leaves the trajectory alone, to the bit. */
TEST("the trajectory is undisturbed")
{
    static struct watch w;
    static struct fixture f;
    const char *const method[] = {"verlet", "gauss4", "dop853", "gauss"};
    for (int m = 0; m < 4; m++) {
        watch_pendulum(&w, at_zero, 100);
        watch_init(&w, method[m], m < 2 ? 0.07 : 1e-9);
        fixture_set(&f, &pendulum_system);
        f.params = w.f.params;
        f.options = w.f.options;
        memcpy(f.q0, w.f.q0, sizeof f.q0);
        memcpy(f.v0, w.f.v0, sizeof f.v0);
        fixture_start(&f, method[m], 0);
        CU_ASSERT(pk_integrator_to(&f.it, 50) == PK_DONE);
        CU_ASSERT(pk_events_to(&w.events, &w.f.it, 50) == PK_DONE);
        CU_ASSERT(w.count > 10 && w.events.tries > 20);
        CU_ASSERT(f.it.count.steps == w.f.it.count.steps);
        CU_ASSERT(f.it.q[0] == w.f.it.q[0] && f.it.v[0] == w.f.it.v[0]);
    }
}

static void down(void *context, pk_real t, pk_real *u)
{
    (void)t;
    u[0] = *(const double *)context;
}

/* q'' = -9.81 above a floor: stops at the floor, is thrown back, goes on. Closed form. */
TEST("bounces")
{
    static struct watch w;
    const char *const method[] = {"verlet", "rk4", "dop853", "gauss", "gauss2"};
    double weight = -9.81, e = 0.8;
    for (int m = 0; m < 5; m++) {
        watch_set(&w, &pushed_system, at_zero, 1);
        w.declared[0].direction = -1;
        w.declared[0].stop = 1;
        w.f.problem.input = down;
        w.f.problem.context = &weight;
        w.f.q0[0] = 2;
        w.f.v0[0] = 0;
        watch_init(&w, method[m], m == 2 || m == 3 ? 1e-12 : 0.01);
        double t = sqrt(2 * 2 / 9.81), v = 9.81 * t;
        for (int k = 0; k < 8; k++) {
            CU_ASSERT_FATAL(pk_events_to(&w.events, &w.f.it, 100) == PK_STOPPED_EVENT);
            CU_ASSERT_DOUBLE_EQUAL(w.f.it.t, t, 1e-12);
            CU_ASSERT_DOUBLE_EQUAL(w.f.it.v[0], -v, 1e-11);
            CU_ASSERT(w.f.it.q[0] <= 0 && w.f.it.q[0] > -1e-13);
            CU_ASSERT_EQUAL(w.f.it.event, 1);
            v *= e;
            t += 2 * v / 9.81;
            const double back = -e * w.f.it.v[0], q = w.f.it.q[0];
            CU_ASSERT(pk_integrator_reset(&w.f.it, w.f.it.t, &q, &back) == PK_DONE);
        }
        CU_ASSERT_EQUAL(w.count, 8);
    }
}

/* Stops name the event; a second call goes on; found() can stop too. */
TEST("stops")
{
    static struct watch w;
    char reason[100];
    watch_cosine(&w, at_zero, 1);
    w.declared[0].stop = 1;
    watch_init(&w, "rk4", 0.01);
    CU_ASSERT(pk_events_to(&w.events, &w.f.it, 10) == PK_STOPPED_EVENT);
    CU_ASSERT(w.f.it.status == PK_STOPPED_EVENT);
    CU_ASSERT_DOUBLE_EQUAL(w.f.it.t, acos(-1) / 2, 1e-8);
    CU_ASSERT_EQUAL(w.f.it.t, w.t[0]);
    CU_ASSERT(w.f.it.q[0] == w.q[0] && w.f.it.v[0] == w.v[0]);
    pk_integrator_reason(&w.f.it, reason, sizeof reason);
    CU_ASSERT(strncmp(reason, "stopped at event crossing at t = 1.5707963", 42) == 0);
    CU_ASSERT(pk_events_to(&w.events, &w.f.it, 10) == PK_STOPPED_EVENT);
    CU_ASSERT_DOUBLE_EQUAL(w.f.it.t, 3 * acos(-1) / 2, 1e-8);

    watch_cosine(&w, at_zero, 1);
    w.stop_after = 3;
    watch_init(&w, "dop853", 1e-12);
    CU_ASSERT(pk_events_to(&w.events, &w.f.it, 100) == PK_STOPPED_EVENT);
    CU_ASSERT_DOUBLE_EQUAL(w.f.it.t, 5 * acos(-1) / 2, 1e-10);
    CU_ASSERT_EQUAL(w.count, 3);
    w.events.found = NULL;
    CU_ASSERT(pk_events_to(&w.events, &w.f.it, 100) == PK_DONE);
    CU_ASSERT_EQUAL(w.f.it.event, 0);
    CU_ASSERT_EQUAL(w.events.count, 3 + 29); /* 100/pi + 1/2 crossings in all */
}

/* q >= 0 of a harmonic motion: to where it goes from q and v, forwards and backwards in time. */
TEST("limits")
{
    const double pi = acos(-1),
                 starts[][4] = {{1, 0, 1, pi / 2}, {1, 0, -1, -pi / 2}, {0, -1, 1, 0},
                                {0, -1, -1, -pi},  {0, 1, 1, pi},       {0, 1, -1, 0}};
    static struct watch w;
    for (size_t k = 0; k < sizeof starts / sizeof *starts; k++) {
        const double *s = starts[k], again = -2, zero = 0;
        watch_cosine(&w, at_zero, 1);
        w.declared[0] = (struct pk_event){{"crossing", "", ""}, -1, 2};
        w.f.q0[0] = s[0];
        w.f.v0[0] = s[1];
        watch_init(&w, "dop853", 1e-12);
        CU_ASSERT(pk_events_to(&w.events, &w.f.it, 10 * s[2]) == PK_STOPPED_EVENT);
        CU_ASSERT_DOUBLE_EQUAL(w.f.it.t, s[3], 1e-10);
        const double t = w.f.it.t;
        CU_ASSERT(pk_integrator_reset(&w.f.it, t, &zero, &again) == PK_DONE);
        CU_ASSERT(pk_events_to(&w.events, &w.f.it, t + 1) == PK_STOPPED_EVENT);
        CU_ASSERT_DOUBLE_EQUAL(w.f.it.t, t, 1e-14);
        watch_free(&w);
    }
}

static void no_number(ARGS, pk_real *g)
{
    UNUSED;
    g[0] = sqrt(q[0] - 0.5) - 0.1;
}

/* What fails: its function, its memory, the motion. */
TEST("failures")
{
    static struct watch w;
    char reason[100];
    watch_cosine(&w, no_number, 1);
    watch_init(&w, "rk4", 0.01);
    CU_ASSERT(pk_events_to(&w.events, &w.f.it, 10) == PK_NOT_FINITE);
    CU_ASSERT_EQUAL(w.count, 1); /* at cos t = .51 */
    CU_ASSERT_DOUBLE_EQUAL(w.t[0], acos(0.51), 1e-7);
    CU_ASSERT_DOUBLE_EQUAL(w.f.it.t, acos(0.5), 0.011);
    CU_ASSERT(says(&w.f.it, "function of event crossing is not finite at t = 1.0"));
    /* The motion's own failure has the motion's reason, after an event's too. */
    watch_set(&w, &broken_system, at_zero, 1);
    watch_init(&w, "rk4", 0.01);
    w.f.it.event = 1;
    CU_ASSERT(pk_events_to(&w.events, &w.f.it, 10) == PK_NOT_FINITE);
    pk_integrator_reason(&w.f.it, reason, sizeof reason);
    CU_ASSERT(strstr(reason, "the motion is no longer finite; last valid time") != NULL);

    watch_cosine(&w, at_zero, 1);
    watch_init(&w, "rk4", 0.01);
    const struct pk_method *rk4 = pk_method_find("rk4");
    const size_t size = pk_events_size(&w.f.problem, rk4);
    CU_ASSERT(size > pk_integrator_size(&w.f.problem, rk4));
    CU_ASSERT(pk_events_init(&w.events, &w.f.it, w.block, size - 1) == PK_BLOCK_TOO_SMALL);
    CU_ASSERT(pk_events_init(&w.events, &w.f.it, (char *)w.block + 1, size) == PK_BLOCK_TOO_SMALL);
    CU_ASSERT(pk_events_init(&w.events, &w.f.it, NULL, size) == PK_BAD_ARGUMENT);
    CU_ASSERT(pk_events_init(&w.events, NULL, w.block, size) == PK_BAD_ARGUMENT);
    memset(w.block, 0x5a, sizeof w.block);
    CU_ASSERT(pk_events_init(&w.events, &w.f.it, w.block, size) == PK_DONE);
    CU_ASSERT(pk_events_to(&w.events, &w.f.it, 10) == PK_DONE);
    CU_ASSERT(*((unsigned char *)w.block + size) == 0x5a); /* nothing is written behind it */
}

/* Without events in the system all is as without them. */
TEST("no events")
{
    static struct watch w;
    watch_set(&w, &pendulum_system, NULL, 0);
    watch_init(&w, "verlet", 0.1);
    CU_ASSERT(pk_events_to(&w.events, &w.f.it, 1) == PK_DONE);
    CU_ASSERT_EQUAL(w.f.it.count.steps, 10);
}

/* Which crossings there are: several in a step, at the same time, both ways, near to each other. */
#include "event_watch.h"

static void four(ARGS, pk_real *g)
{
    UNUSED;
    g[0] = t - 0.61;
    g[1] = 0.32 - t;
    g[2] = q[0] - cos(0.32); /* with the second, to rounding */
    g[3] = t - 0.47;
}

/* Several in one step, in order of time; both directions of integration. */
TEST("several in a step, in order")
{
    static struct watch w;
    for (int backward = 0; backward < 2; backward++) {
        watch_set(&w, &oscillator_system, four, 4);
        w.declared[2].direction = 1; /* it falls: not asked for */
        w.f.params.g = 1;
        w.system.prepare(&w.f.params);
        w.f.q0[0] = backward ? cos(1) : 1;
        w.f.v0[0] = backward ? -sin(1) : 0;
        watch_init(&w, "gauss8", 1);
        if (backward)
            pk_integrator_reset(&w.f.it, 1, w.f.q0, w.f.v0);
        CU_ASSERT(pk_events_to(&w.events, &w.f.it, backward ? 0 : 1) == PK_DONE);
        CU_ASSERT_EQUAL(w.f.it.count.steps, 1);
        CU_ASSERT_EQUAL_FATAL(w.count, 3);
        const double t[] = {0.32, 0.47, 0.61};
        const size_t which[] = {1, 3, 0};
        const int direction[] = {-1, 1, 1};
        for (int k = 0; k < 3; k++) {
            const int at = backward ? 2 - k : k;
            CU_ASSERT_DOUBLE_EQUAL(w.t[at], t[k], 3e-15);
            CU_ASSERT_EQUAL(w.which[at], which[k]);
            CU_ASSERT_EQUAL(w.direction[at], direction[k]);
        }
    }
}

static void both_at_once(ARGS, pk_real *g)
{
    UNUSED;
    g[0] = t - 0.25;
    g[1] = g[0];
    g[2] = t - 0.125; /* at a sample, exactly zero there */
}

TEST("ties")
{
    static struct watch w;
    watch_set(&w, &oscillator_system, both_at_once, 3);
    watch_init(&w, "rk4", 0.5);
    CU_ASSERT(pk_events_to(&w.events, &w.f.it, 2) == PK_DONE);
    CU_ASSERT_EQUAL_FATAL(w.count, 3);
    CU_ASSERT(w.which[0] == 2 && w.which[1] == 0 && w.which[2] == 1);
    CU_ASSERT(w.t[0] == 0.125 && w.t[1] == 0.25 && w.t[2] == 0.25);
}

/* What stops hides nothing that happens at the same time; going on finds none of it again. */
TEST("ties with an event that stops")
{
    static struct watch w;
    watch_set(&w, &oscillator_system, both_at_once, 3);
    w.declared[0].stop = 1;
    watch_init(&w, "rk4", 0.5);
    CU_ASSERT(pk_events_to(&w.events, &w.f.it, 2) == PK_STOPPED_EVENT);
    CU_ASSERT_EQUAL_FATAL(w.count, 3);
    CU_ASSERT(w.which[1] == 0 && w.which[2] == 1 && w.t[2] == 0.25);
    CU_ASSERT(w.f.it.t == 0.25 && w.f.it.event == 1);
    CU_ASSERT(pk_events_to(&w.events, &w.f.it, 2) == PK_DONE);
    CU_ASSERT_EQUAL(w.count, 3);
}

TEST("directions, zero at the start")
{
    static struct watch w;
    for (int direction = -1; direction <= 1; direction++) {
        watch_cosine(&w, at_rest, 1); /* v is 0 at the start, and falls: that is no event */
        w.declared[0].direction = direction;
        watch_init(&w, "gauss4", 0.1);
        CU_ASSERT(pk_events_to(&w.events, &w.f.it, 20) == PK_DONE);
        CU_ASSERT_EQUAL(w.count, direction == 0 ? 6 : 3);
        for (int k = 0; k < w.count; k++)
            CU_ASSERT_EQUAL(w.direction[k], direction ? direction : k % 2 ? -1 : 1);
        CU_ASSERT_DOUBLE_EQUAL(w.t[0], (direction < 0 ? 2 : 1) * acos(-1), 1e-9);
    }
}

static void near_the_top(ARGS, pk_real *g)
{
    UNUSED;
    g[0] = q[0] - 0.9999;
}

static void touching(ARGS, pk_real *g)
{
    UNUSED;
    g[0] = q[0] - 1.0001;
}

/* Two crossings within a step, for 2 acos(.9999) = .028, while the step is ten times as long and
 * more (dop853: six times). */
TEST("two crossings within a step")
{
    static struct watch w;
    const char *const method[] = {"gauss4", "gauss8", "gauss", "dop853"};
    const double h[] = {0.3, 0.7, 1e-12, 1e-12};
    for (int m = 0; m < 4; m++) {
        watch_cosine(&w, near_the_top, 1);
        w.f.q0[0] = cos(1);
        w.f.v0[0] = -sin(1);
        watch_init(&w, method[m], h[m]);
        CU_ASSERT(pk_events_to(&w.events, &w.f.it, 40) == PK_DONE);
        CU_ASSERT(w.f.it.count.steps < 250);
        CU_ASSERT_EQUAL_FATAL(w.count, 12);
        for (int k = 0; k < w.count; k++) {
            const double top = 2 * acos(-1) * (1 + k / 2) - 1, away = acos(0.9999);
            CU_ASSERT_DOUBLE_EQUAL(w.t[k], top + (k % 2 ? away : -away), 1e-7);
        }
        watch_cosine(&w, touching, 1); /* near misses are misses */
        watch_init(&w, method[m], h[m]);
        CU_ASSERT(pk_events_to(&w.events, &w.f.it, 40) == PK_DONE);
        CU_ASSERT_EQUAL(w.count, 0);
    }
}

static void inside(ARGS, pk_real *g)
{
    UNUSED;
    g[0] = q[0] - 0.3;
}

/* Steps of almost a period, which gauss8 makes well and no cubic follows. */
TEST("steps longer than a cubic follows")
{
    static struct watch w;
    watch_cosine(&w, inside, 1);
    watch_init(&w, "gauss8", 6);
    CU_ASSERT(pk_events_to(&w.events, &w.f.it, 100) == PK_DONE);
    CU_ASSERT_EQUAL_FATAL(w.count, 32);
    for (int k = 0; k < w.count; k++) {
        const double top = 2 * acos(-1) * ((k + 1) / 2), away = acos(0.3);
        CU_ASSERT_DOUBLE_EQUAL(w.t[k], top + (k % 2 ? -away : away), 1e-3);
    }
}

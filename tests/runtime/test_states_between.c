/* A state between the ends of a step, where it has no coordinate to be interpolated with: x = cos(t
 * - top) turns within the first step, and what happens about its top is seen there. */
#include "event_watch.h"

static double top, level;

static int falling(ARGS, double *a)
{
    UNUSED;
    a[0] = -sin(t - top);
    return 0;
}

static void near_the_top(ARGS, double *g)
{
    UNUSED;
    g[0] = v[0] - level;
}

/* Far below 0 at the ends of the step, 0 at the top. */
static void short_hill(ARGS, double *m)
{
    UNUSED;
    m[0] = 80 * (v[0] - 1);
}

static struct pk_system turning(void)
{
    struct pk_system system = free_point(falling);
    system.n_first_order = 1;
    return system;
}

/* Of the first a cubic through the ends and the rates there stays below the level; of the second
 * that is so bad that steps of the method are made in place of it. */
TEST("events on a state that turns")
{
    static const char *const methods[] = {"rk4", "rkmk4", "dopri5", "dop853", "gauss"};
    static const double steps[] = {1, 6}, tops[] = {0.5, 1.5707963267948966},
                        levels[] = {0.999, 0.9};
    static struct watch w;
    const struct pk_system system = turning();
    for (size_t k = 0; k < sizeof methods / sizeof *methods; k++)
        for (int i = 0; i < 2; i++) {
            top = tops[i], level = levels[i];
            watch_set(&w, &system, near_the_top, 1);
            w.f.v0[0] = cos(top);
            w.f.options.h_max = steps[i];
            watch_init(&w, methods[k], k < 2 ? steps[i] : 1e-3);
            CU_ASSERT(pk_events_to(&w.events, &w.f.it, steps[i]) == PK_DONE);
            CU_ASSERT_FATAL(w.count == 2);
            for (int n = 0; n < 2; n++)
                CU_ASSERT(fabs(w.t[n] - top - (n ? 1 : -1) * acos(level)) < 2e-2);
            watch_free(&w);
        }
}

TEST("a force that follows one")
{
    static const struct pk_quantity name[] = {{"exp(80*(x - 1))", "", ""}};
    static struct fixture f;
    struct pk_system system = turning();
    system.marks = (struct pk_part_marks){.n = 1, .names = name, .values = short_hill};
    for (int fine = 0; fine < 2; fine++) {
        top = 0.75;
        fixture_set(&f, &system);
        f.v0[0] = cos(top);
        fixture_start(&f, "rk4", fine ? 0.05 : 2 * top);
        CU_ASSERT(pk_integrator_to(&f.it, 2 * top) == PK_DONE);
        CU_ASSERT((f.it.passed_over.count == 0) == fine);
    }
}

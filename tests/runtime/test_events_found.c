/* Events of functions that turn many times within a step, or hardly cross: the number of crossings
 * and their times against closed forms, by methods of all kinds, forwards and backwards, in tiny
 * and huge units. The motion is q = cos t.
 */
#include <stdlib.h>

#include "event_watch.h"

#include <pk/root.h>

enum kind { SINE, TOPS, PAIR, KINK, PRODUCT, OF_RATE, KINDS };

static struct {
    enum kind kind;
    double w, c, a, d, unit;
} law;

static void lawful(ARGS, pk_real *g)
{
    const double away = (t - law.a) * (t - law.a);
    const double all[] = {sin(law.w * t + law.c),
                          cos(t) - 0.999,
                          away - law.d,
                          fabs(t - law.a) - law.d,
                          sin(law.w * t + law.c) * (t - law.a),
                          v[0] - law.c / 4};
    UNUSED;
    g[0] = law.unit * all[law.kind];
}

static int by_size(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The roots between 0 and T, in order of |t|. */
static int roots(double T, double *t)
{
    const double pi = acos(-1), lo = T < 0 ? T : 0, hi = T < 0 ? 0 : T;
    double found[2000];
    int n = 0, m = 0;
    for (int k = -400; k <= 400; k++) {
        if (law.kind == SINE || law.kind == PRODUCT)
            found[n++] = (pi * k - law.c) / law.w;
        if (law.kind == TOPS)
            found[n++] = 2 * pi * k - acos(0.999), found[n++] = 2 * pi * k + acos(0.999);
        if (law.kind == OF_RATE) /* -sin t = c/4 */
            found[n++] = 2 * pi * k - asin(law.c / 4),
            found[n++] = pi * (2 * k + 1) + asin(law.c / 4);
    }
    if (law.kind == PRODUCT)
        found[n++] = law.a;
    if (law.kind == PAIR)
        found[n++] = law.a - sqrt(law.d), found[n++] = law.a + sqrt(law.d);
    if (law.kind == KINK)
        found[n++] = law.a - law.d, found[n++] = law.a + law.d;
    for (int k = 0; k < n; k++)
        if (found[k] > lo && found[k] < hi)
            t[m++] = fabs(found[k]);
    qsort(t, (size_t)m, sizeof *t, by_size);
    return m;
}

static double chance(void) { return rand() / (RAND_MAX + 1.0); }

TEST("all are found")
{
    static const struct {
        const char *method;
        double h, within; /* of what is a function of the motion */
    } by[] = {{"gauss", 1e-11, 1e-7}, {"dop853", 1e-10, 1e-7}, {"rk4", 0.4, 0.05},
              {"verlet", 0.3, 0.1},   {"radau", 1e-8, 1e-4},   {"gauss4", 2, 1e-2}};
    static const double units[] = {1, 1e-12, 1e12};
    static struct watch w;
    double t[2000];
    int crossings = 0, missed = 0;
    srand(2385);
    for (int k = 0; k < 240; k++) {
        const int m = k % 6, sign = k % 4 == 3 ? -1 : 1;
        law.kind = (enum kind)(k / 6 % KINDS);
        law.unit = units[k / 12 % 3];
        law.w = 0.5 + 24 * chance() * chance();
        law.c = 0.1 + 2.8 * chance();
        law.a = sign * (2 + 14 * chance());
        law.d = pow(10, -2 - 8 * chance()) * (law.kind == PAIR ? law.a * law.a : 1);
        const int count = roots(sign * 18, t);
        watch_cosine(&w, lawful, 1);
        watch_init(&w, by[m].method, by[m].h);
        CU_ASSERT_FATAL(count < 200);
        CU_ASSERT(pk_events_to(&w.events, &w.f.it, sign * 18) == PK_DONE);
        if (law.kind == KINK && w.count == 0 && count) { /* beside the end of a step */
            missed++;
            continue;
        }
        CU_ASSERT_EQUAL(w.count, count);
        if (w.count != count)
            printf("\n    %s kind %d w %g c %g a %g d %g: %d of %d", by[m].method, (int)law.kind,
                   law.w, law.c, law.a, law.d, w.count, count);
        for (int i = 0; i < w.count && i < count; i++) {
            const double near = law.kind == OF_RATE ? by[m].within : 1e-9;
            CU_ASSERT(fabs(fabs(w.t[i]) - t[i]) < near);
            CU_ASSERT(law.kind == PRODUCT || i == 0 || w.direction[i] == -w.direction[i - 1]);
        }
        CU_ASSERT(w.events.doubts == 0);
        crossings += count;
    }
    CU_ASSERT(crossings > 3000 && missed <= 1);
}

/* What turns too often for any number of windows is said to be. */
static void doubt(void *context, const struct pk_events *events)
{
    struct watch *w = (struct watch *)context;
    w->stop_after += events->which == 0;
}
static int nothing(void *context, const struct pk_events *events)
{
    (void)context, (void)events;
    return 0;
}

TEST("what turns too often is told")
{
    static struct watch w;
    law.kind = SINE, law.w = 1e7, law.c = 0.3, law.unit = 1;
    watch_cosine(&w, lawful, 1);
    watch_init(&w, "gauss", 1e-9);
    w.events.doubtful = doubt;
    w.events.found = nothing;
    CU_ASSERT(pk_events_to(&w.events, &w.f.it, 0.5) == PK_DONE);
    CU_ASSERT(w.stop_after > 0 && (unsigned long)w.stop_after == w.events.doubts);
}

/* A jump over zero is one crossing, and no doubt; a touch none, be it smooth or a kink. */
static void jumping(ARGS, pk_real *g)
{
    UNUSED;
    g[0] = t < law.a ? -1 : 2;
    g[1] = fabs(t - law.a);
    g[2] = (t - law.a) * (t - law.a);
}

TEST("jumps and touches")
{
    static const char *const methods[] = {"gauss", "dop853", "rk4"};
    static struct watch w;
    for (int m = 0; m < 3; m++) {
        law.a = 1.2345678;
        watch_cosine(&w, jumping, 3);
        watch_init(&w, methods[m], m < 2 ? 1e-10 : 0.7);
        CU_ASSERT(pk_events_to(&w.events, &w.f.it, 5) == PK_DONE);
        CU_ASSERT_EQUAL(w.count, 1);
        CU_ASSERT(w.which[0] == 0 && fabs(w.t[0] - law.a) < 1e-14);
        CU_ASSERT(w.events.doubts == 0);
    }
}

static enum pk_status less_two(void *context, pk_real x, pk_real *y)
{
    ++*(int *)context;
    *y = x * x - 2;
    return PK_DONE;
}

TEST("a root between adjacent numbers")
{
    pk_real a = 1, b = 2;
    int count = 0;
    CU_ASSERT(pk_root(less_two, &count, &a, -1, &b, 2, 0) == PK_DONE);
    CU_ASSERT(a < sqrt(2) && nextafter(a, 2) == b && count < 60);
}

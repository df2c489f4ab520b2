/* Singularities of a family kept as loops, a number for each member: masses on a line, each
 * neighbours' distance a singularity. A member is not hidden by another one, nor are two that meet
 * at once.
 */
#include "fixture.h"

enum { MOST = 40 };

static size_t masses;
static double strength; /* of V = sum of strength/(x[i+1] - x[i]) */
static int absolute;    /* |x[i+1] - x[i]|, which touches 0 and has no sign to tell */
static unsigned long calls;
static double least;

static size_t count(const void *p)
{
    (void)p;
    return masses;
}

static size_t gaps(const void *p)
{
    (void)p;
    return masses - 1;
}

static int acceleration(ARGS, double *a)
{
    UNUSED;
    memset(a, 0, masses * sizeof *a);
    for (size_t i = 0; i + 1 < masses; i++) {
        const double d = q[i + 1] - q[i], force = strength / (d * d);
        a[i] -= force;
        a[i + 1] += force;
    }
    return 0;
}

static void singularity(ARGS, double *out)
{
    UNUSED;
    calls++;
    for (size_t i = 0; i + 1 < masses; i++) {
        out[i] = q[i + 1] - q[i];
        least = fmin(least, out[i]);
        out[i] = absolute ? fabs(out[i]) : out[i];
    }
}

static void place(const void *p, size_t k, struct pk_place *at)
{
    (void)p;
    *at = (struct pk_place){0, (ptrdiff_t)k + 1, 0};
}

static const struct pk_singularity line_singularity[] = {
    {{"x[i+1] - x[i]", "", ""}, PK_SINGULARITY_DIVISOR}};

struct line {
    struct fixture f;
    double q[MOST], v[MOST], block[20000];
};

/* Ready for init_line(), at rest, a distance of 1 apart. */
static struct pk_system line(struct line *l, size_t n, double g)
{
    struct pk_system system = guarded_point(acceleration, line_singularity, singularity);
    masses = n;
    strength = g;
    absolute = 0;
    calls = 0;
    least = 1;
    system.families.count = count;
    system.linear = NULL;
    system.jacobian = NULL;
    system.singularities.count = gaps;
    system.singularities.place = place;
    fixture_set(&l->f, &oscillator_system);
    for (size_t i = 0; i < n; i++) {
        l->q[i] = (double)i;
        l->v[i] = 0;
    }
    return system;
}

static void init_line(struct line *l, const struct pk_system *system, const char *name, double h)
{
    const struct pk_method *method = pk_method_find(name);
    l->f.problem.system = system;
    l->f.options.h = method->traits & PK_ADAPTIVE ? 0 : h;
    l->f.options.rtol = l->f.options.atol = h;
    CU_ASSERT_FATAL(pk_integrator_size(&l->f.problem, method) <= sizeof l->block);
    CU_ASSERT_FATAL(pk_integrator_init(&l->f.it, &l->f.problem, method, &l->f.options, 0, l->q,
                                       l->v, l->block, sizeof l->block) == PK_DONE);
}

/* From unequal distances one pair meets first, wherever in the line: the same for each method. */
TEST("one pair meets")
{
    static struct line l;
    static const struct {
        const char *name;
        double h, within;
    } by[] = {{"dop853", 1e-9, 1e-9}, {"gauss", 1e-6, 1e-7},    {"rk4", 0.01, 1e-6},
              {"verlet", 0.01, 1e-3}, {"yoshida8", 0.01, 1e-4}, {"euler", 1e-3, 5e-3}};
    char text[200], what[60];
    double reference = 0;
    for (size_t member = 1; member < 20; member += 6)
        for (size_t k = 0; k < sizeof by / sizeof *by; k++) {
            const struct pk_system system = line(&l, 20, -1);
            for (size_t i = member; i < 20; i++)
                l.q[i] -= 0.3;
            init_line(&l, &system, by[k].name, by[k].h);
            CU_ASSERT(pk_integrator_to(&l.f.it, 5) == PK_SINGULAR_TIME);
            CU_ASSERT(l.f.it.reason.index == member - 1 && l.f.it.t < l.f.it.reason.time + 1e-12);
            reference = k ? reference : l.f.it.reason.time;
            /* Two alone meet after pi/4 sqrt(.7^3) = .46; the next ones hold them back. */
            CU_ASSERT(reference > 0.5 && reference < 0.58);
            CU_ASSERT(fabs(l.f.it.reason.time - reference) < by[k].within);
            snprintf(what, sizeof what, "x[%zu] - x[%zu] vanishes at t = 0.5", member + 1, member);
            CU_ASSERT(pk_integrator_reason(&l.f.it, text, sizeof text) > 0);
            CU_ASSERT(strstr(text, what) != NULL);
        }
}

/* Two pairs pass through each other in the same step, and two masses between them are always
 * nearer: neither the least distance nor the product of all signs changes. */
TEST("two behind a nearer one")
{
    static struct line l;
    static const double q[4] = {-1, 0, 0.01, 1.01}, v[4] = {2, 0, 0, -2};
    for (int sign = 0; sign < 2; sign++) {
        const struct pk_system system = line(&l, 4, 0);
        absolute = sign;
        memcpy(l.q, q, sizeof q);
        memcpy(l.v, v, sizeof v);
        init_line(&l, &system, "verlet", 1);
        CU_ASSERT(pk_integrator_to(&l.f.it, 5) == PK_SINGULAR_TIME);
        CU_ASSERT(l.f.it.t == 0 && (l.f.it.reason.index == 0 || l.f.it.reason.index == 2));
        CU_ASSERT(fabs(l.f.it.reason.time - 0.5) < 1e-9);
    }
    struct pk_system unguarded = line(&l, 4, 0);
    unguarded.singularities = (struct pk_part_singularities){.n = 0, .count = NULL};
    memcpy(l.q, q, sizeof q);
    memcpy(l.v, v, sizeof v);
    init_line(&l, &unguarded, "verlet", 1);
    CU_ASSERT(pk_integrator_to(&l.f.it, 5) == PK_DONE && l.f.it.q[0] == 9);
}

/* Hot, and repelling each other: thousands of near passes, none of them an end, and seldom a
 * search, of which each takes hundreds of calls. */
TEST("none meets")
{
    static struct line l;
    static const struct {
        const char *name;
        double h;
    } by[] = {{"verlet", 1e-3}, {"rk4", 1e-3}, {"dop853", 1e-7}};
    for (size_t k = 0; k < sizeof by / sizeof *by; k++) {
        const struct pk_system system = line(&l, MOST, 0.3);
        for (size_t i = 0; i < MOST; i++)
            l.v[i] = i == 0 ? 6 : i == MOST - 1 ? -6 : 3 * sin((double)(7 * i * i + 1));
        init_line(&l, &system, by[k].name, by[k].h);
        CU_ASSERT(pk_integrator_to(&l.f.it, 10) == PK_DONE && l.f.it.t == 10);
        CU_ASSERT(least > 0 && least < 0.05);
        CU_ASSERT(calls > 100 && calls < 3 * l.f.it.count.steps);
    }
}

static int fused;

static void advance(const void *p, int stages, const double *kick, const double *drift, double t,
                    double h, unsigned long steps, double *q, double *v)
{
    (void)p, (void)stages, (void)kick, (void)drift, (void)t;
    fused = 1;
    for (size_t i = 0; i < masses; i++)
        q[i] += h * (double)steps * v[i];
}

/* Fused steps would not see a singularity: they are made where there is none, as of a single mass.
 */
TEST("not fused")
{
    static struct line l;
    for (size_t n = 1; n < 3; n++) {
        struct pk_system system = line(&l, n, 0);
        system.families.advance = advance;
        l.v[0] = 3;
        fused = 0;
        init_line(&l, &system, "verlet", 0.01);
        CU_ASSERT(pk_integrator_steps(&l.f.it, 2, 0) == (n == 1 ? PK_DONE : PK_SINGULAR_TIME));
        CU_ASSERT(fused == (n == 1) && (n == 1 || fabs(l.f.it.reason.time - 1. / 3) < 1e-9));
    }
}

static size_t one(const void *p)
{
    (void)p;
    return 1;
}

static void seven(const void *p, size_t k, struct pk_place *at)
{
    (void)p, (void)k;
    *at = (struct pk_place){0, 7, 11};
}

TEST("names")
{
    static const struct {
        const char *name, *said;
    } texts[] = {{"x[i+1] - x[i]", "x[8] - x[7]"},
                 {"(x[j-2] - y[i])^2", "(x[9] - y[7])^2"},
                 {"r[3] + s[N] + k[2*i] + in[i", "r[3] + s[N] + k[2*i] + in[i"},
                 {"", ""}};
    struct pk_singularity singularities[1] = {{{"", "", ""}, PK_SINGULARITY_DIVISOR}};
    const struct pk_system system = {.singularities.n = 1,
                                     .singularities.table = singularities,
                                     .singularities.count = one,
                                     .singularities.place = seven};
    char text[40], few[4];
    for (size_t k = 0; k < sizeof texts / sizeof *texts; k++) {
        singularities[0].what.name = texts[k].name;
        CU_ASSERT(pk_system_singularity_name(&system, NULL, 0, text, sizeof text) ==
                  (int)strlen(texts[k].said));
        CU_ASSERT(strcmp(text, texts[k].said) == 0);
        for (size_t size = 0; size <= sizeof few; size++) {
            CU_ASSERT(pk_system_singularity_name(&system, NULL, 0, size ? few : NULL, size) ==
                      (int)strlen(texts[k].said));
            CU_ASSERT(!size || (strncmp(few, texts[k].said, size - 1) == 0 && strlen(few) < size));
        }
    }
}

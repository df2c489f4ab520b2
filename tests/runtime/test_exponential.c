/* The exact flow of affine systems against closed forms, in long double: M q'' = push - K q - C
 * q'. */
#include <stdlib.h>

#include "fixture.h"

struct affine {
    size_t n;
    const double *mass, *spring, *damping, *push; /* M of one, or two by two, or 1; NULL: none */
};

#define SELF                                                \
    const struct affine *s = (const struct affine *)params; \
    const size_t n = s->n

static size_t count(const void *params) { return ((const struct affine *)params)->n; }

static void force(ARGS, double *f)
{
    SELF;
    UNUSED;
    for (size_t i = 0; i < n; i++) {
        f[i] = s->push ? s->push[i] : 0;
        for (size_t j = 0; j < n; j++)
            f[i] -= (s->spring ? s->spring[i * n + j] * q[j] : 0) +
                    (s->damping ? s->damping[i * n + j] * v[j] : 0);
    }
}

static int acceleration(ARGS, double *a)
{
    SELF;
    const double *M = s->mass;
    force(params, t, q, v, u, a);
    if (M && n == 2) {
        const double f = a[0], det = M[0] * M[3] - M[1] * M[2];
        a[0] = (M[3] * f - M[1] * a[1]) / det;
        a[1] = (M[0] * a[1] - M[2] * f) / det;
    } else if (M) {
        a[0] /= M[0];
    }
    return 0;
}

static void mass(ARGS, double *M)
{
    SELF;
    UNUSED;
    for (size_t k = 0; k < n * n; k++)
        M[k] = s->mass ? s->mass[k] : k % (n + 1) == 0;
}

static void linear(ARGS, const double *a, double *r_q, double *r_v, double *r_t)
{
    SELF;
    UNUSED;
    (void)a;
    for (size_t k = 0; k < n * n; k++) {
        r_q[k] = s->spring ? -s->spring[k] : 0;
        r_v[k] = s->damping ? -s->damping[k] : 0;
    }
    memset(r_t, 0, n * sizeof *r_t);
}

static const struct pk_system affine_system = {.abi = PK_ABI,
                                               .name = "affine",
                                               .source_hash = "by hand",
                                               .facts = PK_AFFINE | PK_AUTONOMOUS | PK_SMOOTH |
                                                        PK_QUADRATIC | PK_MASS_CONSTANT,
                                               .n = 1,
                                               .params_size = sizeof(struct affine),
                                               .families.count = count,
                                               .acceleration = acceleration,
                                               .mass = mass,
                                               .force = force,
                                               .linear = linear};

/* What a test integrates; by_kernel: with `linear`, which coefficients are then refined by. */
struct motion {
    struct affine of;
    struct pk_system system;
    struct pk_problem problem;
    struct pk_integrator it;
    void *block;
};

static enum pk_status begin(struct motion *m, const char *name, struct affine of, int by_kernel,
                            double h, const double *q, const double *v)
{
    const struct pk_method *method = pk_method_find(name);
    struct pk_options options = pk_options_default();
    options.h = h;
    m->of = of;
    m->system = affine_system;
    if (!by_kernel)
        m->system.linear = NULL;
    m->problem = (struct pk_problem){.system = &m->system, .params = &m->of};
    const size_t size = pk_integrator_size(&m->problem, method);
    m->block = malloc(size);
    CU_ASSERT_PTR_NOT_NULL_FATAL(m->block);
    return pk_integrator_init(&m->it, &m->problem, method, &options, 0, q, v, m->block, size);
}

static void make_steps(struct motion *m, long steps)
{
    long made = 0;
    while (made < steps && pk_integrator_step(&m->it, 1e300) == PK_DONE)
        made++;
    CU_ASSERT_FATAL(made == steps);
}

/* One coordinate from (q, v) in so many steps of h: how far from the closed form, over its size. */
static double missed(struct affine of, double h, long steps, double q, double v, long double exact)
{
    double worst = 0;
    for (int by_kernel = 0; by_kernel < 2; by_kernel++) {
        struct motion m;
        CU_ASSERT_FATAL(begin(&m, "exponential", of, by_kernel, h, &q, &v) == PK_DONE);
        make_steps(&m, steps);
        CU_ASSERT(m.it.count.factorisations == 1);
        worst = fmax(worst, (double)fabsl((m.it.q[0] - exact) / exact));
        free(m.block);
    }
    return worst;
}

enum { LONGEST = 32 };

/* Unit masses between walls, unit springs. From all masses displaced at once, so that every mode is
 * in it: its largest error after so many steps. */
static double chain(const char *method, size_t n, double h, long steps)
{
    static double K[LONGEST * LONGEST], q0[LONGEST], v0[LONGEST];
    const long double pi = acosl(-1.0L), T = (long double)h * (long double)steps;
    struct motion m;
    double worst = 0;
    memset(K, 0, sizeof K);
    for (size_t i = 0; i < n; i++) {
        q0[i] = i % 3 ? 0.25 : -0.5;
        v0[i] = i % 2 ? 0.125 : 0;
        K[i * n + i] = 2;
        if (i + 1 < n)
            K[i * n + i + 1] = K[(i + 1) * n + i] = -1;
    }
    CU_ASSERT_FATAL(begin(&m, method, (struct affine){.n = n, .spring = K}, 0, h, q0, v0) ==
                    PK_DONE);
    make_steps(&m, steps);
    for (size_t i = 0; i < n; i++) {
        long double exact = 0;
        for (size_t k = 1; k <= n; k++) {
            const long double w = 2 * sinl(pi * k / (2 * (n + 1)));
            long double a = 0, b = 0;
            for (size_t j = 0; j < n; j++) {
                a += sinl(pi * k * (j + 1) / (n + 1)) * q0[j];
                b += sinl(pi * k * (j + 1) / (n + 1)) * v0[j];
            }
            exact += (a * cosl(w * T) + b / w * sinl(w * T)) * sinl(pi * k * (i + 1) / (n + 1)) *
                     2 / (n + 1);
        }
        worst = fmax(worst, (double)fabsl(m.it.q[i] - exact));
    }
    free(m.block);
    return worst;
}

TEST("modes of chains")
{
    const struct {
        size_t n;
        double h;
        long steps;
    } rows[] = {{3, 0.1, 1000}, {3, 0.1, 1000000}, {3, 97, 1000}, {32, 0.1, 20000}, {32, 40, 50}};
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        const double error = chain("exponential", rows[k].n, rows[k].h, rows[k].steps);
        printf("\n    %zu masses, %ld steps of %g: error %.1e", rows[k].n, rows[k].steps, rows[k].h,
               error);
        CU_ASSERT(error > 0 && error < 2e-14); /* that of the closed form at t = 1e5, by the way */
    }
    CU_ASSERT(chain("rk4", 3, 0.1, 10000) > 1e-3);
}

/* The modes of M = (2 1; 1 2), K = (2 -1; -1 2) have w^2 = 1/3 and 3, and 1/3 is no number of the
 * machine: M x = r refined leaves no trace of that, accelerations leave its rounding. */
TEST("coefficients")
{
    static const double M[] = {2, 1, 1, 2}, K[] = {2, -1, -1, 2}, q0[] = {0.5, 0.5}, v0[] = {0, 0};
    const struct affine of = {.n = 2, .mass = M, .spring = K};
    double error[2];
    for (int by_kernel = 0; by_kernel < 2; by_kernel++) {
        struct motion m;
        CU_ASSERT_FATAL(begin(&m, "exponential", of, by_kernel, 1024, q0, v0) == PK_DONE);
        make_steps(&m, 10000);
        const long double exact = 0.5L * cosl(sqrtl(1 / 3.0L) * 1024 * 10000);
        error[by_kernel] = (double)fabsl(m.it.q[0] - exact);
        free(m.block);
    }
    printf("\n    t = 1e7 by accelerations %.1e, by M and `linear` %.1e", error[0], error[1]);
    CU_ASSERT(error[1] < 2e-12); /* of sqrtl() */
    CU_ASSERT(error[0] > 20 * error[1] && error[0] < 1e-8);
}

/* (q'' + c q' + k q = f) with real rates; they come from the larger one, without cancellation. */
static long double decays(long double c, long double k, long double t)
{
    const long double fast = -(c + sqrtl(c * c - 4 * k)) / 2, slow = k / fast;
    return (fast * expl(slow * t) - slow * expl(fast * t)) / (fast - slow); /* from (1, 0) */
}

TEST("one coordinate")
{
    const double one = 1, down = -9.81, k = 4, c = 1, stiff = 1e6, saddle = -1, third = 3;
    const struct affine falls = {.n = 1, .push = &down}, drags = {1, NULL, NULL, &one, &down};
    const struct affine damped = {1, NULL, &k, &c, NULL}, slow = {1, NULL, &one, &stiff, NULL};
    const struct affine grows = {1, NULL, &saddle, NULL, NULL}, heavy = {1, &third, &k, NULL, NULL};
    const long double w = sqrtl(3.75L), d = -9.81;
    double worst = 0;
#define CASE(of, h, steps, q, v, exact, bound)                         \
    do {                                                               \
        const double e = missed(of, h, steps, q, v, exact);            \
        worst = fmax(worst, e);                                        \
        printf("\n    %-40s %.1e", #of " " #steps " steps of " #h, e); \
        CU_ASSERT(e < (bound));                                        \
    } while (0)
    /* A and B are 0, and L is no more than nilpotent. */
    CASE(falls, 1000, 1000, 1, 2, 1 + 2e6L + (long double)down * 1e12L / 2, 3e-16);
    CASE(drags, 0.25, 40, 1, 2, 1 + d * 10 + (2 - d) * (1 - expl(-10.0L)), 3e-16);
    CASE(drags, 1000, 3, 1, 2, 1 + d * 3000 + (2 - d), 3e-16);
    CASE(damped, 0.5, 20, 1, 0, expl(-5.0L) * (cosl(w * 10) + sinl(w * 10) / (2 * w)), 1e-15);
    CASE(slow, 1000, 1000, 1, 0, decays(1e6L, 1, 1e6L), 1e-15);
    CASE(slow, 1e-6, 5, 1, 0, decays(1e6L, 1, 5 * (long double)1e-6), 1e-15);
    CASE(grows, 0.5, 40, 1, 0, coshl(20), 1e-15);
    CASE(grows, 20, 1, 0, 1, sinhl(20), 1e-15);
    CASE(heavy, 0.5, 40, 1, 0, cosl(sqrtl(4 / 3.0L) * 20), 3e-15);
#undef CASE
    CU_ASSERT(worst > 0);
}

/* q'' = 2 w J q': a circle, by the rates alone. And c beside coefficients 1e12 smaller. */
TEST("gyroscopic, and a large force")
{
    static const double C[] = {0, -2, 2, 0}, push[] = {1e12 / 3, 0}, q0[] = {0, 0}, v0[] = {1, 0};
    static const double other[] = {0, -0.7, 0.7, 0}; /* no multiples of what `push` is rounded to */
    const struct affine turns = {.n = 2, .damping = C};
    const struct affine drifts = {.n = 2, .damping = other, .push = push};
    for (int by_kernel = 0; by_kernel < 2; by_kernel++) {
        struct motion m;
        CU_ASSERT_FATAL(begin(&m, "exponential", turns, by_kernel, 0.5, q0, v0) == PK_DONE);
        make_steps(&m, 100000);
        CU_ASSERT(fabsl(m.it.q[0] - sinl(1e5L) / 2) < 3e-16 && m.it.q[0] != 0);
        CU_ASSERT(fabsl(m.it.v[1] + sinl(1e5L)) < 3e-16);
        free(m.block);
        /* v = F/w (sin wt, cos wt - 1), but for the start */
        CU_ASSERT_FATAL(begin(&m, "exponential", drifts, by_kernel, 0.5, q0, v0) == PK_DONE);
        make_steps(&m, 20);
        const long double w = other[2], exact = push[0] / w * sinl(10 * w) + cosl(10 * w);
        CU_ASSERT(fabsl(m.it.v[0] / exact - 1) < 1e-15);
        free(m.block);
    }
}

/* Shorter last steps: two matrices, made once each. Dense output: the same flow. */
TEST("other steps, dense output")
{
    static struct fixture f;
    fixture_open(&f, &oscillator_system, "exponential", 0.125);
    for (int k = 1; k <= 20; k++)
        CU_ASSERT(pk_integrator_to(&f.it, k * 1.0625) == PK_DONE);
    CU_ASSERT(f.it.count.factorisations == 2 && f.it.count.steps == 180);
    CU_ASSERT(fabs(f.it.q[0] - (0.7 * cos(21.25) + 0.2 * sin(21.25))) < 1e-15);
    CU_ASSERT(pk_integrator_to(&f.it, 0) == PK_DONE);
    CU_ASSERT(fixture_distance(&f, f.q0, f.v0) < 1e-16);
    fixture_set(&f, &oscillator_system);
    f.params.g = 64; /* so that there is something to balance */
    fixture_start(&f, "exponential", 50);
    CU_ASSERT(pk_integrator_step(&f.it, 100) == PK_DONE && f.it.t == 50);
    for (double t = 0; t <= 50; t += 3.125) {
        double q, v;
        CU_ASSERT(pk_integrator_dense(&f.it, t, &q, &v) == PK_DONE);
        CU_ASSERT(fabs(q - (0.7 * cos(8 * t) + 0.025 * sin(8 * t))) < 4e-16);
        CU_ASSERT(fabs(v - (0.2 * cos(8 * t) - 5.6 * sin(8 * t))) < 2e-15);
    }
}

static int found(void *context, const struct pk_events *events)
{
    double *worst = (double *)context;
    const double exact = ((double)events->count - 0.5) * acos(-1);
    *worst = fmax(*worst, fabs(events->t - exact) / exact);
    return 0;
}

static void zero(ARGS, double *g)
{
    UNUSED;
    (void)params;
    g[0] = q[0];
}

/* Crossings of cos t to the last digits; where a step could hide one it is refused. */
TEST("events")
{
    static const struct pk_event event[] = {{{"zero", "", ""}, 0, 0}};
    static struct fixture f;
    static double block[4096];
    struct pk_system system = oscillator_system;
    struct pk_events watched;
    double worst = 0;
    system.events = (struct pk_part_events){.n = 1, .table = event, .values = zero};
    fixture_set(&f, &system);
    f.q0[0] = 1, f.v0[0] = 0;
    fixture_start(&f, "exponential", 3);
    CU_ASSERT_FATAL(pk_events_init(&watched, &f.it, block, sizeof block) == PK_DONE);
    watched.found = found;
    watched.context = &worst;
    CU_ASSERT(pk_events_to(&watched, &f.it, 1000) == PK_DONE);
    printf("\n    %lu crossings, error %.1e", watched.count, worst);
    CU_ASSERT(watched.count == 318 && worst > 0 && worst < 3e-15); /* an ulp of the step's end */
    CU_ASSERT(f.it.count.factorisations <= 3);
    pk_integrator_set_step(&f.it, 3.2);
    CU_ASSERT(pk_events_to(&watched, &f.it, 1010) == PK_REFUSED);
    CU_ASSERT(says(&f.it, "crossings of events could be missed in steps of 3.2"));
}

TEST("refused")
{
    static const double q0[257], v0[257];
    static struct fixture f;
    CU_ASSERT(fixture_run(&f, &pendulum_system, "exponential", 0.1, 1) == PK_REFUSED);
    CU_ASSERT(says(&f.it, "is linear: its acceleration affine in q and v"));
    struct motion m;
    CU_ASSERT(begin(&m, "exponential", (struct affine){.n = 257}, 0, 1, q0, v0) == PK_REFUSED);
    CU_ASSERT(says(&m.it, "at most 256 coordinates"));
    free(m.block);
    /* What grows to no number. */
    const double up = -1e6, start = 1;
    CU_ASSERT_FATAL(begin(&m, "exponential", (struct affine){.n = 1, .spring = &up}, 1, 10, &start,
                          v0) == PK_DONE);
    CU_ASSERT(pk_integrator_step(&m.it, 10) == PK_NOT_FINITE && m.it.t == 0 && m.it.q[0] == 1);
    free(m.block);
}

/* Splitting where forces have C v: by a constant C, and boris by C(q, t). M a = g(q, t) + C v of two
 * coordinates with random M and C; what is true against dop853. A drift that is exact makes a free
 * motion exact; orders hold; what is symmetric leads back; boris keeps |v| in a magnetic field.
 */
#include <stdlib.h>

#include "fixture.h"

struct pushed {
    double M[4], C[4], field, force; /* C is (1 + field cos(x + t)) of that */
};

#define SELF const struct pushed *s = (const struct pushed *)params

static void force(ARGS, double *f)
{
    SELF;
    (void)u;
    const double of = 1 + s->field * cos(q[0] + t);
    f[0] = of * (s->C[0] * v[0] + s->C[1] * v[1]) - s->force * sin(q[0] - q[1] / 2);
    f[1] = of * (s->C[2] * v[0] + s->C[3] * v[1]) - s->force * (q[1] - cos(2 * t) * sin(q[0]));
}

static int acceleration(ARGS, double *a)
{
    SELF;
    const double *M = s->M, det = M[0] * M[3] - M[1] * M[2];
    force(params, t, q, v, u, a);
    const double f = a[0];
    a[0] = (M[3] * f - M[1] * a[1]) / det;
    a[1] = (M[0] * a[1] - M[2] * f) / det;
    return 0;
}

static void mass(ARGS, double *M)
{
    SELF;
    (void)t, (void)q, (void)v, (void)u;
    memcpy(M, s->M, sizeof s->M);
}

static void linear(ARGS, const double *a, double *r_q, double *r_v, double *r_t)
{
    SELF;
    (void)v, (void)u, (void)a;
    for (int k = 0; k < 4; k++) {
        r_q[k] = NAN; /* nobody asks */
        r_v[k] = (1 + s->field * cos(q[0] + t)) * s->C[k];
    }
    r_t[0] = r_t[1] = NAN;
}

static struct pk_system pushed_system_of(const struct pushed *s)
{
    return (struct pk_system){.abi = PK_ABI,
                              .name = "pushed",
                              .facts = PK_MASS_CONSTANT | PK_QUADRATIC | PK_SMOOTH |
                                       (s->field > 0 ? PK_AFFINE_RATES : PK_LINEAR_DRAG),
                              .n = 2,
                              .acceleration = acceleration,
                              .mass = mass,
                              .linear = linear};
}

static double between(double lo, double hi) { return lo + (hi - lo) * rand() / RAND_MAX; }

/* `drag`: how strong, beside what turns. */
static struct pushed random_one(double drag, double field, double push)
{
    const double m = between(-.4, .4), c = between(-drag, drag) / 2, turn = between(.5, 2);
    return (struct pushed){{between(.6, 2), m, m, between(.6, 2)},
                           {-drag, c + turn, c - turn, -drag * between(.6, 2)},
                           field,
                           push};
}

/* In `steps` steps, or by a tolerance where they are 0; and back again. */
static enum pk_status run(const struct pushed *s, const char *name, int steps, double t_end,
                          int back, double *z)
{
    static double block[1 << 13];
    const struct pk_system system = pushed_system_of(s);
    const struct pk_problem problem = {.system = &system, .params = s};
    const double q[] = {.4, -.7}, v[] = {.9, .3};
    struct pk_options options = pk_options_default();
    struct pk_integrator it;
    options.h = steps ? t_end / steps : 0;
    options.rtol = options.atol = 1e-14;
    if (pk_integrator_init(&it, &problem, pk_method_find(name), &options, 0, q, v, block,
                           sizeof block) < 0)
        return it.status;
    enum pk_status status = pk_integrator_to(&it, t_end);
    if (status >= 0 && back)
        status = pk_integrator_to(&it, 0);
    memcpy(z, it.q, 2 * sizeof *z);
    memcpy(z + 2, it.v, 2 * sizeof *z);
    return status;
}

static double apart(const double *a, const double *b)
{
    double most = 0;
    for (int i = 0; i < 4; i++)
        most = fmax(most, fabs(a[i] - b[i]));
    return most;
}

static int applies(const struct pk_method *m, const struct pushed *s)
{
    const unsigned one = s->field > 0 ? PK_AFFINE_RATES : PK_LINEAR_DRAG | PK_AFFINE_RATES;
    return (m->needs & one) != 0;
}

TEST("a free motion is exact")
{
    srand(2385);
    double exact[4], z[4];
    for (int trial = 0; trial < 6; trial++) {
        const struct pushed s = random_one(trial < 3 ? 0 : 3e-4 * pow(30, trial - 2), 0, 0);
        int found = 0;
        CU_ASSERT(run(&s, "dop853", 0, 3, 0, exact) == PK_DONE);
        for (size_t i = 0; pk_method_at(i); i++) {
            const struct pk_method *m = pk_method_at(i);
            if (!(m->needs & PK_LINEAR_DRAG) || m->traits & PK_NOISE)
                continue;
            CU_ASSERT(run(&s, m->name, 3, 3, 0, z) == PK_DONE);
            CU_ASSERT(apart(z, exact) < (trial < 5 ? 1e-12 : 1e-9)); /* yoshida8 goes far back */
            found++;
        }
        CU_ASSERT(found == 11);
        CU_ASSERT(run(&s, "boris", 3, 3, 0, z) == PK_DONE && apart(z, exact) > 1e-4);
    }
}

TEST("orders")
{
    srand(2385);
    for (int trial = 0; trial < 4; trial++) {
        const struct pushed s = random_one(trial % 2 ? 0 : .4, trial < 2 ? 0 : .5, 1);
        double exact[4], z[4];
        int found = 0;
        CU_ASSERT(run(&s, "dop853", 0, 2, 0, exact) == PK_DONE);
        for (size_t i = 0; pk_method_at(i); i++) {
            const struct pk_method *m = pk_method_at(i);
            double h[40], error[40];
            int count = 0;
            if (!applies(m, &s)) {
                if (m->needs & PK_LINEAR_DRAG)
                    CU_ASSERT(run(&s, m->name, 9, 2, 0, z) == PK_REFUSED);
                continue;
            }
            for (double steps = 4; count < 40 && steps < 10000; steps = ceil(1.25 * steps)) {
                if (run(&s, m->name, (int)steps, 2, 0, z) < 0)
                    continue;
                const double e = apart(z, exact);
                if (e < 3e-12)
                    break;
                h[count] = 2 / steps;
                error[count++] = e;
            }
            CU_ASSERT_FATAL(count >= 4);
            const double p = fit_slope(h + count - 4, error + count - 4, 4);
            printf("\n    %-16s order %d, measured %.3f", m->name, m->order, p);
            CU_ASSERT(fabs(p - m->order) < (m->order > 6 ? 1.2 : .3));
            found++;
        }
        CU_ASSERT(found == (trial < 2 ? 16 : 3));
    }
}

TEST("there and back")
{
    srand(2385);
    const double start[] = {.4, -.7, .9, .3};
    double z[4];
    for (int trial = 0; trial < 2; trial++) {
        const struct pushed s = random_one(.1, trial ? .4 : 0, 1);
        for (size_t i = 0; pk_method_at(i); i++) {
            const struct pk_method *m = pk_method_at(i);
            if (!applies(m, &s) || !(m->traits & PK_SYMMETRIC))
                continue;
            CU_ASSERT(run(&s, m->name, 40, 2, 1, z) == PK_DONE && apart(z, start) < 1e-13);
        }
        CU_ASSERT(run(&s, "rk4", 10, 2, 1, z) == PK_DONE && apart(z, start) > 1e-7);
    }
}

/* T is kept where nothing but a field acts, by steps of any length. */
TEST("a field turns")
{
    srand(2385);
    struct pushed s = random_one(0, .9, 0);
    double z[4];
    for (int k = 0; k < 3; k++) {
        const char *name = k == 0 ? "boris" : k == 1 ? "boris6" : "rk4";
        CU_ASSERT(run(&s, name, 2000, 1000, 0, z) == PK_DONE);
        const double *M = s.M, of[] = {.9, .3};
#define T(v) (M[0] * v[0] * v[0] + 2 * M[1] * v[0] * v[1] + M[3] * v[1] * v[1])
        const double off = fabs(T((z + 2)) / T(of) - 1);
        CU_ASSERT(k == 2 ? off > 1e-3 : off < 1e-13);
    }
}

/* A drag that no explicit method takes at this step; and none at all, by a parameter. */
TEST("strong, and none")
{
    struct pushed s = {{1, 0, 0, 1}, {-1e6, 0, 0, -1e6}, 0, 1};
    double z[4], other[4];
    /* its place is right, and its rate is of the last kick */
    CU_ASSERT(run(&s, "verlet", 40, 2, 0, z) == PK_DONE && fabs(z[0] - .4) < 1e-5);
    CU_ASSERT(run(&s, "rk4", 40, 2, 0, other) != PK_DONE || !(fabs(other[0]) < 1));
    s.C[0] = s.C[3] = 0;
    struct pushed plain = s;
    CU_ASSERT(run(&plain, "verlet", 40, 2, 0, z) == PK_DONE);
    CU_ASSERT(run(&s, "dop853", 0, 2, 0, other) == PK_DONE);
    CU_ASSERT(apart(z, other) < 1e-2 && apart(z, other) > 1e-6);
}

/* The derivatives of the acceleration against differences of the acceleration itself. The kernel
 * `linear` of these hand-written systems is made of differences of force and mass, so what is
 * tested is the solving; the generated kernel has tests of its own.
 */
#include "fixture.h"

static struct fixture f;

enum { N = 2, NN = N * N };
static const struct pk_system *of; /* whose force and mass are differenced */
static const double H = 1e-3;
static const double weight[4] = {1. / 12, -2. / 3, 2. / 3, -1. / 12};
static const double at[4] = {-2, -1, 1, 2};

static void remainder_of_motion(ARGS, const double *a, double *r)
{
    double M[NN];
    of->force(params, t, q, v, u, r);
    of->mass(params, t, q, v, u, M);
    for (size_t i = 0; i < of->n; i++)
        for (size_t j = 0; j < of->n; j++)
            r[i] -= M[i * of->n + j] * a[j];
}

static void linear(ARGS, const double *a, double *r_q, double *r_v, double *r_t)
{
    const size_t n = of->n;
    memset(r_q, 0, n * n * sizeof *r_q);
    memset(r_v, 0, n * n * sizeof *r_v);
    memset(r_t, 0, n * sizeof *r_t);
    for (size_t k = 0; k < 4; k++) {
        const double w = weight[k] / H, d = at[k] * H;
        double r[N];
        remainder_of_motion(params, t + d, q, v, u, a, r);
        for (size_t i = 0; i < n; i++)
            r_t[i] += w * r[i];
        for (size_t j = 0; j < n; j++) {
            double q1[N], v1[N];
            memcpy(q1, q, n * sizeof *q);
            memcpy(v1, v, n * sizeof *v);
            q1[j] += d;
            remainder_of_motion(params, t, q1, v, u, a, r);
            for (size_t i = 0; i < n; i++)
                r_q[i * n + j] += w * r[i];
            v1[j] += d;
            remainder_of_motion(params, t, q, v1, u, a, r);
            for (size_t i = 0; i < n; i++)
                r_v[i * n + j] += w * r[i];
        }
    }
}

/* How far a row or column of derivatives is from differences of the acceleration. */
static double missed(double t, size_t by, size_t j, const double *given, size_t stride,
                     double *size)
{
    const size_t n = of->n;
    double sum[N] = {0}, d = 0;
    for (size_t k = 0; k < 4; k++) {
        double q[N], v[N], a[N];
        memcpy(q, f.q0, n * sizeof *q);
        memcpy(v, f.v0, n * sizeof *v);
        (by == 0 ? q : v)[j] += by < 2 ? at[k] * H : 0;
        CU_ASSERT(!of->acceleration(&f.params, t + (by == 2 ? at[k] * H : 0), q, v, NULL, a));
        for (size_t i = 0; i < n; i++)
            sum[i] += weight[k] / H * a[i];
    }
    for (size_t i = 0; i < n; i++) {
        d = fmax(d, fabs(sum[i] - given[i * stride]));
        *size = fmax(*size, fabs(sum[i]));
    }
    return d;
}

TEST("derivatives of the acceleration")
{
    const struct pk_system *const systems[] = {&double_pendulum_system, &forced_system};
    for (int s = 0; s < 2; s++) {
        struct pk_system system = *systems[s];
        const size_t n = system.n;
        double a[N], a_q[NN], a_v[NN], a_t[N], work[NN + N], size[3] = {0}, worst = 0;
        const double t = 0.385;
        of = systems[s];
        fixture_set(&f, &system);
        f.q0[n - 1] = 0.7;
        f.v0[0] = 1.3;
        CU_ASSERT(pk_system_linear_size(&f.problem) <= sizeof work / sizeof *work);
        system.linear = NULL;
        CU_ASSERT(pk_system_linear(&f.problem, t, f.q0, f.v0, a, a_q, a_v, a_t, work) ==
                  PK_REFUSED);
        system.linear = linear;
        CU_ASSERT(pk_system_linear(&f.problem, t, f.q0, f.v0, a, a_q, a_v, a_t, work) == PK_DONE);
        for (size_t j = 0; j < n; j++) {
            worst = fmax(worst, missed(t, 0, j, a_q + j, n, &size[0]));
            worst = fmax(worst, missed(t, 1, j, a_v + j, n, &size[1]));
        }
        worst = fmax(worst, missed(t, 2, 0, a_t, 1, &size[2]));
        CU_ASSERT(worst < 1e-8);
        CU_ASSERT(size[0] > 0.05 && size[1] > 0.1 && (s == 0 || size[2] > 0.1));
    }
}

/* Where M is singular there is no derivative; nor where the state is no number. */
TEST("refused where there are none")
{
    struct pk_system system = folded_system;
    double a, a_q, a_v, a_t, work[2];
    of = &folded_system;
    system.linear = linear;
    fixture_set(&f, &system);
    f.q0[0] = f.params.limit;
    CU_ASSERT(pk_system_linear(&f.problem, 0, f.q0, f.v0, &a, &a_q, &a_v, &a_t, work) ==
              PK_SINGULAR_MASS);
    system = broken_system;
    of = &broken_system;
    system.linear = linear;
    fixture_set(&f, &system);
    CU_ASSERT(pk_system_linear(&f.problem, 2 * f.params.limit, f.q0, f.v0, &a, &a_q, &a_v, &a_t,
                               work) == PK_NOT_FINITE);
}

/* Displacements without units; see metric.h. C, with M = C C^T, is L sqrt(D) from M = L D L^T. */
#include <string.h>

#include "metric.h"

size_t pk_metric_reals(size_t n) { return n * n; }

static pk_real root(const struct pk_metric *m, size_t i) { return PK_F(sqrt)(m->L[i * m->n + i]); }

/* These functions compute x = C^T x, C x, C^-T x, C^-1 x in place: each loop only reads numbers
 * that it has not overwritten. */
static void times_Ct(const struct pk_metric *m, pk_real *x)
{
    for (size_t i = 0; i < m->n; i++) {
        for (size_t j = i + 1; j < m->n; j++)
            x[i] += m->L[j * m->n + i] * x[j];
        x[i] *= root(m, i);
    }
}

static void times_C(const struct pk_metric *m, pk_real *x)
{
    for (size_t i = m->n; i-- > 0;) {
        x[i] *= root(m, i);
        for (size_t j = 0; j < i; j++)
            x[i] += m->L[i * m->n + j] * root(m, j) * x[j];
    }
}

static void divide_Ct(const struct pk_metric *m, pk_real *x)
{
    for (size_t i = m->n; i-- > 0;) {
        x[i] /= root(m, i);
        for (size_t j = i + 1; j < m->n; j++)
            x[i] -= m->L[j * m->n + i] * x[j];
    }
}

static void divide_C(const struct pk_metric *m, pk_real *x)
{
    for (size_t i = 0; i < m->n; i++)
        for (size_t j = 0; j < i; j++)
            x[i] -= m->L[i * m->n + j] * x[j];
    for (size_t i = 0; i < m->n; i++)
        x[i] /= root(m, i);
}

static void scale(pk_real *x, size_t n, pk_real factor)
{
    for (size_t i = 0; i < n; i++)
        x[i] *= factor;
}

void pk_metric_dq(const struct pk_metric *m, pk_real *x)
{
    divide_Ct(m, x);
    scale(x, m->n, PK_F(sqrt)(m->tau));
}

void pk_metric_dp(const struct pk_metric *m, pk_real *x)
{
    times_C(m, x);
    scale(x, m->n, 1 / PK_F(sqrt)(m->tau));
}

void pk_metric_Q(const struct pk_metric *m, pk_real *x)
{
    times_Ct(m, x);
    scale(x, m->n, 1 / PK_F(sqrt)(m->tau));
}

void pk_metric_P(const struct pk_metric *m, pk_real *x)
{
    divide_C(m, x);
    scale(x, m->n, PK_F(sqrt)(m->tau));
}

/* Returns |C^T x|^2, where x has `n` numbers in memory and further components that are 0. */
static pk_real square(const struct pk_metric *m, const pk_real *x, size_t n)
{
    pk_real sum = 0;
    for (size_t i = 0; i < n; i++) {
        pk_real y = x[i];
        for (size_t j = i + 1; j < n; j++)
            y += m->L[j * m->n + i] * x[j];
        sum += m->L[i * m->n + i] * y * y;
    }
    return sum;
}

pk_real pk_metric_length(const struct pk_metric *m, const pk_real *dq, const pk_real *dv)
{
    return PK_F(sqrt)(square(m, dq, m->seen) / (m->tau * m->tau) + square(m, dv, m->n));
}

/* Returns the Frobenius norm of C^-1 A C^-T; overwrites A. A row of A C^-T solves C x = (row of
 * A). */
static pk_real frobenius(const struct pk_metric *m, pk_real *A)
{
    const size_t n = m->n;
    pk_real sum = 0;
    for (size_t i = 0; i < n; i++)
        divide_C(m, A + i * n);
    for (size_t i = 0; i < n; i++) /* transposes A in place */
        for (size_t j = 0; j < i; j++) {
            const pk_real x = A[i * n + j];
            A[i * n + j] = A[j * n + i];
            A[j * n + i] = x;
        }
    for (size_t i = 0; i < n; i++)
        divide_C(m, A + i * n);
    for (size_t i = 0; i < n * n; i++)
        sum += A[i] * A[i];
    return PK_F(sqrt)(sum);
}

enum pk_status pk_metric_init(struct pk_metric *metric, const struct pk_variation *variation,
                              pk_real t, const pk_real *q, const pk_real *v, const pk_real *u,
                              pk_real otherwise, pk_real *memory)
{
    const struct pk_problem *of = &variation->of;
    const size_t n = variation->n, nn = n * n;
    pk_real *r_q = variation->work, *r_v = r_q + nn, *a = r_v + nn, *r_t = a + n;
    metric->n = n;
    metric->seen = variation->n_q;
    metric->L = memory;
    metric->tau = otherwise;
    of->system->mass(of->params, t, q, v, u, metric->L);
    if (pk_ldl_factor(metric->L, n))
        return PK_SINGULAR_MASS;
    if (of->system->acceleration(of->params, t, q, v, u, a))
        return PK_SINGULAR_MASS;
    of->system->linear(of->params, t, q, v, u, a, r_q, r_v, r_t);
    const pk_real square = frobenius(metric, r_q);
    if (!pk_finite(square))
        return PK_NOT_FINITE;
    if (square > 0)
        metric->tau = 1 / PK_F(sqrt)(square);
    return PK_DONE;
}

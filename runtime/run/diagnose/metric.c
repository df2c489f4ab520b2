/* Displacements without units; see motion.h. C, with M = C C^T, is L sqrt(D) from M = L D L^T. */
#include "../../src/core/internal.h"
#include "motion.h"

static pk_real root(const struct metric *m, size_t i) { return PK_F(sqrt)(m->L[i * m->n + i]); }

static void scale(const struct metric *m, pk_real *x, pk_real factor)
{
    for (size_t i = 0; i < m->n; i++)
        x[i] *= factor;
}

/* These functions multiply by C^T, C, C^-T, C^-1 in place; loops read only what is not
 * overwritten. */
void metric_Q(const struct metric *m, pk_real *x)
{
    for (size_t i = 0; i < m->n; i++) {
        for (size_t j = i + 1; j < m->n; j++)
            x[i] += m->L[j * m->n + i] * x[j];
        x[i] *= root(m, i);
    }
    scale(m, x, 1 / PK_F(sqrt)(m->tau));
}

void metric_dp(const struct metric *m, pk_real *x)
{
    for (size_t i = m->n; i-- > 0;) {
        x[i] *= root(m, i);
        for (size_t j = 0; j < i; j++)
            x[i] += m->L[i * m->n + j] * root(m, j) * x[j];
    }
    scale(m, x, 1 / PK_F(sqrt)(m->tau));
}

void metric_dq(const struct metric *m, pk_real *x)
{
    for (size_t i = m->n; i-- > 0;) {
        x[i] /= root(m, i);
        for (size_t j = i + 1; j < m->n; j++)
            x[i] -= m->L[j * m->n + i] * x[j];
    }
    scale(m, x, PK_F(sqrt)(m->tau));
}

void metric_P(const struct metric *m, pk_real *x)
{
    for (size_t i = 0; i < m->n; i++)
        for (size_t j = 0; j < i; j++)
            x[i] -= m->L[i * m->n + j] * x[j];
    for (size_t i = 0; i < m->n; i++)
        x[i] /= root(m, i);
    scale(m, x, PK_F(sqrt)(m->tau));
}

/* Returns |C^T x|^2, where x has `n` numbers in memory and further components that are 0. */
static pk_real square(const struct metric *m, const pk_real *x, size_t n)
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

pk_real metric_length(const struct metric *m, const pk_real *dq, const pk_real *dv)
{
    return PK_F(sqrt)(square(m, dq, m->seen) / (m->tau * m->tau) + square(m, dv, m->n));
}

/* Returns the Frobenius norm of C^-1 A C^-T at tau = 1; overwrites A. A row of A C^-T is C^-1 of
 * A's. */
static pk_real frobenius(const struct metric *m, pk_real *A)
{
    const size_t n = m->n;
    pk_real sum = 0;
    for (int side = 0; side < 2; side++) {
        for (size_t i = 0; i < n; i++)
            metric_P(m, A + i * n);
        for (size_t i = 0; i < n; i++) /* transposes A in place */
            for (size_t j = 0; j < i; j++) {
                const pk_real x = A[i * n + j];
                A[i * n + j] = A[j * n + i];
                A[j * n + i] = x;
            }
    }
    for (size_t i = 0; i < n * n; i++)
        sum += A[i % n * n + i / n] * A[i % n * n + i / n];
    return PK_F(sqrt)(sum);
}

enum pk_status metric_init(struct metric *m, const struct variation *w, pk_real t, const pk_real *q,
                           const pk_real *v, pk_real otherwise)
{
    const struct pk_system *system = w->of.system;
    const void *params = w->of.params;
    const size_t n = w->n, nn = n * n;
    const pk_real *u = variation_inputs(w, t);
    pk_real *r_q = w->work, *r_v = r_q + nn, *r_t = r_v + nn;
    if (!m->L)
        m->L = memory_take(w->motion.memory, nn, sizeof *m->L);
    m->n = n;
    m->seen = w->n_q;
    m->tau = 1;
    system->mass(params, t, q, v, u, m->L);
    if (pk_ldl_factor(m->L, n) || system->acceleration(params, t, q, v, u, w->a))
        return PK_SINGULAR_MASS;
    system->linear(params, t, q, v, u, w->a, r_q, r_v, r_t);
    const pk_real norm = frobenius(m, r_q);
    if (!pk_finite(norm))
        return PK_NOT_FINITE;
    m->tau = norm > 0 ? 1 / PK_F(sqrt)(norm) : otherwise;
    return PK_DONE;
}

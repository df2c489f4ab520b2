/* The adjoint of a step of an implicit Runge-Kutta method (src/implicit/gauss.c). With A for h a,
 *
 *     Q_i = q + sum_j A_ij V_j,   p(Q_i, V_i) = p + sum_j A^_ij pdot_j,
 *
 * and (q1, p1) in row i = s. The multipliers mu_i of the second equation solve the transpose of
 * Newton's equations, with mu_s = lambda_p:
 *
 *     eta_j = sum_k A^_kj mu_k,   xi_j = pdot_q^T eta_j - p_q^T mu_j,
 *     p_v^T mu_i = pdot_v^T eta_i + sum_j A_ji xi_j + A_si lambda_q.
 *
 * Then lambda_q += sum xi_j, lambda_p += sum mu_j. The adaptive Gauss method has v in place of p.
 * Reference: J. M. Sanz-Serna, SIAM Rev. 58 (2016) 3. */
#include "../../src/core/internal.h"
#include "../settings/settings.h"
#include "adjoint.h"

/* most unknowns of a step; a variational equation of each parameter is cheaper above */
enum { MOST = 400 };

struct adjoint_stages {
    size_t s, wide;                    /* wide: columns of `slopes` */
    const struct pk_jacobian *momenta; /* NULL: the method has v in place of p */
    struct pk_stages of;
    pk_real *slopes; /* p and pdot by (q, v, t, u, p) of each stage, and of an end */
    pk_real *matrix, *pivot, *mu, *eta, *y, *a;
};

void adjoint_implicit_make(struct adjoint *x)
{
    const struct pk_method *method = x->run->settings.method;
    const size_t n = x->n, s = method->last ? (size_t)method->stages : 0, m = s * n;
    if (!s || (method->equations && m > MOST))
        return;
    struct adjoint_stages *w = memory_take(&x->run->memory, 1, sizeof *w);
    w->s = s;
    w->wide = 2 * n + 1 + x->m;
    w->momenta = method->equations ? run_jacobian_named(x->system, "canonical_d") : NULL;
    const struct pk_slot slots[] = {{&w->of.c, s},
                                    {&w->of.A, (s + 1) * s},
                                    {&w->slopes, (s + 1) * 2 * n * w->wide},
                                    {&w->of.Q, m},
                                    {&w->of.V, m},
                                    {&w->of.A_p, (s + 1) * s},
                                    {&w->mu, m + n},
                                    {&w->matrix, w->momenta ? m * m : 2 * m * (n + 1)},
                                    {&w->pivot, m},
                                    {&w->eta, m},
                                    {&w->y, 2 * n},
                                    {&w->a, 2 * n}};
    PK_LAY_OUT(memory_take(&x->run->memory, PK_LAY_OUT(NULL, slots), sizeof *w->a), slots);
    x->stages = w;
}

/* Evaluates the derivatives of p and pdot at (q, v). */
static void find_slopes(struct adjoint *x, pk_real t, const pk_real *q, const pk_real *v,
                        pk_real *slopes)
{
    struct adjoint_stages *w = x->stages;
    const size_t n = x->n, wide = w->wide;
    if (w->momenta) {
        w->momenta->plain(x->d->params, t, q, v, x->d->u, slopes);
        return;
    }
    pk_copy(w->y, q, n);
    pk_copy(w->y + n, v, n);
    pk_zero(slopes, 2 * n * wide);
    pk_zero(w->a + n, n);
    if (x->system->acceleration(x->d->params, t, q, v, x->d->u, w->a))
        x->status = PK_SINGULAR_MASS;
    adjoint_mass(x, t, w->y);
    for (size_t i = 0; i < n; i++) {
        slopes[i * wide + n + i] = 1;
        w->a[n + i] = 1;
        adjoint_sweep(x, t, w->y, w->a, w->a + n);
        w->a[n + i] = 0;
        pk_copy(slopes + (n + i) * wide, x->bars, wide);
    }
}

/* Adds factor * the rows of `slopes` times l to lambda of coordinates, inputs and parameters. */
static void add_slopes(struct adjoint *x, pk_real factor, const pk_real *slopes, const pk_real *l)
{
    const size_t n = x->n;
    for (size_t i = 0; i < n; i++, slopes += x->stages->wide) {
        pk_add(x->lambda, factor * l[i], slopes, x->n_q);
        pk_add(x->lambda + 2 * n, factor * l[i], slopes + 2 * n + 1, x->m);
    }
}

/* Replaces v by p (sign = -1), or p by v (1), in what lambda belongs to, at (q, v). */
static void exchange(struct adjoint *x, pk_real sign, pk_real t, const pk_real *q, const pk_real *v)
{
    struct adjoint_stages *w = x->stages;
    const size_t n = x->n;
    pk_real *const S = w->slopes + w->s * 2 * n * w->wide, *const l = x->lambda + n, *mu = w->eta;
    if (!w->momenta)
        return;
    find_slopes(x, t, q, v, S);
    for (size_t i = 0; i < n; i++)
        pk_copy(x->M + i * n, S + i * w->wide + n, n);
    pk_zero(mu, n);
    pk_add_product(mu, x->M, l, n); /* M is symmetric */
    if (sign < 0) {
        if (pk_ldl_factor(x->M, n))
            x->status = PK_SINGULAR_MASS;
        pk_ldl_solve(x->M, n, l);
    }
    add_slopes(x, sign, S, l);
    if (sign > 0)
        pk_copy(l, mu, n);
}

/* Returns the coefficient of component r of mu_k in equation c of stage i. */
static pk_real coefficient(const struct adjoint *x, size_t i, size_t c, size_t k, size_t r)
{
    const struct adjoint_stages *w = x->stages;
    const size_t n = x->n, s = w->s, wide = w->wide, of_stage = 2 * n * wide;
    const pk_real *const p = w->slopes + k * of_stage + r * wide;
    const pk_real *pdot = w->slopes + (n + r) * wide;
    pk_real sum = (k == i ? p[n + c] : 0) - w->of.A_p[k * s + i] * pdot[i * of_stage + n + c];
    if (c >= x->n_q)
        return sum;
    if (k < s)
        sum += w->of.A[k * s + i] * p[c];
    for (size_t j = 0; j < s; j++, pdot += of_stage)
        sum -= w->of.A[j * s + i] * w->of.A_p[k * s + j] * pdot[c];
    return sum;
}

/* Computes mu by elimination. */
static void eliminate(struct adjoint *x)
{
    struct adjoint_stages *w = x->stages;
    const size_t n = x->n, s = w->s, m = s * n;
    for (size_t row = 0; row < m; row++) {
        const size_t i = row / n, c = row % n;
        for (size_t k = 0; k < m; k++)
            w->matrix[row * m + k] = coefficient(x, i, c, k / n, k % n);
        w->mu[row] = c < x->n_q ? w->of.A[s * s + i] * x->lambda[c] : 0;
        for (size_t r = 0; r < n; r++)
            w->mu[row] -= coefficient(x, i, c, s, r) * w->mu[m + r];
    }
    if (!pk_lu_factor(w->matrix, w->pivot, m))
        x->status = PK_NO_CONVERGENCE;
    pk_lu_solve(w->matrix, w->pivot, m, w->mu);
}

static void find_eta(struct adjoint *x)
{
    struct adjoint_stages *w = x->stages;
    const size_t n = x->n, s = w->s;
    pk_zero(w->eta, s * n);
    for (size_t j = 0; j < s; j++)
        for (size_t k = 0; k <= s; k++)
            pk_add(w->eta + j * n, w->of.A_p[k * s + j], w->mu + k * n, n);
}

/* Computes y_i = sum_k A_ki x_k, x_s = `last`. */
static inline void weigh(const pk_real *A, const pk_real *x, pk_real last, pk_real *y)
{
    for (size_t l = 0; l < PK_LANES; l++)
        y[l] = A[PK_LANES * PK_LANES + l] * last;
    for (size_t k = 0; k < PK_LANES; k++)
        for (size_t l = 0; l < PK_LANES; l++)
            y[l] += A[k * PK_LANES + l] * x[k];
}

/* Computes y += sum_r pdot_r eta_r; both have a number for each stage. */
static inline void add_columns(const pk_real *pdot, const pk_real *eta, size_t n, pk_real *y)
{
    for (size_t r = 0; r < n * PK_LANES; r += PK_LANES)
        for (size_t l = 0; l < PK_LANES; l++)
            y[l] += pdot[r + l] * eta[r + l];
}

/* Computes mu of the adaptive Gauss method by fixed-point iteration, as its steps do. The stages
 * are side by side. */
static void iterate(struct adjoint *x)
{
    struct adjoint_stages *w = x->stages;
    const size_t n = x->n, of = n * PK_LANES;
    pk_real *const pdot = w->matrix, *const mu = pdot + 2 * n * of, *const next = mu + of,
                   *eta = w->eta;
    for (size_t k = 0; k < 2 * n * of; k++) {
        const size_t c = k / of, r = k % of / PK_LANES, l = k % PK_LANES;
        pdot[k] = w->slopes[((2 * l + 1) * n + r) * w->wide + c];
    }
    pk_zero(mu, of);
    pk_real change = 1, size = 0;
    for (int count = 0; count < 100 && change > 16 * PK_EPS * size; count++) {
        for (size_t r = 0; r < n; r++)
            weigh(w->of.A_p, mu + r * PK_LANES, x->lambda[n + r], eta + r * PK_LANES);
        pk_zero(next, of);
        for (size_t c = 0; c < n; c++) {
            pk_real xi[PK_LANES] = {0};
            add_columns(pdot + c * of, eta, n, xi);
            if (c < x->n_q)
                weigh(w->of.A, xi, x->lambda[c], next + c * PK_LANES);
            add_columns(pdot + (n + c) * of, eta, n, next + c * PK_LANES);
        }
        change = size = 0;
        for (size_t k = 0; k < of; k++) {
            change = pk_max(change, pk_abs(next[k] - mu[k]));
            size = pk_max(size, pk_abs(next[k]));
            mu[k] = next[k];
        }
    }
    if (!(change <= 256 * PK_EPS * size)) /* a NaN too: the forward derivative decides */
        x->status = PK_REFUSED;
    for (size_t k = 0; k < of; k++)
        w->mu[k % PK_LANES * n + k / PK_LANES] = mu[k];
}

enum pk_status adjoint_implicit(struct adjoint *x, size_t k)
{
    struct adjoint_stages *w = x->stages;
    const size_t n = x->n, s = w->s;
    const pk_real *const row = tape_row(x->run->tape, k), t = row[TAPE_T0], h = row[TAPE_T1] - t;
    struct differences *d = x->d;
    PK_TRY(differences_step(d, k, row[TAPE_T1]));
    if (d->it.count.steps != k + 1)
        return PK_REFUSED;
    exchange(x, -1, row[TAPE_T1], d->q, d->v);
    d->it.method->last(&d->it, &w->of);
    for (size_t i = 0; i < s; i++)
        find_slopes(x, t + w->of.c[i] * h, w->of.Q + i * n, w->of.V + i * n,
                    w->slopes + i * 2 * n * w->wide);
    pk_copy(w->mu + s * n, x->lambda + n, n);
    w->momenta ? eliminate(x) : iterate(x);
    find_eta(x);
    for (size_t i = 0; i < s; i++) {
        const pk_real *const S = w->slopes + i * 2 * n * w->wide;
        add_slopes(x, -1, S, w->mu + i * n);
        add_slopes(x, 1, S + n * w->wide, w->eta + i * n);
        pk_add(x->lambda + n, 1, w->mu + i * n, n);
    }
    exchange(x, 1, t, row + TAPE_STATE, row + TAPE_STATE + n);
    return x->status;
}

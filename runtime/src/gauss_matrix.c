/* Newton's matrix of the stage equations G(V) = 0 in gauss.c. It has the blocks
 *
 *     dG_i/dV_j = delta_ij M + h (a_ij p_q - a^_ij pdot_v) - h^2 sum_r a^_ir a_rj pdot_q
 *
 * with the derivatives at the stages: M and p_q at i, pdot_v at j, pdot_q at r; or in large systems
 * all at their mean, where the error of freezing is of second order in h.
 *
 * References: E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, IV.8; for the norm,
 * R. S. Varga, Matrix Iterative Analysis, 2.1 (Collatz, Wielandt).
 */
#include <string.h>

#include "gauss.h"

void pk_gauss_derivatives(struct pk_integrator *it, pk_real t, const pk_real *q, const pk_real *v,
                          pk_real *J)
{
    const struct pk_system *system = it->problem.system;
    const size_t nn = it->n * it->n;
    const pk_real *u = pk_eval_input(it, t);
    system->mass(it->problem.params, t, q, v, u, J);
    system->jacobian(it->problem.params, t, q, v, u, J + nn, J + 2 * nn, J + 3 * nn);
    it->count.jacobians++;
}

void pk_gauss_stage_derivatives(struct pk_integrator *it, struct pk_gauss_work *w)
{
    const size_t n = it->n;
    for (size_t i = 0; i < w->s; i++)
        pk_gauss_derivatives(it, it->t + w->table->c[i] * it->h, w->Q + i * n, w->V + i * n,
                             w->jacobian + i * 4 * n * n);
}

void pk_gauss_matrix(const struct pk_integrator *it, const struct pk_gauss_work *w,
                     const pk_real *J, size_t stride, pk_real tau, pk_real *matrix)
{
    const size_t n = it->n, s = w->s, m = s * n, nn = n * n;
    for (size_t i = 0; i < s; i++)
        for (size_t j = 0; j < s; j++) {
            pk_real *block = matrix + i * n * m + j * n;
            const pk_real *Ji = J + i * stride, *Jj = J + j * stride;
            const pk_real a = tau * w->hA[i * s + j], a_p = tau * w->hA_p[i * s + j];
            for (size_t k = 0; k < n; k++)
                for (size_t l = 0; l < n; l++) {
                    const size_t x = k * n + l;
                    pk_real sum = a * Ji[nn + x] - a_p * Jj[3 * nn + x] + (i == j ? Ji[x] : 0);
                    for (size_t r = 0; r < s; r++)
                        sum -= (tau * w->hA_p[i * s + r]) * (tau * w->hA[r * s + j]) *
                               J[r * stride + 2 * nn + x];
                    block[k * m + l] = sum;
                }
        }
}

int pk_gauss_small(const struct pk_integrator *it, const struct pk_gauss_work *w)
{
    return w->s * it->n <= 24;
}

int pk_gauss_refactor(struct pk_integrator *it, struct pk_gauss_work *w, enum pk_gauss_mode mode)
{
    const size_t n = it->n, s = w->s;
    it->flags &= ~(PK_HAVE_LU | PK_REFRESH);
    it->count.factorisations++;
    if (mode == PK_BY_MASS) {
        it->problem.system->mass(it->problem.params, it->t, it->q, it->v,
                                 pk_eval_input(it, it->t), w->jacobian);
        return pk_ldl_factor(w->jacobian, n) == 0;
    }
    const int each = mode == PK_FULL || pk_gauss_small(it, w);
    if (each) {
        pk_gauss_stage_derivatives(it, w);
    } else {
        memset(w->mean_q, 0, n * sizeof *w->mean_q);
        memset(w->mean_v, 0, n * sizeof *w->mean_v);
        for (size_t i = 0; i < s; i++)
            for (size_t k = 0; k < n; k++) {
                w->mean_q[k] += w->Q[i * n + k] / (pk_real)s;
                w->mean_v[k] += w->V[i * n + k] / (pk_real)s;
            }
        pk_gauss_derivatives(it, it->t + it->h / 2, w->mean_q, w->mean_v, w->jacobian);
    }
    *w->contraction = pk_gauss_contraction(it, w, w->jacobian, each ? s : 1);
    *w->sure = 0;
    pk_gauss_matrix(it, w, w->jacobian, each ? 4 * n * n : 0, 1, w->lu);
    *w->lu_h = it->h;
    if (!pk_lu_factor(w->lu, w->pivot, s * n))
        return 0;
    if (mode == PK_SIMPLIFIED)
        it->flags |= PK_HAVE_LU;
    return 1;
}

pk_real pk_gauss_norm(const pk_real *X, size_t m, pk_real *x, pk_real *y)
{
    pk_real least = PK_INFINITY;
    for (size_t i = 0; i < m; i++)
        x[i] = 1;
    for (int turn = 0; turn < 6; turn++) {
        pk_real most = 0, sum = 0;
        for (size_t i = 0; i < m; i++) {
            y[i] = 0;
            for (size_t j = 0; j < m; j++)
                y[i] += pk_abs(X[i * m + j]) * x[j];
            if (!(y[i] <= most * x[i])) /* so that what is no number gets through */
                most = y[i] / x[i];
        }
        if (!pk_finite(most))
            return most;
        least = pk_min(least, most);
        if (m == 1 || !(most > 0))
            break;
        for (size_t i = 0; i < m; i++) { /* a power step, damped since |X| may turn in a circle */
            x[i] += y[i] / most;
            sum = pk_max(sum, x[i]);
        }
        for (size_t i = 0; i < m; i++)
            x[i] /= sum;
    }
    return least;
}

/* most_ij += factor max |(M^-1 X)_ij| */
static void add_most(const pk_real *ldl, const pk_real *X, size_t n, pk_real factor, pk_real *x,
                     pk_real *N)
{
    for (size_t j = 0; j < n; j++) {
        for (size_t i = 0; i < n; i++)
            x[i] = X[i * n + j];
        pk_ldl_solve(ldl, n, x);
        for (size_t i = 0; i < n; i++)
            N[i * n + j] += factor * pk_abs(x[i]);
    }
}

/* With N = h |A| |M^-1 p_q| + h |A^| |M^-1 pdot_v| + h^2 |A^| |A| |M^-1 pdot_q|, the norms of the
 * tables being their largest row sums. */
pk_real pk_gauss_contraction(const struct pk_integrator *it, const struct pk_gauss_work *w,
                             const pk_real *J, size_t count)
{
    const size_t n = it->n, s = w->s, nn = n * n;
    const int separable = (it->problem.system->facts & PK_SEPARABLE) != 0;
    pk_real *ldl = w->other, *N = ldl + nn, *all = N + nn;
    pk_real of_a = 0, of_p = 0, of_both = 0;
    for (size_t i = 0; i < s; i++) {
        pk_real a = 0, p = 0, both = 0;
        for (size_t j = 0; j < s; j++) {
            pk_real sum = 0;
            for (size_t r = 0; r < s; r++)
                sum += pk_abs(w->hA[j * s + r]);
            a += pk_abs(w->hA[i * s + j]);
            p += pk_abs(w->hA_p[i * s + j]);
            both += pk_abs(w->hA_p[i * s + j]) * sum;
        }
        of_a = pk_max(of_a, a);
        of_p = pk_max(of_p, p);
        of_both = pk_max(of_both, both);
    }
    memset(all, 0, nn * sizeof *all);
    for (size_t k = 0; k < count; k++, J += 4 * nn) {
        memcpy(ldl, J, nn * sizeof *ldl);
        if (pk_ldl_factor(ldl, n))
            return PK_INFINITY;
        memset(N, 0, nn * sizeof *N);
        add_most(ldl, J + 2 * nn, n, of_both, w->x, N);
        if (!separable) {
            add_most(ldl, J + nn, n, of_a, w->x, N);
            add_most(ldl, J + 3 * nn, n, of_p, w->x, N);
        }
        for (size_t i = 0; i < nn; i++)
            if (!(N[i] <= all[i]))
                all[i] = N[i];
    }
    return pk_gauss_norm(all, n, w->x, w->y);
}

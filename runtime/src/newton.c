/* The stage equations G(V) = 0 of a Gauss method. Newton's matrix has the blocks
 *
 *     dG_i/dV_j = delta_ij M + h a_ij (p_q - pdot_v) - h^2 (A^2)_ij pdot_q
 *
 * with the derivatives at the stages. Simplified: frozen at the predicted stages, or in large
 * systems all at their mean, where the error of freezing is of second order in h; the LU is kept
 * over iterations and steps while these converge as fast as at first. If that fails, full Newton
 * from V = v0. Fixed-point iteration has M alone for its matrix and converges for small h only
 * (h omega < 2, 3.46, 4.64 for 1, 2, 3 stages); it is told apart from convergence, never cut off.
 *
 * An iteration ends where the next correction is foreseen to be far below round-off, on a scale
 * of its own for each coordinate, max|V| + |q|/h; or where corrections are at round-off and no
 * longer shrink. Far below, because what is left undone has a sign: at round-off itself the
 * energy drifts like t, not like sqrt(t) (E. Hairer, R. McLachlan, A. Razakarivony, BIT 48 (2008)
 * 231). Reference: E. Hairer, G. Wanner, Solving Ordinary Differential Equations II,
 * IV.8; GNI VIII.6.
 */
#include <string.h>

#include "gauss.h"

/* G, and Q, P, F, at V. 0 where one is not finite. A product with h b_j is rounded once, and the
 * same number serves the stages and the end of the step; h a_ij rounded on its own would break
 * b_i a_ij + b_j a_ji = b_i b_j by round-off, always the same way, and the energy would drift. */
static int residual(struct pk_integrator *it, struct pk_gauss_work *w)
{
    const size_t n = it->n, s = w->s;
    const pk_real *p0 = pk_part(it->state, n, PK_P);
    for (size_t j = 0; j < s; j++)
        for (size_t k = 0; k < n; k++)
            w->P[j * n + k] = w->hb[j] * w->V[j * n + k];
    for (size_t i = 0; i < s; i++)
        for (size_t k = 0; k < n; k++) {
            pk_real dq = 0;
            for (size_t j = 0; j < s; j++)
                dq += w->mu[i * s + j] * w->P[j * n + k];
            w->Q[i * n + k] = it->q[k] + dq;
        }
    for (size_t i = 0; i < s; i++) {
        pk_real *F = w->F + i * n;
        pk_eval_canonical(it, it->t + w->table->c[i] * it->h, w->Q + i * n, w->V + i * n,
                          w->P + i * n, F);
        for (size_t k = 0; k < n; k++)
            F[k] *= w->hb[i];
    }
    for (size_t i = 0; i < s; i++)
        for (size_t k = 0; k < n; k++) {
            pk_real dp = 0;
            for (size_t j = 0; j < s; j++)
                dp += w->mu[i * s + j] * w->F[j * n + k];
            w->G[i * n + k] = (w->P[i * n + k] - p0[k]) - dp;
        }
    return pk_all_finite(w->G, s * n);
}

static void derivatives(struct pk_integrator *it, pk_real t, const pk_real *q, const pk_real *v,
                        pk_real *J)
{
    const struct pk_system *system = it->problem.system;
    const size_t nn = it->n * it->n;
    const pk_real *u = pk_eval_input(it, t);
    system->mass(it->problem.params, t, q, v, u, J);
    system->jacobian(it->problem.params, t, q, v, u, J + nn, J + 2 * nn, J + 3 * nn);
    it->count.jacobians++;
}

/* Newton's matrix and its LU. Derivatives of stage j start at jacobian + j * stride, so a stride
 * of 0 is one set for all stages. */
static int factor(struct pk_integrator *it, struct pk_gauss_work *w, size_t stride)
{
    const size_t n = it->n, s = w->s, m = s * n, nn = n * n;
    memset(w->lu, 0, m * m * sizeof *w->lu);
    for (size_t i = 0; i < s; i++)
        for (size_t j = 0; j < s; j++) {
            pk_real *block = w->lu + i * n * m + j * n;
            const pk_real *Ji = w->jacobian + i * stride, *Jj = w->jacobian + j * stride;
            const pk_real ha = w->hA[i * s + j];
            for (size_t k = 0; k < n; k++)
                for (size_t l = 0; l < n; l++) {
                    const size_t x = k * n + l;
                    pk_real sum = ha * (Ji[nn + x] - Jj[3 * nn + x]) + (i == j ? Ji[x] : 0);
                    for (size_t r = 0; r < s; r++)
                        sum -= w->hA[i * s + r] * w->hA[r * s + j] *
                               w->jacobian[r * stride + 2 * nn + x];
                    block[k * m + l] = sum;
                }
        }
    it->count.factorisations++;
    *w->lu_h = it->h;
    return pk_lu_factor(w->lu, w->pivot, m);
}

/* Derivatives at the mean of the stages of the present iterate. */
static int factor_simplified(struct pk_integrator *it, struct pk_gauss_work *w)
{
    const size_t n = it->n;
    for (size_t k = 0; k < n; k++) {
        w->mean_q[k] = w->mean_v[k] = 0;
        for (size_t i = 0; i < w->s; i++) {
            w->mean_q[k] += w->Q[i * n + k] / (pk_real)w->s;
            w->mean_v[k] += w->V[i * n + k] / (pk_real)w->s;
        }
    }
    derivatives(it, it->t + it->h / 2, w->mean_q, w->mean_v, w->jacobian);
    return factor(it, w, 0);
}

static int factor_full(struct pk_integrator *it, struct pk_gauss_work *w)
{
    const size_t n = it->n, stride = 4 * n * n;
    for (size_t i = 0; i < w->s; i++)
        derivatives(it, it->t + w->table->c[i] * it->h, w->Q + i * n, w->V + i * n,
                    w->jacobian + i * stride);
    return factor(it, w, stride);
}

static int factor_mass(struct pk_integrator *it, struct pk_gauss_work *w)
{
    it->problem.system->mass(it->problem.params, it->t, it->q, it->v, pk_eval_input(it, it->t),
                             w->jacobian);
    it->count.factorisations++;
    return pk_ldl_factor(w->jacobian, it->n) == 0;
}

/* Sizes of the correction G: on each coordinate's own scale, and on one that forgives
 * coordinates at rest beside moving ones. */
static void sizes(const struct pk_integrator *it, const struct pk_gauss_work *w, pk_real *own,
                  pk_real *shared)
{
    const size_t n = it->n;
    pk_real most = 0;
    for (size_t k = 0; k < n; k++)
        most = pk_max(most, w->scale[k]);
    *own = *shared = 0;
    for (size_t k = 0; k < n; k++) {
        pk_real size = 0;
        for (size_t i = 0; i < w->s; i++) /* written so that what is no number gets through */
            if (!(pk_abs(w->G[i * n + k]) <= size))
                size = pk_abs(w->G[i * n + k]);
        if (size > 0 || !pk_finite(size)) {
            *own = pk_max(size / (w->scale[k] + PK_EPS * most), *own);
            *shared = pk_max(size / (w->scale[k] + PK_C(1e-3) * most), *shared);
        }
    }
}

/* Set once a step, after the first correction: a scale that grew with a diverging V would hide
 * its divergence. */
static void set_scale(const struct pk_integrator *it, struct pk_gauss_work *w)
{
    for (size_t k = 0; k < it->n; k++) {
        w->scale[k] = pk_max(pk_abs(it->q[k] / it->h), pk_abs(it->v[k]));
        for (size_t i = 0; i < w->s; i++)
            w->scale[k] = pk_max(w->scale[k], pk_abs(w->V[i * it->n + k]));
    }
}

/* Where a matrix costs less than an iteration or two: it then takes the derivatives at each
 * predicted stage, and is made anew at the first sign of slower convergence. */
static int small(const struct pk_integrator *it, const struct pk_gauss_work *w)
{
    return w->s * it->n <= 24;
}

enum mode { SIMPLIFIED, FULL, FIXED_POINT };
enum outcome { CONVERGED, FAILED, NO_NUMBER };

static int refactor(struct pk_integrator *it, struct pk_gauss_work *w, enum mode mode)
{
    it->flags &= ~(PK_HAVE_LU | PK_REFRESH);
    if (mode == FIXED_POINT)
        return factor_mass(it, w);
    if (!(mode == FULL || small(it, w) ? factor_full(it, w) : factor_simplified(it, w)))
        return 0;
    if (mode == SIMPLIFIED)
        it->flags |= PK_HAVE_LU;
    return 1;
}

static void correct(struct pk_integrator *it, struct pk_gauss_work *w, enum mode mode)
{
    const size_t n = it->n, m = w->s * n;
    if (mode == FIXED_POINT)
        for (size_t i = 0; i < w->s; i++)
            pk_ldl_solve(w->jacobian, n, w->G + i * n);
    else
        pk_lu_solve(w->lu, w->pivot, m, w->G);
    for (size_t k = 0; k < m; k++)
        w->V[k] -= w->G[k];
}

/* Divergence of a slow iteration: the largest correction of 25 is not below that of the 25
 * before. Single ones may rise and fall, since the eigenvalues of h^2 A^2 are complex. */
static int rising(pk_real size, int count, pk_real *window)
{
    window[0] = pk_max(window[0], size);
    if (count % 25 != 24)
        return 0;
    const int up = count > 25 && window[0] >= window[1];
    window[1] = window[0];
    window[0] = 0;
    return up;
}

/* Keeps the matrix for the next step only while that does not cost iterations; where it did, it
 * is made anew for a while, twice as long each time, before keeping it is tried again. */
static void keep_or_refresh(struct pk_integrator *it, struct pk_gauss_work *w, int fresh,
                            pk_real count)
{
    if (!(it->flags & PK_HAVE_STEP)) {
        it->flags |= PK_REFRESH; /* a first step has no prediction: its count says nothing */
    } else if (fresh) {
        *w->best = count;
        *w->wait -= *w->wait > 0 ? PK_C(1.0) : PK_C(0.0);
    } else if (count > *w->best + (small(it, w) ? PK_C(0.0) : PK_C(1.0))) {
        *w->patience = pk_min(2 * *w->patience + 1, PK_C(63.0));
        *w->wait = *w->patience;
    } else {
        *w->patience = 0;
    }
    if (*w->wait > 0)
        it->flags |= PK_REFRESH;
}

static enum outcome iterate(struct pk_integrator *it, struct pk_gauss_work *w, enum mode mode)
{
    const int most = it->options.max_iterations > 0 ? it->options.max_iterations
                     : mode == FIXED_POINT          ? 1000
                                                    : 50;
    int fresh = 0, growing = 0, last = 0;
    pk_real before = 0, least = 0, window[2] = {0, 0};
    for (int count = 0; count <= most; count++) {
        if (!residual(it, w))
            return NO_NUMBER;
        if (last) { /* P and F now belong to the V that is kept */
            keep_or_refresh(it, w, fresh, (pk_real)count);
            return CONVERGED;
        }
        const int stale = !(it->flags & PK_HAVE_LU) || it->flags & PK_REFRESH ||
                          it->h > *w->lu_h || it->h < *w->lu_h;
        if (mode == FULL || (count == 0 && (mode == FIXED_POINT || stale))) {
            if (!refactor(it, w, mode))
                return FAILED;
            fresh = 1;
        }
        correct(it, w, mode);
        it->count.iterations++;
        pk_real size, shared;
        if (count == 0)
            set_scale(it, w);
        sizes(it, w, &size, &shared);
        it->detail = size;
        if (!pk_finite(size) || !pk_all_finite(w->V, w->s * it->n))
            return NO_NUMBER;
        const pk_real rate = count ? size / before : PK_C(1.0);
        if (it->options.newton_tol > 0)
            last = size <= it->options.newton_tol;
        else if (size <= (count ? PK_EPS / 4 : PK_GAUSS_BIAS) ||
                 (rate < 1 && size * rate / (1 - rate) <= PK_GAUSS_BIAS) ||
                 (rate > PK_C(0.5) && count && shared <= PK_GAUSS_ROUND &&
                  mode != FIXED_POINT && (fresh || mode == FULL)))
            last = 1;
        growing = count && size >= least ? growing + 1 : 0;
        least = count == 0 ? size : pk_min(least, size);
        if (mode == FIXED_POINT && growing >= 3 && shared <= PK_GAUSS_ROUND)
            last = 1;
        if (!last && (mode == FIXED_POINT ? rising(size, count, window) : growing >= 3))
            return FAILED;
        if (!last && mode == SIMPLIFIED && count && rate > PK_C(0.3)) {
            if (fresh)
                return FAILED;
            it->flags |= PK_REFRESH; /* a kept matrix became too old within this step */
            if (!residual(it, w) || !refactor(it, w, mode))
                return FAILED;
            fresh = 1;
            growing = 0;
        }
        before = size;
    }
    return FAILED;
}

enum pk_status pk_gauss_solve(struct pk_integrator *it, struct pk_gauss_work *w)
{
    const size_t n = it->n;
    if (it->options.iteration == PK_FIXED_POINT) {
        const enum outcome outcome = iterate(it, w, FIXED_POINT);
        return outcome == CONVERGED ? PK_DONE : PK_NO_CONVERGENCE;
    }
    if (iterate(it, w, SIMPLIFIED) == CONVERGED)
        return PK_DONE;
    for (size_t i = 0; i < w->s; i++)
        memcpy(w->V + i * n, it->v, n * sizeof *w->V);
    if (!residual(it, w))
        return PK_NOT_FINITE; /* at the mildest guess there is */
    const enum outcome outcome = iterate(it, w, FULL);
    it->flags &= ~PK_HAVE_LU;
    return outcome == CONVERGED ? PK_DONE : PK_NO_CONVERGENCE;
}

/* Solves the stage equations G(V) = 0 of gauss.c by Newton's method; the matrix is computed in
 * gauss_matrix.c. Simplified Newton iteration uses the matrix at the predicted stages, and reuses
 * its LU factors in iterations and steps as long as these converge as fast as with a new matrix. If
 * that fails, full Newton iteration starts from V = v0. Fixed-point iteration uses M as matrix and
 * converges only for small h (Gauss: h omega < 2, 3.46, 4.64 for 1, 2, 3 stages); its divergence is
 * detected early. branch.c certifies that the solution is on the branch of short steps.
 *
 * An iteration ends when the next correction is predicted to be far below round-off, on the scale
 * max(|V|, |q|/h) of each coordinate except quadratures; or when corrections are at round-off and
 * no longer decrease. It must be far below, since the remaining error is systematic: with an error
 * at round-off the energy would drift like t, not like sqrt(t) (E. Hairer, R. McLachlan, A.
 * Razakarivony, BIT 48 (2008) 231). Reference: E. Hairer, G. Wanner, Solving Ordinary Differential
 * Equations II, IV.8; GNI VIII.6. */

#include "gauss.h"

/* A product with h b_j is rounded once, and the same number is used for the stages and the end of
 * the step. If h a_ij were rounded separately, b_i a^_ij + b_j a_ji = b_i b_j would be violated by
 * the same round-off in each step, and the energy would drift. */
int pk_gauss_residual(struct pk_integrator *it, struct pk_gauss_work *w)
{
    const size_t n_q = it->n_q, n = it->n, s = w->s;
    const pk_real *p0 = pk_state(it, PK_P);
    for (size_t j = 0; j < s; j++)
        for (size_t k = 0; k < n; k++)
            w->P[j * n + k] = w->hb[j] * w->V[j * n + k];
    for (size_t i = 0; i < s; i++)
        for (size_t k = 0; k < n_q; k++) {
            pk_real dq = 0;
            for (size_t j = 0; j < s; j++)
                dq += w->mu[i * s + j] * w->P[j * n + k];
            w->Q[i * n_q + k] = it->q[k] + dq;
        }
    for (size_t i = 0; i < s; i++) {
        pk_real *F = w->F + i * n;
        pk_eval_canonical(it, it->t + w->c[i] * it->own->h, w->Q + i * n_q, w->V + i * n,
                          w->P + i * n, F);
        for (size_t k = 0; k < n; k++)
            F[k] *= w->hb[i];
    }
    for (size_t i = 0; i < s; i++)
        for (size_t k = 0; k < n; k++) {
            pk_real dp = 0;
            for (size_t j = 0; j < s; j++)
                dp += w->mu_p[i * s + j] * w->F[j * n + k];
            w->G[i * n + k] = (w->P[i * n + k] - p0[k]) - dp;
        }
    return pk_all_finite(w->G, s * n);
}

/* Computes the size of the correction in w->G, relative to each coordinate's own scale and relative
 * to scales that share part of the largest one. The shared scales tolerate errors of coordinates
 * that are at rest while others move. */
static void sizes(const struct pk_integrator *it, const struct pk_gauss_work *w, pk_real *own,
                  pk_real *shared)
{
    const size_t n = it->n, read = pk_gauss_read(w);
    pk_real most = 0;
    for (size_t k = 0; k < read; k++)
        most = pk_max(most, w->scale[k]);
    *own = *shared = 0;
    for (size_t k = 0; k < read; k++) {
        pk_real size = 0;
        for (size_t i = 0; i < w->s; i++) /* written so that a NaN is not lost */
            if (!(pk_abs(w->G[i * n + k]) <= size))
                size = pk_abs(w->G[i * n + k]);
        if (size > 0 || !pk_finite(size)) {
            *own = pk_max(size / (w->scale[k] + PK_EPS * most + PK_TINY), *own);
            *shared = pk_max(size / (w->scale[k] + PK_C(1e-3) * most + PK_TINY), *shared);
        }
    }
}

/* Sets the scale once per step, after the first correction: a scale that grew with a diverging V
 * would hide the divergence. */
void pk_gauss_set_scale(const struct pk_integrator *it, struct pk_gauss_work *w)
{
    for (size_t k = 0; k < it->n; k++) {
        w->scale[k] = pk_abs(it->v[k]);
        if (k < it->n_q)
            w->scale[k] = pk_max(pk_abs(it->q[k] / it->own->h), w->scale[k]);
        for (size_t i = 0; i < w->s; i++)
            w->scale[k] = pk_max(w->scale[k], pk_abs(w->V[i * it->n + k]));
    }
}

/* Returns the largest relative change of M, p_q, pdot_q and pdot_v since the last iteration. */
static pk_real changed(const struct pk_gauss_work *w)
{
    const size_t nn = w->nn, seen = w->pattern.dense ? w->places * w->n : nn;
    pk_real worst = 0;
    for (size_t kind = 0; kind < 4; kind++) {
        pk_real most = 0, change = 0;
        for (size_t i = 0; i < w->s; i++)
            for (size_t k = 0; k < seen; k++) {
                const size_t x = (4 * i + kind) * nn + k;
                most = pk_max(most, pk_abs(w->jacobian[x]));
                change = pk_max(change, pk_abs(w->jacobian[x] - w->before_J[x]));
            }
        worst = change > 0 ? pk_max(worst, change / most) : worst;
    }
    return worst;
}

void pk_gauss_correct(struct pk_integrator *it, struct pk_gauss_work *w, enum pk_gauss_mode mode)
{
    const size_t n = it->n, m = w->s * n;
    if (mode == PK_BY_MASS)
        for (size_t i = 0; i < w->s; i++)
            pk_gauss_mass_solve(w, w->jacobian, w->G + i * n);
    else
        pk_gauss_lu_solve(w, &w->lu, w->s, w->G);
    for (size_t k = 0; k < m; k++) { /* G becomes the change of V, including its rounding */
        const pk_real before = w->V[k];
        w->V[k] -= w->G[k];
        w->G[k] = before - w->V[k];
    }
}

void pk_gauss_settle(const struct pk_integrator *it, const struct pk_gauss_work *w)
{
    const size_t n = it->n;
    for (size_t i = 0; i < w->s; i++)
        for (size_t k = i * n + pk_gauss_read(w); k < (i + 1) * n; k++) {
            w->V[k] -= w->G[k];
            w->P[k] = w->V[k];
        }
}

/* Returns whether a slow iteration diverges: the largest of the last 25 corrections is not less
 * than the largest of the 25 corrections before them. Single corrections may oscillate, since the
 * eigenvalues of h^2 A^2 are complex, where A is the method's matrix. */
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

/* Keeps the matrix for the next step unless this step took more iterations than one with a new
 * matrix. In that case the matrix is recomputed for some steps before it is kept again; their
 * number doubles each time. */
static void keep_or_refresh(struct pk_integrator *it, struct pk_gauss_work *w, int fresh, int count)
{
    if (!(it->own->flags & PK_HAVE_STEP)) {
        it->own->flags |= PK_REFRESH; /* stages were not predicted, so count is no measure */
    } else if (fresh) {
        w->kept->best = count;
        w->kept->wait -= w->kept->wait > 0;
    } else if (count - !pk_gauss_small(w) > w->kept->best) {
        const int patience = w->kept->patience; /* a restored value may be invalid */
        w->kept->patience = patience >= 0 && patience < 31 ? 2 * patience + 1 : 63;
        w->kept->wait = w->kept->patience;
    } else {
        w->kept->patience = 0;
    }
    if (w->kept->wait > 0)
        it->own->flags |= PK_REFRESH;
}

int pk_gauss_iterate(struct pk_integrator *it, struct pk_gauss_work *w, enum pk_gauss_mode mode)
{
    const int most = it->options.max_iterations > 0 ? it->options.max_iterations
                     : mode == PK_BY_MASS           ? 1000
                                                    : 50;
    int fresh = 0, growing = 0, last = 0, stuck = 0;
    pk_real before = 0, least = 0, window[2] = {0, 0};
    w->kept->first_rate = w->kept->worst_rate = 0;
    w->kept->fresh = w->kept->noisy = 0;
    for (int count = 0; count <= most; count++) {
        if (!pk_gauss_residual(it, w))
            return 0;
        if (last) { /* P and F now correspond to the final V */
            pk_gauss_settle(it, w);
            keep_or_refresh(it, w, fresh, count);
            return 1;
        }
        if (mode == PK_FULL || (count == 0 && (mode == PK_BY_MASS || pk_gauss_stale(it, w)))) {
            if (mode == PK_FULL)
                pk_copy(w->before_J, w->jacobian, 4 * w->s * w->nn);
            if (!pk_gauss_refactor(it, w, mode))
                return 0;
            fresh = 1;
        }
        pk_gauss_correct(it, w, mode);
        it->count.iterations++;
        pk_real size, shared;
        if (count == 0)
            pk_gauss_set_scale(it, w);
        sizes(it, w, &size, &shared);
        it->reason.value = size;
        if (!pk_finite(size) || !pk_all_finite(w->V, w->s * it->n))
            return 0;
        const pk_real rate = count ? size / before : 1;
        /* With an unchanged matrix, one correction is enough. Further corrections, near rest, are
         * the round-off of forces whose terms cancel. */
        const int same = mode == PK_FULL && count && changed(w) <= PK_GAUSS_STEADY;
        stuck = !same ? 0 : rate > PK_GAUSS_STUCK ? stuck + 2 : stuck + 1;
        if (stuck >= 4) {
            w->kept->noisy = 1;
            last = 1;
        } else if (count == 1 && size > PK_GAUSS_ROUND && !same) {
            w->kept->first_rate = rate;
        }
        if (count && size > PK_GAUSS_FAR)
            w->kept->worst_rate = pk_max(w->kept->worst_rate, rate);
        if (it->options.newton_tol > 0)
            last = size <= it->options.newton_tol;
        else if (size <= (count ? PK_EPS / 4 : PK_GAUSS_BIAS) ||
                 (rate < 1 && size * rate / (1 - rate) <= PK_GAUSS_BIAS) ||
                 (rate > PK_C(0.5) && count && shared <= PK_GAUSS_ROUND && mode != PK_BY_MASS &&
                  (fresh || mode == PK_FULL)))
            last = 1;
        growing = count && size >= least ? growing + 1 : 0;
        least = count == 0 ? size : pk_min(least, size);
        if (mode == PK_BY_MASS && growing >= 3 && shared <= PK_GAUSS_ROUND)
            last = 1;
        if (!last && (mode == PK_BY_MASS ? rising(size, count, window) : growing >= 3 && !same))
            return 0;
        if (!last && mode == PK_SIMPLIFIED && count && rate > PK_C(0.3)) {
            if (fresh)
                return 0;
            it->own->flags |= PK_REFRESH; /* the reused matrix became inaccurate within this step */
            if (!pk_gauss_residual(it, w) || !pk_gauss_refactor(it, w, mode))
                return 0;
            fresh = 1;
            growing = 0;
        }
        before = size;
    }
    return 0;
}

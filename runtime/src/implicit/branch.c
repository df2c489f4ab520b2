/* Certifies which solution of the stage equations G(V; h) = 0 was found. There may be several: the
 * midpoint rule on a pendulum at rest upright has one while h omega <= 2, three at 2.01, seven at
 * 6. All of them satisfy the equations, so no residual distinguishes them. The intended solution is
 * on the branch of short steps: at h = 0 it is V_i = v0, where Newton's matrix J is M, and the
 * branch continues in h as long as J is regular. There are three tests, the cheapest first:
 *
 * 1. A fixed-point iteration would contract: |M^-1 (J - M)| <= .9, or .5 if J is reused from an
 *    earlier step, both with the derivatives at the stages and with those of the last step or at
 *    the start (pk_gauss_contraction). This costs nothing if the matrix is reused, and holds for
 *    h omega < 1 to 1.4.
 * 2. With the derivatives at the stages, J(tau h) is regular for 0 <= tau <= 1, and J is close both
 *    to J with the derivatives at the start and to the average of J over the straight path from v0
 *    to V. Two matrices are connected if |J1^-1 J2 - I| < 1 or |I - J2^-1 J1| < 1: then all
 *    matrices between them are regular. The sign of a determinant does not show that, since two
 *    eigenvalues may change sign at once. The range of tau is covered by one or several such pairs;
 *    for a convex potential with band matrices see bounded().
 * 3. The solution is continued from tau = 0 in small steps, with the same test between successive
 *    points, and accepted if it reaches tau = 1. If not, there is a fold or a crossing of branches:
 *    PK_AMBIGUOUS_STEP.
 *
 * Derivatives are sampled at the stages, so this is no proof over all states between them. The
 * norms are those of pk_gauss_norm, so that units do not matter. If derivatives are band matrices,
 * J1^-1 J2 is dense: twice the spectral radius of J1^-1 J2 - I, by a power iteration, replaces its
 * norm. A radius below 1 suffices for all matrices from J1 to J2 to be regular. So does a radius of
 * J1^-1 J2 - c I below c: then no eigenvalue of J1^-1 J2 is 0 or negative.
 *
 * References: E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, IV.14 (existence
 * and uniqueness); P. Deuflhard, Newton Methods for Nonlinear Problems, 5.1 (continuation). */
#include <string.h>

#include "gauss.h"

/* limit of the norms in tests 2 and 3 above; below 1, J1 to J2 are regular */
#define REGULAR PK_C(0.95)
#define SURE PK_C(0.75)    /* the same about another centre; the radius is not doubled there */
#define MOST_OFF 8         /* more than this is not tried */
#define STRAIGHT PK_C(0.5) /* limit of the norm in straight(), for the path from v0 to V */
#define LASTING PK_C(0.3)  /* if derivatives change by less, no test is made in later steps */
#define LEAST_LEAP PK_C(1e-4)
#define NEWTON_RATE PK_C(0.25) /* usual ratio of the first two corrections of Newton's method */
enum { MOST_POINTS = 400 };

/* Returns |J1^-1 J2 - I|, where J1 is factored in w->lu. */
static pk_real apart(struct pk_gauss_work *w, const pk_real *J2, size_t stride, pk_real tau)
{
    const size_t m = w->s * w->places;
    pk_real *X = w->other.corner;
    pk_gauss_matrix(w, J2, stride, tau, 1, &w->other);
    if (!w->pattern.dense)
        return 2 * pk_gauss_radius(w, 1);
    for (size_t j = 0; j < m; j++) {
        for (size_t i = 0; i < m; i++)
            w->x[i] = X[i * m + j];
        pk_band_solve(&w->lu, w->x);
        for (size_t i = 0; i < m; i++)
            X[i * m + j] = w->x[i] - (i == j ? 1 : 0);
    }
    return pk_gauss_norm(w, NULL);
}

static int factor(struct pk_integrator *it, struct pk_gauss_work *w, const pk_real *J,
                  size_t stride, pk_real tau)
{
    pk_gauss_matrix(w, J, stride, tau, 1, &w->lu);
    it->count.factorisations++;
    return pk_band_factor(&w->lu);
}

/* Returns whether all matrices between J1(tau1), factored in w->lu, and J2(tau2) are regular. If
 * so, w->lu then holds J2 factored; if not, w->lu is undefined. */
static int leap(struct pk_integrator *it, struct pk_gauss_work *w, const pk_real *J1,
                size_t stride1, pk_real tau1, const pk_real *J2, size_t stride2, pk_real tau2)
{
    const pk_real off = apart(w, J2, stride2, tau2);
    int near = off < REGULAR;
    if (!near && !w->pattern.dense && off < MOST_OFF) {
        /* Stiff equations: eigenvalues are between 1 and 1 + off / 2 if J grows with tau. */
        const pk_real centre = 1 + off / 4;
        near = pk_gauss_radius(w, centre) < SURE * centre;
    }
    if (!factor(it, w, J2, stride2, tau2))
        return 0;
    return near || apart(w, J1, stride1, tau1) < REGULAR;
}

/* Makes a matrix symmetric; returns its largest asymmetry relative to its largest entry. */
static pk_real symmetrise(const struct pk_gauss_work *w, pk_real *numbers)
{
    const struct pk_band A = pk_gauss_band(w, numbers);
    pk_real most = PK_TINY, off = 0;
    for (size_t i = 0; i < w->places; i++)
        for (size_t j = i < A.rows && i > A.below ? i - A.below : 0; j <= i; j++) {
            pk_real *x = pk_band_entry(&A, i, j), *y = pk_band_entry(&A, j, i);
            most = pk_max(most, pk_max(pk_abs(*x), pk_abs(*y)));
            off = pk_max(off, pk_abs(*x - *y));
            *x = *y = (*x + *y) / 2;
        }
    return off / most;
}

/* Returns whether J(tau h) with one set of derivatives is regular for 0 <= tau <= 1, by a theorem:
 * if p_q = 0, K = -pdot_q symmetric, K >= -mu M and C = -(pdot_v + pdot_v^T)/2 >= -nu M, a linear
 * motion grows in the norm q.(K + 2 mu M) q + v.M v by exp((sqrt(mu) + nu) t) at most, and the
 * equations of a step are solvable if (sqrt(mu) + nu) h < .5, which is below the limits of the
 * Gauss and Radau tableaus. Hairer, Wanner II, Theorem IV.14.4, (14.24), (14.25). */
static int bounded(const struct pk_gauss_work *w, const pk_real *J, pk_real h)
{
    const size_t nn = w->nn;
    const pk_real mu = PK_C(0.0625) / (h * h), nu = PK_C(0.2) / pk_abs(h);
    if (w->table->conjugate || w->closed)
        return 0;
    for (size_t x = 0; x < nn; x++) {
        if (J[nn + x] > 0 || J[nn + x] < 0)
            return 0;
        w->M[x] = -J[2 * nn + x];
    }
    if (!(symmetrise(w, w->M) <= 64 * PK_EPS))
        return 0;
    for (size_t x = 0; x < nn; x++)
        w->M[x] += mu * J[x];
    if (pk_gauss_mass_factor(w, w->M))
        return 0;
    for (size_t x = 0; x < nn; x++)
        w->M[x] = nu * J[x] - J[3 * nn + x];
    symmetrise(w, w->M);
    return pk_gauss_mass_factor(w, w->M) == 0;
}

/* The first part of test 2 (see above): returns whether J(tau h) with the derivatives in
 * w->jacobian is regular for 0 <= tau <= 1. If so, w->lu holds J(h) factored. */
static int regular(struct pk_integrator *it, struct pk_gauss_work *w)
{
    const size_t stride = 4 * w->nn;
    const pk_real contraction = w->kept->contraction;
    pk_real at = 0, step = 1;
    if (pk_finite(contraction)) /* if the contraction bound is known */
        step /= PK_F(sqrt)(pk_max(contraction, 1));
    if (!w->pattern.dense && bounded(w, w->start_J, it->own->h))
        return factor(it, w, w->jacobian, stride, 1);
    /* With additional unknowns pk_gauss_contraction() has left the factors of J(0) in w->lu. */
    const int known = w->closed && contraction > PK_GAUSS_SURE_ONCE && pk_finite(contraction);
    if (!known && !factor(it, w, w->jacobian, stride, at))
        return 0;
    for (int count = 0; at < 1 && count < MOST_POINTS; count++) {
        const pk_real to = pk_min(at + step, 1);
        if (leap(it, w, w->jacobian, stride, at, w->jacobian, stride, to)) {
            at = to;
            step *= 4;
        } else {
            step = (to - at) / 4;
            if (step < LEAST_LEAP * at || !factor(it, w, w->jacobian, stride, at))
                return 0;
        }
    }
    return at >= 1;
}

/* Returns whether J, factored in w->lu, is near its average over the straight path from v0 to V,
 * using G(V) - G(v0) = (average of J) (V - v0). Only this test detects a distant solution beyond a
 * fold. Restores V, Q, P, F and G. */
static int straight(struct pk_integrator *it, struct pk_gauss_work *w)
{
    const size_t n = it->n, m = w->s * n, read = pk_gauss_read(w);
    pk_real most = 0, off = 0;
    pk_copy(w->older_V, w->V, m);
    pk_gauss_rest(it, w);
    if (!pk_gauss_residual(it, w))
        return 0;
    pk_gauss_lu_solve(w, &w->lu, w->s, w->G);
    for (size_t k = 0; k < m; k++) {
        if (k % n >= read)
            continue;
        const pk_real d = w->older_V[k] - it->v[k % n], scale = w->scale[k % n] + PK_TINY;
        most = pk_max(most, pk_abs(d) / scale);
        off = pk_max(off, pk_abs(w->G[k] + d) / scale);
    }
    pk_copy(w->V, w->older_V, m);
    return pk_gauss_residual(it, w) && (off < STRAIGHT * most || off <= PK_GAUSS_ROUND);
}

/* Checks that M is positive definite at the stages; other code checks M at the ends of the step. */
static enum pk_status check_mass(struct pk_integrator *it, const struct pk_gauss_work *w)
{
    const size_t n_q = it->n_q, n = it->n;
    for (size_t i = 0; i < w->s; i++) {
        const pk_real t = it->t + w->c[i] * it->own->h;
        pk_gauss_mass(it, t, w->Q + i * n_q, w->V + i * n, w->M);
        const int failed = pk_gauss_mass_factor(w, w->M);
        if (failed)
            return pk_eval_failed(it, t, w->Q + i * n_q, w->V + i * n, failed);
    }
    return PK_DONE;
}

/* Computes the next point of the continuation, the solution of a step of length `to` h; it is first
 * extrapolated from the last two points. Returns PK_DONE if the solution is found and all matrices
 * between the last point and this one are regular. */
static enum pk_status advance(struct pk_integrator *it, struct pk_gauss_work *w, pk_real h,
                              pk_real was, pk_real at, pk_real to)
{
    const size_t m = w->s * it->n, stride = 4 * w->nn;
    const pk_real further = at > 0 ? (to - at) / (at - was) : 0;
    for (size_t k = 0; k < m; k++)
        w->V[k] = w->old_V[k] + further * (w->old_V[k] - w->older_V[k]);
    it->own->h = to * h;
    pk_gauss_set_step(it, w, it->own->h);
    if (!pk_gauss_iterate(it, w, PK_FULL) || w->kept->first_rate > NEWTON_RATE)
        return PK_AMBIGUOUS_STEP;
    pk_gauss_stage_derivatives(it, w);
    PK_TRY(check_mass(it, w));
    return factor(it, w, w->old_J, stride, at / to) &&
                   leap(it, w, w->old_J, stride, at / to, w->jacobian, stride, 1)
               ? PK_DONE
               : PK_AMBIGUOUS_STEP;
}

static enum pk_status follow(struct pk_integrator *it, struct pk_gauss_work *w)
{
    const size_t n = it->n, s = w->s, nn = w->nn;
    const pk_real h = it->own->h, contraction = pk_gauss_contraction(it, w, w->start_J, 1);
    pk_real was = 0, at = 0, step = PK_C(0.5);
    if (pk_finite(contraction))
        step = pk_min(step, PK_GAUSS_SURE / (contraction + PK_TINY));
    enum pk_status status = PK_DONE;
    for (size_t i = 0; i < s; i++) {
        pk_copy(w->old_J + i * 4 * nn, w->start_J, 4 * nn);
        pk_copy(w->old_V + i * n, it->v, n);
        pk_copy(w->older_V + i * n, it->v, n);
    }
    for (int count = 0; at < 1; count++) {
        const pk_real to = pk_min(at + step, 1);
        status = advance(it, w, h, was, at, to);
        if (status >= 0) {
            pk_copy(w->older_V, w->old_V, s * n);
            pk_copy(w->old_V, w->V, s * n);
            pk_copy(w->old_J, w->jacobian, 4 * s * nn);
            was = at;
            at = to;
            step *= 2;
        } else {
            step = (to - at) / 2;
            if (!(step > LEAST_LEAP * pk_max(at, LEAST_LEAP)) || count > MOST_POINTS)
                break;
        }
    }
    it->own->flags &= ~PK_HAVE_LU;
    it->own->h = h;
    pk_gauss_set_step(it, w, h);
    w->kept->contraction = PK_INFINITY;
    if (status == PK_AMBIGUOUS_STEP)
        it->reason = PK_WHY(.value = pk_abs(at * h));
    return status;
}

static enum pk_status follow_from_start(struct pk_integrator *it, struct pk_gauss_work *w)
{
    pk_gauss_derivatives(it, w, it->t, it->q, it->v, w->start_J);
    const enum pk_status status = follow(it, w);
    if (status != PK_AMBIGUOUS_STEP)
        return status;
    it->reason.kind = PK_BY_NEWTON;
    return PK_NO_CONVERGENCE;
}

enum pk_status pk_gauss_certify(struct pk_integrator *it, struct pk_gauss_work *w)
{
    const size_t stride = 4 * w->nn;
    const pk_real ratio = it->own->flags & PK_HAVE_STEP ? pk_abs(it->own->h / w->kept->last_h) : 0;
    pk_real before = w->kept->last_contraction * ratio * pk_max(ratio, 1);
    if (w->kept->sure > 0)
        return PK_DONE;
    if (!(ratio > 0)) {
        pk_gauss_derivatives(it, w, it->t, it->q, it->v, w->start_J);
        before = pk_gauss_contraction(it, w, w->start_J, 1);
    }
    if (w->kept->contraction <= (w->kept->fresh > 0 ? PK_GAUSS_SURE_ONCE : PK_GAUSS_SURE) &&
        before <= PK_GAUSS_SURE_ONCE)
        return PK_DONE;
    pk_gauss_set_scale(it, w);
    pk_gauss_stage_derivatives(it, w);
    if (ratio > 0)
        pk_gauss_derivatives(it, w, it->t, it->q, it->v, w->start_J);
    w->kept->contraction = pk_gauss_contraction(it, w, w->jacobian, w->s);
    PK_TRY(check_mass(it, w));
    w->kept->lu_h = it->own->h;
    it->own->flags |= PK_HAVE_LU;
    if (w->kept->contraction <= PK_GAUSS_SURE_ONCE &&
        pk_gauss_contraction(it, w, w->start_J, 1) <= PK_GAUSS_SURE_ONCE)
        return factor(it, w, w->jacobian, stride, 1) ? PK_DONE : follow(it, w);
    if (regular(it, w)) {
        const pk_real varied = apart(w, w->start_J, 0, 1);
        if (varied < REGULAR && (w->kept->noisy > 0 || straight(it, w))) {
            w->kept->sure = varied <= LASTING;
            return PK_DONE;
        }
    }
    return follow(it, w);
}

enum pk_status pk_gauss_solve(struct pk_integrator *it, struct pk_gauss_work *w)
{
    if (it->options.iteration == PK_FIXED_POINT) {
        it->reason.kind = PK_BY_FIXED_POINT;
        if (!pk_gauss_iterate(it, w, PK_BY_MASS))
            return PK_NO_CONVERGENCE;
        /* If all iterations contracted, V is the solution nearest to the guess. */
        w->kept->contraction = w->kept->worst_rate <= PK_GAUSS_FAST ? 0 : PK_INFINITY;
        return pk_gauss_certify(it, w);
    }
    if (pk_gauss_iterate(it, w, PK_SIMPLIFIED))
        return pk_gauss_certify(it, w);
    pk_gauss_rest(it, w);
    if (!pk_gauss_residual(it, w))
        return PK_NOT_FINITE; /* V = v0 is the safest guess */
    const int converged = pk_gauss_iterate(it, w, PK_FULL);
    it->own->flags &= ~PK_HAVE_LU;
    return converged ? pk_gauss_certify(it, w) : follow_from_start(it, w);
}

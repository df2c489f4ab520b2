/* Implicit Runge-Kutta methods at a fixed step in (q, p): Gauss, Lobatto IIIA-IIIB, Radau IIA. With
 * the stage rates V_i as unknowns, a_ij = mu_ij b_j for q, a^_ij = mu^_ij b_j for p, t_i = t0 +
 * c_i h:
 *
 *     Q_i = q0 + h sum a_ij V_j
 *     G_i = p(Q_i, V_i, t_i) - p0 - h sum a^_ij pdot(Q_j, V_j, t_j) = 0
 *     q1  = q0 + h sum b_i V_i,   p1 = p0 + h sum b_i pdot_i,   v1 from p(q1, v1, t1) = p1
 *
 * This is the method for Hamilton's equations (with forces), since V = dH/dp and pdot = -dH/dq
 * there. It is symplectic where a^_ij = b_j (1 - a_ji / b_i), the conjugate of a, for every L,
 * M(q, v) included: Gauss with a^ = a, Lobatto with IIIA for q and IIIB for p. That row of IIIA
 * which is zero makes Q_1 = q0, that column of IIIB leaves pdot_s out of the stages; each V_i is
 * still determined, since dG_i/dV_i is M at h = 0. Radau has a^ = a, its last stage is the end of
 * the step, and it damps what is fast.
 * p is the state carried from step to step; v1 is recovered and errs by round-off alone. The
 * products h b_i are made so that they sum to h, and mu_ij + mu^_ji = 1 exactly; both sums are
 * compensated. Here is the step; the equations are solved in newton.c.
 *
 * gauss8 has its stages in the lanes of one kernel where the system is separable: gauss_nystrom.c.
 *
 * References: E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration, 2nd ed., II.1.3,
 * II.2, VI.4, VIII.6; E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, IV.8;
 * M. Antonana, J. Makazaga, A. Murua, Numer. Algorithms 76 (2017) 861.
 */
#include <string.h>

#include "gauss.h"

size_t pk_gauss_size(const struct pk_method *method, size_t n)
{
    const struct pk_gauss *table = (const struct pk_gauss *)method->table;
    const size_t s = (size_t)table->stages, m = s * n;
    return 11 * m + 13 * s * n * n + 2 * m * m + 6 * n * n + 3 * n +
           6 * s * s + s * s * s + 2 * s + 20 +
           (s == PK_LANES ? pk_gauss_nystrom_size(n) : 0);
}

struct pk_gauss_work pk_gauss_parts(struct pk_integrator *it)
{
    struct pk_gauss_work w;
    const struct pk_gauss *table = (const struct pk_gauss *)it->method->table;
    const size_t n = it->n, s = (size_t)table->stages, m = s * n;
    pk_real *x = it->work;
    w.table = table;
    w.s = s;
    w.V = x, x += m;
    w.Q = x, x += m;
    w.P = x, x += m;
    w.F = x, x += m;
    w.G = x, x += m;
    w.last_V = x, x += m;
    w.pivot = x, x += m;
    w.jacobian = x, x += 5 * s * n * n;
    w.lu = x, x += m * m;
    w.mass = x, x += n * n;
    w.mean_q = x, x += n;
    w.mean_v = x, x += n;
    w.scale = x, x += n;
    w.mu = x, x += s * s;
    w.mu_p = x, x += s * s;
    w.hA = x, x += s * s;
    w.hA_p = x, x += s * s;
    w.predict = x, x += s * (s + 1);
    w.hb = x, x += s;
    w.h = x++, w.lu_h = x++, w.ratio = x++, w.last_h = x++, w.best = x++;
    w.wait = x++, w.patience = x++, w.slow_h = x++;
    w.contraction = x++, w.last_contraction = x++, w.sure = x++, w.fresh = x++;
    w.first_rate = x++, w.worst_rate = x++;
    w.loose = x++, w.loose_for = x++;
    w.norms = x, x += 3;
    w.hh = x, x += s * s * s;
    w.mu_columns = x, x += s * s;
    w.start_J = x, x += 4 * n * n;
    w.before_J = x, x += 4 * s * n * n;
    w.noisy = x++;
    w.old_J = x, x += 4 * s * n * n;
    w.old_V = x, x += m;
    w.older_V = x, x += m;
    w.x = x, x += m;
    w.y = x, x += m;
    w.other = x, x += m * m + n * n;
    w.rest = x;
    return w;
}

enum pk_status pk_gauss_init(struct pk_integrator *it)
{
    const struct pk_gauss_work w = pk_gauss_parts(it);
    pk_real *p = pk_part(it->state, it->n, PK_P);
    for (size_t i = 0; i < w.s; i++)
        for (size_t j = 0; j < w.s; j++) {
            pk_real *mu = &w.mu[i * w.s + j], *conjugate = &w.mu_p[j * w.s + i];
            *mu = w.table->mu[j * w.s + i];
            if (!w.table->conjugate)
                w.mu_p[i * w.s + j] = *mu;
            else if (*mu >= PK_C(0.5))
                *conjugate = PK_C(1.0) - *mu; /* exact, as is the next 1 - x */
            else
                *conjugate = PK_C(1.0) - *mu, *mu = PK_C(1.0) - *conjugate;
            w.mu_columns[j * w.s + i] = *mu;
        }
    *w.contraction = *w.last_contraction = PK_INFINITY;
    *w.sure = *w.loose_for = *w.fresh = *w.noisy = 0;
    *w.slow_h = *w.h = *w.lu_h = *w.ratio = *w.last_h = *w.best = *w.wait = *w.patience = 0;
    pk_eval_canonical(it, it->t, it->q, it->v, p, w.F);
    it->p = p;
    return pk_all_finite(p, it->n) ? PK_DONE : PK_NOT_FINITE;
}

/* h b_i, mending the outer two, or the last, so that their sum is h; then h a_ij = mu_ij h b_j. */
void pk_gauss_set_step(struct pk_integrator *it, struct pk_gauss_work *w, pk_real h)
{
    const size_t s = w->s;
    pk_real inner = 0;
    for (size_t i = 0; i < s; i++)
        w->hb[i] = h * w->table->b[i];
    for (size_t i = 1; i + 1 < s; i++)
        inner += w->hb[i];
    if (!(it->method->traits & PK_SYMMETRIC))
        w->hb[s - 1] = h - (w->hb[0] + inner);
    else if (s > 1)
        w->hb[0] = w->hb[s - 1] = (h - inner) / 2;
    for (size_t i = 0; i < s * s; i++) {
        w->hA[i] = w->mu[i] * w->hb[i % s];
        w->hA_p[i] = w->mu_p[i] * w->hb[i % s];
    }
    memset(w->norms, 0, 3 * sizeof *w->norms);
    for (size_t i = 0; i < s; i++) {
        pk_real sums[3] = {0, 0, 0};
        for (size_t j = 0; j < s; j++) {
            for (size_t r = 0; r < s; r++) {
                const pk_real both = w->hA_p[i * s + r] * w->hA[r * s + j];
                w->hh[(i * s + j) * s + r] = both;
                sums[2] += pk_abs(both);
            }
            sums[0] += pk_abs(w->hA[i * s + j]);
            sums[1] += pk_abs(w->hA_p[i * s + j]);
        }
        for (int k = 0; k < 3; k++)
            w->norms[k] = pk_max(w->norms[k], sums[k]);
    }
    *w->h = h;
}

/* Row i holds the weights by which the last step's stages and its end (nodes c_j and 1) give the
 * value at 1 + c_i h / last_h; where the last stage is at the end, the stages alone. */
static void set_predictor(struct pk_gauss_work *w, pk_real ratio)
{
    const size_t s = w->s, nodes = w->table->c[s - 1] < 1 ? s + 1 : s;
    for (size_t i = 0; i < s; i++)
        for (size_t j = 0; j <= s; j++) {
            const pk_real x = PK_C(1.0) + ratio * w->table->c[i];
            const pk_real xj = j < s ? w->table->c[j] : PK_C(1.0);
            pk_real weight = j < nodes;
            for (size_t k = 0; k < nodes && j < nodes; k++) {
                const pk_real xk = k < s ? w->table->c[k] : PK_C(1.0);
                if (k != j)
                    weight *= (x - xk) / (xj - xk);
            }
            w->predict[i * (s + 1) + j] = weight;
        }
    *w->ratio = ratio;
}

void pk_gauss_predict(struct pk_integrator *it, struct pk_gauss_work *w)
{
    const size_t n = it->n, s = w->s;
    const pk_real ratio = it->flags & PK_HAVE_STEP ? it->h / *w->last_h : 0;
    if (!(pk_abs(ratio) > 0) || !(pk_abs(ratio) <= PK_GAUSS_REACH)) {
        for (size_t i = 0; i < s; i++)
            memcpy(w->V + i * n, it->v, n * sizeof *w->V);
        return;
    }
    if (ratio > *w->ratio || ratio < *w->ratio)
        set_predictor(w, ratio);
    for (size_t i = 0; i < s; i++)
        for (size_t k = 0; k < n; k++) {
            pk_real v = w->predict[i * (s + 1) + s] * it->v[k];
            for (size_t j = 0; j < s; j++)
                v += w->predict[i * (s + 1) + j] * w->last_V[j * n + k];
            w->V[i * n + k] = v;
        }
}

/* v from p(q, v, t) = p, starting at v; Newton on M, one linear solve where p is affine in v. */
static enum pk_status recover_rates(struct pk_integrator *it, const struct pk_gauss_work *w,
                                    pk_real t, const pk_real *q, const pk_real *p, pk_real *v)
{
    const struct pk_system *system = it->problem.system;
    const size_t n = it->n;
    const int once = (system->facts & PK_QUADRATIC) != 0;
    const int constant = (system->facts & PK_MASS_CONSTANT) != 0;
    pk_real *r = w->G, before = 0;

    for (int count = 0; count < 50; count++) {
        pk_eval_canonical(it, t, q, v, r, w->F);
        if (!pk_all_finite(r, n))
            return PK_NOT_FINITE;
        for (size_t i = 0; i < n; i++)
            r[i] = p[i] - r[i];
        if (!constant || !(it->flags & PK_HAVE_A)) {
            system->mass(it->problem.params, t, q, v, pk_eval_input(it, t), w->mass);
            const size_t failed = pk_ldl_factor(w->mass, n);
            if (failed)
                return pk_eval_failed(it, t, q, v, (int)failed);
            it->flags |= PK_HAVE_A;
        }
        pk_ldl_solve(w->mass, n, r);
        pk_real size = 0, scale = 0;
        for (size_t i = 0; i < n; i++) {
            v[i] += r[i];
            size = pk_max(size, pk_abs(r[i]));
            scale = pk_max(scale, pk_abs(v[i]));
        }
        if (once || size <= PK_EPS * scale)
            return PK_DONE;
        if (count && size >= before / 2 && size <= PK_GAUSS_ROUND * scale)
            return PK_DONE; /* corrections no longer shrink: they are round-off */
        before = size;
    }
    it->detail = before;
    it->where = PK_OF_RATES;
    return PK_NO_CONVERGENCE;
}

enum pk_status pk_gauss_step(struct pk_integrator *it, pk_real limit)
{
    struct pk_gauss_work w = pk_gauss_parts(it);
    const size_t n = it->n;
    (void)limit;
    if (it->h > *w.h || it->h < *w.h)
        pk_gauss_set_step(it, &w, it->h);
    if (pk_gauss_by_lanes(it, &w, it->h)) {
        const enum pk_status status = pk_gauss_nystrom_step(it, &w);
        if (status != PK_NO_CONVERGENCE)
            return status;
        *w.slow_h = it->h; /* too long for fixed points, and not for Newton */
        memset(pk_part(it->state, n, PK_LOW_X), 0, n * sizeof *w.V); /* it was that of v */
        it->flags = 0;
    }
    pk_gauss_predict(it, &w);
    const enum pk_status status = pk_gauss_solve(it, &w);
    if (status < 0) {
        it->flags &= ~PK_HAVE_LU;
        return status;
    }
    return pk_gauss_finish(it, &w);
}

enum pk_status pk_gauss_finish(struct pk_integrator *it, struct pk_gauss_work *w)
{
    const size_t n = it->n, s = w->s;
    enum pk_status status = PK_DONE;
    memcpy(it->next, it->state, PK_PARTS * n * sizeof *w->V);
    pk_real *q = pk_part(it->next, n, PK_Q), *v = pk_part(it->next, n, PK_V);
    pk_real *p = pk_part(it->next, n, PK_P);
    pk_real *low_q = pk_part(it->next, n, PK_LOW_Q), *low_p = pk_part(it->next, n, PK_LOW_X);
    for (size_t k = 0; k < n; k++) {
        pk_real dq = 0, dp = 0;
        for (size_t i = 0; i < s; i++) {
            dq += w->hb[i] * w->V[i * n + k];
            dp += w->F[i * n + k];
        }
        q[k] = pk_sum(q[k], dq, &low_q[k]);
        p[k] = pk_sum(p[k], dp, &low_p[k]);
        v[k] = w->V[(s - 1) * n + k];
    }
    if (!pk_all_finite(it->next, PK_LOW_Q * n))
        return PK_NOT_FINITE;
    if (w->table->c[s - 1] < 1 || w->table->conjugate)
        status = recover_rates(it, w, it->next_t, q, p, v);
    else /* p0 + h sum b_i pdot_i would multiply what V errs by with a stiff h pdot_v */
        memcpy(p, w->P + (s - 1) * n, n * sizeof *p), memset(low_p, 0, n * sizeof *p);
    if (status < 0 || !pk_all_finite(v, n))
        return status < 0 ? status : PK_NOT_FINITE;
    memcpy(w->last_V, w->V, s * n * sizeof *w->V);
    *w->last_h = it->h;
    *w->last_contraction = *w->contraction;
    it->flags |= PK_HAVE_STEP;
    return PK_DONE;
}

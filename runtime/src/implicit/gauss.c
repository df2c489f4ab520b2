/* Implicit Runge-Kutta methods at a fixed step in (q, p): Gauss, Lobatto IIIA-IIIB, Radau IIA. With
 * the stage rates V_i as unknowns, a_ij = mu_ij b_j for q, a^_ij = mu^_ij b_j for p, t_i = t0 +
 * c_i h:
 *
 *     Q_i = q0 + h sum a_ij V_j
 *     G_i = p(Q_i, V_i, t_i) - p0 - h sum a^_ij pdot(Q_j, V_j, t_j) = 0
 *     q1  = q0 + h sum b_i V_i,   p1 = p0 + h sum b_i pdot_i,   v1 from p(q1, v1, t1) = p1
 *
 * This is the method for Hamilton's equations (with forces), since V = dH/dp and pdot = -dH/dq
 * there. It is symplectic where a^_ij = b_j (1 - a_ji / b_i), the conjugate of a, for every L, M(q,
 * v) included: Gauss with a^ = a, Lobatto with IIIA for q and IIIB for p. The first row of IIIA is
 * zero, so Q_1 = q0; the last column of IIIB is zero, so no stage depends on pdot_s; each V_i is
 * still determined, since dG_i/dV_i is M at h = 0. Radau has a^ = a, its last stage is the end of
 * the step, and it damps fast motion. The state at the end of a step is (q, p); v1 is computed from
 * p1 and has only round-off errors. The products h b_i sum to h exactly, and mu_ij + mu^_ji = 1
 * exactly; the sums for q1 and p1 are compensated. newton.c solves the equations.
 *
 * For a separable system gauss8 evaluates the stages in the SIMD lanes of one kernel:
 * gauss_nystrom.c.
 *
 * References: E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration, 2nd ed., II.1.3,
 * II.2, VI.4, VIII.6; E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, IV.8;
 * M. Antonana, J. Makazaga, A. Murua, Numer. Algorithms 76 (2017) 861. */

#include "gauss.h"

/* Sets row i of w->predict to the weights that extrapolate stage rates from the last step to stage
 * i of the next step, which is at 1 + c_i h / last_h in units of the last step. They apply to the
 * last step's stages (nodes c_j) and its end (node 1); or, if the last stage is the end, to
 * stages. */
static void set_predictor(struct pk_gauss_work *w, pk_real ratio)
{
    const size_t s = w->s, nodes = w->c[s - 1] < 1 ? s + 1 : s;
    for (size_t i = 0; i < s; i++)
        for (size_t j = 0; j <= s; j++) {
            const pk_real x = 1 + ratio * w->c[i], xj = j < s ? w->c[j] : 1;
            pk_real weight = j < nodes;
            for (size_t k = 0; k < nodes && j < nodes; k++) {
                const pk_real xk = k < s ? w->c[k] : 1;
                if (k != j)
                    weight *= (x - xk) / (xj - xk);
            }
            w->predict[i * (s + 1) + j] = weight;
        }
    w->kept->ratio = ratio;
}

void pk_gauss_predict(struct pk_integrator *it, struct pk_gauss_work *w)
{
    const size_t n = it->n, s = w->s;
    const pk_real ratio = it->own->flags & PK_HAVE_STEP ? it->own->h / w->kept->last_h : 0;
    if (!(pk_abs(ratio) > 0) || !(pk_abs(ratio) <= PK_GAUSS_REACH)) {
        pk_gauss_rest(it, w);
        return;
    }
    if (ratio > w->kept->ratio || ratio < w->kept->ratio)
        set_predictor(w, ratio);
    for (size_t i = 0; i < s; i++)
        for (size_t k = 0; k < n; k++) {
            pk_real v = w->predict[i * (s + 1) + s] * it->v[k];
            for (size_t j = 0; j < s; j++)
                v += w->predict[i * (s + 1) + j] * w->last_V[j * n + k];
            w->V[i * n + k] = v;
        }
}

/* Solves p(q, v, t) = p for v from v by Newton's method with M; once if p is affine in v. */
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
        if (!constant || !(it->own->flags & PK_HAVE_A)) {
            pk_gauss_mass(it, t, q, v, w->mass);
            const int failed = pk_gauss_mass_factor(w, w->mass);
            if (failed)
                return pk_eval_failed(it, t, q, v, failed);
            it->own->flags |= PK_HAVE_A;
        }
        pk_gauss_mass_solve(w, w->mass, r);
        pk_real size = 0, scale = 0;
        for (size_t i = 0; i < n; i++) {
            v[i] += r[i];
            size = pk_max(size, pk_abs(r[i]));
            scale = pk_max(scale, pk_abs(v[i]));
        }
        if (once || size <= PK_EPS * scale)
            return PK_DONE;
        if (count && size >= before / 2 && size <= PK_GAUSS_ROUND * scale)
            return PK_DONE; /* corrections at round-off no longer decrease */
        before = size;
    }
    return pk_fail_with(it, PK_NO_CONVERGENCE, PK_WHY(.kind = PK_OF_RATES, .value = before));
}

static enum pk_status gauss_step(struct pk_integrator *it, pk_real limit)
{
    struct pk_integrator_private *const own = it->own;
    struct pk_gauss_work w = pk_gauss_parts(it);
    const size_t n = it->n;
    (void)limit;
    if (own->h > w.kept->h || own->h < w.kept->h)
        pk_gauss_set_step(it, &w, own->h);
    if (pk_gauss_by_lanes(it, &w, own->h)) {
        const enum pk_status status = pk_gauss_nystrom_step(it, &w);
        if (status != PK_NO_CONVERGENCE)
            return status;
        w.kept->slow_h = own->h;            /* too long for fixed-point iteration */
        pk_zero(pk_state(it, PK_LOW_X), n); /* LOW_X held the low part of v */
        own->flags = 0;
    }
    pk_gauss_predict(it, &w);
    const enum pk_status status = pk_gauss_solve(it, &w);
    if (status < 0) {
        own->flags &= ~PK_HAVE_LU;
        return status;
    }
    return pk_gauss_finish(it, &w);
}

enum pk_status pk_gauss_finish(struct pk_integrator *it, struct pk_gauss_work *w)
{
    const size_t n = it->n, s = w->s;
    pk_copy(it->own->next, it->own->state, pk_state_offset(w->n_q, n, PK_PARTS));
    pk_real *q = pk_next(it, PK_Q), *v = pk_next(it, PK_V), *p = pk_next(it, PK_P);
    pk_real *low_q = pk_next(it, PK_LOW_Q), *low_p = pk_next(it, PK_LOW_X);
    for (size_t k = 0; k < n; k++) {
        pk_real dq = 0, dp = 0;
        for (size_t i = 0; i < s; i++) {
            dq += w->hb[i] * w->V[i * n + k];
            dp += w->F[i * n + k];
        }
        if (k < w->n_q)
            q[k] = pk_sum(q[k], dq, &low_q[k]);
        p[k] = pk_sum(p[k], dp, &low_p[k]);
        v[k] = w->V[(s - 1) * n + k];
    }
    if (!pk_all_finite(it->own->next, pk_state_offset(w->n_q, n, PK_LOW_Q)))
        return PK_NOT_FINITE;
    if (w->c[s - 1] < 1 || w->table->conjugate)
        PK_TRY(recover_rates(it, w, it->own->next_t, q, p, v));
    else /* p0 + h sum b_i pdot_i would amplify the error of V by a stiff h pdot_v */
        pk_copy(p, w->P + (s - 1) * n, n), pk_zero(low_p, n);
    if (!pk_all_finite(v, n))
        return PK_NOT_FINITE;
    pk_copy(w->last_V, w->V, s * n);
    w->kept->last_h = it->own->h;
    w->kept->last_contraction = w->kept->contraction;
    it->own->flags |= PK_HAVE_STEP;
    return PK_DONE;
}

#define COLLOCATION(of)                                                              \
    .needs = PK_NEEDS_COLLOCATION, .table = &pk_##of##_table, .size = pk_gauss_size, \
    .init = pk_gauss_init, .step = gauss_step, .equations = pk_gauss_equations,      \
    .last = pk_gauss_last
PK_METHODS_COLLOCATION(PK_DEFINE_METHOD, COLLOCATION)

/* Variational steps on R^n x SO(3)^b for any L, with holonomic constraints at their ends: the
 * discrete Lagrangian is h L at the middle (lie_midpoint), or h/2 of L at each end (rattle), with
 * v = (q1 - q0)/h and, for a rotation, R0 = R C^T, R1 = R C, C = cay(x), x = h omega/2. From
 *
 *     p0 = -D1 L_d,   p1 = D2 L_d,      P of a rotation in the body frame of its end,
 *
 * with y = x/2, s = 1 + |y|^2, Pi = dL/domega, G = X L + torque, f = dL/dq + Q:
 *
 *     middle   p = p0 + h/2 f = p1 - h/2 f          s Pi = C^T P0 + h/2 (G - y x G)
 *                                                   P1 = C^T (C^T P0 + h G)
 *     ends     (p_0 + p_1)/2 = p0 + h/2 f_0         s (Pi_0 + Pi_1)/2 = C^T (P0 + h/2 G_0)
 *              p1 = p0 + h/2 (f_0 + f_1)            P1 = C^T C^T (P0 + h/2 G_0) + h/2 G_1
 *
 * Constraints: at the start, a kick J(q0)^T mu of p0 and P0 makes phi(q1) = 0; at the end, a kick
 * of p1 and P1 makes J v + j0 = 0. The steps are symplectic and symmetric, and conserve the momenta
 * of symmetries, such as the vector R P of a free body, however well the equations are solved.
 * Without rotations and constraints lie_midpoint is the implicit midpoint rule in (q, p), rattle
 * extends Verlet to any L; with constraints it is RATTLE. First-order variables follow the midpoint
 * or the trapezoidal rule. The state of the method is p and P, with compensated sums; v is computed
 * from them. Methods of order 4 and 6 are compositions.
 *
 * References: E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration, VI.6, VII.1.3-4,
 * VII.5; H. C. Andersen, J. Comput. Phys. 52 (1983) 24; J. E. Marsden, S. Pekarsky, S. Shkoller,
 * Nonlinearity 12 (1999) 1647; N. Bou-Rabee, J. E. Marsden, Found. Comput. Math. 9 (2009) 197;
 * S. Hante, M. Arnold, J. Comput. Appl. Math. 387 (2021) 112492; J. C. Simo, K. K. Wong, Int. J.
 * Numer. Methods Eng. 31 (1991) 19. */

#include "variational.h"

#include <pk/step/tables.h>

static enum pk_status variational_init(struct pk_integrator *it)
{
    const struct pk_variational_work w = pk_variational_parts(it);
    pk_real *p = pk_state(it, PK_P);
    pk_zero(w.kick, w.n);
    pk_variational_momenta(it, it->t, it->q, it->v, p, w.f);
    it->p = p;
    return pk_all_finite(p, it->n) ? PK_DONE : PK_NOT_FINITE;
}

/* Advances p0 to p1 with compensated sums. */
static void add_momenta(const struct pk_variational_work *w, pk_real *p, pk_real *low)
{
    const int ends = w->table->ends;
    const pk_real half = w->h / 2;
    for (size_t k = 0; k < w->rotation; k++) {
        const pk_real force = ends ? half * (w->f[k] + w->f_end[k]) : w->h * w->f[k];
        p[k] = pk_sum(p[k], w->pull[k] + force, &low[k]);
    }
    for (size_t r = 0; r < w->turned; r++) {
        const struct pk_turning at = pk_variational_turning(w, r);
        pk_real omega[3], Pi[3], Pi_end[3];
        pk_gather(omega, w->V + at.rate, 3, at.step);
        pk_gather(Pi, w->p + at.rate, 3, at.step);
        pk_gather(Pi_end, w->p_end + at.rate, 3, at.step);
        const pk_real yy = w->h * w->h * pk_dot3(omega, omega) / 16;
        const pk_real weight = w->h / 2 / (1 + yy); /* quaternion of C C: (1 - yy, 2 y)/(1 + yy) */
        const pk_real back[3] = {-weight * omega[0], -weight * omega[1], -weight * omega[2]};
        pk_real y[3], G[3], G_end[3], before[3], turned[3], torque[3];
        pk_variational_y(w, omega, y);
        pk_cross(Pi, omega, G);
        pk_cross(Pi_end, omega, G_end);
        for (size_t i = 0; i < 3; i++) {
            const size_t k = at.rate + i * at.step;
            G[i] = w->f[k] - G[i];
            G_end[i] = w->f_end[k] - G_end[i];
            before[i] = p[k] + low[k] + w->pull[k] + (ends ? half * G[i] : 0);
        }
        pk_turn_added((1 - yy) / (1 + yy), back, before, turned);
        pk_cayley_turn(y, -1, G, torque);
        for (size_t i = 0; i < 3; i++) {
            const size_t k = at.rate + i * at.step;
            const pk_real force = ends ? half * (G[i] + G_end[i]) : w->h * torque[i];
            p[k] = pk_sum(p[k], w->pull[k] + force + turned[i], &low[k]);
        }
    }
}

/* Guesses V by extrapolation, for each rate on a line through its values at the middle and the end
 * of the last part, and guesses the kick. */
static void guess(struct pk_integrator *it, struct pk_variational_work *w, const pk_real *v)
{
    const int before = it->own->flags & PK_HAVE_STEP; /* otherwise last_V is not set */
    const pk_real ratio = before && pk_abs(w->h / *w->last_h) <= 64 ? w->h / *w->last_h : 0;
    for (size_t k = 0; k < w->n; k++) {
        const int turns = k >= w->m && k < w->states; /* quaternions are no unknowns */
        w->V[k] = k < w->m ? v[k] : turns || !before ? 0 : w->last_V[k];
        if (before && k < w->m)
            w->V[k] += ratio * (v[k] - w->last_V[k]);
    }
    for (size_t i = 0; i < w->c; i++)
        w->kick[i] *= ratio;
}

static enum pk_status part(struct pk_integrator *it, struct pk_variational_work *w)
{
    const size_t n = w->n;
    pk_real *q = pk_variational_to(w, PK_Q), *v = pk_variational_to(w, PK_V);
    pk_real *p = pk_variational_to(w, PK_P), *low_p = pk_variational_to(w, PK_LOW_X);
    guess(it, w, v);
    const int known = it->own->flags & PK_HAVE_A; /* M and the forces are those of this state */
    if (!known)
        pk_variational_momenta(it, w->t, q, v, w->spare, w->f_start);
    if (!known || !w->whole) /* the factors of [M J^T; J 0] may be overwritten */
        PK_TRY(pk_variational_mass(it, w, w->t, q, v));
    it->own->flags &= ~PK_HAVE_A;
    PK_TRY(pk_variational_solve(it, w));
    add_momenta(w, p, low_p);
    pk_copy(q, w->q_end, w->rotation);
    pk_copy(pk_variational_to(w, PK_LOW_Q), w->low_q, w->rotation);
    pk_copy(v + w->m, w->v_end + w->m, n - w->m);
    pk_copy(low_p + w->m, w->low_v + w->m, n - w->m);
    for (size_t r = 0; r < w->turned; r++) {
        const struct pk_turning at = pk_variational_turning(w, r);
        if (pk_normalise(v + at.number, low_p + at.number, at.step) < 0)
            return PK_NOT_FINITE;
    }
    pk_copy(p + w->m, v + w->m, n - w->m);
    if (!pk_all_finite(q, w->rotation) || !pk_all_finite(p, n))
        return PK_NOT_FINITE;
    pk_copy(v, w->V, w->m); /* initial guess of pk_variational_rates() */
    const enum pk_status status = pk_variational_rates(it, w, p, low_p);
    pk_copy(w->last_V, w->V, n);
    *w->last_h = w->h;
    it->own->flags |= status < 0 ? 0 : PK_HAVE_STEP | PK_HAVE_A;
    return status;
}

static enum pk_status variational_step(struct pk_integrator *it, pk_real limit)
{
    struct pk_integrator_private *const own = it->own;
    struct pk_variational_work w = pk_variational_parts(it);
    const struct pk_splitting *parts = w.table->parts;
    enum pk_status status = PK_DONE;
    pk_real done = 0;
    (void)limit;
    pk_copy(own->next, own->state, pk_state_offset(it->n_q, it->n, PK_PARTS));
    w.to = own->next;
    for (int i = 0; i < parts->stages && status >= 0; i++) {
        w.t = it->t + done * own->h;
        done += parts->drift[i];
        w.end = i + 1 == parts->stages ? own->next_t : it->t + done * own->h;
        w.h = parts->drift[i] * own->h;
        status = part(it, &w);
    }
    return status;
}

#define VARIATIONAL(of, ends)                                                                     \
    .table = &(const struct pk_variational){&pk_##of##_table, ends}, .size = pk_variational_size, \
    .init = variational_init, .step = variational_step
#define LIE_MIDPOINT(of) .needs = PK_NEEDS_LIE_MIDPOINT, VARIATIONAL(of, 0)
#define RATTLE(of) .needs = PK_NEEDS_RATTLE, VARIATIONAL(of, 1)
PK_METHODS_LIE_MIDPOINT(PK_DEFINE_METHOD, LIE_MIDPOINT)
PK_METHODS_RATTLE(PK_DEFINE_METHOD, RATTLE)

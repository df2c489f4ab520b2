/* Solves the equations of a variational step, r(V) = 0 for the rates V of its middle and phi(q1) =
 * 0 for the kick J(q0)^T mu of its start; see variational.c. The first iteration uses M at the
 * start as its matrix: it contracts for h omega below 2, and fast if h omega is small. If it does
 * not contract well, there may be several solutions. Newton's method with differences of r then
 * follows the branch that begins at short steps. Its matrix is M at h = 0, and its determinant must
 * not change sign. Derivatives of phi are always exact.
 *
 * An iteration ends as in newton.c, far below round-off, with phi within the rounding of its terms.
 * For this, the scale of a coordinate includes its terms in phi divided by J. */

#include "variational.h"

enum { BY_MASS_MOST = 1000, BY_NEWTON_MOST = 50, PATIENCE = 12 };

/* The solution counts as the one nearest the guess if the largest ratio of successive corrections
 * above FAR is at most FAST (iteration with M) or SURE (Newton's method). GENTLE is the limit of
 * the change of r - M V in the step, relative to the rates. FIRST and SHORTEST are the first and
 * the least part of the step in follow(). */
#define FAR PK_C(0.1)
#define FAST PK_C(0.7)
#define SURE PK_C(0.5)
#define GENTLE PK_C(0.5)
#define FIRST PK_C(0.125)
#define SHORTEST (PK_C(1.0) / 16777216)
/* A phi up to this counts as 0, in units of its rounding error, which comes from the terms of phi
 * and from q1 = q0 + h V; see project.c. */
#define ROUND PK_C(4.0)
#define STALLED (1024 * PK_EPS)

/* Computes the distance by which coordinates move in a step; for a body rate the angle by which the
 * body turns, from all three rates, since they mix. */
static void set_moved(const struct pk_variational_work *w, pk_real *moved)
{
    for (size_t k = 0; k < w->rotation; k++)
        moved[k] = pk_abs(w->h * w->V[k]);
    for (size_t r = 0; r < w->turned; r++) {
        const struct pk_turning at = pk_variational_turning(w, r);
        pk_real turn[3];
        pk_gather(turn, w->V + at.rate, 3, at.step);
        for (size_t i = 0; i < 3; i++)
            moved[at.rate + i * at.step] = pk_abs(w->h) *
                                           (pk_abs(turn[0]) + pk_abs(turn[1]) + pk_abs(turn[2]));
    }
}

/* Returns the largest phi at the end, in units of the rounding of its terms and of q1 = q0 + h V;
 * sets w->at.J to J there. */
static pk_real broken(struct pk_integrator *it, struct pk_variational_work *w)
{
    struct pk_projection *at = &w->at;
    pk_real worst = 0, *size = at->mu;
    at->t = w->end;
    at->u = pk_eval_input(it, w->end);
    pk_project_rows(at, w->q_end, w->v_end);
    pk_project_terms(at, w->q_end, w->v_end);
    set_moved(w, w->spare);
    pk_project_spread(at, w->q_end, w->v_end, at->J, w->c, w->spare, size);
    for (size_t i = 0; i < w->c; i++) {
        const pk_real ratio = pk_abs(at->phi[i]) / (PK_EPS * (at->phi_size[i] + PK_TINY + size[i]));
        worst = ratio <= worst ? worst : ratio; /* NaN is kept as the worst */
    }
    return worst;
}

/* Sets the scale of rounding of V: V itself, momenta and forces, and coordinates divided by h. If
 * phi adds constants to coordinates, as in (a + x)^2, these count as the motion that changes phi by
 * as much as its terms. */
static void set_scale(struct pk_variational_work *w)
{
    const pk_real *q = pk_variational_to(w, PK_Q), *v = pk_variational_to(w, PK_V);
    const pk_real *p = pk_variational_to(w, PK_P);
    for (size_t k = 0; k < w->n; k++) {
        const pk_real x = k < w->rotation ? q[k] : k < w->states ? 1 : v[k];
        const pk_real rate = k < w->m ? pk_max(pk_abs(v[k]), pk_abs(w->V[k])) : pk_abs(w->V[k]);
        w->scale[k] = pk_max(rate, pk_abs(x / w->h));
    }
    for (size_t k = 0; k < w->m; k++) {
        const pk_real sum = pk_max(pk_abs(p[k]), pk_abs(w->h * w->f[k]));
        w->scale[k] = pk_max(w->scale[k], sum / (w->root[k] * w->root[k]));
    }
    /* spare: the shortest motion, in the metric of M, that changes phi by as much as its terms */
    if (w->c && !w->whole) {
        w->at.system->constraints.solve(w->at.params, NULL, w->at.phi_size, w->spare, w->at.mu);
        for (size_t k = 0; k < w->m; k++)
            w->scale[k] = pk_max(w->scale[k], pk_abs(w->spare[k] / w->h));
    }
    for (size_t i = 0; i < w->c && w->whole; i++) {
        const pk_real *J = w->at.J + i * w->n;
        pk_real all = PK_TINY;
        for (size_t k = 0; k < w->m; k++)
            all += J[k] / w->root[k] * (J[k] / w->root[k]);
        for (size_t k = 0; k < w->m; k++) {
            const pk_real x = w->at.phi_size[i] * J[k] / (w->root[k] * w->root[k]) / all;
            w->scale[k] = pk_max(w->scale[k], pk_abs(x / w->h));
        }
    }
}

/* Raises the scale after the first correction to at least the change of rates in the step, in the
 * metric of M, so that rates that begin at 0 have a scale too. Sets w->jump to the size of this
 * correction, without first-order variables that begin at 0, since these had no scale. */
static void raise_scale(struct pk_variational_work *w)
{
    const pk_real *v = pk_variational_to(w, PK_V);
    pk_real change = PK_TINY;
    w->jump = 0;
    for (size_t k = 0; k < w->m; k++)
        change = pk_max(change, pk_abs(w->V[k] + w->dV[k] - v[k]) * w->root[k]);
    for (size_t k = 0; k < w->n; k++) {
        const pk_real other = k < w->m ? change / w->root[k] : pk_abs(w->V[k] + w->dV[k]);
        const int at_rest = k >= w->states && !(w->scale[k] > 0);
        w->scale[k] = pk_max(w->scale[k], other + PK_TINY);
        if (!at_rest)
            w->jump = pk_max(w->jump, pk_abs(w->dV[k]) / w->scale[k]);
    }
}

/* Returns the largest |dV| relative to its scale plus the fraction `share` of the largest scale. */
static pk_real corrected(const struct pk_variational_work *w, pk_real share)
{
    const pk_real more = share * pk_largest(w->scale, w->n);
    pk_real size = 0;
    for (size_t k = 0; k < w->n; k++) {
        const pk_real x = pk_abs(w->dV[k]) / (w->scale[k] + more);
        if (!(x <= size)) /* the condition is true for NaN */
            size = x;
    }
    return size;
}

/* Computes the kick J^T mu at the start. */
static void pull(struct pk_integrator *it, struct pk_variational_work *w)
{
    w->at.t = w->t;
    w->at.u = pk_eval_input(it, w->t);
    pk_project_pull(&w->at, pk_variational_to(w, PK_Q), pk_variational_to(w, PK_V), w->J, w->c,
                    w->kick, w->pull);
}

/* Iterates from V and w->kick. Returns 1 on convergence, else 0. Sets *sign to the sign of the last
 * determinant. */
static int iterate(struct pk_integrator *it, struct pk_variational_work *w, int newton, int *sign)
{
    const int most = it->options.max_iterations > 0 ? it->options.max_iterations
                     : newton                       ? BY_NEWTON_MOST
                                                    : BY_MASS_MOST;
    pk_real before = 0, least = 0;
    int small = 0, idle = 0;
    w->worst = 0;
    for (int count = 0; count <= most && idle < PATIENCE; count++) {
        pull(it, w);
        if (!pk_variational_evaluate(it, w))
            return 0;
        pk_variational_residual(w, w->dV);
        const pk_real off = w->c ? broken(it, w) : 0;
        if (small && off <= ROUND) /* p, f and phi belong to this V */
            return 1;
        if (count == 0)
            set_scale(w);
        *sign = pk_variational_correction(it, w, newton);
        if (!*sign)
            return 0;
        if (count == 0)
            raise_scale(w);
        const pk_real size = corrected(w, 0), rate = count ? size / before : 1;
        it->reason.value = size;
        if (!pk_finite(size))
            return 0;
        if (count && size > FAR)
            w->worst = pk_max(w->worst, rate);
        if (it->options.newton_tol > 0)
            small = size <= it->options.newton_tol;
        else
            small = size <= (count ? PK_EPS / 4 : PK_VARIATIONAL_BIAS) ||
                    (rate < 1 && size * rate / (1 - rate) <= PK_VARIATIONAL_BIAS) ||
                    (count && rate > PK_C(0.5) && corrected(w, PK_VARIATIONAL_SHARE) <= STALLED);
        pk_add(w->V, 1, w->dV, w->n);
        idle = count && size >= least ? idle + 1 : 0;
        least = count ? pk_min(least, size) : size;
        before = size;
    }
    return 0;
}

/* Follows the solution by Newton's method from step size 0, in parts of the step. Each part starts
 * from a line through the last points; its solution is accepted if it is near this line. */
static enum pk_status follow(struct pk_integrator *it, struct pk_variational_work *w)
{
    const pk_real h = w->h, end = w->end, *v = pk_variational_to(w, PK_V);
    pk_real made = 0, part = FIRST;
    for (size_t k = 0; k < w->n; k++) {
        w->kept[k] = k < w->m ? v[k] : k < w->states ? 0 : w->f_start[k];
        w->slope[k] = k < w->m ? h / 2 * w->f_start[k] : 0;
    }
    pk_variational_by_mass(w, w->slope);
    pk_zero(w->kept_kick, w->n);
    while (made < 1) {
        const pk_real next = made + part < 1 ? made + part : 1;
        int sign = 1;
        for (size_t k = 0; k < w->n; k++)
            w->V[k] = w->kept[k] + (next - made) * w->slope[k];
        for (size_t j = 0; j < w->c; j++)
            w->kick[j] = made > 0 ? w->kept_kick[j] * (next / made) : 0;
        w->h = h * next;
        w->end = next < 1 ? w->t + w->h : end;
        const int converged = iterate(it, w, 1, &sign);
        if (converged && sign > 0 && w->worst <= SURE && w->jump <= GENTLE) {
            for (size_t k = 0; k < w->n; k++)
                w->slope[k] = (w->V[k] - w->kept[k]) / (next - made);
            pk_copy(w->kept, w->V, w->n);
            pk_copy(w->kept_kick, w->kick, w->n);
            made = next;
            part *= 2;
            continue;
        }
        part /= 4;
        if (part < SHORTEST) {
            w->h = h;
            return pk_fail_with(it, converged ? PK_AMBIGUOUS_STEP : PK_NO_CONVERGENCE,
                                PK_WHY(.kind = PK_BY_NEWTON, .value = pk_abs(it->own->h) * made));
        }
    }
    return PK_DONE;
}

/* Returns whether the forces at the middle are close to those at the start or, with `ends`, the
 * momenta at the end are close to those at the start. It then contracts for shorter steps too. */
static int is_gentle(struct pk_variational_work *w)
{
    for (size_t k = 0; k < w->n; k++) {
        const pk_real d = w->table->ends ? w->p_end[k] - w->p[k] : w->h * (w->f[k] - w->f_start[k]);
        w->dV[k] = k < w->m ? d / 2 : 0;
    }
    pk_variational_by_mass(w, w->dV);
    for (size_t k = 0; k < w->m; k++)
        if (!(pk_abs(w->dV[k]) <= GENTLE * w->scale[k]))
            return 0;
    return 1;
}

enum pk_status pk_variational_solve(struct pk_integrator *it, struct pk_variational_work *w)
{
    int sign = 1;
    if (w->c && w->whole)
        it->problem.system->constraints.jacobian(
            it->problem.params, w->t, pk_variational_to(w, PK_Q), pk_variational_to(w, PK_V),
            pk_eval_input(it, w->t), w->J, w->at.rate);
    const int converged = iterate(it, w, 0, &sign);
    if (converged && sign > 0 && w->worst <= FAST && is_gentle(w))
        return PK_DONE;
    if (w->whole && it->options.iteration != PK_FIXED_POINT)
        return follow(it, w);
    it->reason.kind = PK_BY_FIXED_POINT;
    return PK_NO_CONVERGENCE;
}

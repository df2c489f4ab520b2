/* The equations of a variational step, r(V) = 0 for the rates V of its middle and phi(q1) = 0 for
 * the kick J(q0)^T mu of its start; see variational.c. By M for their matrix, at the start: that
 * contracts while h omega is below 2 and is quick where it is small. Where it does not contract all
 * the way, the equations may have several solutions: then by Newton's method with differences of r,
 * and followed from short steps on, so that the solution is theirs; its matrix, M at h = 0, must keep
 * the sign of its determinant. phi has its exact derivatives in either case.
 *
 * An iteration ends as that of newton.c does, far below round-off.
 */
#include <string.h>

#include "variational.h"

enum { BY_MASS_MOST = 1000, BY_NEWTON_MOST = 50 };

/* Rates of corrections beyond FAR, relative, at which the solution is that next to the guess: of the
 * iteration by M, and of Newton's; and by how much of the rates what r holds beside M V may change
 * within the step. Parts of a step that are followed: the first, and the shortest. */
#define FAR PK_C(0.1)
#define FAST PK_C(0.7)
#define SURE PK_C(0.5)
#define GENTLE PK_C(0.5)
#define FIRST PK_C(0.125)
#define LOST PK_F(cbrt)(PK_EPS)
#define SHORTEST (PK_C(1.0) / 16777216)

static size_t unknowns(const struct pk_variational_work *w) { return w->m + (w->n - w->states); }
static size_t place(const struct pk_variational_work *w, size_t i)
{
    return i < w->m ? i : i - w->m + w->states;
}

/* x by the matrix of the iteration, in place. */
static void solve(const struct pk_variational_work *w, int newton, pk_real *x)
{
    if (!newton) {
        pk_ldl_solve(w->M, w->m, x);
        return;
    }
    for (size_t i = w->m; i < unknowns(w); i++)
        x[i] = x[place(w, i)];
    pk_lu_solve(w->lu, w->pivot, unknowns(w), x);
    for (size_t i = unknowns(w); i-- > w->m;) {
        const pk_real state = x[i];
        x[i] = 0;
        x[place(w, i)] = state;
    }
}

/* Its sign. */
static int determinant(const pk_real *lu, const pk_real *pivot, size_t count)
{
    int sign = 1;
    for (size_t i = 0; i < count; i++) {
        const int swapped = (size_t)pivot[i] != i;
        sign *= (lu[i * count + i] < 0) == swapped ? 1 : -1;
    }
    return sign;
}

/* dr/dV by differences, factored; the sign of its determinant, or 0. */
static int differences(struct pk_integrator *it, struct pk_variational_work *w)
{
    const size_t count = unknowns(w);
    const pk_real e = PK_F(sqrt)(PK_EPS);
    pk_real *column = w->spare, most = 0;
    for (size_t k = 0; k < w->n; k++)
        most = pk_max(most, w->scale[k]);
    for (size_t j = 0; j < count; j++) {
        const size_t k = place(w, j);
        const pk_real V = w->V[k], own = pk_max(w->scale[k], most / 1024);
        const pk_real d = e * (own > 0 ? own : 1);
        w->V[k] = V + d;
        const int finite = pk_variational_evaluate(it, w);
        pk_variational_residual(w, column);
        w->V[k] = V;
        if (!finite)
            return 0;
        for (size_t i = 0; i < count; i++)
            w->lu[i * count + j] = (column[place(w, i)] - w->dV[place(w, i)]) / d;
    }
    it->count.jacobians++;
    it->count.factorisations++;
    return pk_lu_factor(w->lu, w->pivot, count) ? determinant(w->lu, w->pivot, count) : 0;
}

/* dV += what makes phi vanish at the end of V + dV, and that much more kick. By rows D of
 * d(phi)/dV and columns of J(q0)^T, which is turned into the middle's frame. The sign of what that
 * adds to the determinant of all, 1 at h = 0; 0: singular. */
static int constrain(struct pk_variational_work *w, int newton)
{
    const size_t n = w->n, c = w->c;
    for (size_t j = 0; j < c; j++) {
        pk_real *column = w->by_kick + j * n;
        memcpy(column, w->J + j * n, n * sizeof *column);
        memset(column + w->m, 0, (n - w->m) * sizeof *column);
        for (size_t k = w->rotation; k < w->first; k += 3) {
            const pk_real y[3] = {w->h * w->V[k] / 4, w->h * w->V[k + 1] / 4,
                                  w->h * w->V[k + 2] / 4};
            pk_cayley_turn(y, -1, column + k, column + k);
        }
        solve(w, newton, column);
    }
    for (size_t i = 0; i < c; i++) {
        pk_real *row = w->spare, sum = w->phi[i];
        for (size_t k = 0; k < w->rotation; k++)
            row[k] = w->h * w->J_end[i * n + k];
        for (size_t k = w->rotation; k < w->first; k += 3) {
            const pk_real y[3] = {w->h * w->V[k] / 4, w->h * w->V[k + 1] / 4,
                                  w->h * w->V[k + 2] / 4};
            const pk_real *j = w->J_end + i * n + k, weight = w->h / 2 / (1 + pk_dot3(y, y));
            pk_real both[3], across[3];
            pk_cayley_turn(y, 1, j, both);
            for (size_t l = 0; l < 3; l++)
                both[l] += j[l];
            pk_cross(y, both, across);
            for (size_t l = 0; l < 3; l++)
                row[k + l] = weight * (both[l] + across[l]);
        }
        for (size_t j = 0; j < c; j++) {
            w->S[i * c + j] = 0;
            for (size_t k = 0; k < w->m; k++)
                w->S[i * c + j] += row[k] * w->by_kick[j * n + k];
        }
        for (size_t k = 0; k < w->m; k++)
            sum += row[k] * w->dV[k];
        w->phi[i] = -sum;
    }
    if (!pk_lu_factor(w->S, w->S_pivot, c))
        return 0;
    pk_lu_solve(w->S, w->S_pivot, c, w->phi);
    for (size_t j = 0; j < c; j++) {
        w->kick[j] += w->phi[j];
        for (size_t k = 0; k < n; k++)
            w->dV[k] += w->phi[j] * w->by_kick[j * n + k];
    }
    return determinant(w->S, w->S_pivot, c) * (w->h < 0 && c % 2 ? -1 : 1);
}

/* phi at the end, in units of the rounding of its terms; J there. */
static pk_real broken(struct pk_integrator *it, struct pk_variational_work *w)
{
    const struct pk_system *system = it->problem.system;
    const pk_real *u = pk_eval_input(it, w->end), *q = pk_part(w->to, w->n, PK_Q);
    pk_real worst = 0;
    system->constraint(it->problem.params, w->end, w->q_end, w->v_end, u, w->phi);
    system->rows(it->problem.params, w->end, w->q_end, w->v_end, u, w->J_end, w->spare);
    for (size_t i = 0; i < w->c; i++) {
        pk_real size = PK_TINY;
        for (size_t k = 0; k < w->m; k++) { /* what q1 = q0 + h V is rounded by */
            const pk_real moved = pk_max(pk_abs(w->h * w->V[k]), pk_abs(q[k]));
            const pk_real x = k < w->rotation ? pk_max(pk_abs(w->q_end[k]), moved) : 1;
            size += pk_abs(w->J_end[i * w->n + k]) * x;
        }
        const pk_real ratio = pk_abs(w->phi[i]) / (PK_EPS * size);
        worst = ratio <= worst ? worst : ratio;
    }
    return worst;
}

static void set_scale(struct pk_variational_work *w)
{
    const pk_real *q = pk_part(w->to, w->n, PK_Q), *v = pk_part(w->to, w->n, PK_V);
    for (size_t k = 0; k < w->n; k++) {
        const pk_real x = k < w->rotation ? q[k] : k < w->states ? 1 : v[k];
        const pk_real rate = k < w->m ? pk_max(pk_abs(v[k]), pk_abs(w->V[k])) : pk_abs(w->V[k]);
        w->scale[k] = pk_max(rate, pk_abs(x / w->h));
    }
}

/* By the first correction: at least the change of rates that the step makes, in the metric of M, so
 * that what is at rest at 0 has a scale too. */
static void raise_scale(struct pk_variational_work *w)
{
    const pk_real *v = pk_part(w->to, w->n, PK_V);
    pk_real most = 0;
    for (size_t k = 0; k < w->m; k++) {
        const pk_real change = w->V[k] + w->dV[k] - v[k];
        most = pk_max(most, pk_abs(change) * PK_F(sqrt)(pk_ldl_diagonal(w->M, w->m, k)));
    }
    for (size_t k = 0; k < w->m; k++)
        w->scale[k] = pk_max(w->scale[k], most / PK_F(sqrt)(pk_ldl_diagonal(w->M, w->m, k)));
    for (size_t k = w->states; k < w->n; k++)
        w->scale[k] = pk_max(w->scale[k], pk_abs(w->V[k] + w->dV[k]));
}

/* The largest of dV beside its scale, with what is at rest at 0 beside others that move; *shared: on
 * a scale that forgives those. */
static pk_real corrected(const struct pk_variational_work *w, pk_real *shared)
{
    pk_real most = PK_TINY, size = 0;
    for (size_t k = 0; k < w->n; k++)
        most = pk_max(most, w->scale[k]);
    *shared = 0;
    for (size_t k = 0; k < w->n; k++) {
        const pk_real d = pk_abs(w->dV[k]), own = d / (w->scale[k] + PK_EPS * most);
        if (!(own <= size)) /* what is no number gets through */
            size = own;
        *shared = pk_max(*shared, d / (w->scale[k] + PK_C(1e-3) * most));
    }
    return size;
}

/* 1 where it converged. *sign: of the determinant of Newton's last matrix. */
static int iterate(struct pk_integrator *it, struct pk_variational_work *w, int newton, int *sign)
{
    const int most = it->options.max_iterations > 0 ? it->options.max_iterations
                     : newton                       ? BY_NEWTON_MOST
                                                    : BY_MASS_MOST;
    pk_real before = 0, least = 0;
    int last = 0, growing = 0, more = 0;
    w->worst = 0;
    for (int count = 0; count <= most; count++) {
        if (!pk_variational_evaluate(it, w))
            return 0;
        pk_variational_residual(w, w->dV);
        const pk_real off = w->c ? broken(it, w) : 0;
        if (last && (off <= 8 || ++more > 3)) /* all now belongs to the V that is kept */
            return pk_finite(off);
        if (count == 0)
            set_scale(w);
        if (newton && (*sign = differences(it, w)) == 0)
            return 0;
        if (newton && w->c) { /* differences have moved the end */
            pk_variational_reach(w);
            broken(it, w);
        }
        for (size_t k = 0; k < w->n; k++)
            w->dV[k] = -w->dV[k];
        solve(w, newton, w->dV);
        pk_real shared;
        const pk_real of_momenta = w->c ? corrected(w, &shared) : 0;
        const int of_phi = w->c ? constrain(w, newton) : 1;
        if (!of_phi)
            return 0;
        *sign = newton ? *sign * of_phi : of_phi;
        it->count.iterations++;
        if (count == 0)
            raise_scale(w);
        const pk_real size = corrected(w, &shared);
        for (size_t k = 0; k < w->n; k++)
            w->V[k] += w->dV[k];
        it->detail = size;
        if (!pk_finite(size))
            return 0;
        const pk_real rate = count ? size / before : PK_C(1.0);
        if (count == 0)
            w->jump = size;
        else if (size > FAR)
            w->worst = pk_max(w->worst, rate);
        if (it->options.newton_tol > 0)
            last = size <= it->options.newton_tol;
        else
            last = size <= (count ? PK_EPS / 4 : PK_VARIATIONAL_BIAS) ||
                   (rate < 1 && size * rate / (1 - rate) <= PK_VARIATIONAL_BIAS) ||
                   (count && rate > PK_C(0.5) && shared <= PK_VARIATIONAL_ROUND / 16);
        growing = count && size >= least ? growing + 1 : 0;
        least = count == 0 ? size : pk_min(least, size);
        if (!last && growing >= (newton ? 3 : 12)) {
            /* Terms of phi that cancel, as those of sin(x + a) - sin a, are rounded by more than
             * x tells: by Newton's method, with exact derivatives, that alone does not shrink. */
            last = w->c && shared <= LOST && of_momenta <= size / 8;
            if (!last)
                return 0;
        }
        before = size;
    }
    return 0;
}

/* By Newton's method, from a step of none on, in parts of it: each is begun on a straight line
 * through those before, and is one only if the solution is near that. */
static enum pk_status follow(struct pk_integrator *it, struct pk_variational_work *w)
{
    const pk_real h = w->h, end = w->end, *v = pk_part(w->to, w->n, PK_V);
    const size_t bytes = w->n * sizeof *w->V;
    pk_real made = 0, part = FIRST;
    for (size_t k = 0; k < w->n; k++) {
        w->kept[k] = k < w->m ? v[k] : k < w->states ? 0 : w->f_start[k];
        w->slope[k] = k < w->m ? h / 2 * w->f_start[k] : 0;
    }
    pk_ldl_solve(w->M, w->m, w->slope);
    memset(w->kept_kick, 0, bytes);
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
            memcpy(w->kept, w->V, bytes);
            memcpy(w->kept_kick, w->kick, bytes);
            made = next;
            part *= 2;
            continue;
        }
        part /= 4;
        if (part < SHORTEST) {
            w->h = h;
            it->detail = pk_abs(it->h) * made;
            it->where = PK_BY_NEWTON;
            return converged ? PK_AMBIGUOUS_STEP : PK_NO_CONVERGENCE;
        }
    }
    return PK_DONE;
}

/* Whether forces at the middle are much those at the start, or momenta at the end: then the
 * iteration contracts all along from a step of none. */
static int is_gentle(struct pk_variational_work *w)
{
    for (size_t k = 0; k < w->n; k++) {
        const pk_real d = w->table->ends ? w->p_end[k] - w->p[k] : w->h * (w->f[k] - w->f_start[k]);
        w->dV[k] = k < w->m ? d / 2 : 0;
    }
    pk_ldl_solve(w->M, w->m, w->dV);
    for (size_t k = 0; k < w->m; k++)
        if (!(pk_abs(w->dV[k]) <= GENTLE * w->scale[k]))
            return 0;
    return 1;
}

enum pk_status pk_variational_solve(struct pk_integrator *it, struct pk_variational_work *w)
{
    int sign = 1;
    if (w->c)
        it->problem.system->rows(it->problem.params, w->t, pk_part(w->to, w->n, PK_Q),
                                 pk_part(w->to, w->n, PK_V), pk_eval_input(it, w->t), w->J,
                                 w->spare);
    const int converged = iterate(it, w, 0, &sign);
    if (converged && sign > 0 && w->worst <= FAST && is_gentle(w))
        return PK_DONE;
    if (it->options.iteration != PK_FIXED_POINT)
        return follow(it, w);
    it->where = PK_BY_FIXED_POINT;
    return PK_NO_CONVERGENCE;
}

/* The end of a variational step, see variational.c: v from p(t, q, v) = p by Newton's method on M,
 * one linear solve where L is of second degree in v. Where there are constraints p has left their
 * tangent by as much as the forces of the step's end: p -= J^T nu, so that J v + j0 = 0.
 */
#include "variational.h"

/* A correction, relative, whose square is far below round-off. */
#define SMALL (PK_F(sqrt)(PK_EPS) / 64)
enum { MOST = 50 };

/* What rates are rounded beside, times the roots of their masses: the fastest in the metric of M,
 * and momenta, which are large of a charge at rest in a magnetic field, or M^-1 of them. */
static pk_real fastest(const struct pk_variational_work *w, const pk_real *v, const pk_real *p)
{
    pk_real most = PK_TINY;
    for (size_t k = 0; k < w->m; k++)
        most = pk_max(most, pk_max(w->root[k] * pk_abs(v[k]), pk_abs(p[k]) / w->root[k]));
    return most;
}

/* Onto J v + j0 = 0: what is left of it before, beside its terms. A row may be of rates that are
 * rounding alone, as those across the axle of a body that spins: the fastest tells what that is. */
static pk_real tangent(struct pk_variational_work *w, const pk_real *q, pk_real most, pk_real *v,
                       pk_real *p, pk_real *low_p)
{
    struct pk_projection *at = &w->at;
    pk_real worst = 0;
    pk_project_rows(at, q, v);
    pk_project_terms(at, q, v);
    for (size_t i = 0; i < w->c; i++) {
        pk_real all = 0;
        for (size_t k = 0; k < w->m; k++)
            all += pk_abs(at->J[i * w->n + k]) / w->root[k];
        worst = pk_max(worst, pk_abs(at->rate[i]) / pk_max(at->rate_size[i], all * most));
        at->mu[i] = at->rate[i];
    }
    pk_ldl_solve(at->A, w->c, at->mu);
    for (size_t i = 0; i < w->c; i++)
        for (size_t k = 0; k < w->m; k++) {
            v[k] -= at->mu[i] * at->W[i * w->m + k];
            p[k] = pk_sum(p[k], -at->mu[i] * at->J[i * w->n + k], &low_p[k]);
        }
    return worst;
}

/* M at the end, and J M^-1 J^T there. */
static enum pk_status matrices(struct pk_integrator *it, struct pk_variational_work *w,
                               const pk_real *q, const pk_real *v)
{
    PK_TRY(pk_variational_mass(it, w, w->end, q, v));
    if (!w->c)
        return PK_DONE;
    pk_project_rows(&w->at, q, v);
    const size_t singular = pk_project_factor(&w->at, w->c, q, v);
    it->where = singular ? singular - 1 : 0;
    if (!singular)
        pk_project_seen(it, &w->at);
    return singular ? PK_NO_PROJECTION : PK_DONE;
}

enum pk_status pk_variational_rates(struct pk_integrator *it, struct pk_variational_work *w,
                                    pk_real *p, pk_real *low_p)
{
    const pk_real *q = pk_part(w->to, w->n, PK_Q);
    pk_real *v = pk_part(w->to, w->n, PK_V), left = 0;
    const int quadratic = (it->problem.system->facts & PK_QUADRATIC) != 0;
    for (int count = 0; count < MOST; count++) {
        pk_variational_momenta(it, w->end, q, v, w->p, w->f_start);
        if (!pk_all_finite(w->p, w->m))
            return PK_NOT_FINITE;
        if (count == 0 || !quadratic) /* else M is the same */
            PK_TRY(matrices(it, w, q, v));
        left = 0;
        for (size_t k = 0; k < w->m; k++)
            w->dV[k] = p[k] - w->p[k];
        pk_ldl_solve(w->at.M, w->m, w->dV);
        for (size_t k = 0; k < w->m; k++) {
            v[k] += w->dV[k];
            left = pk_max(left, pk_abs(w->dV[k]) * w->root[k]);
        }
        const pk_real most = fastest(w, v, p);
        left /= most;
        if (w->c)
            left = pk_max(left, tangent(w, q, most, v, p, low_p));
        if (left <= SMALL)
            return pk_all_finite(v, w->m) ? PK_DONE : PK_NOT_FINITE;
    }
    return pk_because(it, PK_NO_CONVERGENCE, PK_OF_RATES, left);
}

/* The end of a variational step; see variational.c. Solves p(t, q, v) = p for the rates v by
 * Newton's method on M, with one linear solve if L is quadratic in v. With constraints, the forces
 * at the end change p so that J v + j0 = 0 is violated; the correction p -= J^T nu restores it. */
#include "variational.h"

/* A relative correction below this is the last one, since its square is far below round-off. */
#define SMALL (PK_F(sqrt)(PK_EPS) / 64)
enum { MOST = 50 };

/* Returns the scale of rounding of rates times the roots of their masses: the largest rate in the
 * metric of M, or M^-1 p if that is larger, as for a charge at rest in a magnetic field. */
static pk_real fastest(const struct pk_variational_work *w, const pk_real *v, const pk_real *p)
{
    pk_real most = PK_TINY;
    for (size_t k = 0; k < w->m; k++)
        most = pk_max(most, pk_max(w->root[k] * pk_abs(v[k]), pk_abs(p[k]) / w->root[k]));
    return most;
}

/* Returns the largest |J v + j0| relative to its terms. If the rates in a row are only rounding, as
 * across the axle of a spinning body, the largest rate gives their scale. */
static pk_real left_of_rows(struct pk_variational_work *w, const pk_real *q, pk_real most,
                            const pk_real *v)
{
    struct pk_projection *at = &w->at;
    pk_real worst = 0, *all = at->mu;
    pk_project_rows(at, q, v);
    pk_project_terms(at, q, v);
    pk_project_slopes(at, q, v, at->J, w->c, all);
    for (size_t i = 0; i < w->c; i++)
        worst = pk_max(worst, pk_abs(at->rate[i]) / pk_max(at->rate_size[i], all[i] * most));
    return worst;
}

/* Adds sign * d to v, and the force sign * J^T mu of the rows to p. */
static void correct(struct pk_variational_work *w, const pk_real *q, const pk_real *d, pk_real sign,
                    pk_real *v, pk_real *p, pk_real *low_p)
{
    pk_project_pull(&w->at, q, v, w->at.J, w->c, w->at.mu, w->spare);
    for (size_t k = 0; k < w->m; k++) {
        v[k] += sign * d[k];
        p[k] = pk_sum(p[k], sign * w->spare[k], &low_p[k]);
    }
}

/* Factors M and J M^-1 J^T at the end. */
static enum pk_status matrices(struct pk_integrator *it, struct pk_variational_work *w,
                               const pk_real *q, const pk_real *v)
{
    PK_TRY(pk_variational_mass(it, w, w->end, q, v));
    if (!w->c)
        return PK_DONE;
    if (w->whole)
        PK_TRY(pk_variational_rows(it, w, q, v));
    pk_project_seen(it, &w->at);
    return PK_DONE;
}

/* For families under constraints: solves M d - J^T mu = p - p(v) and J d = -(J v + j0) together.
 * Returns the size of the correction. */
static pk_real settled(struct pk_variational_work *w, const pk_real *q, pk_real *v, pk_real *p,
                       pk_real *low_p)
{
    struct pk_projection *at = &w->at;
    pk_real left = left_of_rows(w, q, fastest(w, v, p), v), most;
    for (size_t i = 0; i < w->c; i++)
        at->mu[i] = -at->rate[i];
    at->system->constraints.solve(at->params, w->dV, at->mu, w->dV, at->mu);
    correct(w, q, w->dV, 1, v, p, low_p);
    most = fastest(w, v, p);
    for (size_t k = 0; k < w->m; k++)
        left = pk_max(left, pk_abs(w->dV[k]) * w->root[k] / most);
    return left;
}

enum pk_status pk_variational_rates(struct pk_integrator *it, struct pk_variational_work *w,
                                    pk_real *p, pk_real *low_p)
{
    const pk_real *q = pk_variational_to(w, PK_Q);
    pk_real *v = pk_variational_to(w, PK_V), left = 0;
    const int quadratic = (it->problem.system->facts & PK_QUADRATIC) != 0;
    for (int count = 0; count < MOST; count++) {
        pk_variational_momenta(it, w->end, q, v, w->p, w->f_start);
        if (!pk_all_finite(w->p, w->m))
            return PK_NOT_FINITE;
        if (count == 0 || !quadratic) /* if L is quadratic, M is constant in this iteration */
            PK_TRY(matrices(it, w, q, v));
        left = 0;
        for (size_t k = 0; k < w->m; k++)
            w->dV[k] = p[k] - w->p[k];
        if (w->c && !w->whole) {
            left = settled(w, q, v, p, low_p);
        } else {
            pk_variational_by_mass(w, w->dV);
            for (size_t k = 0; k < w->m; k++) {
                v[k] += w->dV[k];
                left = pk_max(left, pk_abs(w->dV[k]) * w->root[k]);
            }
            const pk_real most = fastest(w, v, p);
            left /= most;
            if (w->c) {
                left = pk_max(left, left_of_rows(w, q, most, v));
                pk_project_solve(&w->at, w->c, w->at.rate);
                correct(w, q, w->at.d, -1, v, p, low_p);
            }
        }
        if (left <= SMALL)
            return pk_all_finite(v, w->m) ? PK_DONE : PK_NOT_FINITE;
    }
    return pk_fail_with(it, PK_NO_CONVERGENCE, PK_WHY(.kind = PK_OF_RATES, .value = left));
}

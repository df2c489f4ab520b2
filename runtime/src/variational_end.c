/* The end of a variational step, see variational.c: v from p(t, q, v) = p by Newton's method on M,
 * one linear solve where L is of second degree in v. Where there are constraints p has left their
 * tangent by as much as the forces of the step's end: p -= J^T nu, so that J v + j0 = 0.
 */
#include <string.h>

#include "variational.h"

enum { MOST = 50 };

/* J M^-1 J^T, factored into w->S: 0, or 1 + the row that depends on others. */
static size_t factor(struct pk_variational_work *w)
{
    const size_t n = w->n, c = w->c;
    for (size_t i = 0; i < c; i++) {
        memcpy(w->by_kick + i * n, w->J_end + i * n, n * sizeof *w->by_kick);
        pk_ldl_solve(w->M, w->m, w->by_kick + i * n);
    }
    for (size_t i = 0; i < c; i++)
        for (size_t j = 0; j < c; j++) {
            w->S[i * c + j] = 0;
            for (size_t k = 0; k < w->m; k++)
                w->S[i * c + j] += w->J_end[i * n + k] * w->by_kick[j * n + k];
        }
    return pk_ldl_factor(w->S, c);
}

/* What is undone: beside what it is of, and beside the fastest of all. */
struct undone {
    pk_real own, shared;
};

/* The largest rate in the metric of M, times the root of its mass; and that what the forces of a
 * step give, since momenta are sums with it: beside these rates are rounded. */
static pk_real fastest(const struct pk_variational_work *w, const pk_real *v)
{
    pk_real most = PK_TINY;
    for (size_t k = 0; k < w->m; k++) {
        const pk_real root = PK_F(sqrt)(pk_ldl_diagonal(w->M, w->m, k));
        most = pk_max(most, pk_max(root * pk_abs(v[k]), pk_abs(w->h * w->f[k]) / root));
    }
    return most;
}

/* Onto J v + j0 = 0: what is left of it before. A row may be of rates that are rounding alone, as
 * those across the axle of a body that spins, and own is then never small. */
static struct undone tangent(struct pk_integrator *it, struct pk_variational_work *w,
                             const pk_real *q, pk_real most, pk_real *v, pk_real *p,
                             pk_real *low_p)
{
    const size_t n = w->n;
    struct undone worst = {0, 0};
    it->problem.system->rows(it->problem.params, w->end, q, v, it->u, w->J_end, w->phi);
    for (size_t i = 0; i < w->c; i++) {
        pk_real size = PK_TINY, known = w->phi[i], all = 0;
        for (size_t k = 0; k < w->m; k++) {
            const pk_real j = pk_abs(w->J_end[i * n + k]);
            size += j * pk_abs(v[k]);
            known -= w->J_end[i * n + k] * v[k];
            all += j / PK_F(sqrt)(pk_ldl_diagonal(w->M, w->m, k));
        }
        size += pk_abs(known);
        worst.own = pk_max(worst.own, pk_abs(w->phi[i]) / size);
        worst.shared = pk_max(worst.shared, pk_abs(w->phi[i]) / pk_max(size, all * most));
    }
    pk_ldl_solve(w->S, w->c, w->phi);
    for (size_t i = 0; i < w->c; i++)
        for (size_t k = 0; k < w->m; k++) {
            v[k] -= w->phi[i] * w->by_kick[i * n + k];
            p[k] = pk_sum(p[k], -w->phi[i] * w->J_end[i * n + k], &low_p[k]);
        }
    return worst;
}

/* M at the end, and J M^-1 J^T there. */
static enum pk_status matrices(struct pk_integrator *it, struct pk_variational_work *w,
                               const pk_real *q, const pk_real *v)
{
    const enum pk_status status = pk_variational_mass(it, w, w->end, q, v);
    if (status < 0 || !w->c)
        return status;
    it->problem.system->rows(it->problem.params, w->end, q, v, it->u, w->J_end, w->phi);
    const size_t singular = factor(w);
    if (!singular)
        return PK_DONE;
    it->where = singular - 1;
    it->detail = w->end;
    return pk_project_singular(it, q, v);
}

enum pk_status pk_variational_rates(struct pk_integrator *it, struct pk_variational_work *w,
                                    pk_real *p, pk_real *low_p)
{
    const size_t m = w->m;
    const pk_real *q = pk_part(w->to, w->n, PK_Q);
    pk_real *v = pk_part(w->to, w->n, PK_V);
    struct undone before = {0, 0};
    pk_real rate = it->problem.system->facts & PK_QUADRATIC ? 0 : 1;
    for (int count = 0; count < MOST; count++) {
        struct undone left = {0, 0};
        pk_real size = 0, scale = PK_TINY, length = 0;
        pk_variational_momenta(it, w->end, q, v, w->p, w->f_start);
        if (!pk_all_finite(w->p, m))
            return PK_NOT_FINITE;
        if (count == 0 || rate > PK_C(0.1)) { /* else M at the guess will do */
            const enum pk_status status = matrices(it, w, q, v);
            if (status < 0)
                return status;
        }
        for (size_t k = 0; k < m; k++)
            w->dV[k] = p[k] - w->p[k];
        pk_ldl_solve(w->M, m, w->dV);
        for (size_t k = 0; k < m; k++) {
            v[k] += w->dV[k];
            size = pk_max(size, pk_abs(w->dV[k]));
            length = pk_max(length, pk_abs(w->dV[k]) * PK_F(sqrt)(pk_ldl_diagonal(w->M, m, k)));
            scale = pk_max(scale, pk_abs(v[k]));
        }
        const pk_real most = fastest(w, v);
        if (w->c)
            left = tangent(it, w, q, most, v, p, low_p);
        left.own = pk_max(left.own, size / scale);
        left.shared = pk_max(left.shared, length / most);
        if (left.own <= 2 * PK_EPS)
            return pk_all_finite(v, m) ? PK_DONE : PK_NOT_FINITE;
        if (count && left.own >= before.own / 2 && left.shared >= before.shared / 2 &&
            left.shared <= PK_VARIATIONAL_ROUND)
            return PK_DONE; /* corrections no longer shrink: they are round-off */
        rate = count ? left.shared / pk_max(before.shared, PK_TINY) : rate;
        before = left;
    }
    it->detail = before.shared;
    it->where = PK_OF_RATES;
    return PK_NO_CONVERGENCE;
}

/* J, and J M^-1 J^T factored: what constraints do to accelerations, corrections and impulses. Where
 * a row depends on those before it, by how much of each.
 */
#include <string.h>

#include "project.h"

#define LIGHT PK_C(1e-4) /* of a diagonal: what A loses by its smaller pivots, K does not */

static inline pk_real *take(pk_real *base, size_t *used, size_t count)
{
    pk_real *part = base ? base + *used : NULL;
    *used += count;
    return part;
}

/* Each step asks for it, so that it is written out. */
static inline size_t lay_out(struct pk_projection *w, const struct pk_problem *problem, size_t n,
                             pk_real *base)
{
    const struct pk_system *system = problem->system;
    const void *params = problem->params;
    const size_t c = pk_system_rows(system, params, 0), r = system->constraints.n_redundant;
    const size_t dense = system->constraints.factor ? 0 : c;
    size_t used = 0;
    w->system = system, w->params = params, w->u = NULL, w->t = 0;
    w->n = n, w->c = c, w->r = r, w->whole = !system->constraints.factor;
    w->inertia = 0;
    w->h = pk_system_rows(system, params, 1);
    w->rotation = pk_system_coordinates(system, params);
    w->m = w->rotation + 3 * pk_system_rotations(system, params);
    w->d = take(base, &used, 2 * n);
    w->M = take(base, &used, w->whole ? n * n : n);
    w->J = take(base, &used, dense * n);
    w->W = take(base, &used, dense * n);
    w->A = take(base, &used, dense * c);
    w->phi = take(base, &used, c);
    w->rate = take(base, &used, c);
    w->phi_size = take(base, &used, c);
    w->rate_size = take(base, &used, c);
    w->mu = take(base, &used, c);
    w->pivots = take(base, &used, c);
    w->norms = take(base, &used, c);
    w->most = take(base, &used, c);
    w->sizes = take(base, &used, dense * n);
    w->scale = take(base, &used, n);
    w->G = take(base, &used, dense * c);
    w->K = take(base, &used, dense ? (n + c) * (n + c) : 0);
    w->K_pivot = take(base, &used, n + c);
    w->x = take(base, &used, n + c);
    w->row_scale = take(base, &used, c);
    w->weight = take(base, &used, 1);
    w->depends = take(base, &used, 1 + c);
    w->off = take(base, &used, 2 * r);
    w->off_size = take(base, &used, 2 * r);
    w->off_rows = take(base, &used, r * n);
    w->off_slopes = take(base, &used, r);
    return used;
}

size_t pk_project_room(const struct pk_problem *problem, size_t n)
{
    struct pk_projection w;
    return lay_out(&w, problem, n, NULL);
}

struct pk_projection pk_project_parts(const struct pk_problem *problem, size_t n, pk_real *room)
{
    struct pk_projection w;
    lay_out(&w, problem, n, room);
    return w;
}

size_t pk_project_size(const struct pk_problem *problem, size_t n)
{
    const struct pk_system *system = problem->system;
    if (system->constraints.n)
        return pk_project_room(problem, n);
    return system->n_rotations || system->families.rotations ? 2 * n : 0; /* of quaternions alone */
}

int pk_project_inertia(struct pk_projection *w, const pk_real *q, const pk_real *v)
{
    const struct pk_system *system = w->system; /* without either, `mass` is the inertia */
    if (!w->whole) {
        system->families.diagonal(w->params, w->t, q, v, w->u, w->M);
        for (size_t k = 0; k < w->m; k++) /* factored with the rows, but they are weighed by it */
            if (!(w->M[k] > 0))
                return PK_FAILED(PK_FAILURE_MASS, k);
        return 0;
    }
    (system->inertia ? system->inertia : system->mass)(w->params, w->t, q, v, w->u, w->M);
    for (size_t i = 1; i < w->m; i++) /* without the columns of quaternions and states */
        memmove(w->M + i * w->m, w->M + i * w->n, w->m * sizeof *w->M);
    const size_t pivot = pk_ldl_factor(w->M, w->m);
    return pivot ? PK_FAILED(PK_FAILURE_MASS, pivot - 1) : 0;
}

void pk_project_rows(struct pk_projection *w, const pk_real *q, const pk_real *v)
{
    if (w->whole)
        w->system->constraints.jacobian(w->params, w->t, q, v, w->u, w->J, w->rate);
    else
        w->system->constraints.rates(w->params, w->t, q, v, w->u, w->rate);
    if (w->h)
        w->system->constraints.values(w->params, w->t, q, v, w->u, w->phi);
}

void pk_project_terms(struct pk_projection *w, const pk_real *q, const pk_real *v)
{
    w->system->constraints.scale(w->params, w->t, q, v, w->u, w->phi_size, w->rate_size);
}

void pk_project_spread(const struct pk_projection *w, const pk_real *q, const pk_real *v,
                       const pk_real *J, size_t rows, const pk_real *x, pk_real *out)
{
    if (!w->whole)
        w->system->constraints.spread(w->params, w->t, q, v, w->u, x, out);
    for (size_t i = 0; i < rows && w->whole; i++) {
        out[i] = 0;
        for (size_t k = 0; k < w->m; k++)
            out[i] += pk_abs(J[i * w->n + k]) * x[k];
    }
}

void pk_project_pull(const struct pk_projection *w, const pk_real *q, const pk_real *v,
                     const pk_real *J, size_t rows, const pk_real *x, pk_real *out)
{
    memset(out, 0, w->m * sizeof *out);
    if (!w->whole)
        w->system->constraints.pull(w->params, w->t, q, v, w->u, x, out);
    for (size_t i = 0; i < rows && w->whole; i++)
        for (size_t k = 0; k < w->m; k++)
            out[k] += J[i * w->n + k] * x[i];
}

void pk_project_slopes(struct pk_projection *w, const pk_real *q, const pk_real *v,
                       const pk_real *J, size_t rows, pk_real *out)
{
    for (size_t k = 0; k < w->m; k++)
        w->d[k] = 1 / PK_F(sqrt)(pk_project_mass(w, k));
    pk_project_spread(w, q, v, J, rows, w->d, out);
}

/* Scales of the rows and columns of J by the largest entries that it had, so that the largest of each
 * is about 1: D. Ruiz, A scaling algorithm to equilibrate both rows and columns norms in matrices,
 * RAL-TR-2001-034. Units and masses do not enter. In mu: of the rows, so that they are of length 1.
 */
static void equilibrate(struct pk_projection *w, size_t rows)
{
    enum { SWEEPS = 8 };
    const size_t m = w->m;
    for (size_t k = 0; k < m; k++)
        w->scale[k] = 1;
    for (size_t i = 0; i < rows; i++)
        w->mu[i] = 1;
    for (int sweep = 0; sweep <= SWEEPS; sweep++) {
        for (size_t i = 0; i < rows; i++) { /* in the end, lengths */
            pk_real most = 0, sum = 0;
            for (size_t k = 0; k < m; k++) {
                const pk_real x = w->mu[i] * w->sizes[i * w->n + k] * w->scale[k];
                most = pk_max(most, x);
                sum += x * x;
            }
            if (most > 0)
                w->mu[i] /= PK_F(sqrt)(sweep < SWEEPS ? most : sum);
        }
        for (size_t k = 0; k < m && sweep < SWEEPS; k++) {
            pk_real most = 0;
            for (size_t i = 0; i < rows; i++)
                most = pk_max(most, w->mu[i] * w->sizes[i * w->n + k] * w->scale[k]);
            if (most > 0)
                w->scale[k] /= PK_F(sqrt)(most);
        }
    }
}

/* G of the first rows, factored: 0, or 1 + the row that depends on others. It takes mu. */
static size_t gram(struct pk_projection *w, size_t rows)
{
    equilibrate(w, rows);
    for (size_t i = 0; i < rows; i++)
        for (size_t j = 0; j <= i; j++) {
            pk_real sum = 0;
            for (size_t k = 0; k < w->m; k++)
                sum += (w->mu[i] * w->J[i * w->n + k] * w->scale[k]) *
                       (w->mu[j] * w->J[j * w->n + k] * w->scale[k]);
            w->G[i * rows + j] = w->G[j * rows + i] = sum;
        }
    return pk_ldl_factor(w->G, rows);
}

void pk_project_explain(struct pk_projection *w, size_t c, size_t row)
{
    pk_real *x = w->depends + 1;
    gram(w, c);
    w->depends[0] = (pk_real)(row + 1);
    for (size_t i = 0; i < row; i++) {
        x[i] = 0;
        for (size_t k = 0; k < w->m; k++)
            x[i] += (w->mu[row] * w->J[row * w->n + k] * w->scale[k]) *
                    (w->mu[i] * w->J[i * w->n + k] * w->scale[k]);
        for (size_t k = 0; k < i; k++)
            x[i] -= w->G[i * c + k] * x[k];
    }
    for (size_t i = row; i-- > 0;) {
        x[i] /= w->G[i * c + i];
        for (size_t k = i + 1; k < row; k++)
            x[i] -= w->G[k * c + i] * x[k];
    }
}

/* [M J^T; J 0] in the scales of J, factored. Where masses are far apart, J M^-1 J^T is what the light
 * ones do, and the others are lost in its rounding: pivots of J come first here. */
static int augmented(struct pk_projection *w, size_t rows)
{
    const size_t m = w->m, count = m + rows;
    pk_real most = 0;
    for (size_t i = 0; i < m; i++)
        most = pk_max(most, w->scale[i] * w->scale[i] * pk_ldl_diagonal(w->M, m, i));
    w->weight[0] = 1 / most;
    memset(w->K, 0, count * count * sizeof *w->K);
    for (size_t i = 0; i < m; i++) /* above its diagonal M is left as it was */
        for (size_t j = i; j < m; j++) {
            const pk_real M = j > i ? w->M[i * m + j] : pk_ldl_diagonal(w->M, m, i);
            w->K[i * count + j] = w->K[j * count + i] = w->weight[0] *
                                                        (w->scale[i] * M * w->scale[j]);
        }
    for (size_t i = 0; i < rows; i++)
        for (size_t k = 0; k < m; k++)
            w->K[(m + i) * count + k] = w->K[k * count + m + i] = w->mu[i] * w->J[i * w->n + k] *
                                                                  w->scale[k];
    memcpy(w->row_scale, w->mu, rows * sizeof *w->mu);
    return pk_lu_factor(w->K, w->K_pivot, count);
}

/* 1 + the row without a pivot, and what it is of the others. */
static size_t lost(struct pk_projection *w, size_t row)
{
    w->system->constraints.shares(w->params, row, w->depends + 1);
    w->depends[0] = (pk_real)(row + 1);
    w->depends[1 + row] = 0;
    return row + 1;
}

size_t pk_project_factor(struct pk_projection *w, size_t rows, const pk_real *q, const pk_real *v)
{
    const size_t m = w->m, c = rows;
    w->depends[0] = 0;
    if (!w->whole) {
        const int failed = w->system->constraints.factor(w->params, w->t, q, v, w->u, rows < w->c,
                                                         w->pivots, w->norms);
        w->inertia = PK_FAILURE(failed) == PK_FAILURE_MASS ? failed : 0;
        if (!failed || w->inertia)
            return failed ? 1 : 0;
        return lost(w, (size_t)PK_FAILURE_AT(failed));
    }
    for (size_t i = 0; i < c; i++) {
        for (size_t k = 0; k < m; k++)
            w->sizes[i * w->n + k] = pk_max(w->sizes[i * w->n + k], pk_abs(w->J[i * w->n + k]));
        memcpy(w->W + i * m, w->J + i * w->n, m * sizeof *w->W);
        pk_ldl_solve(w->M, m, w->W + i * m);
    }
    for (size_t i = 0; i < c; i++)
        for (size_t j = 0; j <= i; j++) {
            pk_real sum = 0;
            for (size_t k = 0; k < m; k++)
                sum += w->J[i * w->n + k] * w->W[j * m + k];
            w->A[i * c + j] = w->A[j * c + i] = sum;
        }
    for (size_t i = 0; i < c; i++)
        w->norms[i] = w->A[i * c + i];
    const size_t failed_A = pk_ldl_factor(w->A, c);
    int low = 0, light = failed_A > 0;
    for (size_t i = 0; i < c; i++) {
        w->pivots[i] = failed_A && i + 1 >= failed_A ? 0 : w->A[i * c + i];
        low |= w->pivots[i] < 4 * PK_NEAR * PK_NEAR * pk_max(w->most[i], w->norms[i]);
        light |= w->pivots[i] < LIGHT * w->norms[i];
    }
    w->K_pivot[0] = -1;
    if (!low && !light)
        return 0;
    const size_t failed = gram(w, c);
    if (failed) {
        pk_project_explain(w, c, failed - 1);
        return failed;
    }
    for (size_t i = 0; i < c; i++)
        w->pivots[i] = pk_max(w->pivots[i], w->G[i * c + i] * pk_max(w->most[i], w->norms[i]));
    if (light && !augmented(w, c))
        w->K_pivot[0] = -1;
    return w->K_pivot[0] < 0 ? failed_A : 0;
}

void pk_project_seen(struct pk_integrator *it, const struct pk_projection *w)
{
    const pk_real low = 4 * PK_NEAR * PK_NEAR, far = PK_FAR * PK_FAR;
    int seen = PK_SEEN;
    for (size_t i = 0; i < w->c; i++) {
        const pk_real pivot = w->pivots[i];
        w->most[i] = pk_max(w->most[i], w->norms[i]);
        seen |= (pivot < low * w->most[i] ? PK_SEEN_LOW : 0) |
                (pivot < far * w->most[i] ? PK_SEEN_DIPS : 0);
    }
    it->own->seen = seen;
}

void pk_project_solve(struct pk_projection *w, size_t rows, const pk_real *r)
{
    if (!w->whole) {
        w->system->constraints.solve(w->params, NULL, r, w->d, w->mu);
        return;
    }
    if (!(w->K_pivot[0] < 0)) {
        pk_real *x = w->x;
        memset(x, 0, w->m * sizeof *x);
        for (size_t i = 0; i < rows; i++)
            x[w->m + i] = w->row_scale[i] * r[i];
        pk_lu_solve(w->K, w->K_pivot, w->m + rows, x);
        for (size_t k = 0; k < w->m; k++)
            w->d[k] = w->scale[k] * x[k];
        for (size_t i = 0; i < rows; i++)
            w->mu[i] = -w->row_scale[i] * x[w->m + i] / w->weight[0];
        return;
    }
    memcpy(w->mu, r, rows * sizeof *w->mu);
    pk_ldl_solve(w->A, rows, w->mu);
    for (size_t k = 0; k < w->m; k++) {
        w->d[k] = 0;
        for (size_t i = 0; i < rows; i++)
            w->d[k] += w->W[i * w->m + k] * w->mu[i];
    }
}

enum pk_status pk_project_singular(struct pk_integrator *it, const pk_real *q, const pk_real *v)
{
    struct pk_projection w = pk_project_parts(&it->problem, it->n, it->own->project);
    w.t = it->detail;
    w.u = it->own->u;
    if (!pk_project_inertia(&w, q, v)) {
        pk_project_rows(&w, q, v);
        const size_t row = pk_project_factor(&w, w.c, q, v);
        it->where = row ? row - 1 : it->where;
        if (!row && w.whole) /* found by the acceleration alone */
            pk_project_explain(&w, w.c, it->where);
    }
    return PK_NO_PROJECTION;
}

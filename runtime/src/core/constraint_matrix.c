/* Computes J and factors J M^-1 J^T, for accelerations, corrections and impulses under constraints.
 * Expresses a row that depends on previous rows as their linear combination. */
#include <string.h>

#include "project.h"

enum { SWEEPS = 3 }; /* number of iterations of the scaling of rows and columns */
/* an entry of a row that is smaller than this, relative to the largest one, may be an error */
#define COUNTS PK_C(1e-3)

/* The arguments of a kernel at q and v. */
#define OF(w) (w)->params, (w)->t, q, v, (w)->u

static inline pk_real *take(pk_real *base, size_t *used, size_t count)
{
    pk_real *part = base ? base + *used : NULL;
    *used += count;
    return part;
}

/* Assigns memory; does not use pk_lay_out(), which would be slow in each step. */
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
    w->inertia = w->all = 0;
    w->h = pk_system_rows(system, params, 1);
    w->rotation = pk_system_coordinates(system, params);
    w->m = w->rotation + 3 * pk_system_rotations(system, params);
    w->d = take(base, &used, 2 * n);
    w->M = take(base, &used, w->whole ? n * n : n);
    w->J = take(base, &used, dense * n);
    w->W = take(base, &used, dense * n);
    w->A = take(base, &used, dense * c);
    w->gram = take(base, &used, dense * c);
    w->sizes = take(base, &used, dense * n);
    w->columns = take(base, &used, n);
    w->phi = take(base, &used, c);
    w->rate = take(base, &used, c);
    w->phi_size = take(base, &used, c);
    w->rate_size = take(base, &used, c);
    w->mu = take(base, &used, c);
    w->pivots = take(base, &used, c);
    w->norms = take(base, &used, c);
    w->most = take(base, &used, c);
    w->sines = take(base, &used, c);
    w->depends = take(base, &used, 1 + c);
    w->rows = take(base, &used, system->contacts.modes ? c : 0);
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
    /* work memory for the normalisation of quaternions */
    return system->n_rotations || system->families.rotations ? 2 * n : 0;
}

int pk_project_inertia(struct pk_projection *w, const pk_real *q, const pk_real *v)
{
    /* M comes from the kernel `inertia`, or from `mass` if the system has no `inertia` */
    const struct pk_system *system = w->system;
    if (!w->whole) {
        system->families.diagonal(OF(w), w->M);
        for (size_t k = 0; k < w->m; k++) /* checks that the diagonal is positive */
            if (!(w->M[k] > 0))
                return PK_FAILED(PK_FAILURE_MASS, k);
        return 0;
    }
    (system->inertia ? system->inertia : system->mass)(OF(w), w->M);
    for (size_t i = 1; i < w->m; i++) /* removes the columns of variables that have no momenta */
        memmove(w->M + i * w->m, w->M + i * w->n, w->m * sizeof *w->M);
    const size_t pivot = pk_ldl_factor(w->M, w->m);
    return pivot ? PK_FAILED(PK_FAILURE_MASS, pivot - 1) : 0;
}

/* Moves the numbers of the rows that hold now to the front: `of_rates` of all rows, `of_places` of
 * holonomic ones, and J unless NULL. */
static void pack(struct pk_projection *w, pk_real *of_places, pk_real *of_rates, pk_real *J)
{
    const size_t *modes = w->system->contacts.modes;
    if (!modes || w->all)
        return;
    w->c = w->h = 0;
    for (size_t i = 0; i < w->system->constraints.n; i++) {
        if (modes[i] && !(w->u[modes[i] - 1] > 0))
            continue;
        w->rows[w->c] = (pk_real)i;
        of_rates[w->c] = of_rates[i];
        if (J)
            memmove(J + w->c * w->n, J + i * w->n, w->n * sizeof *J);
        if (i < w->system->constraints.n_holonomic)
            of_places[w->h++] = of_places[i];
        w->c++;
    }
}

size_t pk_project_row(const struct pk_projection *w, size_t row)
{
    return w->system->contacts.modes && !w->all ? (size_t)w->rows[row] : row;
}

void pk_project_rows(struct pk_projection *w, const pk_real *q, const pk_real *v)
{
    if (w->whole)
        w->system->constraints.jacobian(OF(w), w->J, w->rate);
    else
        w->system->constraints.rates(OF(w), w->rate);
    if (w->system->constraints.values)
        w->system->constraints.values(OF(w), w->phi);
    pack(w, w->phi, w->rate, w->J);
}

void pk_project_terms(struct pk_projection *w, const pk_real *q, const pk_real *v)
{
    w->system->constraints.scale(OF(w), w->phi_size, w->rate_size);
    pack(w, w->phi_size, w->rate_size, NULL);
}

void pk_project_spread(const struct pk_projection *w, const pk_real *q, const pk_real *v,
                       const pk_real *J, size_t rows, const pk_real *x, pk_real *out)
{
    if (!w->whole)
        w->system->constraints.spread(OF(w), x, out);
    for (size_t i = 0; i < rows && w->whole; i++) {
        out[i] = 0;
        for (size_t k = 0; k < w->m; k++)
            out[i] += pk_abs(J[i * w->n + k]) * x[k];
    }
}

void pk_project_pull(const struct pk_projection *w, const pk_real *q, const pk_real *v,
                     const pk_real *J, size_t rows, const pk_real *x, pk_real *out)
{
    pk_zero(out, w->m);
    if (!w->whole)
        w->system->constraints.pull(OF(w), x, out);
    for (size_t i = 0; i < rows && w->whole; i++)
        pk_add(out, x[i], J + i * w->n, w->m);
}

void pk_project_slopes(struct pk_projection *w, const pk_real *q, const pk_real *v,
                       const pk_real *J, size_t rows, pk_real *out)
{
    for (size_t k = 0; k < w->m; k++)
        w->d[k] = 1 / PK_F(sqrt)(pk_project_mass(w, k));
    pk_project_spread(w, q, v, J, rows, w->d, out);
}

/* Returns the squared length of a row in the metric of M^-1. */
static pk_real length2(const struct pk_projection *w, size_t row)
{
    return pk_dot(w->J + row * w->n, w->W + row * w->m, w->m);
}

void pk_project_explain(struct pk_projection *w, size_t c, size_t row)
{
    pk_real *x = w->depends + 1;
    w->depends[0] = (pk_real)(row + 1);
    for (size_t i = 0; i < row; i++) {
        x[i] = pk_dot(w->J + row * w->n, w->W + i * w->m, w->m);
        for (size_t k = 0; k < i; k++)
            x[i] -= w->A[i * c + k] * x[k];
    }
    for (size_t i = row; i-- > 0;) {
        x[i] /= w->A[i * c + i];
        for (size_t k = i + 1; k < row; k++)
            x[i] -= w->A[k * c + i] * x[k];
    }
    for (size_t i = 0; i < row; i++)
        x[i] *= PK_F(sqrt)(length2(w, i) / (length2(w, row) + PK_TINY));
}

/* Records in w->depends by which linear combination `row` depends on others. Returns 1 + row. */
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
        const int failed = w->system->constraints.factor(OF(w), rows < w->c, w->pivots, w->norms);
        w->inertia = PK_FAILURE(failed) == PK_FAILURE_MASS ? failed : 0;
        if (!failed || w->inertia)
            return failed ? 1 : 0;
        return lost(w, (size_t)PK_FAILURE_AT(failed));
    }
    for (size_t i = 0; i < c; i++) {
        pk_copy(w->W + i * m, w->J + i * w->n, m);
        pk_ldl_solve(w->M, m, w->W + i * m);
    }
    for (size_t i = 0; i < c; i++)
        for (size_t j = 0; j <= i; j++)
            w->A[i * c + j] = w->A[j * c + i] = pk_dot(w->J + i * w->n, w->W + j * m, m);
    const size_t failed = pk_ldl_factor(w->A, c);
    if (failed)
        pk_project_explain(w, c, failed - 1);
    return failed;
}

/* Computes column scales that equilibrate the largest |J_ik| so far. Scales computed from the
 * current entries would hide a small part of a row by which it differs from the other rows.
 * Reference: D. Ruiz, RAL-TR-2001-034. */
static void scale_columns(struct pk_projection *w)
{
    int grown = 0;
    for (size_t i = 0; i < w->c; i++)
        for (size_t k = 0; k < w->m; k++)
            if (pk_abs(w->J[i * w->n + k]) > w->sizes[i * w->n + k]) {
                w->sizes[i * w->n + k] = 2 * pk_abs(w->J[i * w->n + k]);
                grown = 1;
            }
    for (size_t k = 0; grown && k < w->m; k++)
        w->columns[k] = 1;
    for (int sweep = 0; grown && sweep < SWEEPS; sweep++) {
        for (size_t i = 0; i < w->c; i++) {
            w->norms[i] = PK_TINY;
            for (size_t k = 0; k < w->m; k++)
                w->norms[i] = pk_max(w->norms[i], w->sizes[i * w->n + k] * w->columns[k]);
        }
        for (size_t k = 0; k < w->m; k++) {
            pk_real most = PK_TINY;
            for (size_t i = 0; i < w->c; i++)
                most = pk_max(most, w->sizes[i * w->n + k] / w->norms[i]);
            w->columns[k] = 1 / most;
        }
    }
}

/* Returns the squared size of row i, divided by its largest so far: small if the row vanishes. It is
 * the larger of two ratios: that of the row's lengths, which does not depend on its direction, and
 * the largest of an entry that was not small, which does not depend on units. */
static pk_real shrunk(struct pk_projection *w, size_t i)
{
    const pk_real *sizes = w->sizes + i * w->n;
    pk_real length = 0, entry = 0, largest = PK_TINY;
    for (size_t k = 0; k < w->m; k++)
        largest = pk_max(largest, sizes[k] * w->columns[k]);
    for (size_t k = 0; k < w->m; k++) {
        const pk_real x = pk_abs(w->J[i * w->n + k]);
        length += x * x;
        if (sizes[k] * w->columns[k] > COUNTS * largest)
            entry = pk_max(entry, x / sizes[k]);
    }
    w->most[i] = pk_max(w->most[i], length);
    return pk_max(length / (w->most[i] + PK_TINY), entry * entry);
}

void pk_project_rank(struct pk_projection *w)
{
    const size_t c = w->c;
    for (size_t i = 0; i < c && !w->whole; i++) {
        w->most[i] = pk_max(w->most[i], w->norms[i]);
        w->sines[i] = w->pivots[i] / w->most[i];
    }
    if (!w->whole)
        return;
    scale_columns(w);
    for (size_t i = 0; i < c; i++)
        for (size_t j = 0; j <= i; j++) {
            pk_real sum = 0;
            for (size_t k = 0; k < w->m; k++)
                sum += w->J[i * w->n + k] * w->columns[k] * (w->J[j * w->n + k] * w->columns[k]);
            w->gram[i * c + j] = w->gram[j * c + i] = sum;
        }
    for (size_t i = 0; i < c; i++)
        w->norms[i] = w->gram[i * c + i] + PK_TINY;
    const size_t failed = pk_ldl_factor(w->gram, c);
    for (size_t i = 0; i < c; i++)
        w->sines[i] = failed == i + 1 ? 0 : w->gram[i * c + i] / w->norms[i] * shrunk(w, i);
}

void pk_project_seen(struct pk_integrator *it, struct pk_projection *w)
{
    const pk_real low = 4 * PK_NEAR * PK_NEAR, far = PK_FAR * PK_FAR;
    int seen = PK_SEEN;
    pk_project_rank(w);
    for (size_t i = 0; i < w->c; i++)
        seen |= (w->sines[i] < low ? PK_SEEN_LOW : 0) | (w->sines[i] < far ? PK_SEEN_DIPS : 0);
    it->own->passing.seen = seen;
}

void pk_project_solve(struct pk_projection *w, size_t rows, const pk_real *r)
{
    if (!w->whole) {
        w->system->constraints.solve(w->params, NULL, r, w->d, w->mu);
        return;
    }
    pk_copy(w->mu, r, rows);
    pk_ldl_solve(w->A, rows, w->mu);
    pk_zero(w->d, w->m);
    for (size_t i = 0; i < rows; i++)
        pk_add(w->d, w->mu[i], w->W + i * w->m, w->m);
}

enum pk_status pk_project_singular(struct pk_integrator *it, const pk_real *q, const pk_real *v)
{
    struct pk_projection w = pk_projection(it);
    w.t = it->reason.time;
    w.u = it->own->u;
    if (!pk_project_inertia(&w, q, v)) {
        pk_project_rows(&w, q, v);
        const size_t row = pk_project_factor(&w, w.c, q, v);
        it->reason.index = row ? row - 1 : it->reason.index;
        /* the kernel `acceleration` has found the dependent row, but this factorisation has not */
        if (!row && w.whole)
            pk_project_explain(&w, w.c, it->reason.index);
    }
    return PK_NO_PROJECTION;
}

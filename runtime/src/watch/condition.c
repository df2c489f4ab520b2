/* Condition numbers along a motion; see pk/condition.h. */
#include <string.h>

#include <pk/condition.h>

#include "../core/project.h"

#define CLOSE PK_C(1.03) /* a computed spectral radius is correct up to this factor */
enum { TURNS = 40 };

struct parts {
    size_t n, most;
    pk_real *project, *u, *a, *lost, *lambda, *x, *y, *pivot, *A, *inverse, *X;
};

/* Returns the number of unknowns of the equations that a step solves; 0 if none, or too many. */
static size_t unknowns(const struct pk_system *system, const struct pk_method *method, size_t n)
{
    const size_t m = method && method->equations ? (size_t)method->stages * (n - system->n_unread)
                                                 : 0;
    return m <= PK_CONDITION_MOST ? m : 0;
}

static size_t lay_out(struct parts *w, const struct pk_problem *problem,
                      const struct pk_method *method, pk_real *base)
{
    const struct pk_system *system = problem->system;
    const size_t n = pk_count_of(problem), c = system->constraints.n;
    w->n = n;
    w->most = unknowns(system, method, n);
    w->most = w->most > n ? w->most : n;
    w->most = w->most > c ? w->most : c;
    /* families kept as loops have no matrices */
    w->most = system->constraints.factor ? 0 : w->most;
    const size_t m = w->most;
    const struct pk_slot slots[] = {{&w->project, pk_project_room(problem, n)},
                                    {&w->u, system->n_inputs},
                                    {&w->a, n},
                                    {&w->lost, n},
                                    {&w->lambda, c},
                                    {&w->x, m},
                                    {&w->y, m},
                                    {&w->pivot, m},
                                    {&w->A, m * m},
                                    {&w->inverse, m * m},
                                    {&w->X, m * m}};
    return PK_LAY_OUT(base, slots);
}

size_t pk_condition_size(const struct pk_problem *problem, const struct pk_method *method)
{
    struct parts w;
    const struct pk_system *system = problem->system;
    const size_t size = lay_out(&w, problem, method, NULL);
    const int kernels = system->mass || system->inertia || system->constraints.factor;
    const int has = kernels && system->acceleration;
    return has && w.n && w.most <= PK_CONDITION_MOST ? size * sizeof *w.A : 0;
}

static void most(struct pk_condition_most *most, pk_real x, pk_real t)
{
    if (!(x <= most->x)) /* the condition is true for NaN */
        *most = (struct pk_condition_most){pk_finite(x) ? x : PK_INFINITY, t};
}

/* Returns an upper bound of the spectral radius of X >= 0: the least of max_i (X x)_i/x_i over
 * vectors x > 0 of a damped power iteration (R. S. Varga, Matrix Iterative Analysis, 2.1). */
static pk_real radius(struct parts *w, size_t m)
{
    pk_real least = PK_INFINITY;
    for (size_t i = 0; i < m; i++)
        w->x[i] = 1;
    if (!pk_all_finite(w->X, m * m))
        return PK_INFINITY;
    for (int turn = 0; turn < TURNS; turn++) {
        pk_real above = 0, below = PK_INFINITY, sum = 0;
        memset(w->y, 0, m * sizeof *w->y);
        pk_add_product(w->y, w->X, w->x, m);
        for (size_t i = 0; i < m; i++) {
            above = pk_max(above, w->y[i] / w->x[i]);
            below = pk_min(below, w->y[i] / w->x[i]);
        }
        least = pk_min(least, above);
        if (above <= CLOSE * below)
            break;
        for (size_t i = 0; i < m; i++) {
            w->x[i] += 3 * w->y[i] / above;
            sum = pk_max(sum, w->x[i]);
        }
        for (size_t i = 0; i < m; i++)
            w->x[i] /= sum;
    }
    return least;
}

/* Sets w->X = |A^-1| |A|, an m by m matrix; returns its spectral radius, the condition number. */
static pk_real scaled(struct parts *w, size_t m)
{
    memset(w->X, 0, m * m * sizeof *w->X);
    for (size_t i = 0; i < m; i++)
        for (size_t k = 0; k < m; k++)
            for (size_t j = 0; j < m; j++)
                w->X[i * m + j] += pk_abs(w->inverse[i * m + k] * w->A[k * m + j]);
    return radius(w, m);
}

/* Returns the condition number of A by its factors L D L^T; the upper triangle is still A's. */
static pk_real of_ldl(struct parts *w, const pk_real *factors, size_t m)
{
    for (size_t i = 0; i < m; i++) {
        w->A[i * m + i] = pk_ldl_diagonal(factors, m, i);
        for (size_t j = i + 1; j < m; j++)
            w->A[i * m + j] = w->A[j * m + i] = factors[i * m + j];
        pk_real *row = w->inverse + i * m; /* row i is also column i of the symmetric inverse */
        memset(row, 0, m * sizeof *row);
        row[i] = 1;
        pk_ldl_solve(factors, m, row);
    }
    return scaled(w, m);
}

/* Returns the condition number of A = L U. The permutation of its rows does not change it. */
static pk_real of_lu(struct parts *w, const pk_real *factors, size_t m)
{
    memset(w->A, 0, m * m * sizeof *w->A);
    for (size_t i = 0; i < m; i++) {
        w->pivot[i] = (pk_real)i;
        for (size_t k = 0; k <= i; k++)
            for (size_t j = k; j < m; j++)
                w->A[i * m + j] += (k < i ? factors[i * m + k] : 1) * factors[k * m + j];
    }
    for (size_t j = 0; j < m; j++) {
        memset(w->x, 0, m * sizeof *w->x);
        w->x[j] = 1;
        pk_lu_solve(factors, w->pivot, m, w->x);
        for (size_t i = 0; i < m; i++)
            w->inverse[i * m + j] = w->x[i];
    }
    return scaled(w, m);
}

/* Returns the condition number of J M^-1 J^T. Adds to w->lost the errors of accelerations due to
 * rounding of the multipliers lambda, and to `terms` the accelerations due to lambda. */
static pk_real of_rows(struct parts *w, struct pk_projection *at, const pk_real *q,
                       const pk_real *v, pk_real *terms)
{
    const size_t m = at->m, c = at->c;
    pk_project_rows(at, q, v);
    if (pk_project_factor(at, c, q, v))
        return PK_INFINITY;
    const pk_real found = of_ldl(w, at->A, c);
    if (!at->system->constraints.multipliers) { /* lambda is unknown: assumes the largest loss */
        for (size_t k = 0; k < m; k++)
            w->lost[k] += found * terms[k];
        return found;
    }
    at->system->constraints.multipliers(at->params, at->t, q, v, at->u, w->lambda);
    for (size_t i = 0; i < c; i++) {
        pk_real error = 0;
        for (size_t k = 0; k < c; k++)
            error += w->X[i * c + k] * pk_abs(w->lambda[k]);
        for (size_t k = 0; k < m; k++) {
            w->lost[k] += pk_abs(at->W[i * m + k]) * error;
            terms[k] += pk_abs(at->W[i * m + k] * w->lambda[i]);
        }
    }
    return found;
}

/* Returns a lower bound of the condition number for families kept as loops: there are no matrices,
 * but systems with S = J M^-1 J^T can be solved. S_kk (S^-1)_kk is 1/sin^2 of the angle between row
 * k and the span of the others in the metric of M^-1. Column r of S^-1, for the row r with the
 * smallest pivot, gives the bound S_kk (S^-1)_kr^2/(S^-1)_rr. If it is large, S z is nearly 0, and
 * z^T |S| z >= 3 S_kk z_k^2, so that the condition number is larger by a factor 3. Sets *where to
 * the rate that the multiplier of row r changes most, in the metric of M. */
static pk_real of_solves(struct pk_projection *at, const pk_real *q, const pk_real *v,
                         size_t *where)
{
    size_t row = 0;
    pk_real least = PK_INFINITY, found = 1, turned = 0;
    pk_project_inertia(at, q, v);
    if (pk_project_factor(at, at->c, q, v))
        return PK_INFINITY;
    for (size_t i = 0; i < at->c; i++) {
        at->rate[i] = 0;
        if (at->pivots[i] < least * at->norms[i])
            least = at->pivots[i] / at->norms[i], row = i;
    }
    at->rate[row] = 1;
    pk_project_solve(at, at->c, at->rate);
    for (size_t i = 0; i < at->c; i++)
        found = pk_max(found, at->norms[i] * at->mu[i] * (at->mu[i] / at->mu[row]));
    for (size_t k = 0; k < at->m; k++) {
        const pk_real x = PK_F(sqrt)(at->M[k]) * pk_abs(at->d[k]);
        if (x > turned)
            turned = x, *where = k;
    }
    return 3 * found - 2;
}

void pk_condition_look(struct pk_condition *c, const struct pk_problem *problem,
                       struct pk_integrator *it, pk_real t, const pk_real *q, const pk_real *v,
                       void *block)
{
    struct parts w;
    lay_out(&w, problem, it ? it->method : NULL, (pk_real *)block);
    struct pk_projection at = pk_project_parts(problem, w.n, w.project);
    const size_t m = at.m;
    c->looks++;
    at.t = t;
    at.u = w.u;
    pk_input(problem, t, w.u);
    if (!at.whole) {
        size_t where = c->where;
        const pk_real found = of_solves(&at, q, v, &where), before = c->lost.x;
        most(&c->constraints, found, t);
        most(&c->lost, found, t);
        c->where = c->lost.x > before ? where : c->where;
        return;
    }
    if (problem->system->acceleration(problem->params, t, q, v, w.u, w.a) ||
        pk_project_inertia(&at, q, v)) {
        most(&c->mass, PK_INFINITY, t);
        most(&c->lost, PK_INFINITY, t);
        return;
    }
    pk_real *const terms = w.pivot; /* `pivot` is not in use yet */
    most(&c->mass, of_ldl(&w, at.M, m), t);
    for (size_t i = 0; i < m; i++) {
        w.lost[i] = terms[i] = 0;
        for (size_t j = 0; j < m; j++) {
            w.lost[i] += w.X[i * m + j] * pk_abs(w.a[j]);
            terms[i] += pk_abs(w.A[i * m + j] * w.a[j] / w.A[i * m + i]);
        }
    }
    if (at.c)
        most(&c->constraints, of_rows(&w, &at, q, v, terms), t);
    for (size_t i = 0; i < m; i++) {
        const pk_real before = c->lost.x;
        most(&c->lost, terms[i] > 0 ? w.lost[i] / terms[i] : 0, t);
        c->where = c->lost.x > before ? i : c->where;
    }
    const size_t of_step = it ? unknowns(problem->system, it->method, w.n) : 0;
    const pk_real *factors = of_step ? it->method->equations(it) : NULL;
    if (factors)
        most(&c->step, of_lu(&w, factors, of_step), t);
}

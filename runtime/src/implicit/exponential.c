/* The exact flow of an affine system, q'' = A q + B v + c with constant coefficients. With
 *
 *     x = (q, v, 1),   x' = x L  (a row),   L = (0 A' 0; 1 B' 0; 0 c 0),
 *
 * with a 1 for each coordinate but not for first-order variables,
 *
 * a step is x exp(h L), a row times a matrix that is computed once per step size. Matrix and state
 * have twice the working precision, since the error of the matrix is the same in each step and
 * accumulates in proportion to the number of steps, and the random round-off of the state like the
 * square root of that number. Only the coefficients are rounded to working precision. The
 * coefficients come from the kernels M and `linear`, with M x = r refined to twice the precision
 * (an error of c only moves the equilibrium); or from accelerations, if the system has a variable
 * size or is too large for `linear`.
 *
 * L is balanced by powers of two. Its norm, and the number of squarings, then depend on the fastest
 * motion and not on units. References: double_double.c for the exponential; B. N. Parlett, C.
 * Reinsch, Numer. Math. 13 (1969) 293, for balancing; N. J. Higham, Accuracy and Stability of
 * Numerical Algorithms, 12, for refinement. */

#include "../core/double_double.h"
#include "../core/tableau.h"

#define ALONE PK_C(0x1p20)
enum { KEPT = 2 }; /* stored matrices: for the step, and for the shorter last step of an interval */

struct work {
    size_t n_q, n, m; /* m = n_q + n + 1, the order of L */
    struct pk_pairs L, E[KEPT], x, y;
    struct pk_pairs series; /* Taylor series for dense output in a piece of the step */
    pk_real *piece, *at;    /* length of this piece; its index in the step */
    /* factors of balancing; norm of L; step size of each E; index of the last E used */
    pk_real *scale, *norm, *h, *last;
    pk_real *room;
};

static size_t lay_out(struct work *w, size_t n_q, size_t n, pk_real *base)
{
    const size_t m = n_q + n + 1, mm = m * m, terms = (PK_EXPM_TERMS + 1) * m;
    const size_t of_expm = pk_expm_room(m), of_linear = 4 * n * n + 4 * n;
    const struct pk_slot slots[] = {{&w->L.hi, mm},
                                    {&w->L.lo, mm},
                                    {&w->E[0].hi, mm},
                                    {&w->E[0].lo, mm},
                                    {&w->E[1].hi, mm},
                                    {&w->E[1].lo, mm},
                                    {&w->x.hi, m},
                                    {&w->x.lo, m},
                                    {&w->y.hi, m},
                                    {&w->y.lo, m},
                                    {&w->scale, m},
                                    {&w->h, KEPT},
                                    {&w->norm, 1},
                                    {&w->last, 1},
                                    {&w->room, of_expm > of_linear ? of_expm : of_linear},
                                    {&w->piece, 1},
                                    {&w->at, 1},
                                    {&w->series.hi, terms},
                                    {&w->series.lo, terms}};
    w->n_q = n_q;
    w->n = n;
    w->m = m;
    return PK_LAY_OUT(base, slots);
}

static size_t exponential_size(const struct pk_method *method, const struct pk_problem *problem,
                               size_t n)
{
    struct work w;
    (void)method;
    return n > PK_EXPONENTIAL_MOST ? 0 : lay_out(&w, pk_coordinates_of(problem), n, NULL);
}

static struct work work_of(const struct pk_integrator *it)
{
    struct work w;
    lay_out(&w, it->n_q, it->n, it->own->work);
    return w;
}

/* Solves M y = r with iterative refinement, M factored; y = hi + lo has twice the precision. */
static void refined(const struct work *w, const pk_real *M, const pk_real *factors,
                    const pk_real *r, pk_real *room, pk_real *hi, pk_real *lo)
{
    const size_t n = w->n;
    pk_zero(hi, n);
    pk_zero(lo, n);
    for (int count = 0; count < 3; count++) {
        for (size_t i = 0; i < n; i++) {
            pk_real left = r[i * n], rest = 0;
            for (size_t k = 0; k < n; k++)
                pk_pair_add(&left, &rest, -M[i * n + k], 0, hi[k], lo[k]);
            room[i] = left + rest;
        }
        pk_ldl_solve(factors, n, room);
        for (size_t i = 0; i < n; i++)
            hi[i] = pk_sum(hi[i], room[i], &lo[i]);
    }
}

static enum pk_status from_linear(struct pk_integrator *it, const struct work *w)
{
    const struct pk_system *system = it->problem.system;
    const void *params = it->problem.params;
    const size_t n_q = w->n_q, n = w->n, m = w->m;
    pk_real *M = w->room, *factors = M + n * n, *r_q = factors + n * n, *r_v = r_q + n * n;
    pk_real *zero = r_v + n * n, *c = w->L.hi + (m - 1) * m + n_q, *r_t = zero + 2 * n;
    pk_real *room = r_t + n;
    pk_zero(zero, n);
    PK_TRY(pk_eval_acceleration(it, it->t, zero, zero, c));
    system->mass(params, it->t, zero, zero, it->own->u, M);
    system->linear(params, it->t, zero, zero, it->own->u, c, r_q, r_v, r_t);
    pk_copy(factors, M, n * n);
    const size_t pivot = pk_ldl_factor(factors, n);
    if (pivot)
        return pk_eval_failed(it, it->t, zero, zero, PK_FAILED(PK_FAILURE_MASS, pivot - 1));
    for (size_t j = 0; j < n_q + n; j++)
        refined(w, M, factors, j < n_q ? r_q + j : r_v + j - n_q, room, w->L.hi + j * m + n_q,
                w->L.lo + j * m + n_q);
    return PK_DONE;
}

/* Computes L from accelerations a at multiples of unit vectors. The multiples are so large that the
 * constant term c is below the round-off of a; then a - c has no more round-off than a. */
static enum pk_status from_accelerations(struct pk_integrator *it, const struct work *w)
{
    const size_t n_q = w->n_q, n = w->n, m = w->m;
    const pk_real length = 1 / (PK_EPS * PK_EPS);
    pk_real *at = w->room, *a = at + n_q + n, *c = w->L.hi + (m - 1) * m + n_q;
    pk_zero(at, n_q + n);
    enum pk_status status = pk_eval_acceleration(it, it->t, at, at + n_q, c);
    for (size_t j = 0; j < n_q + n && status >= 0; j++) {
        at[j] = length;
        status = pk_eval_acceleration(it, it->t, at, at + n_q, a);
        at[j] = 0;
        for (size_t i = 0; i < n; i++)
            w->L.hi[j * m + n_q + i] = (a[i] - c[i]) / length;
    }
    return status;
}

/* Balances L: replaces it by S^-1 L S, S = diag(scale) of powers of two, with rows and columns of
 * equal size and the last row, c, no larger. Returns its norm. */
static pk_real balance(const struct work *w)
{
    const size_t m = w->m;
    pk_real *const L[] = {w->L.hi, w->L.lo}, norm = 0, most = 0;
    for (size_t i = 0; i < m; i++)
        w->scale[i] = 1;
    for (int again = 1, first = 1; again; first = 0) {
        again = 0;
        for (size_t i = 0; i + 1 < m; i++) {
            pk_real row = 0, column = 0, f = 1;
            for (size_t j = 0; j + 1 < m; j++)
                if (j != i)
                    row += pk_abs(L[0][i * m + j]), column += pk_abs(L[0][j * m + i]);
            const pk_real before = row + column;
            if (!(before > 0) || !pk_finite(before))
                continue;
            if (row > 0 && column > 0) {
                for (; column < row / 2; column *= 4)
                    f *= 2;
                for (; column >= row * 2; column /= 4)
                    f /= 2;
                if (!((column + row) / f < PK_C(0.95) * before))
                    continue;
            } else if (first) { /* a zero row or column: any scale is valid */
                f = row > 0 ? ALONE : 1 / ALONE;
            } else {
                continue;
            }
            again = 1;
            w->scale[i] *= f;
            for (int k = 0; k < 2; k++)
                for (size_t j = 0; j < m; j++)
                    L[k][i * m + j] /= f, L[k][j * m + i] *= f;
        }
    }
    for (size_t i = 0; i < m; i++) {
        pk_real row = 0;
        for (size_t j = 0; j < m; j++)
            row += pk_abs(L[0][i * m + j]);
        *(i + 1 < m ? &norm : &most) = pk_max(i + 1 < m ? norm : most, row);
    }
    for (; most > norm && pk_finite(most); most /= 2) {
        w->scale[m - 1] *= 2;
        for (size_t j = 0; j < m; j++)
            L[0][(m - 1) * m + j] /= 2, L[1][(m - 1) * m + j] /= 2;
    }
    return norm;
}

static enum pk_status exponential_init(struct pk_integrator *it)
{
    const struct pk_system *system = it->problem.system;
    if (it->n > PK_EXPONENTIAL_MOST)
        return PK_REFUSED;
    const struct work w = work_of(it);
    const size_t m = w.m;
    pk_zero(w.L.hi, m * m);
    pk_zero(w.L.lo, m * m);
    pk_zero(w.h, KEPT);
    *w.last = 0;
    PK_TRY(system->linear && system->mass ? from_linear(it, &w) : from_accelerations(it, &w));
    for (size_t j = 0; j < w.n_q; j++)
        w.L.hi[(w.n_q + j) * m + j] = 1;
    if (!pk_all_finite(w.L.hi, m * m))
        return PK_NOT_FINITE;
    *w.norm = balance(&w);
    for (*w.piece = 1 / PK_TINY; *w.norm * *w.piece > PK_EXPM_PIECE; *w.piece /= 2)
        ;
    return PK_DONE;
}

/* Finds the stored exp(h L) of this step, or replaces the least recently used matrix by it. */
static enum pk_status matrix(struct pk_integrator *it, const struct work *w, pk_real h, int *which)
{
    const size_t m = w->m;
    for (int k = 0; k < KEPT; k++)
        if (!(w->h[k] > h) && !(w->h[k] < h)) {
            *w->last = (pk_real)k;
            *which = k;
            return PK_DONE;
        }
    const int k = (int)(pk_index(*w->last, KEPT) + 1) % KEPT;
    const struct pk_pairs E = w->E[k];
    w->h[k] = 0;
    it->count.factorisations++;
    PK_TRY(pk_expm(E, w->L, *w->norm, h, m, w->room));
    for (size_t i = 0; i < m; i++)
        for (size_t j = 0; j < m; j++) {
            const pk_real back = w->scale[i] / w->scale[j];
            E.hi[i * m + j] *= back;
            E.lo[i * m + j] *= back;
            if (i == j)
                pk_pair_add(&E.hi[i * m + j], &E.lo[i * m + j], 1, 0, 1, 0);
        }
    pk_pairs_settle(E, m * m);
    w->h[k] = h;
    *w->last = (pk_real)k;
    *which = k;
    return PK_DONE;
}

static void load(const struct work *w, const pk_real *state)
{
    const size_t m = w->m - 1;
    pk_copy(w->x.hi, state, m); /* q and v are contiguous, and so are their low parts */
    pk_copy(w->x.lo, state + pk_state_offset(w->n_q, w->n, PK_LOW_Q), m);
    w->x.hi[m] = 1;
    w->x.lo[m] = 0;
}

static enum pk_status exponential_step(struct pk_integrator *it, pk_real limit)
{
    const struct work w = work_of(it);
    int k = 0;
    (void)limit;
    PK_TRY(matrix(it, &w, it->own->h, &k));
    load(&w, it->own->state);
    pk_pairs_multiply(w.y, w.x, w.E[k], 1, w.m);
    pk_copy(it->own->next, w.y.hi, w.m - 1);
    pk_copy(pk_next(it, PK_LOW_Q), w.y.lo, w.m - 1);
    it->own->flags = PK_HAVE_STEP;
    return PK_DONE;
}

/* Sums the Taylor series from the start of the last step, piece by piece, without the matrix. */
static enum pk_status exponential_dense(struct pk_integrator *it, pk_real t, pk_real *q, pk_real *v)
{
    const struct work w = work_of(it);
    const pk_real s = (t - it->last_t) / *w.piece, sign = s < 0 ? -1 : 1;
    const pk_real last = pk_max(PK_F(ceil)(pk_abs(s)) - 1, 0);
    if (!pk_finite(s))
        return PK_NOT_FINITE;
    if (!(it->own->flags & PK_HAVE_DENSE) || !(*w.at <= last)) {
        load(&w, it->own->next);
        for (size_t j = 0; j < w.m; j++)
            w.series.hi[j] = w.x.hi[j] * w.scale[j], w.series.lo[j] = w.x.lo[j] * w.scale[j];
        pk_expm_series(w.series, w.L, *w.piece, w.m, w.room);
        *w.at = 0;
        it->own->flags |= PK_HAVE_DENSE;
    }
    enum pk_status status = PK_DONE;
    for (; *w.at < last && status >= 0; *w.at += 1) {
        status = pk_expm_sum(w.y, w.series, sign, w.m);
        pk_copy(w.series.hi, w.y.hi, w.m);
        pk_copy(w.series.lo, w.y.lo, w.m);
        pk_expm_series(w.series, w.L, *w.piece, w.m, w.room);
    }
    if (status >= 0)
        status = pk_expm_sum(w.y, w.series, s - sign * last, w.m);
    for (size_t j = 0; j < w.n_q; j++)
        q[j] = w.y.hi[j] / w.scale[j];
    for (size_t j = 0; j < w.n; j++)
        v[j] = w.y.hi[w.n_q + j] / w.scale[w.n_q + j];
    return status;
}

/* Returns half a period of the fastest motion: the norm of L bounds frequencies and rates. */
static pk_real exponential_resolved(const struct pk_integrator *it)
{
    return PK_PI / *work_of(it).norm;
}

#define EXPONENTIAL(of)                                                                \
    .needs = PK_NEEDS_EXPONENTIAL, .size = exponential_size, .init = exponential_init, \
    .step = exponential_step, .dense = exponential_dense, .resolved = exponential_resolved
PK_METHODS_EXPONENTIAL(PK_DEFINE_METHOD, EXPONENTIAL)

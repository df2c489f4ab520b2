/* Linearised constraints and rotations; see rates.h. A rotation of the body by a small vector d
 * adds Q (0, d)/2 to its quaternion, so that d = 2 vec(Q* dQ).
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <gsl/gsl_blas.h>
#include <gsl/gsl_linalg.h>

#include "rates.h"

#include "../src/core/internal.h"

static const double DEPENDENT = 1e-9; /* relative to the largest singular value: smaller are 0 */

size_t pk_gsl_kept_count(const struct pk_problem *problem)
{
    const struct pk_system *system = problem->system;
    return system->constraints.n_holonomic + system->constraints.n + system->n_rotations;
}

void pk_gsl_residuals(const struct pk_problem *problem, const double *q, const double *v,
                      double *residuals, double *work)
{
    const struct pk_part_constraints *kept = &problem->system->constraints;
    if (kept->n_holonomic)
        kept->values(problem->params, 0, q, v, NULL, residuals);
    if (kept->n)
        kept->jacobian(problem->params, 0, q, v, NULL, work, residuals + kept->n_holonomic);
}

/* Writes a row of J to row `to` of C; its columns of body rates become columns of quaternions. */
static void fill(const struct pk_problem *problem, const double *v, const double *row, size_t to,
                 gsl_matrix *C)
{
    const struct pk_system *system = problem->system;
    const size_t m = pk_system_coordinates(system, problem->params);
    const size_t first = m + 3 * system->n_rotations;
    for (size_t j = 0; j < m; j++)
        gsl_matrix_set(C, to, j, row[j]);
    for (size_t r = 0; r < system->n_rotations; r++) {
        const double *Q = v + first + 4 * r, *d = row + m + 3 * r;
        const double by[4] = {
            -Q[1] * d[0] - Q[2] * d[1] - Q[3] * d[2], Q[0] * d[0] - Q[3] * d[1] + Q[2] * d[2],
            Q[3] * d[0] + Q[0] * d[1] - Q[1] * d[2], -Q[2] * d[0] + Q[1] * d[1] + Q[0] * d[2]};
        for (size_t i = 0; i < 4; i++)
            gsl_matrix_set(C, to, first + 4 * r + i, 2 * by[i]);
    }
}

/* Computes d(J v + j0) by coordinates and first-order variables, except body rates, by central
 * differences. */
static void by_places(const struct pk_problem *problem, double *q, double *v, double *work,
                      gsl_matrix *C)
{
    const struct pk_system *system = problem->system;
    const struct pk_part_constraints *kept = &system->constraints;
    const size_t n = pk_system_count(system, problem->params);
    const size_t m = pk_system_coordinates(system, problem->params);
    double *const up = work + kept->n * n, *const down = up + kept->n, most = 0;
    for (size_t i = 0; i < m; i++)
        most = fmax(most, fabs(q[i]));
    for (size_t j = 0; j < n; j++) {
        double *const x = j < m ? q + j : v + j, at = *x;
        const double d = 6e-6 * (j < m ? (most > 0 ? most : 1) : fmax(1, fabs(at)));
        if (j >= m && j < m + 3 * system->n_rotations)
            continue;
        *x = at + d;
        kept->jacobian(problem->params, 0, q, v, NULL, work, up);
        *x = at - d;
        kept->jacobian(problem->params, 0, q, v, NULL, work, down);
        *x = at;
        for (size_t i = 0; i < kept->n; i++)
            gsl_matrix_set(C, kept->n_holonomic + i, j, (up[i] - down[i]) / (2 * d));
    }
}

enum pk_status pk_gsl_kept(const struct pk_problem *problem, const double *q, const double *v,
                           gsl_matrix *C)
{
    const struct pk_system *system = problem->system;
    const struct pk_part_constraints *kept = &system->constraints;
    const size_t n = pk_system_count(system, problem->params);
    const size_t m = pk_system_coordinates(system, problem->params);
    const size_t c = kept->n, h = kept->n_holonomic, first = m + 3 * system->n_rotations;
    double *block = (double *)calloc(2 * c * n + 3 * c + 2 * n, sizeof *block);
    double *const J = block, *const place = J + c * n, *const work = place + 2 * n;
    if (!block)
        return PK_NO_MEMORY;
    gsl_matrix_set_zero(C);
    memcpy(place, q, n * sizeof *q);
    memcpy(place + n, v, n * sizeof *v);
    if (c) {
        kept->jacobian(problem->params, 0, q, v, NULL, J, work);
        by_places(problem, place, place + n, work, C);
    }
    for (size_t i = 0; i < c; i++) {
        if (i < h)
            fill(problem, v, J + i * n, i, C);
        for (size_t j = 0; j < first; j++) /* rates of coordinates, body rates */
            gsl_matrix_set(C, h + i, j < m ? n + j : j, J[i * n + j]);
    }
    for (size_t r = 0; r < system->n_rotations; r++)
        for (size_t i = 0; i < 4; i++)
            gsl_matrix_set(C, h + c + r, first + 4 * r + i, v[first + 4 * r + i]);
    const int finite = pk_all_finite(J, c * n) && !gsl_isnan(gsl_matrix_max(C));
    free(block);
    return finite ? PK_DONE : PK_NOT_FINITE;
}

/* Appends to T an orthonormal basis of the null space of C, restricted to the `count` rows `some`
 * of T; rows of C are scaled to length 1. Returns whether it succeeded. */
static int add_free(const gsl_matrix *C, const size_t *among, const size_t *some, size_t count,
                    gsl_matrix *T, size_t *columns)
{
    const size_t rows = count > C->size1 ? count : C->size1;
    gsl_matrix *B = gsl_matrix_calloc(rows, count), *V = gsl_matrix_alloc(count, count);
    gsl_vector *S = gsl_vector_alloc(count);
    int good = B && V && S;
    for (size_t i = 0; i < C->size1 && good; i++) {
        double size = 0;
        for (size_t j = 0; j < count; j++)
            size = hypot(size, gsl_matrix_get(C, i, among[some[j]]));
        for (size_t j = 0; j < count && size > 0; j++)
            gsl_matrix_set(B, i, j, gsl_matrix_get(C, i, among[some[j]]) / size);
    }
    good = good && !gsl_linalg_SV_decomp_jacobi(B, V, S);
    for (size_t k = 0; k < count && good; k++) {
        if (gsl_vector_get(S, k) > DEPENDENT * gsl_vector_get(S, 0))
            continue;
        for (size_t j = 0; j < count; j++)
            gsl_matrix_set(T, some[j], *columns, gsl_matrix_get(V, j, k));
        ++*columns;
    }
    gsl_matrix_free(B);
    gsl_matrix_free(V);
    gsl_vector_free(S);
    return good;
}

/* Returns whether number j of A is a rate of a coordinate or a body rate. */
static int is_rate(const struct pk_problem *problem, size_t j)
{
    const size_t n = pk_system_count(problem->system, problem->params);
    const size_t m = pk_system_coordinates(problem->system, problem->params);
    return j >= n || (j >= m && j < m + 3 * problem->system->n_rotations);
}

/* Returns T^T A T. Entries that are round-off relative to A's entries of the same kind (positions
 * or rates, by positions or rates) are set to 0: a free motion's eigenvalues would be their square
 * root. */
static gsl_matrix *projected(const struct pk_problem *problem, const size_t *among,
                             const gsl_matrix *A, const gsl_matrix *T, const int *rates)
{
    const size_t N = T->size1, k = T->size2;
    gsl_matrix *AT = gsl_matrix_alloc(N, k), *found = gsl_matrix_alloc(k, k);
    double most[2][2] = {{0, 0}, {0, 0}};
    for (size_t i = 0; i < N; i++)
        for (size_t j = 0; j < N; j++) {
            double *x = &most[is_rate(problem, among[i])][is_rate(problem, among[j])];
            *x = fmax(*x, fabs(gsl_matrix_get(A, i, j)));
        }
    if (AT && found) {
        gsl_blas_dgemm(CblasNoTrans, CblasNoTrans, 1, A, T, 0, AT);
        gsl_blas_dgemm(CblasTrans, CblasNoTrans, 1, T, AT, 0, found);
        for (size_t i = 0; i < k; i++)
            for (size_t j = 0; j < k; j++)
                if (rates[i] >= 0 &&
                    fabs(gsl_matrix_get(found, i, j)) <= 1e-13 * most[rates[i]][rates[j]])
                    gsl_matrix_set(found, i, j, 0);
    }
    gsl_matrix_free(AT);
    return found;
}

enum pk_status pk_gsl_tangent(const struct pk_problem *problem, const double *q, const double *v,
                              const size_t *among, gsl_matrix **A, gsl_matrix **T)
{
    const size_t N = (*A)->size1, kept = pk_gsl_kept_count(problem);
    const size_t n = pk_system_count(problem->system, problem->params);
    const size_t h = problem->system->constraints.n_holonomic, c = problem->system->constraints.n;
    const size_t all = n + pk_system_coordinates(problem->system, problem->params);
    gsl_matrix *C = gsl_matrix_alloc(kept, all), *wide = gsl_matrix_calloc(N, N), *less = NULL;
    size_t *some = (size_t *)calloc(N, sizeof *some), columns = 0;
    int *rates = (int *)calloc(N, sizeof *rates), mixed = 0, good = 1;
    enum pk_status status = C && wide && some && rates ? PK_DONE : PK_NO_MEMORY;
    *T = NULL;
    if (status == PK_DONE)
        status = pk_gsl_kept(problem, q, v, C);
    for (size_t i = h; i < h + c && status == PK_DONE; i++) /* J v + j0 depends on positions */
        for (size_t j = 0; j < N; j++)
            mixed |= !is_rate(problem, among[j]) && fabs(gsl_matrix_get(C, i, among[j])) > 0;
    for (int part = 0; part < 2 && status == PK_DONE && good; part++) {
        size_t count = 0;
        const size_t before = columns;
        for (size_t j = 0; j < N; j++)
            if (mixed ? !part : is_rate(problem, among[j]) == part)
                some[count++] = j;
        good = !count || add_free(C, among, some, count, wide, &columns);
        for (size_t k = before; k < columns; k++)
            rates[k] = mixed ? -1 : part;
    }
    if (status == PK_DONE && !good)
        status = PK_NO_CONVERGENCE;
    if (status == PK_DONE && !columns)
        status = PK_REFUSED;
    if (status == PK_DONE && (*T = gsl_matrix_alloc(N, columns))) {
        gsl_matrix_const_view first = gsl_matrix_const_submatrix(wide, 0, 0, N, columns);
        gsl_matrix_memcpy(*T, &first.matrix);
        less = projected(problem, among, *A, *T, rates);
    }
    if (less) {
        gsl_matrix_free(*A);
        *A = less;
    } else if (status == PK_DONE) {
        status = PK_NO_MEMORY;
    }
    gsl_matrix_free(C);
    gsl_matrix_free(wide);
    free(some);
    free(rates);
    return status;
}

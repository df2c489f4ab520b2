/* Linearised constraints and rotations; see rates.h. A rotation of the body by a small vector d
 * adds Q (0, d)/2 to its quaternion, so that d = 2 vec(Q* dQ).
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "rates.h"

#include "../src/core/internal.h"

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
    const int finite = pk_all_finite(J, c * n) && !isnan(gsl_matrix_max(C));
    free(block);
    return finite ? PK_DONE : PK_NOT_FINITE;
}

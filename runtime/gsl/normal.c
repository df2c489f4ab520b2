/* Normal coordinates of a natural system; see pk/gsl_equilibria.h. K u = omega^2 M u by Cholesky's
 * factors of M and symmetric QR (gsl_eigen_gensymmv).
 */
#include <math.h>
#include <stdlib.h>

#include <gsl/gsl_eigen.h>
#include <gsl/gsl_errno.h>

#include <pk/gsl_equilibria.h>

#include "../src/core/internal.h"

static const double SAME = 1e-12; /* of what is to cancel, beside what there is */

static double largest(const double *A, size_t count)
{
    double most = 0;
    for (size_t i = 0; i < count; i++)
        most = fmax(most, fabs(A[i]));
    return most;
}

/* M, and K = -d(pdot)/dq made symmetric. PK_REFUSED where rates act besides, or K is no Hessian. */
static enum pk_status pencil(const struct pk_problem *problem, size_t n, const double *q, double *M,
                             double *K, double *work)
{
    const struct pk_system *system = problem->system;
    double *P = work, *G = P + n * n, *rest = G + n * n;
    for (size_t i = 0; i < n; i++)
        rest[i] = 0;
    system->mass(problem->params, 0, q, rest, NULL, M);
    system->jacobian(problem->params, 0, q, rest, NULL, P, K, G);
    if (!pk_all_finite(M, n * n) || !pk_all_finite(K, n * n) || !pk_all_finite(work, 2 * n * n))
        return PK_NOT_FINITE;
    const double k = largest(K, n * n), m = largest(M, n * n);
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j <= i; j++) {
            const size_t a = i * n + j, b = j * n + i;
            if (fabs(P[a] - G[a]) > SAME * sqrt(k * m) || fabs(P[b] - G[b]) > SAME * sqrt(k * m) ||
                fabs(K[a] - K[b]) > SAME * k)
                return PK_REFUSED;
            K[a] = K[b] = -(K[a] + K[b]) / 2;
        }
    return PK_DONE;
}

/* Mode k of `U`, column k, to a row of its own: of unit mass, the largest component positive. */
static void take(size_t n, const double *M, const gsl_matrix *U, size_t k, double *shape)
{
    double mass = 0, most = 0;
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < n; j++)
            mass += gsl_matrix_get(U, i, k) * M[i * n + j] * gsl_matrix_get(U, j, k);
    for (size_t i = 0; i < n; i++)
        if (fabs(gsl_matrix_get(U, i, k)) > fabs(most) * (1 + 1e-9))
            most = gsl_matrix_get(U, i, k);
    for (size_t i = 0; i < n; i++)
        shape[i] = gsl_matrix_get(U, i, k) / (most < 0 ? -sqrt(mass) : sqrt(mass));
}

enum pk_status pk_gsl_normal(const struct pk_problem *problem, const double *q, double *M,
                             double *squares, double *shapes)
{
    const size_t n = pk_system_count(problem->system, problem->params);
    if (!problem->system->mass || !problem->system->jacobian)
        return PK_REFUSED;
    double *block = (double *)malloc((4 * n * n + n) * sizeof *block);
    if (!block)
        return PK_NO_MEMORY;
    double *K = block, *copy = K + n * n, *work = copy + n * n;
    enum pk_status status = pencil(problem, n, q, M, K, work);
    if (status == PK_DONE) {
        gsl_error_handler_t *handler = gsl_set_error_handler_off();
        gsl_eigen_gensymmv_workspace *w = gsl_eigen_gensymmv_alloc(n);
        gsl_vector *square = gsl_vector_alloc(n);
        gsl_matrix *U = gsl_matrix_alloc(n, n);
        for (size_t i = 0; i < n * n; i++)
            copy[i] = M[i];
        const size_t singular = pk_ldl_factor(copy, n);
        for (size_t i = 0; i < n * n; i++)
            copy[i] = M[i];
        gsl_matrix_view k = gsl_matrix_view_array(K, n, n), m = gsl_matrix_view_array(copy, n, n);
        if (!w || !square || !U)
            status = PK_NO_MEMORY;
        else if (singular || gsl_eigen_gensymmv(&k.matrix, &m.matrix, square, U, w))
            status = PK_SINGULAR_MASS;
        else
            gsl_eigen_gensymmv_sort(square, U, GSL_EIGEN_SORT_VAL_ASC);
        for (size_t i = 0; i < n && status == PK_DONE; i++) {
            squares[i] = gsl_vector_get(square, i);
            take(n, M, U, i, shapes + i * n);
        }
        const double most = status == PK_DONE ? largest(squares, n) : 0;
        for (size_t i = 0; i < n && status == PK_DONE; i++)
            if (fabs(squares[i]) <= SAME * most)
                squares[i] = 0;
        gsl_eigen_gensymmv_free(w);
        gsl_vector_free(square);
        gsl_matrix_free(U);
        gsl_set_error_handler(handler);
    }
    free(block);
    return status;
}

void pk_normal_energies(size_t n, const double *M, const double *squares, const double *shapes,
                        const double *q, const double *p, double *E)
{
    for (size_t k = 0; k < n; k++) {
        const double *u = shapes + k * n;
        double Q = 0, P = 0;
        for (size_t i = 0; i < n; i++) {
            double row = 0;
            for (size_t j = 0; j < n; j++)
                row += M[i * n + j] * q[j];
            Q += u[i] * row;
            P += u[i] * p[i];
        }
        E[k] = (P * P + squares[k] * Q * Q) / 2;
    }
}

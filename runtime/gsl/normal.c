/* Normal modes u of a natural system with the mass matrix M and the stiffness matrix K: the
 * solutions of K u = omega^2 M u; see pk/gsl_equilibria.h. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <pk/gsl.h>
#include <pk/gsl_equilibria.h>

#include "../src/core/internal.h"

/* numbers below this fraction of the scale of K and M count as 0 */
static const double SAME = 1e-12;

/* Computes M and the symmetric part K of -d(pdot)/dq. Returns PK_REFUSED if forces depend on rates,
 * or the matrix is not symmetric. */
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
    const double k = pk_largest(K, n * n), m = pk_largest(M, n * n);
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

/* Copies column k of U, a mode, to `shape`, with the sign that makes its largest entry positive. */
static void take(size_t n, const double *U, size_t k, double *shape)
{
    double most = 0;
    for (size_t i = 0; i < n; i++)
        if (fabs(U[i * n + k]) > fabs(most) * (1 + 1e-9))
            most = U[i * n + k];
    for (size_t i = 0; i < n; i++)
        shape[i] = most < 0 ? -U[i * n + k] : U[i * n + k];
}

enum pk_status pk_gsl_normal(const struct pk_problem *problem, const double *q, double *M,
                             double *squares, double *shapes)
{
    const size_t n = pk_count_of(problem);
    if (!problem->system->mass || !problem->system->jacobian)
        return PK_REFUSED;
    double *K = (double *)malloc((4 * n * n + n) * sizeof *K);
    if (!K)
        return PK_NO_MEMORY;
    double *U = K + n * n, *work = U + n * n;
    enum pk_status status = pencil(problem, n, q, M, K, work);
    if (status == PK_DONE) {
        memcpy(work, M, n * n * sizeof *M);
        status = pk_ldl_factor(work, n) ? PK_SINGULAR_MASS : pk_gsl_pencil(n, K, M, squares, U);
    }
    const double most = status == PK_DONE ? pk_largest(squares, n) : 0;
    for (size_t i = 0; i < n && status == PK_DONE; i++) {
        take(n, U, i, shapes + i * n);
        if (fabs(squares[i]) <= SAME * most)
            squares[i] = 0;
    }
    free(K);
    return status;
}

void pk_normal_energies(size_t n, const double *M, const double *squares, const double *shapes,
                        const double *q, const double *p, double *E)
{
    for (size_t k = 0; k < n; k++) {
        const double *u = shapes + k * n;
        const double P = pk_dot(u, p, n);
        double Q = 0;
        for (size_t i = 0; i < n; i++)
            Q += u[i] * pk_dot(M + i * n, q, n);
        E[k] = (P * P + squares[k] * Q * Q) / 2;
    }
}

/* Functions for implicit methods, in addition to pk/step/state.h: Jacobians of an integrator's
 * problem, and small dense linear algebra. */
#ifndef PK_STEP_LINEAR_H
#define PK_STEP_LINEAR_H

#include <pk/step/state.h>

PK_BEGIN

/* Computes the acceleration and its derivatives (pk/linear.h), counts calls, reports a failure. */
enum pk_status pk_eval_linear(struct pk_integrator *it, pk_real t, const pk_real *q,
                              const pk_real *v, pk_real *a, pk_real *a_q, pk_real *a_v,
                              pk_real *a_t, pk_real *work);

/* Converts an index that is stored as a pk_real to an integer < count; count > 0. Returns 0 if the
 * index is invalid, as it may be in restored bytes of unknown origin (pk/keep.h). */
static inline size_t pk_index(pk_real x, size_t count)
{
    return x >= 0 && x < (pk_real)count ? (size_t)x : 0;
}

/* Computes y += A x for an n by n matrix A, row-major. */
void pk_add_product(pk_real *y, const pk_real *A, const pk_real *x, size_t n);
/* Factors A = P L U in place, m by m; `pivot` gets exchanged rows. Returns 0 if A is singular. */
int pk_lu_factor(pk_real *A, pk_real *pivot, size_t m);
void pk_lu_solve(const pk_real *A, const pk_real *pivot, size_t m, pk_real *x);
/* Returns the determinant of a factored matrix, and its sign in *sign, also if it underflows. */
pk_real pk_lu_determinant(const pk_real *A, const pk_real *pivot, size_t m, int *sign);
/* Factors A = L D L^T in place, A symmetric. Returns 0, or 1 + i if pivot i is not positive or,
 * relative to A_ii, so small that it may be rounding (PK_PIVOT_MIN). */
size_t pk_ldl_factor(pk_real *A, size_t n);
void pk_ldl_solve(const pk_real *A, size_t n, pk_real *x);
/* Returns the diagonal entry A_kk of a factored matrix. */
pk_real pk_ldl_diagonal(const pk_real *A, size_t n, size_t k);

PK_END

#endif

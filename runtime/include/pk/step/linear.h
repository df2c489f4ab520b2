/* What methods outside the core need beyond pk/step/state.h: derivatives through the integrator,
 * and small dense linear algebra.
 */
#ifndef PK_STEP_LINEAR_H
#define PK_STEP_LINEAR_H

#include <pk/step/state.h>

PK_BEGIN

/* The acceleration and its derivatives, see pk/linear.h; counted, a failure named. */
enum pk_status pk_eval_linear(struct pk_integrator *it, pk_real t, const pk_real *q,
                              const pk_real *v, pk_real *a, pk_real *a_q, pk_real *a_v,
                              pk_real *a_t, pk_real *work);

/* An index that is kept as a number, below `count`, which is not 0. One that is none, as a block
 * may have that came from elsewhere (pk/keep.h), is 0. */
static inline size_t pk_index(pk_real x, size_t count)
{
    return x >= 0 && x < (pk_real)count ? (size_t)x : 0;
}

/* y += A x, A row-major n by n. */
void pk_add_product(pk_real *y, const pk_real *A, const pk_real *x, size_t n);
/* A = P L U in place, row-major m by m; pivot holds row numbers. 0 where A is singular. */
int pk_lu_factor(pk_real *A, pk_real *pivot, size_t m);
void pk_lu_solve(const pk_real *A, const pk_real *pivot, size_t m, pk_real *x);
/* The determinant of what is factored, and its sign. */
pk_real pk_lu_determinant(const pk_real *A, const pk_real *pivot, size_t m, int *sign);
/* A = L D L^T in place, A symmetric. 0, or 1 + i where pivot i is not positive, or so small
 * beside A_ii that it is rounding (PK_PIVOT_MIN, as in generated accelerations). */
size_t pk_ldl_factor(pk_real *A, size_t n);
void pk_ldl_solve(const pk_real *A, size_t n, pk_real *x);
/* A_kk, of what is factored. */
pk_real pk_ldl_diagonal(const pk_real *A, size_t n, size_t k);

PK_END

#endif

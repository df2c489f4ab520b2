/* What the core's files share: round-off, the layout of a state, kernel calls that count and
 * name their failures, small dense linear algebra. Not installed.
 */
#ifndef PK_INTERNAL_H
#define PK_INTERNAL_H

#include <float.h>

#include <pk/integrator.h>

#if defined PK_FLOAT
#define PK_EPS FLT_EPSILON
#define PK_TINY FLT_MIN
#elif defined PK_LONG_DOUBLE
#define PK_EPS LDBL_EPSILON
#define PK_TINY LDBL_MIN
#elif defined PK_FLOAT128
#define PK_EPS FLT128_EPSILON
#define PK_TINY FLT128_MIN
#else
#define PK_EPS DBL_EPSILON
#define PK_TINY DBL_MIN
#endif

/* Parts of it->state and of it->next, n numbers each: q, v, p, the compensations (low parts) of
 * q and of v or p, and an acceleration that belongs to this state and may be reused. */
enum { PK_Q, PK_V, PK_P, PK_LOW_Q, PK_LOW_X, PK_A, PK_PARTS };

/* it->flags */
enum { PK_HAVE_A = 1, PK_HAVE_LU = 2, PK_HAVE_STEP = 4, PK_HAVE_DENSE = 8, PK_REFRESH = 16 };

static inline pk_real *pk_part(pk_real *state, size_t n, int part)
{
    return state + (size_t)part * n;
}

static inline pk_real pk_max(pk_real a, pk_real b) { return a > b ? a : b; }
static inline pk_real pk_min(pk_real a, pk_real b) { return a < b ? a : b; }
static inline pk_real pk_abs(pk_real a) { return PK_F(fabs)(a); }

/* x - x is 0 for finite x alone; works for every scalar type, as isfinite() does not. */
static inline int pk_finite(pk_real x) { return x - x == PK_C(0.0); }

int pk_all_finite(const pk_real *x, size_t count);

/* x + low + d, rounded once, and its new low part: Knuth's two-sum, exact also where |d| > |x|.
 * Compensated summation after Kahan (1965), Babuska, Neumaier (1974). */
static inline pk_real pk_sum(pk_real x, pk_real d, pk_real *low)
{
    const pk_real y = d + *low;
    const pk_real sum = x + y;
    const pk_real back = sum - x;
    *low = (x - (sum - back)) + (y - back);
    return sum;
}

/* it->where of PK_BAD_ARGUMENT. */
enum {
    BAD_POINTER = 1,
    BAD_SYSTEM,
    BAD_STEP,
    BAD_TOLERANCE,
    BAD_STATE,
    BAD_TIME,
    BAD_DENSE,
    BAD_ITERATION,
    BAD_PARAMS
};

/* Checks before the first step; scratch holds pk_params_reals() numbers. */
size_t pk_params_reals(const struct pk_system *system);
enum pk_status pk_check_params(struct pk_integrator *it, pk_real *scratch);
enum pk_status pk_check_options(struct pk_integrator *it);

/* The status of an adaptive method whose step h became too small, with its cause if known. */
enum pk_status pk_underflow(struct pk_integrator *it, pk_real h);

/* Kernels through the integrator: inputs filled, calls counted, failures named. */
const pk_real *pk_eval_input(struct pk_integrator *it, pk_real t);
enum pk_status pk_eval_acceleration(struct pk_integrator *it, pk_real t, const pk_real *q,
                                    const pk_real *v, pk_real *a);
void pk_eval_canonical(struct pk_integrator *it, pk_real t, const pk_real *q, const pk_real *v,
                       pk_real *p, pk_real *pdot);

/* A = P L U in place, row-major m by m; pivot holds row numbers. 0 where A is singular. */
int pk_lu_factor(pk_real *A, pk_real *pivot, size_t m);
void pk_lu_solve(const pk_real *A, const pk_real *pivot, size_t m, pk_real *x);
/* A = L D L^T in place, A symmetric. 0, or 1 + i where pivot i is not positive, or so small
 * beside A_ii that it is rounding (PK_PIVOT_MIN, as in generated accelerations). */
size_t pk_ldl_factor(pk_real *A, size_t n);
void pk_ldl_solve(const pk_real *A, size_t n, pk_real *x);

#endif

/* The arithmetic of steps: round-off, compensated sums, the layout of a state. Needs only
 * pk/real.h, since C exports without the runtime contain this text too. */
#ifndef PK_STEP_NUMBERS_H
#define PK_STEP_NUMBERS_H

#include <float.h>
#include <stddef.h>

#include <pk/real.h>

#define PK_EPS PK_EPSILON
#if defined PK_FLOAT
#define PK_TINY FLT_MIN
#elif defined PK_LONG_DOUBLE
#define PK_TINY LDBL_MIN
#elif defined PK_FLOAT128
#define PK_TINY FLT128_MIN
#else
#define PK_TINY DBL_MIN
#endif

/* Parts of it->own->state and it->own->next: q, v, p, the low parts of q and of v or p
 * (compensations of their sums), and the acceleration at this state, which the next step may reuse.
 * q and its low part have n_q numbers, the others n; the last n - n_q are first-order. */
enum { PK_Q, PK_V, PK_P, PK_LOW_Q, PK_LOW_X, PK_A, PK_PARTS };

/* Returns the offset of a part of the state. */
static inline size_t pk_state_offset(size_t n_q, size_t n, int part)
{
    const size_t of_q = (size_t)(part > PK_Q) + (size_t)(part > PK_LOW_Q);
    return of_q * n_q + ((size_t)part - of_q) * n;
}

static inline pk_real *pk_part(pk_real *state, size_t n_q, size_t n, int part)
{
    return state + pk_state_offset(n_q, n, part);
}

static inline pk_real pk_max(pk_real a, pk_real b) { return a > b ? a : b; }
static inline pk_real pk_min(pk_real a, pk_real b) { return a < b ? a : b; }
static inline pk_real pk_abs(pk_real a) { return PK_F(fabs)(a); }

/* x - x is 0 only for finite x; unlike isfinite(), this works for every scalar type. */
static inline int pk_finite(pk_real x) { return x - x == 0; }

/* Returns a + b rounded, and the rounding error in *rest: Knuth's two-sum. */
static inline pk_real pk_pair_sum(pk_real a, pk_real b, pk_real *rest)
{
    const pk_real sum = a + b, back = sum - a;
    *rest = (a - (sum - back)) + (b - back);
    return sum;
}

/* Returns x + low + d, rounded once, and sets the new low part, exact also for |d| > |x|.
 * Compensated summation after Kahan (1965), Babuska, Neumaier (1974). */
static inline pk_real pk_sum(pk_real x, pk_real d, pk_real *low)
{
    return pk_pair_sum(x, d + *low, low);
}

/* Evaluates a call; if it fails, the calling function returns its status. */
#define PK_TRY(call)                           \
    do {                                       \
        const enum pk_status of_call = (call); \
        if (of_call < 0)                       \
            return of_call;                    \
    } while (0)

#endif

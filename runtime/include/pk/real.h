/* The scalar type of kernels and runtime: double, or with -DPK_FLOAT float, -DPK_LONG_DOUBLE
 * long double, -DPK_FLOAT128 gcc's __float128 (link with -lquadmath).
 *
 * PK_C(0.5) is a constant of that type, PK_F(sin) the <math.h> function for it, PK_EPSILON the
 * gap between 1 and the next number.
 *
 * MIT-0: pkgen pastes this text into the headers that it generates; see LICENSE.
 */
#ifndef PK_REAL_H
#define PK_REAL_H

#include <float.h>
#include <math.h>
#include <stdint.h>

#if defined PK_FLOAT
typedef float pk_real;
#define PK_C(x) x##F
#define PK_F(name) name##f
#define PK_EPSILON FLT_EPSILON
#define PK_INFINITY INFINITY /* an infinite float; not all C libraries have HUGE_VALF */
#elif defined PK_LONG_DOUBLE
typedef long double pk_real;
#define PK_C(x) x##L
#define PK_F(name) name##l
#define PK_EPSILON LDBL_EPSILON
#define PK_INFINITY HUGE_VALL
#elif defined PK_FLOAT128
#include <quadmath.h>
__extension__ typedef __float128 pk_real;
#define PK_C(x) x##Q
#define PK_F(name) name##q
#define PK_EPSILON FLT128_EPSILON
#define PK_INFINITY HUGE_VALQ
#else
typedef double pk_real;
#define PK_C(x) x
#define PK_F(name) name
#define PK_EPSILON DBL_EPSILON
#define PK_INFINITY HUGE_VAL
#endif

/* The result of a kernel that can fail: 0, or PK_FAILED(failure, number), where the number is the
 * index of what failed. PK_FAILURE() and PK_FAILURE_AT() return the failure and the number. */
enum pk_failure {
    PK_FAILURE_MASS = 1,   /* pivot i of M = L D L^T is not positive: M is singular or indefinite */
    PK_FAILURE_CONSTRAINT, /* row k of the constraints depends on previous rows */
    PK_FAILURE_PARAMETER,  /* parameter k is outside its bounds, or not finite */
    PK_FAILURE_DERIVED,    /* a number computed from the parameters is not finite (1/m at m = 0) */
    PK_FAILURE_SIZE        /* the length of a family is below its least */
};
#define PK_FAILED(failure, number) ((int)(failure) + 8 * (int)(number))
#define PK_FAILURE(value) ((enum pk_failure)((value) % 8))
#define PK_FAILURE_AT(value) ((value) / 8)

#define PK_PI PK_C(3.14159265358979323846264338327950288)

/* An unsigned type as wide as pk_real if possible, for flags in SIMD lanes. */
#ifdef PK_FLOAT
typedef uint32_t pk_bits;
#else
typedef uint64_t pk_bits;
#endif

/* Number of states in the lanes of a kernel: two vectors of AVX2, one of AVX-512. On x86 gcc 12
 * vectorises lanes from SSE4.2 on, not for plain SSE2: use -march=native. */
#define PK_LANES 8

/* C++ has no `restrict`, but its compilers have. */
#if defined __cplusplus && (defined __GNUC__ || defined _MSC_VER)
#define PK_RESTRICT __restrict
#elif defined __cplusplus
#define PK_RESTRICT
#else
#define PK_RESTRICT restrict
#endif

#if defined __GNUC__
#define PK_INLINE inline __attribute__((always_inline, unused))
#define PK_PERHAPS __attribute__((unused))
#define PK_RARELY __attribute__((noinline, cold))
#else
#define PK_INLINE inline
#define PK_PERHAPS
#define PK_RARELY
#endif

/* How a kernel that may fail is run. PK_IN_LANE: in a SIMD lane, without branches. PK_IN_MEMBER:
 * likewise, for an ensemble member, whose own parameters are checked too. PK_ONCE: alone, without
 * the code for rare cases, which is slow. PK_CAREFULLY: alone, with that code. */
enum pk_pass { PK_IN_LANE, PK_IN_MEMBER, PK_ONCE, PK_CAREFULLY };

/* PK_LANE_LOOP is written before a for statement whose iterations are independent. gcc would unroll
 * a short loop of 8 iterations before it looks for vectors, and find none. (clang finds them by
 * `restrict`; a pragma of its own would warn wherever it cannot vectorise.) */
#if defined __GNUC__ && !defined __clang__
#define PK_LANE_LOOP _Pragma("GCC ivdep") _Pragma("GCC unroll 1")
#else
#define PK_LANE_LOOP
#endif

/* A pivot of M counts as rounding error if it is smaller than PK_PIVOT_MIN times its diagonal
 * entry. */
#define PK_PIVOT_MIN (16 * PK_EPSILON)

#endif

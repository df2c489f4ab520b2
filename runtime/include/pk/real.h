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
#define PK_INFINITY INFINITY /* a float; not all have HUGE_VALF */
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

/* What a kernel that can fail returns: 0, or which failure it is and the number of what failed. Of
 * such a value, say PK_FAILED(PK_FAILURE_MASS, i), PK_FAILURE() and PK_FAILURE_AT() are the
 * parts. */
enum pk_failure {
    PK_FAILURE_MASS = 1,   /* pivot i of M = L D L^T is not positive: M is singular or indefinite */
    PK_FAILURE_CONSTRAINT, /* row k of the constraints depends on those before it */
    PK_FAILURE_PARAMETER,  /* parameter k is outside its bounds, or not finite */
    PK_FAILURE_DERIVED,    /* what follows from the parameters is not finite (1/m at m = 0) */
    PK_FAILURE_SIZE        /* a size is too small */
};
#define PK_FAILED(failure, number) ((int)(failure) + 8 * (int)(number))
#define PK_FAILURE(value) ((enum pk_failure)((value) % 8))
#define PK_FAILURE_AT(value) ((value) / 8)

#define PK_PI PK_C(3.14159265358979323846264338327950288)

/* Unsigned, as wide as pk_real where that can be: flags of a lane beside its numbers. */
#ifdef PK_FLOAT
typedef uint32_t pk_bits;
#else
typedef uint64_t pk_bits;
#endif

/* States that a lane kernel takes side by side: two vectors of AVX2, one of AVX-512. On x86 gcc 12
 * makes vector code of lanes from SSE4.2 on, not of plain SSE2: give -march=native. */
#define PK_LANES 8

/* C++ has no such word, but compilers have. */
#if defined __cplusplus && (defined __GNUC__ || defined _MSC_VER)
#define PK_RESTRICT __restrict
#elif defined __cplusplus
#define PK_RESTRICT
#else
#define PK_RESTRICT restrict
#endif

#if defined __GNUC__
#define PK_INLINE inline __attribute__((always_inline, unused))
#define PK_RARELY __attribute__((noinline, cold))
#else
#define PK_INLINE inline
#define PK_RARELY
#endif

/* How a kernel that may fail is run: in a lane without any branch, so too as a member with its own
 * parameters (those of lanes are checked ahead), once without slow cases, or carefully, with all
 * of them. */
enum pk_pass { PK_IN_LANE, PK_IN_MEMBER, PK_ONCE, PK_CAREFULLY };

/* Before a loop whose turns do not depend on each other. gcc would unroll a short one of 8 turns
 * ahead of looking for vectors, and find none. (clang sees that by `restrict`, and would warn
 * where it cannot do what a pragma of its own demands.) */
#if defined __GNUC__ && !defined __clang__
#define PK_LANE_LOOP _Pragma("GCC ivdep") _Pragma("GCC unroll 1")
#else
#define PK_LANE_LOOP
#endif

/* A pivot of M smaller than this, relative to its diagonal entry, is lost in rounding. */
#define PK_PIVOT_MIN (16 * PK_EPSILON)

#endif

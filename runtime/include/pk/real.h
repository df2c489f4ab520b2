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

#if defined PK_FLOAT
typedef float pk_real;
#define PK_C(x) x##F
#define PK_F(name) name##f
#define PK_EPSILON FLT_EPSILON
#define PK_INFINITY HUGE_VALF
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

#define PK_PI PK_C(3.14159265358979323846264338327950288)
/* A pivot of M smaller than this, relative to its diagonal entry, is lost in rounding. */
#define PK_PIVOT_MIN (16 * PK_EPSILON)
/* Lane kernels take so many states side by side, as a structure of arrays: q[i * PK_LANES + l] is
 * coordinate i of lane l. Eight doubles are one register of AVX-512, two of AVX2, four of NEON. */
#define PK_LANES 8

#endif

/* The scalar type of kernels and runtime: double, or with -DPK_FLOAT float, -DPK_LONG_DOUBLE
 * long double, -DPK_FLOAT128 gcc's __float128 (link with -lquadmath).
 *
 * PK_C(0.5) is a constant of that type, PK_F(sin) the <math.h> function for it.
 *
 * MIT-0: pkgen pastes this text into the headers that it generates; see LICENSE.
 */
#ifndef PK_REAL_H
#define PK_REAL_H

#include <math.h>

#if defined PK_FLOAT
typedef float pk_real;
#define PK_C(x) x##F
#define PK_F(f) f##f
#elif defined PK_LONG_DOUBLE
typedef long double pk_real;
#define PK_C(x) x##L
#define PK_F(f) f##l
#elif defined PK_FLOAT128
#include <quadmath.h>
__extension__ typedef __float128 pk_real;
#define PK_C(x) x##Q
#define PK_F(f) f##q
#else
typedef double pk_real;
#define PK_C(x) x
#define PK_F(f) f
#endif

#endif

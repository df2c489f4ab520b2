/* Finds a root of a function in an interval. */
#ifndef PK_ROOT_H
#define PK_ROOT_H

#include <pk/real.h>
#include <pk/status.h>

PK_BEGIN

/* Computes y = f(x); a negative status ends the search. */
typedef enum pk_status (*pk_function)(void *context, pk_real x, pk_real *y);

/* Shrinks the interval [*a, *b], at whose ends f has values fa and fb of opposite signs (fb may be
 * 0), until b - a <= width or a and b are adjacent numbers; f(*b) keeps the sign of fb, or is 0. */
enum pk_status pk_root(pk_function f, void *context, pk_real *a, pk_real fa, pk_real *b, pk_real fb,
                       pk_real width);

PK_END

#endif

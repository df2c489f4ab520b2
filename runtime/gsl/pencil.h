/* Symmetric pencils K u = lambda M u, M positive definite. Not installed. */
#ifndef PK_GSL_PENCIL_H
#define PK_GSL_PENCIL_H

#include <stddef.h>

#include <pk/status.h>

/* lambda rising and the columns u of U, n by n, so that u.M u = 1; K and M are left as they are, of
 * each the lower triangle is read. PK_SINGULAR_MASS where M is not positive definite. */
enum pk_status pk_gsl_pencil(size_t n, const double *K, const double *M, double *lambda, double *U);
/* The largest of some numbers without their signs. */
double pk_gsl_largest(const double *x, size_t count);

#endif

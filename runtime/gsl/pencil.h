/* Generalised symmetric eigenproblems K u = lambda M u, M positive definite. Not installed. */
#ifndef PK_GSL_PENCIL_H
#define PK_GSL_PENCIL_H

#include <stddef.h>

#include <pk/status.h>

/* Computes lambda, ascending, and the eigenvectors u, columns of U (n by n) with u.M u = 1. Reads
 * the lower triangles of K and M. Returns PK_SINGULAR_MASS if M is not positive definite. */
enum pk_status pk_gsl_pencil(size_t n, const double *K, const double *M, double *lambda, double *U);
/* Returns the largest |x_i|. */
double pk_gsl_largest(const double *x, size_t count);

#endif

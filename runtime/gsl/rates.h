/* The linearised equations as z' = A z. Not installed. */
#ifndef PK_GSL_RATES_H
#define PK_GSL_RATES_H

#include <gsl/gsl_matrix.h>

#include <pk/integrator.h>

/* A at a state, N by N with N = n + m of m coordinates: z = (displacements of the coordinates and
 * of the first-order variables, in the order of the degrees of freedom; those of the coordinates'
 * rates). The statuses of pk_system_linear(), PK_NO_MEMORY. */
enum pk_status pk_gsl_linearised(const struct pk_problem *problem, double t, const double *q,
                                 const double *v, gsl_matrix *A);

/* Numbers that rotations and constraints keep at 0, and their derivatives: phi of the n_holonomic
 * constraints, J v + j0 of all n, and of each rotation (|Q|^2 - 1)/2, which is not among the
 * residuals. `work`: n times the degrees of freedom. C: as many rows as numbers, columns as A; by
 * differences where rates are not 0. PK_NOT_FINITE, PK_NO_MEMORY. */
void pk_gsl_residuals(const struct pk_problem *problem, const double *q, const double *v,
                      double *residuals, double *work);
enum pk_status pk_gsl_kept(const struct pk_problem *problem, const double *q, const double *v,
                           gsl_matrix *C);
/* Rows of C. */
size_t pk_gsl_kept_count(const struct pk_problem *problem);
/* Of N numbers `among` the columns of A, whose own matrix *A is, an orthonormal basis T, N by k, of
 * the displacements that keep C's; *A becomes T^T A T, k by k. Both are the caller's to free.
 * PK_REFUSED, and *T is NULL, where nothing can move. */
enum pk_status pk_gsl_tangent(const struct pk_problem *problem, const double *q, const double *v,
                              const size_t *among, gsl_matrix **A, gsl_matrix **T);

#endif

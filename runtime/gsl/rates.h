/* The linearised equations as z' = A z. Not installed. */
#ifndef PK_GSL_RATES_H
#define PK_GSL_RATES_H

#include <gsl/gsl_matrix.h>

#include <pk/integrator.h>

/* Computes A at a state, N by N with N = n + m for m coordinates. z = (displacements of coordinates
 * and first-order variables, in the order of the degrees of freedom; displacements of the
 * coordinates' rates). Statuses of pk_system_linear(), PK_NO_MEMORY. */
enum pk_status pk_gsl_linearised(const struct pk_problem *problem, double t, const double *q,
                                 const double *v, gsl_matrix *A);

/* Numbers that rotations and constraints keep at 0, and their derivatives C: phi of the n_holonomic
 * constraints, J v + j0 of all n, then (|Q|^2 - 1)/2 of each rotation, which is in C only. `work`:
 * n times the degrees of freedom. C has one row per number and the columns of A; d(J v + j0)/dq is
 * by differences. PK_NOT_FINITE, PK_NO_MEMORY. */
void pk_gsl_residuals(const struct pk_problem *problem, const double *q, const double *v,
                      double *residuals, double *work);
enum pk_status pk_gsl_kept(const struct pk_problem *problem, const double *q, const double *v,
                           gsl_matrix *C);
/* Returns the number of rows of C. */
size_t pk_gsl_kept_count(const struct pk_problem *problem);

#endif

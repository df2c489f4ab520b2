/* The linearised equations as z' = A z. Not installed. */
#ifndef PK_GSL_RATES_H
#define PK_GSL_RATES_H

#include <gsl/gsl_matrix.h>

#include <pk/integrator.h>

/* Computes the matrix A at a state. A is N by N, N = n + m, for n degrees of freedom, m of which
 * are coordinates; the others are first-order variables. The vector z holds n displacements of
 * coordinates and first-order variables, in the order of the degrees of freedom, and then m
 * displacements of the coordinates' rates. Returns a status of pk_system_linear(), or PK_NO_MEMORY.
 */
enum pk_status pk_gsl_linearised(const struct pk_problem *problem, double t, const double *q,
                                 const double *v, gsl_matrix *A);

#endif

/* The linearised equations as z' = A z. Not installed. */
#ifndef PK_GSL_RATES_H
#define PK_GSL_RATES_H

#include <gsl/gsl_matrix.h>

#include <pk/integrator.h>

/* Computes A at a state, N by N with N = n + m for m coordinates. z = (displacements of coordinates
 * and first-order variables, in the order of the degrees of freedom; displacements of the
 * coordinates' rates). Returns a status of pk_system_linear(), or PK_NO_MEMORY. */
enum pk_status pk_gsl_linearised(const struct pk_problem *problem, double t, const double *q,
                                 const double *v, gsl_matrix *A);

#endif

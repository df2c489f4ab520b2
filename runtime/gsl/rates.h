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

#endif

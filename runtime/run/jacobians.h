/* The derivatives of the acceleration along a motion, for the frequencies there. */
#ifndef RUN_JACOBIANS_H
#define RUN_JACOBIANS_H

#include <pk/pk.h>

/* Numbers of work. */
size_t jacobians_size(const struct pk_problem *problem);
/* a_q[i*n + j] = da_i/dq_j, a_v alike; 0 where the equations are singular. */
int jacobians_at(const struct pk_problem *problem, pk_real t, const pk_real *q, const pk_real *v,
                 const pk_real *u, pk_real *a_q, pk_real *a_v, pk_real *work);

#endif

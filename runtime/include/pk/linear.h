/* The acceleration and its derivatives at a state, from the kernel `linear`: of r = f - M a, with a
 * held, M (da/dq) = dr/dq, and the same by v and by t. Inputs are held.
 */
#ifndef PK_LINEAR_H
#define PK_LINEAR_H

#include <stddef.h>

#include <pk/integrator.h>

PK_BEGIN

/* Numbers of work that pk_system_linear() needs. */
size_t pk_system_linear_size(const struct pk_problem *problem);

/* a[i] = q_i'', a_q[i*n + j] = da_i/dq_j, a_v[i*n + j] = da_i/dv_j, a_t[i] = da_i/dt; none of them
 * may be NULL. PK_REFUSED where the system has no kernel `linear` (families kept as loops, more
 * than some coordinates: name it in --kernels), PK_SINGULAR_MASS where M is not positive definite,
 * PK_NOT_FINITE where a result is no number. */
enum pk_status pk_system_linear(const struct pk_problem *problem, pk_real t, const pk_real *q,
                                const pk_real *v, pk_real *a, pk_real *a_q, pk_real *a_v,
                                pk_real *a_t, pk_real *work);

PK_END

#endif

/* The acceleration and its derivatives at a state, from the kernel `linear`. The equations of
 * motion are M a = f; with r = f - M a at constant a, M (da/dq) = dr/dq, and likewise for v and t.
 * Inputs are constant. */
#ifndef PK_LINEAR_H
#define PK_LINEAR_H

#include <stddef.h>

#include <pk/integrator.h>

PK_BEGIN

/* Returns the number of pk_real of work memory for pk_system_linear(). */
size_t pk_system_linear_size(const struct pk_problem *problem);

/* Writes a[i] = v_i', a_q[i*n + j] = da_i/dq_j, a_v[i*n + j] = da_i/dv_j, a_t[i] = da_i/dt; no
 * pointer may be NULL. PK_REFUSED if the system has no kernel `linear` (a system of variable size,
 * or with many coordinates: request it by pkgen's option --kernels), PK_SINGULAR_MASS if M is not
 * positive definite, PK_NOT_FINITE if a result is not finite. */
enum pk_status pk_system_linear(const struct pk_problem *problem, pk_real t, const pk_real *q,
                                const pk_real *v, pk_real *a, pk_real *a_q, pk_real *a_v,
                                pk_real *a_t, pk_real *work);

PK_END

#endif

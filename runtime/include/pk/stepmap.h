/* The effect of one step on small displacements and on the symplectic form. For the step map (q, p)
 * -> (q1, p1) with S = d(q1, p1)/d(q, p),
 *
 *     defect = max |S^T J S - J|,   volume = det S - 1,
 *
 * in canonical variables that all have the same unit (M = C C^T at the start: C^T dq/sqrt(tau),
 * C^-1 dp sqrt(tau), tau^-2 the norm of C^-1 (dr/dq) C^-T), so both are dimensionless. They are
 * zero for a symplectic method on a variational system; otherwise they show the error of a step, or
 * that forces dissipate energy. S is exact: it comes from the variational equations under the same
 * method (pk/variation.h). `rounding` bounds the error of both defect and volume. */
#ifndef PK_STEPMAP_H
#define PK_STEPMAP_H

#include <pk/variation.h>

PK_BEGIN

struct pk_stepmap {
    pk_real defect, volume;
    pk_real rounding; /* upper bound of the rounding errors of `defect` and of `volume` */
    pk_real h;        /* the size of the step that was made */
};

/* Returns the bytes of the block, aligned for pk_real. */
size_t pk_stepmap_size(const struct pk_problem *problem, const struct pk_method *method);
/* Makes one step of size `h`, forward from t0, q0, v0. An adaptive method makes a step of that size
 * with its equations solved to round-off and its error ignored. PK_REFUSED if the method cannot do
 * this, if its steps depend on the motion (adaptive_verlet), or if the system has no kernel
 * `linear`. Writes S in the variables above, 2 n by 2 n, row-major, unless S is NULL. */
enum pk_status pk_stepmap_find(struct pk_stepmap *map, const struct pk_problem *problem,
                               const struct pk_method *method, const struct pk_options *options,
                               pk_real h, pk_real t0, const pk_real *q0, const pk_real *v0,
                               pk_real *S, void *block, size_t block_size);

PK_END

#endif

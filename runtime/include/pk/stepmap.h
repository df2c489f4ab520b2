/* What one step does to a small displacement, and to the symplectic form: of the step map
 * (q, p) -> (q1, p1), S = d(q1, p1)/d(q, p) and
 *
 *     defect = max |S^T J S - J|,   volume = det S - 1,
 *
 * in canonical variables of one unit (M = C C^T at the start: C^T dq/sqrt(tau), C^-1 dp sqrt(tau),
 * tau^-2 the norm of C^-1 (dr/dq) C^-T), so both are free of units. Zero of a symplectic method on
 * a variational system; elsewhere the error of a step, or the forces' own loss. S is exact: the
 * variational equations under the same method (pk/variation.h), so what `rounding` bounds is the
 * error of defect and of volume both.
 */
#ifndef PK_STEPMAP_H
#define PK_STEPMAP_H

#include <pk/variation.h>

PK_BEGIN

struct pk_stepmap {
    pk_real defect, volume;
    pk_real rounding; /* of both: below it they say nothing */
    pk_real h;        /* the step made */
};

/* Bytes, and alignment for pk_real. */
size_t pk_stepmap_size(const struct pk_problem *problem, const struct pk_method *method);
/* One step of `h`, forward from t0, q0, v0. An adaptive method makes one of that length, its
 * equations solved to round-off and its error not asked; PK_REFUSED if it will not, or if its steps
 * follow the motion (adaptive_verlet), and where the system has no kernel `linear`. S is written
 * to S, 2 n by 2 n in those variables, row-major, unless S is NULL. */
enum pk_status pk_stepmap_find(struct pk_stepmap *map, const struct pk_problem *problem,
                               const struct pk_method *method, const struct pk_options *options,
                               pk_real h, pk_real t0, const pk_real *q0, const pk_real *v0,
                               pk_real *S, void *block, size_t block_size);

PK_END

#endif

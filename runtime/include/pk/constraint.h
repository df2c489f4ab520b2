/* How well a state fulfils what its system keeps: unit quaternions, and constraints phi(t, q) = 0
 * and J v + j0 = 0 (see pk/system.h); and the forces that keep them.
 *
 * An integrator needs none of this: a start that breaks a constraint by more than 1e-8 of what it
 * is made of, or whose quaternion is not of unit length, is refused by pk_integrator_init() and
 * pk_integrator_reset(), and every step ends on the constraints to round-off, and dense output too.
 */
#ifndef PK_CONSTRAINT_H
#define PK_CONSTRAINT_H

#include <stddef.h>

#include <pk/integrator.h>

PK_BEGIN

/* The residual that is largest relative to the sizes of its terms, which are the scale of rounding:
 * in its own unit, and relative to them. 0 where there is no such row. */
struct pk_residuals {
    pk_real norm;    /* | |Q| - 1 | */
    size_t rotation; /* which of n_rotations */
    pk_real position, position_relative;
    size_t position_row;         /* of n_holonomic */
    pk_real rate, rate_relative; /* of positions and of rolling */
    size_t rate_row;             /* of n_constraints */
};

/* Bytes of the block that the next two functions want, aligned for pk_real; 0 for a problem
 * without a system, or one of another PK_ABI. */
size_t pk_constraint_size(const struct pk_problem *problem);
/* q and v have pk_system_count() numbers each, quaternions and states among them; an input is
 * called at t. PK_BAD_ARGUMENT, PK_BLOCK_TOO_SMALL; PK_NOT_FINITE, and then what was found besides.
 */
enum pk_status pk_constraint_residuals(const struct pk_problem *problem, pk_real t,
                                       const pk_real *q, const pk_real *v,
                                       struct pk_residuals *found, void *block, size_t size);
/* lambda, n_constraints numbers, of the motion there: J^T lambda is in the units of the momenta's
 * rates. PK_REFUSED where it was compiled without; else as above. */
enum pk_status pk_constraint_multipliers(const struct pk_problem *problem, pk_real t,
                                         const pk_real *q, const pk_real *v, pk_real *lambda,
                                         void *block, size_t size);
/* Puts q and v onto what the system keeps, by the shortest way in the metric of M: what an integrator
 * of the problem, which has begun, does after each step. PK_NO_PROJECTION, PK_NOT_FINITE. */
enum pk_status pk_constraint_project(struct pk_integrator *it, pk_real t, pk_real *q, pk_real *v);
/* Whether rows of constraints all but depend on each other at a state next to where the integrator
 * is: accelerations and multipliers are lost to rounding there, or some of them. */
int pk_constraint_singular(struct pk_integrator *it, pk_real t, const pk_real *q, const pk_real *v);
/* The name of a row as its author gave it: "rod" of "lambda_rod"; of one without, "number 2". As
 * snprintf(). */
int pk_constraint_name(const struct pk_system *system, const void *params, size_t row, char *text,
                       size_t size);

PK_END

#endif

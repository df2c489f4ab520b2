/* How well a state satisfies its constraints: unit quaternions, phi(t, q) = 0 and J v + j0 = 0 (see
 * pk/system.h); and their forces.
 *
 * An integrator needs none of this: pk_integrator_init() and pk_integrator_reset() refuse a start
 * that violates a constraint by more than 1e-8 of its terms, or whose quaternion is not of unit
 * length; every step, and dense output, ends on the constraints to round-off.
 */
#ifndef PK_CONSTRAINT_H
#define PK_CONSTRAINT_H

#include <stddef.h>

#include <pk/integrator.h>

PK_BEGIN

/* The residual that is largest relative to the sizes of its terms, whose rounding limits it: in its
 * own unit, and relative to them. 0 if there is no such row. */
struct pk_residuals {
    pk_real norm;    /* | |Q| - 1 | */
    size_t rotation; /* its index, < n_rotations */
    pk_real position, position_relative;
    size_t position_row;         /* its index, < n_holonomic */
    pk_real rate, rate_relative; /* of holonomic and rolling rows */
    size_t rate_row;             /* its index, < number of rows */
};

/* Returns the bytes of the block for the next two functions, aligned for pk_real; 0 for a problem
 * without a system, or one of another PK_ABI. */
size_t pk_constraint_size(const struct pk_problem *problem);
/* Computes the residuals; q has n_q numbers, v has pk_system_count(), quaternions and states
 * included; inputs are taken at t. PK_BAD_ARGUMENT, PK_BLOCK_TOO_SMALL; PK_NOT_FINITE, with `found`
 * as far as computed.
 */
enum pk_status pk_constraint_residuals(const struct pk_problem *problem, pk_real t,
                                       const pk_real *q, const pk_real *v,
                                       struct pk_residuals *found, void *block, size_t size);
/* Computes lambda, one number for each constraint row; J^T lambda has the units of the rates of
 * momenta. PK_REFUSED if compiled without this kernel; else as above. */
enum pk_status pk_constraint_multipliers(const struct pk_problem *problem, pk_real t,
                                         const pk_real *q, const pk_real *v, pk_real *lambda,
                                         void *block, size_t size);
/* Projects q and v onto the constraints, orthogonally in the metric of M, as an initialised
 * integrator of the problem does after each step. PK_NO_PROJECTION, PK_NOT_FINITE. */
enum pk_status pk_constraint_project(struct pk_integrator *it, pk_real t, pk_real *q, pk_real *v);
/* Whether constraint rows are nearly dependent at a state near that of the integrator: there
 * rounding ruins accelerations and multipliers, or some of them. */
int pk_constraint_singular(struct pk_integrator *it, pk_real t, const pk_real *q, const pk_real *v);
/* Writes the name of a row as declared, "rod" for "lambda_rod", or "number 2" without one. Returns
 * the length as snprintf() does. */
int pk_constraint_name(const struct pk_system *system, const void *params, size_t row, char *text,
                       size_t size);

PK_END

#endif

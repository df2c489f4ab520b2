/* How well a state satisfies its constraints: unit quaternions, phi(t, q) = 0 and J v + j0 = 0 (see
 * pk/system.h); and the constraint forces.
 *
 * Callers of an integrator need not use these functions: pk_integrator_init() and
 * pk_integrator_reset() refuse a start that violates a constraint by more than 1e-8 of the size of
 * its terms, or whose quaternion is not of unit length; the end of every step, and dense output,
 * satisfy the constraints to round-off. */
#ifndef PK_CONSTRAINT_H
#define PK_CONSTRAINT_H

#include <stddef.h>

#include <pk/integrator.h>

PK_BEGIN

/* The worst residual of each kind of constraint: the one that is largest relative to the sizes of
 * its terms. Each is given in the unit of the constraint, and divided by the sizes of its terms
 * (`_relative`). It is 0 if there are no constraints of that kind. */
struct pk_residuals {
    pk_real norm;    /* | |Q| - 1 | of a quaternion Q */
    size_t rotation; /* index of the rotation, < n_rotations */
    pk_real position, position_relative;
    size_t position_row; /* index of the constraint with this residual of phi, < n_holonomic */
    pk_real rate, rate_relative; /* residuals of J v + j0, for holonomic and rolling rows */
    size_t rate_row; /* index of the constraint row with this residual, < number of rows */
};

/* Returns the bytes of the block for the next two functions, aligned for pk_real; 0 if the problem
 * has no system, or if its system was compiled with another PK_ABI. */
size_t pk_constraint_size(const struct pk_problem *problem);
/* Computes the residuals. q has n_q numbers, v has pk_system_count(), with quaternions and other
 * first-order variables; inputs are evaluated at t. Fails with PK_BAD_ARGUMENT, PK_BLOCK_TOO_SMALL,
 * or PK_NOT_FINITE, which leaves in `found` the residuals computed before. */
enum pk_status pk_constraint_residuals(const struct pk_problem *problem, pk_real t,
                                       const pk_real *q, const pk_real *v,
                                       struct pk_residuals *found, void *block, size_t size);
/* Computes lambda, one number for each constraint row; J^T lambda has the units of the rates of
 * momenta. PK_REFUSED: the model was compiled without a kernel that computes lambda. Other failures
 * are those of pk_constraint_residuals(). */
enum pk_status pk_constraint_multipliers(const struct pk_problem *problem, pk_real t,
                                         const pk_real *q, const pk_real *v, pk_real *lambda,
                                         void *block, size_t size);
/* Projects q and v onto the constraints, orthogonally in the metric that the mass matrix M defines.
 * `it` is an initialised integrator; it does the same after each of its steps. Fails with
 * PK_NO_PROJECTION or PK_NOT_FINITE. */
enum pk_status pk_constraint_project(struct pk_integrator *it, pk_real t, pk_real *q, pk_real *v);
/* Returns whether constraint rows are nearly dependent at a state near that of the integrator, so
 * that rounding spoils some or all accelerations and multipliers. */
int pk_constraint_singular(struct pk_integrator *it, pk_real t, const pk_real *q, const pk_real *v);
/* Writes the declared name of a constraint row: "rod" if its multiplier is "lambda_rod", "number 2"
 * if it has no name. Returns the length as snprintf() does. */
int pk_constraint_name(const struct pk_system *system, const void *params, size_t row, char *text,
                       size_t size);

PK_END

#endif

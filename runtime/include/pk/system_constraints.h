/* The part of a system (pk/system.h) that is its constraints. */
#ifndef PK_SYSTEM_CONSTRAINTS_H
#define PK_SYSTEM_CONSTRAINTS_H

#include <pk/begin.h>
#include <pk/kernel.h>

PK_BEGIN

/* Constraints. Rows J v + j0 = 0 of the rates, of which the first n_holonomic are the rates of
 * phi(t, q) = 0; the motion is that of d'Alembert, with the force J^T lambda, which is in force(),
 * canonical() and acceleration() as a function of (t, q, v). */
struct pk_part_constraints {
    size_t n, n_holonomic;
    const struct pk_quantity *names; /* "lambda_rod": unit and description of the multipliers */
    pk_kernel *values;               /* the n_holonomic phi; NULL where they are none */
    /* J (n by the degrees of freedom, row-major; the columns of quaternions and first-order
     * variables are 0) and J v + j0. */
    pk_kernel_2 *jacobian;
    /* The sizes of the terms that phi and J v + j0 are sums of, in whose units of rounding a
     * residual is judged. */
    pk_kernel_2 *scale;
    pk_kernel *multipliers; /* lambda */
    /* Rows that follow from these where the model starts, and have no force. `redundant` writes what
     * their phi, then their J v + j0 are off, the sizes of the terms of all that, and their J; a run
     * ends where they cease to follow. */
    size_t n_redundant, n_redundant_holonomic;
    const struct pk_quantity *redundant_names;
    pk_kernel_3 *redundant;
    /* Of families kept as loops, in place of `jacobian`, each in O(N). n and n_holonomic are then
     * those at the default sizes, names have an entry for each of n_declared constraints, and count()
     * says how many rows there are. No row may depend on others. */
    size_t (*count)(const void *params, int holonomic); /* NULL: n, n_holonomic */
    size_t n_declared;
    pk_kernel *rates; /* J v + j0 */
    void (*spread)(const void *params, pk_real t, const pk_real *q, const pk_real *v,
                   const pk_real *u, const pk_real *x, pk_real *out); /* |J| x */
    void (*pull)(const void *params, pk_real t, const pk_real *q, const pk_real *v,
                 const pk_real *u, const pk_real *x, pk_real *out); /* out += J^T x */
    /* [M J^T; J 0] factored in the memory of params, with all rows or those of positions, as
     * acceleration() fails; of each row the pivot, and what that is without other rows. Then
     * M d - J^T mu = f, J d = r; f NULL: 0. Where a row had no pivot, shares(): x with x J = 0, 1 of
     * that row. */
    int (*factor)(const void *params, pk_real t, const pk_real *q, const pk_real *v,
                  const pk_real *u, int holonomic, pk_real *pivots, pk_real *norms);
    void (*solve)(const void *params, const pk_real *f, const pk_real *r, pk_real *d, pk_real *mu);
    void (*shares)(const void *params, size_t row, pk_real *out);
};

PK_END

#endif

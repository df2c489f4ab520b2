/* The constraints of a system: a part of struct pk_system (pk/system.h). */
#ifndef PK_SYSTEM_CONSTRAINTS_H
#define PK_SYSTEM_CONSTRAINTS_H

#include <pk/begin.h>
#include <pk/kernel.h>

PK_BEGIN

/* Constraint rows J v + j0 = 0 on the rates. The first n_holonomic rows are time derivatives of
 * phi(t, q) = 0. The motion obeys d'Alembert's principle: the force J^T lambda is part of force(),
 * canonical() and acceleration(), as a function of (t, q, v). */
struct pk_part_constraints {
    size_t n, n_holonomic;
    const struct pk_quantity *names; /* names of multipliers, such as "lambda_rod" */
    pk_kernel *values;               /* phi, n_holonomic numbers; NULL if n_holonomic is 0 */
    /* Writes J, n rows by pk_system.n columns, row-major, with 0 in the columns of first-order
     * variables other than body rates; then writes J v + j0. */
    pk_kernel_2 *jacobian;
    /* Writes the sizes of the terms of phi and of J v + j0; a few PK_EPSILON of them are
     * rounding. */
    pk_kernel_2 *scale;
    pk_kernel *multipliers; /* writes the Lagrange multipliers lambda */
    /* Redundant constraint rows. At the start of the model they follow from previous rows, so they
     * have no multiplier. `redundant` writes the residuals of their phi, then of their J v + j0,
     * then the sizes of the terms of each, then their J. A run fails if they do not stay 0. */
    size_t n_redundant, n_redundant_holonomic;
    const struct pk_quantity *redundant_names;
    pk_kernel_3 *redundant;
    /* The following functions replace `jacobian` in a system of variable size; each takes a time of
     * O(N). In such a system n and n_holonomic are the numbers of rows at the default sizes,
     * `names` has n_declared entries, and count() returns that of rows, which are independent. */
    /* returns the number of rows, or of holonomic rows; NULL: these are n and n_holonomic */
    size_t (*count)(const void *params, int holonomic);
    size_t n_declared;
    pk_kernel *rates; /* writes J v + j0 */
    void (*spread)(const void *params, pk_real t, const pk_real *q, const pk_real *v,
                   const pk_real *u, const pk_real *x, pk_real *out); /* computes |J| x */
    void (*pull)(const void *params, pk_real t, const pk_real *q, const pk_real *v,
                 const pk_real *u, const pk_real *x, pk_real *out); /* adds J^T x to out */
    /* factor() factors [M J^T; J 0] in the memory of params, with all rows or only holonomic rows.
     * It fails like acceleration(). It writes the pivot of each row to `pivots`, and to `norms` the
     * pivot that the row would have if it were the only one. Then solve() solves M d - J^T mu = f,
     * J d = r for d and mu; f NULL means f = 0. If the pivot of `row` was zero, shares() writes the
     * row vector x with x J = 0 and x[row] = 1. */
    int (*factor)(const void *params, pk_real t, const pk_real *q, const pk_real *v,
                  const pk_real *u, int holonomic, pk_real *pivots, pk_real *norms);
    void (*solve)(const void *params, const pk_real *f, const pk_real *r, pk_real *d, pk_real *mu);
    void (*shares)(const void *params, size_t row, pk_real *out);
};

PK_END

#endif

/* The constraints of a system (pk/system.h). */
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
    const struct pk_quantity *names; /* of the multipliers: "lambda_rod", unit, description */
    pk_kernel *values;               /* phi, n_holonomic numbers; NULL if there are none */
    /* Writes J, n rows by pk_system.n columns, row-major, 0 in the columns of quaternions and
     * states; then J v + j0. */
    pk_kernel_2 *jacobian;
    /* Writes the sizes of the terms of phi and of J v + j0. A residual of some PK_EPSILON of them
     * is rounding. */
    pk_kernel_2 *scale;
    pk_kernel *multipliers; /* lambda */
    /* Redundant rows: they follow from the rows above at the model's start and have no multiplier.
     * `redundant` writes the residuals of their phi and then of their J v + j0; the sizes of the
     * terms of each residual; and their J. A run fails where these are not zero later. */
    size_t n_redundant, n_redundant_holonomic;
    const struct pk_quantity *redundant_names;
    pk_kernel_3 *redundant;
    /* With families kept as loops, in place of `jacobian`, each in O(N). n and n_holonomic are then
     * the numbers of rows at the default sizes, names has n_declared entries, and count() returns
     * the number of rows. No row may depend on others. */
    size_t (*count)(const void *params, int holonomic); /* NULL: n, n_holonomic */
    size_t n_declared;
    pk_kernel *rates; /* J v + j0 */
    void (*spread)(const void *params, pk_real t, const pk_real *q, const pk_real *v,
                   const pk_real *u, const pk_real *x, pk_real *out); /* |J| x */
    void (*pull)(const void *params, pk_real t, const pk_real *q, const pk_real *v,
                 const pk_real *u, const pk_real *x, pk_real *out); /* out += J^T x */
    /* factor() factors [M J^T; J 0] in the memory of params, with all rows or the holonomic ones.
     * It fails as acceleration() does. It writes each row's pivot, and in `norms` the pivot without
     * other rows. solve() then solves M d - J^T mu = f, J d = r; f NULL: 0. If `row` had no pivot,
     * shares() writes x with x J = 0, x = 1 for that row. */
    int (*factor)(const void *params, pk_real t, const pk_real *q, const pk_real *v,
                  const pk_real *u, int holonomic, pk_real *pivots, pk_real *norms);
    void (*solve)(const void *params, const pk_real *f, const pk_real *r, pk_real *d, pk_real *mu);
    void (*shares)(const void *params, size_t row, pk_real *out);
};

PK_END

#endif

/* How well the equations of a motion can be solved in this precision: the condition numbers of M,
 * of J M^-1 J^T and of the matrix of a step's equations, and how much rounding is magnified in the
 * accelerations. Here M is the mass matrix, J the matrix of the constraint rows, a the
 * accelerations, and lambda the Lagrange multipliers. The condition number of a matrix A is the
 * least that any choice of units of unknowns and equations gives,
 *
 *     min over diagonal D1, D2 of cond(D1 A D2) = rho(|A^-1| |A|)    (in the maximum norm),
 *
 * independent of units (rho: spectral radius). If M is exact up to its last bit, and lambda is
 * computed with the matrix J M^-1 J^T made from it, accelerations have errors, in units of
 * rounding, of
 *
 *     d = |M^-1| |M| |a| + |M^-1 J^T| |(J M^-1 J^T)^-1| |J M^-1 J^T| |lambda|.
 *
 * Let e_i be the sum of the absolute values of the terms of a_i: |M_ij a_j|/M_ii, and the terms of
 * M^-1 J^T lambda. Then a_i loses log10(d_i/e_i) digits, 0 if M is diagonal. Cancellation in the
 * forces is not included.
 *
 * For systems of variable size with constraints, the condition number of J M^-1 J^T is a lower
 * bound, found in O(N) from the distance of each row of J from the span of the other rows. This
 * bound is also returned as the digit-loss ratio d_i/e_i.
 *
 * References: F. L. Bauer, Numer. Math. 5 (1963) 73; R. D. Skeel, J. ACM 26 (1979) 494; N. J.
 * Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., 7.2, 7.3. */
#ifndef PK_CONDITION_H
#define PK_CONDITION_H

#include <pk/integrator.h>

PK_BEGIN

/* x: the largest value so far, for example of a condition number; t: the time at which it occurred.
 * x is 0 if there is no such matrix, infinite if the matrix was singular. */
struct pk_condition_most {
    pk_real x, t;
};

struct pk_condition {
    struct pk_condition_most mass, constraints, step;
    struct pk_condition_most lost; /* largest digit-loss ratio d_i/e_i */
    size_t where;                  /* the index i of the largest d_i/e_i */
    unsigned long looks;
};

/* Matrices of more unknowns are not examined, since the time grows with the cube of this number. */
enum { PK_CONDITION_MOST = 128 };

/* Returns the bytes of the block, aligned for pk_real; 0 without a kernel for M or with too many
 * unknowns. */
size_t pk_condition_size(const struct pk_problem *problem, const struct pk_method *method);
/* Updates the largest condition numbers at the state (t, q, v). `it` is the integrator whose last
 * step ended at this state, or NULL. */
void pk_condition_look(struct pk_condition *c, const struct pk_problem *problem,
                       struct pk_integrator *it, pk_real t, const pk_real *q, const pk_real *v,
                       void *block);

PK_END

#endif

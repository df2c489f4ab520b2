/* How well the equations of a motion can be solved in this precision: of M, of J M^-1 J^T and of the
 * matrix of a step's equations the condition number, and by how much rounding is magnified in the
 * accelerations. The condition number of A is the least over all units of unknowns and equations,
 *
 *     min over diagonal D1, D2 of cond(D1 A D2) = rho(|A^-1| |A|)    (in the maximum norm),
 *
 * so metres or millimetres make no difference. M known to its last bit, and lambda from
 * J M^-1 J^T known so, leave in the accelerations the errors, in units of rounding,
 *
 *     d = |M^-1| |M| |a| + |M^-1 J^T| |(J M^-1 J^T)^-1| |J M^-1 J^T| |lambda|.
 *
 * Beside the terms e_i that it is a sum of, |M_ij a_j|/M_ii and those of M^-1 J^T lambda, each loses
 * log10(d_i/e_i) digits: 0 of a diagonal M. What cancels within the forces is not seen.
 *
 * Of families kept as loops, under constraints, there is of J M^-1 J^T a bound from below, in O(N):
 * by how little a row differs from what the others say. It stands for the loss too.
 *
 * References: F. L. Bauer, Numer. Math. 5 (1963) 73; R. D. Skeel, J. ACM 26 (1979) 494;
 * N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., 7.2, 7.3.
 */
#ifndef PK_CONDITION_H
#define PK_CONDITION_H

#include <pk/integrator.h>

PK_BEGIN

/* The largest so far, and when; 0 where there is no such matrix, infinite where it is singular. */
struct pk_condition_most {
    pk_real x, t;
};

struct pk_condition {
    struct pk_condition_most mass, constraints, step;
    struct pk_condition_most lost; /* d_i/e_i, */
    size_t where;                  /* of this degree of freedom */
    unsigned long looks;
};

/* More unknowns than these are not looked at where a look costs some 6 times their cube. */
enum { PK_CONDITION_MOST = 128 };

/* Bytes, and alignment for pk_real; 0: the system has no M here, or it is too large. */
size_t pk_condition_size(const struct pk_problem *problem, const struct pk_method *method);
/* A state; `it`, or NULL, is the integrator that has made a step to it. */
void pk_condition_look(struct pk_condition *c, const struct pk_problem *problem,
                       struct pk_integrator *it, pk_real t, const pk_real *q, const pk_real *v,
                       void *block);

PK_END

#endif

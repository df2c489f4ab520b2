/* Tables of the core's methods, and functions of their families. */
#ifndef PK_TABLEAU_H
#define PK_TABLEAU_H

#include <pk/families.h>
#include <pk/step/tableau.h>

/* An implicit Runge-Kutta method by collocation, given by nodes c and weights b (NULL: Gauss);
 * mu_ij = a_ij / b_j are computed (collocation_tables.c). These coefficients apply to q. The
 * coefficients for p are the same, or, if `conjugate` is set, the conjugate ones, mu^_ji = 1 -
 * mu_ij. The smaller of each pair is computed from the larger, so that this relation, and
 * symplecticity, is exact. Gauss methods are self-conjugate. */
struct pk_gauss {
    int stages;
    const pk_real *c, *b;
    int conjugate;
};
/* Computes all s nodes and weights, and mu, row-major. */
void pk_collocation(const struct pk_gauss *table, pk_real *c, pk_real *b, pk_real *mu);

/* pk_legendre() computes the Legendre polynomials P_0 to P_count-1 at 2 x - 1, and, unless
 * `integral` is NULL, their integrals from 0 to x. The caller passes rest = 1 - x, without
 * cancellation if possible. pk_gauss_nodes() computes the s <= 16 nodes and weights of Gauss
 * quadrature on [0, 1]. */
void pk_legendre(pk_real x, pk_real rest, int count, pk_real *P, pk_real *integral);
void pk_gauss_nodes(int s, pk_real *c, pk_real *b);
/* Computes the matrices of the adaptive 8-stage Gauss method (pk/step/gauss_tables.h). */
struct pk_gauss_matrices;
void pk_gauss_make_matrices(struct pk_gauss_matrices *M);

#define PK_DECLARE_TABLE(A, name, p, s, p_dense, flags, of, text) \
    extern const struct pk_gauss pk_##of##_table;
PK_METHODS_COLLOCATION(PK_DECLARE_TABLE, )
/* The largest number of coordinates for which a matrix exponential is computed, in seconds. */
enum { PK_EXPONENTIAL_MOST = 256 };

/* Returns the kicks and drifts of a splitting method; NULL for other methods. */
const struct pk_splitting *pk_splitting_table(const struct pk_method *method);
/* Returns whether a step ends with a kick, whose acceleration the next step reuses. */
static inline int pk_splitting_ends(const struct pk_splitting *table)
{
    const pk_real last = table->kick[table->stages];
    return last > 0 || last < 0;
}
/* Returns the number of pk_real of work memory of a splitting method, which needs memory only if
 * the system is not separable; 0 otherwise. */
size_t pk_splitting_size(const struct pk_method *method, const struct pk_problem *problem,
                         size_t n);
size_t pk_linear_drag_size(const struct pk_splitting *table, size_t n);
enum pk_status pk_linear_drag_init(struct pk_integrator *it, const struct pk_splitting *table);
/* Computes B of an acceleration g + B v; `zero` has n zeros, g and a room for n numbers each. */
enum pk_status pk_drag_matrix(struct pk_integrator *it, pk_real *zero, pk_real *g, pk_real *a,
                              pk_real *B);
/* Return the tableau of an explicit Runge-Kutta method, or NULL for other methods. pk_erk_table()
 * also returns NULL for adaptive methods. */
const struct pk_tableau *pk_explicit_table(const struct pk_method *method);
const struct pk_tableau *pk_erk_table(const struct pk_method *method);
/* Returns the acceleration at an end of an adaptive explicit method's last step, or NULL. */
const pk_real *pk_embedded_acceleration(struct pk_integrator *it, int end);

/* Computes the s + 1 coefficients c_k of the stability function R(z) = sum c_k z^k: a step of size
 * h maps u0 to u1 = R(h) u0 if u' = u. Returns s, the number of stages. */
int pk_tableau_polynomial(const struct pk_tableau *table, pk_real *coefficient);

size_t pk_gauss_size(const struct pk_method *method, const struct pk_problem *problem, size_t n);
enum pk_status pk_gauss_init(struct pk_integrator *it);

#endif

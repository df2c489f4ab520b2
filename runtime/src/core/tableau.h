/* The core's methods and families. */
#ifndef PK_TABLEAU_H
#define PK_TABLEAU_H

#include <pk/families.h>
#include <pk/step/tableau.h>

/* An implicit Runge-Kutta method by collocation: nodes c and weights b, NULL those of Gauss; and
 * mu_ij = a_ij / b_j follow (collocation_tables.c). These are for q. For p the same, or the
 * conjugate table mu^_ji = 1 - mu_ij: of each such pair only the larger counts, so that it holds
 * exactly in floating point, and with it symplecticity. Gauss methods are their own conjugates. */
struct pk_gauss {
    int stages;
    const pk_real *c, *b;
    int conjugate;
};
/* All s nodes and weights, and mu row by row. */
void pk_collocation(const struct pk_gauss *table, pk_real *c, pk_real *b, pk_real *mu);

/* P_0 to P_count-1 of 2 x - 1, and unless NULL their integrals from 0 to x; rest = 1 - x, as exactly
 * as it is known. The s nodes and weights of Gauss's quadrature on [0, 1], s up to 16. */
void pk_legendre(pk_real x, pk_real rest, int count, pk_real *P, pk_real *integral);
void pk_gauss_nodes(int s, pk_real *c, pk_real *b);
/* What the lanes of the 8 stages of Gauss take besides (pk/step/gauss_tables.h). */
struct pk_gauss_matrices;
void pk_gauss_make_matrices(struct pk_gauss_matrices *M);

#define PK_DECLARE_TABLE(A, name, p, s, p_dense, flags, of, text) \
    extern const struct pk_gauss pk_##of##_table;
PK_METHODS_COLLOCATION(PK_DECLARE_TABLE, )
/* Coordinates that `exponential` is for: of so many, its matrix takes seconds to make. */
enum { PK_EXPONENTIAL_MOST = 256 };

/* Kicks and drifts of a splitting method; NULL of any other. */
const struct pk_splitting *pk_splitting_table(const struct pk_method *method);
/* Whether it ends with a kick, whose acceleration is the next step's first. */
static inline int pk_splitting_ends(const struct pk_splitting *table)
{
    const pk_real last = table->kick[table->stages];
    return last > 0 || last < 0;
}
/* Numbers that it takes, where the system is not separable; 0 of any other. */
size_t pk_splitting_size(const struct pk_method *method, const struct pk_problem *problem,
                         size_t n);
size_t pk_linear_drag_size(const struct pk_splitting *table, size_t n);
enum pk_status pk_linear_drag_init(struct pk_integrator *it, const struct pk_splitting *table);
/* Those of an explicit Runge-Kutta method, adaptive or not. */
const struct pk_tableau *pk_explicit_table(const struct pk_method *method);
const struct pk_tableau *pk_erk_table(const struct pk_method *method);
/* The acceleration where the last step of an adaptive one began, or ended; NULL of any other. */
const pk_real *pk_embedded_acceleration(struct pk_integrator *it, int end);

/* R(z) = sum c_k z^k, the step of u' = u; s + 1 numbers. Returns s. */
int pk_tableau_polynomial(const struct pk_tableau *table, pk_real *coefficient);

size_t pk_gauss_size(const struct pk_method *method, const struct pk_problem *problem, size_t n);
enum pk_status pk_gauss_init(struct pk_integrator *it);

#endif

/* The core's methods and families. */
#ifndef PK_TABLEAU_H
#define PK_TABLEAU_H

#include <pk/methods.h>
#include <pk/step/tableau.h>

/* An implicit Runge-Kutta method: nodes, weights, and mu_ij = a_ij / b_j, for q. For p the same, or
 * the conjugate table mu^_ji = 1 - mu_ij: of each such pair only the larger counts, so that it
 * holds exactly in floating point, and with it symplecticity. Gauss methods are their own
 * conjugates. */
struct pk_gauss {
    int stages;
    const pk_real *c, *b;
    const pk_real *mu;
    int conjugate;
};

#define PK_DECLARE_TABLE(A, name, p, s, p_dense, flags, of, text) \
    extern const struct pk_gauss pk_##of##_table;
PK_METHODS_COLLOCATION(PK_DECLARE_TABLE, )
PK_METHODS_CORE(PK_DECLARE_METHOD, )
/* Coordinates that `exponential` is for: of so many, its matrix takes seconds to make. */
enum { PK_EXPONENTIAL_MOST = 256 };

/* Kicks and drifts of a splitting method; NULL of any other. */
const struct pk_splitting *pk_splitting_table(const struct pk_method *method);
/* Stage i of an explicit Runge-Kutta step of h, whose slopes are k. */
int pk_explicit_stage(const struct pk_integrator *it, const struct pk_tableau *table, pk_real h,
                      const pk_real *k, int i, struct pk_stage *stage, pk_real *room);
/* Those of an explicit Runge-Kutta method, adaptive or not. */
const struct pk_tableau *pk_explicit_table(const struct pk_method *method);
const struct pk_tableau *pk_erk_table(const struct pk_method *method);

/* R(z) = sum c_k z^k, the step of u' = u; s + 1 numbers. Returns s. */
int pk_tableau_polynomial(const struct pk_tableau *table, pk_real *coefficient);

size_t pk_gauss_size(const struct pk_method *method, size_t n);
enum pk_status pk_gauss_init(struct pk_integrator *it);
enum pk_status pk_gauss_step(struct pk_integrator *it, pk_real limit);
int pk_gauss_stage(struct pk_integrator *it, int k, struct pk_stage *stage, pk_real *room);

#endif

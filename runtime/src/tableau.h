/* Coefficients as data. Reference for all names: E. Hairer, S. P. Norsett, G. Wanner, Solving
 * Ordinary Differential Equations I, 2nd ed., II.1 and II.4-6 ("HNW").
 */
#ifndef PK_TABLEAU_H
#define PK_TABLEAU_H

#include <pk/method.h>

/* An explicit Runge-Kutta method of s stages; the derivative at the new point counts as number s
 * where `e` or `d` uses it. Of a step: y1 = y0 + h sum b_i k_i. */
struct pk_tableau {
    int stages;
    const pk_real *c; /* s, and then those of the extra stages after the derivative at y1 */
    const pk_real *a; /* strictly lower triangle row by row, without the empty first row */
    const pk_real *b;

    /* Adaptive: the error is h sum e_i k_i (s + 1 of them); with e3, a second estimate of lower
     * order is blended in, HNW II.10 (10.17). Control as in HNW II.4 and IV.2. */
    const pk_real *e, *e3;
    int error_order; /* the error is O(h^error_order); 1/exponent of control */
    pk_real beta, shrink, grow;

    /* Dense output: extra stages, and rows of d over all stages; HNW II.6 (6.12)-(6.14). */
    int extra;
    const pk_real *extra_a; /* rows of s + 1 + i numbers */
    int rows;
    const pk_real *d; /* rows of s + 1 + extra numbers */
};

/* A splitting method: kick[0], drift[0], kick[1], ..., kick[s] of the step each. */
struct pk_splitting {
    int stages;
    const pk_real *kick;  /* s + 1 */
    const pk_real *drift; /* s */
};

/* A Gauss method: nodes, weights, and mu_ij = a_ij / b_j, of which only the larger of each pair
 * counts: mu_ji = 1 - mu_ij then holds exactly in floating point, and with it symplecticity. */
struct pk_gauss {
    int stages;
    const pk_real *c, *b;
    const pk_real *mu;
};

extern const struct pk_method pk_euler, pk_rk4, pk_dopri5, pk_dop853;
extern const struct pk_method pk_symplectic_euler, pk_verlet, pk_yoshida4;
extern const struct pk_method pk_gauss1, pk_gauss2, pk_gauss3, pk_gauss4;

/* The families. */
size_t pk_erk_size(const struct pk_method *method, size_t n);
enum pk_status pk_erk_init(struct pk_integrator *it);
enum pk_status pk_erk_step(struct pk_integrator *it, pk_real limit);

size_t pk_embedded_size(const struct pk_method *method, size_t n);
enum pk_status pk_embedded_init(struct pk_integrator *it);
enum pk_status pk_embedded_step(struct pk_integrator *it, pk_real limit);
enum pk_status pk_embedded_dense(struct pk_integrator *it, pk_real t, pk_real *q, pk_real *v);

size_t pk_splitting_size(const struct pk_method *method, size_t n);
enum pk_status pk_splitting_init(struct pk_integrator *it);
enum pk_status pk_splitting_step(struct pk_integrator *it, pk_real limit);

size_t pk_gauss_size(const struct pk_method *method, size_t n);
enum pk_status pk_gauss_init(struct pk_integrator *it);
enum pk_status pk_gauss_step(struct pk_integrator *it, pk_real limit);

/* y = y0 + h (a_0 k_0 + ... ), m numbers a stage. */
void pk_erk_combine(pk_real *y, const pk_real *y0, pk_real h, const pk_real *a, int count,
                    const pk_real *k, size_t m);

#endif

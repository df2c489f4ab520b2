/* A motion together with small displacements of it: a pk_system made from another system, with 1 +
 * columns times as many coordinates,
 *
 *     Q = (q, dq_1, dq_2, ...),   V = (v, dv_1, dv_2, ...)
 *
 * In V all rates of coordinates come before all first-order variables. The equations are those of q
 * and their linearisation along the motion, the variational equations
 *
 *     M a = f(q, v, t),   M da = (dr/dq) dq + (dr/dv) dv,   r = f - M a at constant a,
 *
 * by the kernel `linear` that pkgen generates. Any method of the runtime can integrate the new
 * system. A Runge-Kutta method, a composition of flows or a Gauss method in (q, p), applied to this
 * system, propagates the displacements by the derivative of its own step map, not only of the flow,
 * to round-off. Reference: E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration, 2nd
 * ed., VI.4, lemma 4.1.
 *
 * The new system has kernels acceleration, mass, canonical, jacobian and linear. The kernels mass,
 * jacobian and linear omit the derivatives of the variational equations by q and v, which need
 * second derivatives: Newton's method takes a few more iterations, and may not converge at step
 * sizes at which it barely converges for the motion alone (for the double pendulum gauss8 fails at
 * step sizes from .4 on instead of from .6; radau shortens its steps instead). */
#ifndef PK_VARIATION_H
#define PK_VARIATION_H

#include <stddef.h>

#include <pk/integrator.h>

PK_BEGIN

struct pk_variation {
    struct pk_problem problem; /* the new system; points to this struct, which must not move */
    struct pk_problem of;      /* the problem of the motion alone */
    struct pk_system system;
    size_t n_q, n, columns;
    /* work memory of n numbers each: v, the acceleration a, a right-hand side b */
    pk_real *work, *v, *a, *b;
};

/* Returns the bytes of the block for pk_variation_init(), aligned for pk_real; 0 if the system has
 * another PK_ABI. */
size_t pk_variation_size(const struct pk_problem *of, size_t columns);
/* Returns the bytes of an integrator of the new system; does not need the new system. */
size_t pk_variation_integrator_size(const struct pk_problem *of, size_t columns,
                                    const struct pk_method *method);
/* Makes the new system. PK_REFUSED: the system has no kernel `linear`, mass or jacobian, or is not
 * PK_SMOOTH. Also fails with PK_BAD_ARGUMENT or PK_BLOCK_TOO_SMALL. One thread at a time may use
 * the new system, since kernels work in the block. */
enum pk_status pk_variation_init(struct pk_variation *variation, const struct pk_problem *of,
                                 size_t columns, void *block, size_t block_size);
/* pk_variation_place() returns the index in V of number i of v (if k = 0) or of dv_k.
 * pk_variation_take() copies the n numbers of v or dv_k from V, pk_variation_put() copies them to
 * V. */
size_t pk_variation_place(const struct pk_variation *variation, size_t k, size_t i);
void pk_variation_take(const struct pk_variation *variation, const pk_real *V, size_t k,
                       pk_real *v);
void pk_variation_put(const struct pk_variation *variation, const pk_real *v, size_t k, pk_real *V);

PK_END

#endif

/* A motion together with small displacements of it: a pk_system made of another one, with
 * 1 + columns times its coordinates
 *
 *     Q = (q, dq_1, dq_2, ...),   V = (v, dv_1, dv_2, ...)
 *
 * where in V the rates of all coordinates come before the states of all, and whose equations are
 * those of q and their linearisation along it, the variational equations
 *
 *     M a = f(q, v, t),   M da = (dr/dq) dq + (dr/dv) dv,   r = f - M a with a held,
 *
 * by the kernel `linear` that pkgen emits. Any method of the runtime integrates it. A Runge-Kutta
 * method, a composition of flows, a Gauss method in (q, p): each, applied to both, gives in the
 * displacements the derivative of its own step map, not only of the flow, to round-off. Reference:
 * E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration, 2nd ed., VI.4, lemma 4.1.
 *
 * The new system has kernels acceleration, mass, canonical, jacobian and linear. Its mass, jacobian
 * and linear leave out how the displacements depend on q and v, which would take second
 * derivatives: what iterates with them takes a few turns more, and may not converge at steps at
 * which the motion's own iteration only just does (of the double pendulum's gauss8 from .4, not .6
 * on; radau then makes shorter steps).
 */
#ifndef PK_VARIATION_H
#define PK_VARIATION_H

#include <stddef.h>

#include <pk/integrator.h>

PK_BEGIN

struct pk_variation {
    struct pk_problem problem; /* to be integrated; refers to this struct, which must not move */
    struct pk_problem of;      /* the motion's own */
    struct pk_system system;
    size_t n_q, n, columns;
    pk_real *work, *v, *a, *b; /* v, a, b: n each, behind what kernels write */
};

/* Bytes of the block that init wants, aligned for pk_real; 0 if the system is of another PK_ABI. */
size_t pk_variation_size(const struct pk_problem *of, size_t columns);
/* Bytes that an integrator of the new system wants, before there is one. */
size_t pk_variation_integrator_size(const struct pk_problem *of, size_t columns,
                                    const struct pk_method *method);
/* PK_REFUSED where the system has no kernel `linear`, mass or jacobian, or has kinks (no
 * PK_SMOOTH); PK_BAD_ARGUMENT, PK_BLOCK_TOO_SMALL. One thread at a time, since kernels work in the
 * block. */
enum pk_status pk_variation_init(struct pk_variation *variation, const struct pk_problem *of,
                                 size_t columns, void *block, size_t block_size);
/* Where number i of v, k = 0, or of dv_k is in V; all n from there, and there. */
size_t pk_variation_place(const struct pk_variation *variation, size_t k, size_t i);
void pk_variation_take(const struct pk_variation *variation, const pk_real *V, size_t k,
                       pk_real *v);
void pk_variation_put(const struct pk_variation *variation, const pk_real *v, size_t k, pk_real *V);

PK_END

#endif

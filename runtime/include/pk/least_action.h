/* Hamilton's principle along a computed path: among paths with the same ends in the same time it
 * makes the action
 *
 *     S = integral of L dt
 *
 * stationary, and a minimum as long as no point conjugate to its start lies within it, at which
 * neighbouring paths from the start meet again. Neighbours are, with k = 1 .. modes,
 *
 *     q(t) + sum a_ik e_i sin(k pi (t - t0)/time),   S(a) = S + slope.a + a.C a/2 + ...
 *
 * slope vanishes along a motion. B is the part of C from v.M v alone. The eigenvalues of C a =
 * lambda B a tend to 1 as modes get shorter; as many are negative as there are conjugate points
 * within the path, counted with multiplicity (Morse's index theorem). For an oscillator lambda_k =
 * 1 - (omega time/(k pi))^2. Conjugate points are where det dq(t)/dv(t0) changes its sign, by the
 * variational equations. References: I. M. Gelfand, S. V. Fomin, Calculus of Variations, chapter 5;
 * J. Milnor, Morse Theory, paragraph 15; C. G. Gray, E. F. Taylor, Am. J. Phys. 75 (2007) 434.
 */
#ifndef PK_LEAST_ACTION_H
#define PK_LEAST_ACTION_H

#include <stddef.h>

#include <pk/variation.h>

PK_BEGIN

enum { PK_CONJUGATE_MOST = 64 };

struct pk_least_action {
    struct pk_integrator it; /* of the path and n displacements; has the reason of a failure */
    pk_real action, size;    /* S; the integral of |p.v| + |h|, the scale of its round-off */
    pk_real slope;           /* max |dS/da_ik| relative to the sum of its absolute terms */
    size_t n, modes;         /* a has n rows of `modes` numbers */
    const pk_real *C, *B;    /* (n modes) by (n modes), row-major, in the block */
    size_t n_conjugate;      /* number of conjugate points; the first PK_CONJUGATE_MOST: */
    pk_real conjugate[PK_CONJUGATE_MOST];

    /* For the runtime alone. */
    struct pk_variation variation;
    pk_real t0, time;
    size_t nodes;
    const pk_real *path; /* q and v at each node */
    pk_real *scratch;
};

/* Returns the bytes for paths of `panels` panels, each of 8 Gauss nodes, aligned for pk_real; 0 as
 * pk_integrator_size(). A struct in use must not move. */
size_t pk_least_action_size(const struct pk_problem *problem, const struct pk_method *method,
                            size_t panels, size_t modes);
/* Integrates from t0 for `time` > 0. PK_REFUSED if not all forces come from L (no PK_VARIATIONAL),
 * or as pk_variation_init(). Panels should be at most half a wave of the shortest mode. */
enum pk_status pk_least_action_find(struct pk_least_action *found, const struct pk_problem *problem,
                                    const struct pk_method *method,
                                    const struct pk_options *options, pk_real t0, const pk_real *q0,
                                    const pk_real *v0, pk_real time, size_t panels, size_t modes,
                                    void *block, size_t size);
/* Returns S of the neighbour a, n by modes, without truncation at second order. */
pk_real pk_least_action_at(const struct pk_least_action *found, const pk_real *a);
void pk_least_action_free(struct pk_least_action *found); /* as pk_integrator_free() */

PK_END

#endif

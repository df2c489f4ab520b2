/* Hamilton's principle along a computed path: among paths with the same ends in the same time it
 * makes the action
 *
 *     S = integral of L dt
 *
 * stationary; a minimum, too, as long as no point conjugate to its start lies within it, where
 * paths that start apart meet again. Neighbours are q(t) + sum a_ik e_i sin(k pi (t - t0)/time),
 * k = 1 .. modes, for which to second order
 *
 *     S(a) = S + slope.a + a.C a/2,    B: the part of C that v.M v alone has.
 *
 * slope vanishes along a motion. Of the eigenvalues of C a = lambda B a, which tend to 1 as modes
 * get shorter, as many are negative as there are conjugate points within the path, each counted as
 * often as it is multiple (Morse's index theorem); for an oscillator lambda_k = 1 - (omega time/
 * (k pi))^2. Conjugate points themselves are where det dq(t)/dv(t0) changes its sign, by the
 * variational equations. References: I. M. Gelfand, S. V. Fomin, Calculus of Variations, chapter
 * 5; J. Milnor, Morse Theory, paragraph 15; C. G. Gray, E. F. Taylor, Am. J. Phys. 75 (2007) 434.
 */
#ifndef PK_LEAST_ACTION_H
#define PK_LEAST_ACTION_H

#include <stddef.h>

#include <pk/variation.h>

PK_BEGIN

enum { PK_CONJUGATE_MOST = 64 };

struct pk_least_action {
    struct pk_integrator it; /* of the path and of n displacements; for the reason if it fails */
    pk_real action, size;    /* S; the integral of |p.v| + |h|, beside which it has round-off */
    pk_real slope;           /* max |dS/da_ik| over what its terms are without their signs */
    size_t n, modes;         /* a is n by modes, by coordinates */
    const pk_real *C, *B;    /* (n modes) by (n modes), row-major, in the block */
    size_t n_conjugate;      /* found; the first PK_CONJUGATE_MOST of them: */
    pk_real conjugate[PK_CONJUGATE_MOST];

    /* For the runtime alone. */
    struct pk_variation variation;
    pk_real t0, time;
    size_t nodes;
    const pk_real *path; /* of each node q and v */
    pk_real *scratch;
};

/* Bytes for paths of so many panels, each of 8 Gauss nodes, aligned for pk_real; 0 as
 * pk_integrator_size(). The struct must not move once it is filled. */
size_t pk_least_action_size(const struct pk_problem *problem, const struct pk_method *method,
                            size_t panels, size_t modes);
/* From t0 for `time` > 0. PK_REFUSED where forces act besides those of L (no PK_VARIATIONAL), or as
 * pk_variation_init(). A panel should be no longer than half a wave of the shortest mode. */
enum pk_status pk_least_action_find(struct pk_least_action *found, const struct pk_problem *problem,
                                    const struct pk_method *method,
                                    const struct pk_options *options, pk_real t0, const pk_real *q0,
                                    const pk_real *v0, pk_real time, size_t panels, size_t modes,
                                    void *block, size_t size);
/* S of the neighbour a, n by modes, with nothing left out. */
pk_real pk_least_action_at(const struct pk_least_action *found, const pk_real *a);
void pk_least_action_free(struct pk_least_action *found); /* as pk_integrator_free() */

PK_END

#endif

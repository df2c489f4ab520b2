/* Hamilton's principle for a computed motion: among all paths with the same end points and times,
 * the motion makes the action S = integral of L dt stationary. S is a minimum if the motion has no
 * point conjugate to its start, where neighbouring motions from the start meet again. The
 * neighbouring paths are, with k = 1 .. modes,
 *
 *     q(t) + sum a_ik e_i sin(k pi (t - t0)/time),   S(a) = S + slope.a + a.C a/2 + ...
 *
 * slope is zero for a motion. B is the contribution of v.M v to C. The eigenvalues of C a = lambda
 * B a tend to 1 with increasing k; the number of negative ones is the number of conjugate points
 * within the path, counted with multiplicity (Morse's index theorem). For an oscillator lambda_k =
 * 1 - (omega time/(k pi))^2. Conjugate points are where det dq(t)/dv(t0) changes its sign, by the
 * variational equations. References: I. M. Gelfand, S. V. Fomin, Calculus of Variations, chapter 5;
 * J. Milnor, Morse Theory, paragraph 15; C. G. Gray, E. F. Taylor, Am. J. Phys. 75 (2007) 434. */
#ifndef PK_LEAST_ACTION_H
#define PK_LEAST_ACTION_H

#include <stddef.h>

#include <pk/variation.h>

PK_BEGIN

enum { PK_CONJUGATE_MOST = 64 };

struct pk_least_action {
    struct pk_integrator it; /* integrator of the motion and of small displacements from it */
    pk_real action, size;    /* S; the integral of |p.v| + |h|, the scale of round-off of S */
    /* max |dS/da_ik|, each divided by the sum of the absolute values of its terms; near 0 for a
     * motion */
    pk_real slope;
    size_t n, modes;      /* number of coordinates, number of modes */
    const pk_real *C, *B; /* n modes by n modes, row-major, in the block */
    size_t n_conjugate;   /* number of conjugate points; the first are in conjugate[] */
    pk_real conjugate[PK_CONJUGATE_MOST];

    /* Private to the runtime. */
    struct pk_variation variation;
    pk_real t0, time;
    size_t nodes;
    const pk_real *path; /* q and v of the motion at each node of the quadrature */
    pk_real *scratch;
};

/* Returns the bytes of the block, aligned for pk_real, for quadrature in `panels` intervals of 8
 * Gauss nodes each; 0 if pk_integrator_size() is 0. A struct in use must not move. */
size_t pk_least_action_size(const struct pk_problem *problem, const struct pk_method *method,
                            size_t panels, size_t modes);
/* Integrates from t0 to t0 + time, time > 0. PK_REFUSED: not all forces come from L (no
 * PK_VARIATIONAL), or pk_variation_init() refuses the system. An interval of the quadrature should
 * be no longer than half a wavelength of the shortest mode, k = modes. */
enum pk_status pk_least_action_find(struct pk_least_action *found, const struct pk_problem *problem,
                                    const struct pk_method *method,
                                    const struct pk_options *options, pk_real t0, const pk_real *q0,
                                    const pk_real *v0, pk_real time, size_t panels, size_t modes,
                                    void *block, size_t size);
/* Returns the action S(a) of the neighbouring path with the coefficients a, n by modes: the
 * integral itself, not its expansion to second order in a. */
pk_real pk_least_action_at(const struct pk_least_action *found, const pk_real *a);
/* frees memory like pk_integrator_free() */
void pk_least_action_free(struct pk_least_action *found);

PK_END

#endif

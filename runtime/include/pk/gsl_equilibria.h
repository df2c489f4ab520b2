/* Equilibria of a system by GSL's root finder from many starts, and normal coordinates at one.
 * double only; link libpk_gsl.a before libpk.a, then -lgsl -lgslcblas. GSL allocates; all memory is
 * freed before these functions return.
 *
 * Cyclic coordinates do not rest: their momenta are constant. So relative equilibria are sought, in
 * which the other coordinates rest and cyclic ones have constant rates (a top's steady precession).
 * With c for cyclic and n for the others,
 *
 *     pdot_n(q_n, v_c) = 0,   p_c(q_n, v_c) = p_c of the given start,   v_n = 0.
 */
#ifndef PK_GSL_EQUILIBRIA_H
#define PK_GSL_EQUILIBRIA_H

#include <pk/integrator.h>

PK_BEGIN

struct pk_equilibria {
    size_t most; /* equilibria for which q and v, the caller's, have room: n numbers each */
    double *q, *v;
    size_t count;         /* equilibria found, the lowest energy first */
    size_t failed;        /* starts without a result */
    size_t singular;      /* starts that led to a singular or indefinite M: the pole of a chart */
    int more;             /* there are more than `most`, perhaps a continuum */
    unsigned char *turns; /* n, or NULL: out, whether q_i + 2 pi is the same position as q_i */
    double *doubt; /* room as q, or NULL: out, Newton's last correction of q_i, or of v_i if cyclic.
                      If the linear terms vanish, it is comparable to the distance from the root. */
    size_t *slack; /* `most`, or NULL: out, with rotations or constraints: the number of directions
                      in which equilibria continue; then one is listed for each energy */
    double *middle, *box; /* n each, or NULL: out, q_i (v_i) is sought in middle_i +- box_i, by a
                             quarter of the starts each 4 and 32 times as far, except for angles */
};

/* Searches from q0, v0 and `tries` more starts (Halton's points: the same each time), from each
 * again with known roots deflated until no other is found. Starts lie in a box about q0: half a
 * turn wide for angles, else a multiple of the range of the motion, or |q0|; no length is absolute.
 * A coordinate in which the equations have the period 2 pi is returned in (-pi, pi]. First-order
 * variables, which are in v, rest too, except quadratures, which keep their values. With rotations
 * or constraints, equilibria satisfy these (equilibria_bound.c); bodies do not rotate there, and
 * the first nonzero component of a quaternion is positive. PK_REFUSED if the equations depend on
 * time or on inputs. There is no guarantee that all are found. */
enum pk_status pk_gsl_equilibria(const struct pk_problem *problem, const double *q0,
                                 const double *v0, size_t tries, struct pk_equilibria *found);

/* Computes the eigenvalues of the linearised equations at any state, zeros included, one entry for
 * lambda and its conjugate; room for 2 n each. The fastest must be resolved by steps. PK_REFUSED
 * without the kernel `linear`; PK_SINGULAR_MASS; PK_NO_CONVERGENCE. */
enum pk_status pk_gsl_rates(const struct pk_problem *problem, double t, const double *q,
                            const double *v, double *growth, double *frequency, size_t *count);

/* Sets, for each entry of v, whether it is a quadrature: a first-order variable that no rate
 * depends on (work done, an action). Tested at the state and at two others. */
enum pk_status pk_gsl_unread(const struct pk_problem *problem, const double *q, const double *v,
                             unsigned char *unread);

/* Computes normal coordinates at an equilibrium q* of a system whose forces all come from L,
 * without terms linear in the rates there:
 *
 *     Q = U^T M (q - q*),  P = U^T (p - p*),  U^T M U = 1,
 *     h = h* + sum of (P^2 + omega^2 Q^2)/2 + higher-order terms.
 *
 * squares: omega^2 of each mode, ascending, 0 below 1e-12 of the largest, negative if unstable; M:
 * n by n; shapes: n by n, rows of U^T. PK_REFUSED for other systems, or without the kernels mass
 * and jacobian; PK_SINGULAR_MASS. */
enum pk_status pk_gsl_normal(const struct pk_problem *problem, const double *q, double *M,
                             double *squares, double *shapes);
/* Computes (P^2 + omega^2 Q^2)/2 of each mode; q and p are q - q* and p - p*. */
void pk_normal_energies(size_t n, const double *M, const double *squares, const double *shapes,
                        const double *q, const double *p, double *E);

PK_END

#endif

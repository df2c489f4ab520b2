/* Where a system can rest, and how it moves close by: equilibria by GSL's root finder from many
 * starts, normal modes by its eigenvalues. double only; link libpk_gsl.a before libpk.a, then -lgsl
 * -lgslcblas. GSL allocates, and what it does is given back before these functions return.
 *
 * Cyclic coordinates do not rest: their momenta are constant, and what is sought are relative
 * equilibria, the other coordinates at rest while these go on at constant rates (a top's steady
 * precession). With c for cyclic and n for the others,
 *
 *     pdot_n(q_n, v_c) = 0,   p_c(q_n, v_c) = p_c of the given start,   v_n = 0,
 *
 * and close to one, momenta p_c held (Routh),  M u'' + C u' + K u = 0  for u = q_n - q_n*, with
 *
 *     M = M_nn - M_nc B M_cn,  K = -F_nn + F'_nc B P_cn,  B = 1 / M_cc,  F = d(pdot)/dq,
 *     C = P_nn - F'_nn - M_nc B P_cn + F'_nc B M_cn,      P = dp/dq,     F' = d(pdot)/dv.
 *
 * A mode is u = Re(shape exp(lambda t)), lambda = growth + i frequency.
 * Reference: L. Meirovitch, Methods of Analytical Dynamics, ch. 6 (small motions, gyroscopic
 * systems); J. Marsden, T. Ratiu, Introduction to Mechanics and Symmetry, 8.9 (Routh reduction).
 */
#ifndef PK_GSL_EQUILIBRIA_H
#define PK_GSL_EQUILIBRIA_H

#include <pk/integrator.h>

PK_BEGIN

struct pk_equilibria {
    size_t most; /* as many as q and v, the caller's, have room for: n numbers each */
    double *q, *v;
    size_t count;         /* found, the lowest energy first */
    size_t failed;        /* starts that led nowhere */
    size_t singular;      /* that led to where M is singular or indefinite: the pole of a chart */
    int more;             /* there are more than `most`, perhaps a continuum */
    unsigned char *turns; /* n, or NULL: out, whether q_i + 2 pi is the same place as q_i */
    double *doubt; /* room as q has, or NULL: out, Newton's last correction of q_i, or of v_i where
                      cyclic. Where the linear terms vanish it is some of the way to the root. */
    size_t *slack; /* as many as q, or NULL: out, with rotations or constraints, in how many
                      directions equilibria go on from it; then one is given of those of an energy */
    double *middle, *box; /* n each, or NULL: out, q_i (v_i) is sought in middle_i +- box_i, by a
                             quarter of the starts each 4 and 32 times as far, but for angles */
};

/* From q0, v0 and `tries` more starts (Halton's points: the same each time), from each again with
 * the roots that are known deflated until no other is found. The starts lie in a box about q0: half
 * a turn wide for angles, else some times what the motion covers, or |q0|; no length is absolute.
 * A coordinate of which the equations have the period 2 pi is given in (-pi, pi]. First-order
 * variables, which are in v, rest too, but for those that no rate depends on, which stay as they
 * are. With rotations or constraints what is sought fulfils them (equilibria_bound.c); bodies do not
 * turn there, and a quaternion's first number that is not 0 is positive. PK_REFUSED where the
 * equations depend on time or on inputs. That all are found cannot be promised. */
enum pk_status pk_gsl_equilibria(const struct pk_problem *problem, const double *q0,
                                 const double *v0, size_t tries, struct pk_equilibria *found);

/* One entry for lambda and its conjugate; a real pair is two entries. A lambda below 1e-7 of the
 * largest is 0: a motion that neither returns nor leaves exponentially. */
struct pk_mode {
    double growth, frequency;
};

/* The modes at an equilibrium, fastest first: up to 2 n of them, and n real and n imaginary parts
 * of each one's shape, 1 the largest component of those that are not cyclic. With rotations or
 * constraints those of what stays on them (pk_gsl_tangent()). PK_REFUSED where a kernel is not
 * there, or nothing can move; PK_SINGULAR_MASS;
 * PK_NO_CONVERGENCE. */
enum pk_status pk_gsl_modes(const struct pk_problem *problem, const double *q, const double *v,
                            struct pk_mode *modes, double *shapes, size_t *count);

/* The eigenvalues of the linearised equations at any state, zeros included, one entry for lambda
 * and its conjugate: room for 2 n each. What grows or turns fastest there is what a step resolves
 * or does not. PK_REFUSED without the kernel `linear`; PK_SINGULAR_MASS; PK_NO_CONVERGENCE. */
enum pk_status pk_gsl_rates(const struct pk_problem *problem, double t, const double *q,
                            const double *v, double *growth, double *frequency, size_t *count);

/* Of each degree of freedom whether it is a first-order variable that no rate depends on (a
 * quadrature: work done, an action), tried at the state and at two others. */
enum pk_status pk_gsl_unread(const struct pk_problem *problem, const double *q, const double *v,
                             unsigned char *unread);

/* Normal coordinates at an equilibrium q* of a system without forces besides those of L, and
 * without terms linear in the rates there:
 *
 *     Q = U^T M (q - q*),  P = U^T (p - p*),  U^T M U = 1,
 *     h = h* + sum of (P^2 + omega^2 Q^2)/2 + what is not quadratic.
 *
 * squares: omega^2 of each mode, the smallest first, 0 below 1e-12 of the largest, negative where
 * it leaves; M: n by n; shapes: n by n, a row of U^T for each. PK_REFUSED of other systems, and of
 * one compiled without the kernels mass and jacobian; PK_SINGULAR_MASS. */
enum pk_status pk_gsl_normal(const struct pk_problem *problem, const double *q, double *M,
                             double *squares, double *shapes);
/* (P^2 + omega^2 Q^2)/2 of each, at q - q* and p - p*. */
void pk_normal_energies(size_t n, const double *M, const double *squares, const double *shapes,
                        const double *q, const double *p, double *E);

PK_END

#endif

/* Equilibria of a system by GSL's root finder from many starts, and normal coordinates at an
 * equilibrium. pk_real must be double; link libpk_gsl.a before libpk.a, then -lgsl -lgslcblas. GSL
 * allocates; all memory is freed before these functions return.
 *
 * Relative equilibria are sought: cyclic coordinates have constant rates and momenta, all other
 * coordinates rest (the steady precession of a top). With subscript c for cyclic coordinates and n
 * for non-cyclic ones,
 *
 *     pdot_n(q_n, v_c) = 0,   p_c(q_n, v_c) = p_c of the given start,   v_n = 0. */
#ifndef PK_GSL_EQUILIBRIA_H
#define PK_GSL_EQUILIBRIA_H

#include <pk/integrator.h>

PK_BEGIN

struct pk_equilibria {
    size_t most; /* number of equilibria that q and v have memory for: most * n numbers each */
    double *q, *v;
    size_t count;  /* equilibria found, the lowest energy first */
    size_t failed; /* number of starts from which no equilibrium was found */
    /* number of starts from which the search met a singular or indefinite M, as at a pole */
    size_t singular;
    int more;             /* 1: there are more equilibria than `most`, perhaps a continuum */
    unsigned char *turns; /* output, n flags, or NULL: q_i + 2 pi is the same position as q_i */
    /* output with as many numbers as q, or NULL: the last correction of q_i by Newton's method,
     * or of v_i if coordinate i is cyclic. It is as large as the error of q_i if the linear
     * terms of the equations vanish at the equilibrium; otherwise the error is smaller. */
    double *doubt;
    /* output of `most` numbers, or NULL. In systems with rotations or constraints equilibria may
     * form a continuum, of which one point is returned for each energy; this is the number of
     * dimensions of the continuum. */
    size_t *slack;
    /* output of n numbers each, or NULL: where starts of the search lie. Half of the starts have
     * q_i (v_i if cyclic) in middle_i +- box_i, a quarter in middle_i +- 4 box_i, and a quarter
     * in middle_i +- 32 box_i. For angles all starts lie in middle_i +- box_i. */
    double *middle, *box;
};

/* Searches from q0, v0 and from `tries` more starts (Halton's points, the same at each call). After
 * each solution the search is repeated from the same start until it fails; deflation of the known
 * roots keeps it from finding them again. The starts lie in a box about q0. Its width is half a
 * turn for angles; for other coordinates it is a multiple of the range of the motion, or of |q0|. A
 * coordinate in which the equations have the period 2 pi is returned in (-pi, pi]. First-order
 * variables, which are in v, are constant too, except quadratures, which keep their start values.
 * Equilibria satisfy constraints (equilibria_bound.c) and have no body rates; the first nonzero
 * component of a quaternion is positive. PK_REFUSED: the equations depend on time or inputs. The
 * search may miss some. */
enum pk_status pk_gsl_equilibria(const struct pk_problem *problem, const double *q0,
                                 const double *v0, size_t tries, struct pk_equilibria *found);

/* Computes the eigenvalues of the linearised equations at any state, zeros included, with one entry
 * for each complex pair; the arrays have 2 n numbers each. The largest eigenvalue shows how short
 * steps of an integrator must be. Fails with PK_REFUSED, PK_SINGULAR_MASS or PK_NO_CONVERGENCE. */
enum pk_status pk_gsl_rates(const struct pk_problem *problem, double t, const double *q,
                            const double *v, double *growth, double *frequency, size_t *count);

/* Sets, for each entry of v, whether it is a quadrature: a first-order variable that no rate
 * depends on (work done, an action), as tested at the given state and at two others. */
enum pk_status pk_gsl_unread(const struct pk_problem *problem, const double *q, const double *v,
                             unsigned char *unread);

/* Computes normal coordinates at an equilibrium q* of a system whose forces all come from L, if L
 * has no terms linear in the rates at q*:
 *
 *     Q = U^T M (q - q*),  P = U^T (p - p*),  U^T M U = 1,
 *     h = h* + sum of (P^2 + omega^2 Q^2)/2 + higher-order terms.
 *
 * squares: omega^2 of each mode, ascending, set to 0 if below 1e-12 of the largest one, and
 * negative if the mode is unstable; M: n by n; shapes: n by n, U^T row by row. Fails with
 * PK_REFUSED for other systems or without the kernels mass and jacobian, or with
 * PK_SINGULAR_MASS. */
enum pk_status pk_gsl_normal(const struct pk_problem *problem, const double *q, double *M,
                             double *squares, double *shapes);
/* Computes (P^2 + omega^2 Q^2)/2 of each mode, from q - q* and p - p*. */
void pk_normal_energies(size_t n, const double *M, const double *squares, const double *shapes,
                        const double *q, const double *p, double *E);

PK_END

#endif

/* What the implicit methods in (q, p) share: the step (gauss.c), its equations (newton.c), their
 * matrix (gauss_matrix.c), which of their solutions it is (branch.c), step control (radau.c).
 */
#ifndef PK_GAUSS_H
#define PK_GAUSS_H

#include "../core/band.h"
#include "../core/internal.h"
#include "../core/tableau.h"

/* Corrections below this, relative, that no longer shrink are round-off, not divergence. */
#define PK_GAUSS_ROUND (PK_C(16384.0) * PK_EPS)
/* What an iteration may leave undone: the error of 1e8 steps is then still of round-off. */
#define PK_GAUSS_BIAS (PK_EPS / PK_C(8192.0))
/* A step so much longer than the last one is not predicted from it. */
#define PK_GAUSS_REACH PK_C(64.0)
/* Below these contractions the solution found is the one of short steps: so too in steps to come
 * that keep the matrix, and in one for which it was made. See branch.c. */
#define PK_GAUSS_SURE PK_C(0.5)
#define PK_GAUSS_SURE_ONCE PK_C(0.9)
/* Corrections of a fixed-point iteration that shrink like this are those of a contraction; smaller
 * ones, relative, may rise and fall without leading to another solution. */
#define PK_GAUSS_FAST PK_C(0.7)
#define PK_GAUSS_FAR PK_C(0.1)
/* Newton's corrections that do not shrink like that, while its matrix changes by no more than
 * this, are no corrections at all. */
#define PK_GAUSS_STUCK PK_C(0.7)
#define PK_GAUSS_STEADY PK_C(1e-3)

/* What a step leaves to the next one. */
struct pk_gauss_kept {
    pk_real h, lu_h, last_h; /* the steps that hA, lu and last_V were made for */
    pk_real ratio;           /* of the predictor: its step over the last one */
    pk_real slow_h;          /* the step at which gauss_nystrom.c did not converge */
    /* newton.c: iterations with a new matrix; steps for which it is still to be made anew, and how
     * many these were; whether the iteration ended in the round-off of the forces. */
    int best, wait, patience, noisy;
    /* branch.c: contraction when lu was made and in the last step; first and worst iteration rate;
     * `loose`, the sharp bound over the quick one where both were computed, and for how many
     * more matrices it is reused; whether lu is known to be on the branch, or is of this step. */
    pk_real contraction, last_contraction, first_rate, worst_rate, loose;
    int loose_for, sure, fresh;
};

struct pk_gauss_work {
    const struct pk_gauss *table;
    size_t s;
    struct pk_pattern pattern; /* of derivatives; rows 0: dense */
    int closed;                /* some places are of multipliers or accelerations */
    /* Coordinates, rates and states; places: where dense the first coordinates, without those that nothing reads,
     * else as many or more; numbers of a matrix that a kernel writes, and how far apart rows of the
     * border are in it. */
    size_t n_q, n, places, nn, across;
    pk_real *place;             /* the coordinate that has each place, where not dense */
    pk_real *V, *Q, *P, *F, *G; /* stages: rates, coordinates, momenta, h b pdot, residual; n_q
                                   each of Q, n of the others */
    pk_real *last_V;            /* of the last step made, for the predictor */
    pk_real *jacobian;          /* s of: M, p_q, pdot_q, pdot_v, one spare */
    struct pk_band lu, other;   /* Newton's matrix, factored; another one, not to be factored */
    pk_real *mass, *mean_q, *mean_v, *scale;
    pk_real *c, *b, *mu, *mu_p, *hA, *hA_p, *hb, *predict; /* _p: for p */
    pk_real *hh, *norms;        /* h^2 a^_ir a_rj; norms of hA, hA_p, hh */
    pk_real *mu_columns, *rest; /* of gauss8: mu for the lanes; work of gauss_nystrom.c. Of radau:
                                   work of radau.c */
    /* branch.c: derivatives at the start and at the point before, V there and before that; M of
     * each stage; vectors, by places. newton.c: derivatives an iteration before. */
    pk_real *start_J, *old_J, *old_V, *older_V, *M, *x, *y, *z, *before_J;
    struct pk_gauss_kept *kept;
};

/* Iteration by Newton's matrix frozen at the predicted stages, or made anew each time, or by M
 * alone. */
enum pk_gauss_mode { PK_SIMPLIFIED, PK_FULL, PK_BY_MASS };

/* gauss_work.c. `kept` is memory of the block too. */
struct pk_gauss_work pk_gauss_parts(struct pk_integrator *it);
enum pk_status pk_gauss_nystrom_step(struct pk_integrator *it, const struct pk_gauss_work *w);

/* Whether a step of h is made by that, or was. */
static inline int pk_gauss_by_lanes(const struct pk_integrator *it, const struct pk_gauss_work *w,
                                    pk_real h)
{
    return w->s == PK_LANES && it->problem.system->facts & PK_SEPARABLE &&
           (h > w->kept->slow_h || h < w->kept->slow_h);
}

/* What a step is made of: h a_ij and h b_i; V as foreseen from the last step; V, Q, P, F that solve
 * the equations, from the V given as a guess; the new state from these. */
void pk_gauss_set_step(struct pk_integrator *it, struct pk_gauss_work *w, pk_real h);
void pk_gauss_predict(struct pk_integrator *it, struct pk_gauss_work *w);
enum pk_status pk_gauss_solve(struct pk_integrator *it, struct pk_gauss_work *w);
enum pk_status pk_gauss_finish(struct pk_integrator *it, struct pk_gauss_work *w);

/* G, and Q, P, F, at V. 0 where one is not finite. */
int pk_gauss_residual(struct pk_integrator *it, struct pk_gauss_work *w);
/* V -= (matrix)^-1 G; G is then that correction. */
void pk_gauss_correct(struct pk_integrator *it, struct pk_gauss_work *w, enum pk_gauss_mode mode);
/* Where V has solved the equations: what nothing reads is G there what it is off, and follows. */
void pk_gauss_settle(const struct pk_integrator *it, const struct pk_gauss_work *w);
/* w->scale of each coordinate's rates, from V and q/h. */
void pk_gauss_set_scale(const struct pk_integrator *it, struct pk_gauss_work *w);
/* The iteration from V. 0 where it did not converge. */
int pk_gauss_iterate(struct pk_integrator *it, struct pk_gauss_work *w, enum pk_gauss_mode mode);

/* M alone; M, p_q, pdot_q, pdot_v into J, w->nn numbers each. */
void pk_gauss_mass(struct pk_integrator *it, pk_real t, const pk_real *q, const pk_real *v,
                   pk_real *M);
void pk_gauss_derivatives(struct pk_integrator *it, const struct pk_gauss_work *w, pk_real t,
                          const pk_real *q, const pk_real *v, pk_real *J);
/* The same at each stage. */
void pk_gauss_stage_derivatives(struct pk_integrator *it, struct pk_gauss_work *w);
/* Newton's matrix for a step of tau h, not factored, with `mass` times M. Derivatives of stage j
 * start at J + j * stride, so a stride of 0 is one set for all stages. */
void pk_gauss_matrix(const struct pk_gauss_work *w, const pk_real *J, size_t stride, pk_real tau,
                     pk_real mass, const struct pk_band *matrix);
/* Newton's matrix as the mode wants it, factored into w->lu; 0 where it is singular. */
int pk_gauss_refactor(struct pk_integrator *it, struct pk_gauss_work *w, enum pk_gauss_mode mode);
/* Of pk_method: w->lu, where it is that of the step made. */
const pk_real *pk_gauss_equations(struct pk_integrator *it);
/* Where a matrix costs less than an iteration or two: it then takes the derivatives at each
 * predicted stage, and is made anew at the first sign of slower convergence. */
int pk_gauss_small(const struct pk_gauss_work *w);
/* M = L D L^T in place; 0, or 1 + the coordinate whose pivot is not positive. x = M^-1 x of what is
 * factored, x by coordinates. */
int pk_gauss_mass_factor(const struct pk_gauss_work *w, pk_real *M);
void pk_gauss_mass_solve(const struct pk_gauss_work *w, pk_real *M, pk_real *x);
/* A matrix whose inverse is no less than |M^-1|, entry by entry, where it is positive definite:
 * A. M. Ostrowski, Comment. Math. Helv. 10 (1937) 69. */
void pk_gauss_compare(const struct pk_gauss_work *w, pk_real *M);
/* How many coordinates Newton's equations are of: they are the first ones. */
static inline size_t pk_gauss_read(const struct pk_gauss_work *w)
{
    return w->pattern.dense ? w->places : w->n;
}
/* x = lu^-1 x, of s stages, x by coordinates; y = lu^-1 (y + A x) of
 * one stage, where dense of all coordinates: what nothing reads is y + A x. */
void pk_gauss_lu_solve(const struct pk_gauss_work *w, const struct pk_band *lu, size_t s,
                       pk_real *x);
void pk_gauss_solve_with(const struct pk_gauss_work *w, pk_real *A, const pk_real *x,
                         const struct pk_band *lu, pk_real *y);
/* gauss_places.c: the matrix of a pattern that lies at `numbers`; its unknowns from a vector of s
 * stages by coordinates, and back. */
struct pk_band pk_gauss_band(const struct pk_gauss_work *w, pk_real *numbers);
void pk_gauss_to_places(const struct pk_gauss_work *w, size_t s, const pk_real *x, pk_real *y);
void pk_gauss_to_coordinates(const struct pk_gauss_work *w, size_t s, const pk_real *y, pk_real *x);

/* Twice the spectral radius of J1^-1 J2 - I, J1 factored in w->lu and J2 in w->other, as a power
 * iteration tells it. */
pk_real pk_gauss_radius(const struct pk_gauss_work *w);
/* A bound on how much one fixed-point iteration contracts, by `count` sets of derivatives; not
 * finite where M is not positive definite. Where some places are no coordinates w->lu is lost. */
pk_real pk_gauss_contraction(const struct pk_integrator *it, const struct pk_gauss_work *w,
                             const pk_real *J, size_t count);
/* The least of max_i (|M^-1 X| x)_i / x_i over some x > 0, which bounds M^-1 X in a norm of weights
 * 1/x; X = w->other, M of each stage as factored in w->M, or 1 where that is NULL. */
pk_real pk_gauss_norm(const struct pk_gauss_work *w, const pk_real *M);

/* Whether V is the solution that belongs to short steps; if not, that solution, or
 * PK_AMBIGUOUS_STEP with the longest step for which there is one in it->detail. */
enum pk_status pk_gauss_certify(struct pk_integrator *it, struct pk_gauss_work *w);

#endif

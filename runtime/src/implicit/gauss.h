/* Shared by the implicit methods in (q, p): the step (gauss.c), its equations (newton.c), their
 * matrix (gauss_matrix.c), the choice of a solution (branch.c), step size control (radau.c). */
#ifndef PK_GAUSS_H
#define PK_GAUSS_H

#include "../core/band.h"
#include "../core/internal.h"
#include "../core/tableau.h"

/* Corrections whose relative size is below this and no longer decreases are round-off: the
 * iteration does not diverge. */
#define PK_GAUSS_ROUND (16384 * PK_EPS)
/* An iteration ends at this relative error: 1e8 of them sum to the round-off of as many steps. */
#define PK_GAUSS_BIAS (PK_EPS / PK_C(8192.0))
/* A step longer than the last step by more than this factor is not predicted from the last step. */
#define PK_GAUSS_REACH PK_C(64.0)
/* A contraction bound below these constants certifies the branch of short steps: SURE also in later
 * steps that reuse the matrix, SURE_ONCE in the step that computes it. See branch.c. */
#define PK_GAUSS_SURE PK_C(0.5)
#define PK_GAUSS_SURE_ONCE PK_C(0.9)
/* A fixed-point iteration contracts if the ratio of successive corrections is at most FAST.
 * Relative corrections below FAR may increase and decrease without leading to another solution. */
#define PK_GAUSS_FAST PK_C(0.7)
#define PK_GAUSS_FAR PK_C(0.1)
/* Newton corrections are rounding noise if their ratio is more than STUCK, while the relative
 * change of the matrix is at most STEADY. */
#define PK_GAUSS_STUCK PK_C(0.7)
#define PK_GAUSS_STEADY PK_C(1e-3)

/* Data stored from one step to the next. */
struct pk_gauss_kept {
    pk_real h, lu_h, last_h; /* step sizes for which hA, lu and last_V were computed */
    pk_real ratio;           /* ratio of step sizes for which `predict` was computed */
    pk_real slow_h;          /* step size for which gauss_nystrom.c did not converge */
    /* For newton.c. best: number of iterations that a new matrix needs. wait: number of further
     * steps that recompute the matrix. patience: value at which `wait` started last. noisy: whether
     * the iteration ended in the round-off of forces. */
    int best, wait, patience, noisy;
    /* For branch.c. contraction, last_contraction: bounds of the contraction factor for lu and in
     * the last step. first_rate, worst_rate: first and largest ratio of successive corrections.
     * loose: ratio of the sharp bound to the quick bound. loose_for: number of further matrices for
     * which `loose` is used. sure: lu is certified for later steps. fresh: lu is of this step. */
    pk_real contraction, last_contraction, first_rate, worst_rate, loose;
    int loose_for, sure, fresh;
};

struct pk_gauss_work {
    const struct pk_gauss *table;
    size_t s;
    struct pk_pattern pattern; /* sparsity of the derivatives: a band with a border, or dense */
    int closed; /* whether some unknowns are multipliers, accelerations or sums, not rates */
    /* n_q: number of coordinates. n: number of rates and other first-order variables. places:
     * number of unknowns per stage; if dense, these are the first of the n variables, without
     * quadratures; otherwise there may be more than n. nn: number of entries of a matrix that a
     * kernel writes. across: distance in memory between rows of the border of such a matrix. */
    size_t n_q, n, places, nn, across;
    pk_real *place; /* if not dense: coordinate of each unknown, < 0 if it has none */
    /* At all stages: rates V, coordinates Q, momenta P, F = h b pdot, residuals G; n numbers per
     * stage, n_q for Q. */
    pk_real *V, *Q, *P, *F, *G;
    pk_real *last_V;          /* stage rates V of the last step, for the predictor */
    pk_real *jacobian;        /* s sets of M, dp/dq, dpdot/dq, dpdot/dv */
    struct pk_band lu, other; /* Newton's matrix, factored; another matrix, not factored */
    pk_real *mass, *mean_q, *mean_v, *scale;
    pk_real *c, *b, *mu, *mu_p, *hA, *hA_p, *hb, *predict; /* tableau; mu_p and hA_p are for p */
    pk_real *hh, *norms;        /* products h^2 a^_ir a_rj; maximum norms of hA, hA_p, hh */
    pk_real *mu_columns, *rest; /* mu stored by columns, for gauss8; memory of other files */
    /* For branch.c. start_J, old_J: derivatives at the start and at the last point of a
     * continuation. old_V, older_V: V at its last two points. M: the M of each stage. x, y, z:
     * vectors in the order of the pattern. before_J: those of newton.c's last iteration. */
    pk_real *start_J, *old_J, *old_V, *older_V, *M, *x, *y, *z, *before_J;
    struct pk_gauss_kept *kept;
};

/* The matrix of an iteration. PK_SIMPLIFIED: Newton's matrix at the predicted stages. PK_FULL:
 * Newton's matrix, recomputed in each iteration. PK_BY_MASS: M, a fixed-point iteration. */
enum pk_gauss_mode { PK_SIMPLIFIED, PK_FULL, PK_BY_MASS };

/* In gauss_work.c. Returns the work arrays of an integrator; they and `kept` are in its block. */
struct pk_gauss_work pk_gauss_parts(struct pk_integrator *it);
enum pk_status pk_gauss_nystrom_step(struct pk_integrator *it, const struct pk_gauss_work *w);

/* Returns whether steps of size h are made by pk_gauss_nystrom_step(). */
static inline int pk_gauss_by_lanes(const struct pk_integrator *it, const struct pk_gauss_work *w,
                                    pk_real h)
{
    return w->s == PK_LANES && it->problem.system->facts & PK_SEPARABLE &&
           (h > w->kept->slow_h || h < w->kept->slow_h);
}

/* Returns whether Newton's matrix is missing, worn out or of another step size. */
static inline int pk_gauss_stale(const struct pk_integrator *it, const struct pk_gauss_work *w)
{
    return !(it->own->flags & PK_HAVE_LU) || it->own->flags & PK_REFRESH ||
           it->own->h > w->kept->lu_h || it->own->h < w->kept->lu_h;
}

/* Guesses V = v0 at all stages. */
static inline void pk_gauss_rest(const struct pk_integrator *it, const struct pk_gauss_work *w)
{
    for (size_t i = 0; i < w->s; i++)
        pk_copy(w->V + i * it->n, it->v, it->n);
}

/* Parts of a step. set_step() computes h a_ij and h b_i; predict() extrapolates V from the last
 * step; solve() finds V, Q, P, F from a guess of V; finish() computes the new state. */
void pk_gauss_set_step(struct pk_integrator *it, struct pk_gauss_work *w, pk_real h);
void pk_gauss_predict(struct pk_integrator *it, struct pk_gauss_work *w);
enum pk_status pk_gauss_solve(struct pk_integrator *it, struct pk_gauss_work *w);
enum pk_status pk_gauss_finish(struct pk_integrator *it, struct pk_gauss_work *w);

/* Computes Q, P, F and G from V. Returns 0 if G is not finite. */
int pk_gauss_residual(struct pk_integrator *it, struct pk_gauss_work *w);
/* Computes V -= (matrix)^-1 G, and replaces G by that correction. */
void pk_gauss_correct(struct pk_integrator *it, struct pk_gauss_work *w, enum pk_gauss_mode mode);
/* Corrects V and P of quadratures by their residuals, once V solves the other equations. */
void pk_gauss_settle(const struct pk_integrator *it, const struct pk_gauss_work *w);
/* Sets w->scale, the scale of the rate of each coordinate, from V and q/h. */
void pk_gauss_set_scale(const struct pk_integrator *it, struct pk_gauss_work *w);
/* Iterates, starting at V. Returns 0 if the iteration does not converge. */
int pk_gauss_iterate(struct pk_integrator *it, struct pk_gauss_work *w, enum pk_gauss_mode mode);

/* pk_gauss_mass() evaluates M. pk_gauss_derivatives() evaluates M, p_q, pdot_q and pdot_v into J,
 * w->nn numbers for each. */
void pk_gauss_mass(struct pk_integrator *it, pk_real t, const pk_real *q, const pk_real *v,
                   pk_real *M);
void pk_gauss_derivatives(struct pk_integrator *it, const struct pk_gauss_work *w, pk_real t,
                          const pk_real *q, const pk_real *v, pk_real *J);
/* Evaluates the derivatives at each stage into w->jacobian. */
void pk_gauss_stage_derivatives(struct pk_integrator *it, struct pk_gauss_work *w);
/* Assembles Newton's matrix for a step of length tau h, without factoring it. M in this matrix is
 * multiplied by `mass`. The derivatives for stage j are at J + j * stride; stride 0 means that all
 * stages have the same derivatives. */
void pk_gauss_matrix(const struct pk_gauss_work *w, const pk_real *J, size_t stride, pk_real tau,
                     pk_real mass, const struct pk_band *matrix);
/* Computes and factors the matrix of `mode`: in w->jacobian for PK_BY_MASS, otherwise in w->lu.
 * Returns 0 if it is singular. */
int pk_gauss_refactor(struct pk_integrator *it, struct pk_gauss_work *w, enum pk_gauss_mode mode);
/* The function pk_method.equations: returns the dense w->lu of the last step, or NULL. */
const pk_real *pk_gauss_equations(struct pk_integrator *it);
/* The functions pk_method.last; pk_gauss_lanes_last() copies Q and V from lanes. */
void pk_gauss_last(struct pk_integrator *it, struct pk_stages *to);
struct pk_gauss_lanes;
void pk_gauss_lanes_last(const struct pk_integrator *it, const struct pk_gauss_lanes *w,
                         struct pk_stages *to);
/* Returns whether a new matrix costs less than an iteration or two. If so, the matrix is computed
 * with the derivatives at each predicted stage, and recomputed once convergence gets slower. */
int pk_gauss_small(const struct pk_gauss_work *w);
/* Factors M = L D L^T in place. Returns 0, or a PK_FAILURE_MASS with the coordinate whose pivot is
 * not positive. pk_gauss_mass_solve() computes x = M^-1 x; x is in the order of coordinates. */
int pk_gauss_mass_factor(const struct pk_gauss_work *w, pk_real *M);
void pk_gauss_mass_solve(const struct pk_gauss_work *w, pk_real *M, pk_real *x);
/* Replaces M by its comparison matrix, whose inverse is entrywise at least |M^-1| if the comparison
 * matrix is positive definite: A. M. Ostrowski, Comment. Math. Helv. 10 (1937) 69. */
void pk_gauss_compare(const struct pk_gauss_work *w, pk_real *M);
/* Returns how many of the n variables, counted from the first, occur in Newton's equations. */
static inline size_t pk_gauss_read(const struct pk_gauss_work *w)
{
    return w->pattern.dense ? w->places : w->n;
}
/* pk_gauss_lu_solve() computes x = lu^-1 x for s stages; x is in the order of coordinates.
 * pk_gauss_solve_with() sets y = lu^-1 (y + A x) for one stage; if dense, y + A x for
 * quadratures. */
void pk_gauss_lu_solve(const struct pk_gauss_work *w, const struct pk_band *lu, size_t s,
                       pk_real *x);
void pk_gauss_solve_with(const struct pk_gauss_work *w, pk_real *A, const pk_real *x,
                         const struct pk_band *lu, pk_real *y);
/* In gauss_places.c. pk_gauss_band() describes the array `numbers` as a band matrix, whose rows and
 * columns have the order of unknowns: member by member along a family. The two other functions copy
 * a vector of s stages from the order of coordinates to that, and back. */
struct pk_band pk_gauss_band(const struct pk_gauss_work *w, pk_real *numbers);
void pk_gauss_to_places(const struct pk_gauss_work *w, size_t s, const pk_real *x, pk_real *y);
void pk_gauss_to_coordinates(const struct pk_gauss_work *w, size_t s, const pk_real *y, pk_real *x);

/* Returns the spectral radius of J1^-1 J2 - shift I, estimated by a power iteration; J1 is factored
 * in w->lu, and J2 is in w->other. */
pk_real pk_gauss_radius(const struct pk_gauss_work *w, pk_real shift);
/* Returns a bound of the contraction factor of the fixed-point iteration with `count` sets of
 * derivatives; not finite if M is not positive definite. May overwrite w->lu if not dense. */
pk_real pk_gauss_contraction(const struct pk_integrator *it, const struct pk_gauss_work *w,
                             const pk_real *J, size_t count);
/* Returns the least value of max_i (|M^-1 X| x)_i / x_i for several vectors x > 0: a bound of M^-1
 * X in the maximum norm with weights 1/x. X is in w->other, and M of each stage is factored in
 * w->M; if the argument M is NULL, M is replaced by 1. */
pk_real pk_gauss_norm(const struct pk_gauss_work *w, const pk_real *M);

/* Certifies that V is on the branch of short steps. Otherwise replaces V by the solution on this
 * branch, or returns PK_AMBIGUOUS_STEP with the longest step that has one. */
enum pk_status pk_gauss_certify(struct pk_integrator *it, struct pk_gauss_work *w);

#endif

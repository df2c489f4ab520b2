/* Shared by the implicit methods in (q, p): the step (gauss.c), its equations (newton.c), their
 * matrix (gauss_matrix.c), the choice of a solution (branch.c), step size control (radau.c).
 */
#ifndef PK_GAUSS_H
#define PK_GAUSS_H

#include "../core/band.h"
#include "../core/internal.h"
#include "../core/tableau.h"

/* Relative corrections below this that no longer decrease are round-off, not divergence. */
#define PK_GAUSS_ROUND (PK_C(16384.0) * PK_EPS)
/* An iteration ends at this relative error: 1e8 of them still add up to round-off. */
#define PK_GAUSS_BIAS (PK_EPS / PK_C(8192.0))
/* If a step is longer than the last one by more than this factor, it is not predicted from it. */
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
    pk_real ratio;           /* step size ratio for which `predict` was computed */
    pk_real slow_h;          /* step size at which gauss_nystrom.c did not converge */
    /* For newton.c. best: iterations with a new matrix. wait: further steps that recompute it.
     * patience: last start value of `wait`. noisy: iteration ended in the round-off of forces. */
    int best, wait, patience, noisy;
    /* For branch.c: contraction bounds of lu and of the last step; first and worst ratio of
     * successive corrections. loose: ratio of the sharp to the quick bound; loose_for: number of
     * further matrices for which it is used. sure: lu is certified for later steps. fresh: lu was
     * made in this step. */
    pk_real contraction, last_contraction, first_rate, worst_rate, loose;
    int loose_for, sure, fresh;
};

struct pk_gauss_work {
    const struct pk_gauss *table;
    size_t s;
    struct pk_pattern pattern; /* sparsity of the derivatives: a band with a border, or dense */
    int closed;                /* some unknowns are multipliers, accelerations or sums */
    /* n_q: number of coordinates. n: of rates and other first-order variables. places: of unknowns
     * per stage (dense: the first ones of n, without quadratures; otherwise may exceed n). nn: of
     * entries that a kernel writes for a matrix. across: distance between rows of its border. */
    size_t n_q, n, places, nn, across;
    pk_real *place;             /* not dense: coordinate of each unknown, or < 0 */
    pk_real *V, *Q, *P, *F, *G; /* at stages: rates, coordinates, momenta, h b pdot, residual; n
                                   numbers each, Q n_q */
    pk_real *last_V;            /* V of the last step, for the predictor */
    pk_real *jacobian;          /* s sets of M, p_q, pdot_q, pdot_v */
    struct pk_band lu, other;   /* Newton's matrix, factored; another one, not factored */
    pk_real *mass, *mean_q, *mean_v, *scale;
    pk_real *c, *b, *mu, *mu_p, *hA, *hA_p, *hb, *predict; /* tableau; names with _p: for p */
    pk_real *hh, *norms;        /* h^2 a^_ir a_rj; maximum norms of hA, hA_p, hh */
    pk_real *mu_columns, *rest; /* mu by columns, for gauss8; work memory of other files */
    /* For branch.c: derivatives at the start and at the last point of a continuation, V at the last
     * two points; M of each stage; vectors in the order of the pattern. before_J, for newton.c:
     * derivatives of the last iteration. */
    pk_real *start_J, *old_J, *old_V, *older_V, *M, *x, *y, *z, *before_J;
    struct pk_gauss_kept *kept;
};

/* The matrix of an iteration. SIMPLIFIED: Newton's at the predicted stages; FULL: Newton's,
 * recomputed in each iteration; BY_MASS: M (fixed-point iteration). */
enum pk_gauss_mode { PK_SIMPLIFIED, PK_FULL, PK_BY_MASS };

/* In gauss_work.c: returns the work arrays of an integrator; `kept` is also in its block. */
struct pk_gauss_work pk_gauss_parts(struct pk_integrator *it);
enum pk_status pk_gauss_nystrom_step(struct pk_integrator *it, const struct pk_gauss_work *w);

/* Returns whether steps of size h are made by pk_gauss_nystrom_step(). */
static inline int pk_gauss_by_lanes(const struct pk_integrator *it, const struct pk_gauss_work *w,
                                    pk_real h)
{
    return w->s == PK_LANES && it->problem.system->facts & PK_SEPARABLE &&
           (h > w->kept->slow_h || h < w->kept->slow_h);
}

/* Parts of a step. set_step() computes h a_ij and h b_i; predict() extrapolates V from the last
 * step; solve() finds V, Q, P, F from a guess of V; finish() computes the new state from V, Q, P
 * and F. */
void pk_gauss_set_step(struct pk_integrator *it, struct pk_gauss_work *w, pk_real h);
void pk_gauss_predict(struct pk_integrator *it, struct pk_gauss_work *w);
enum pk_status pk_gauss_solve(struct pk_integrator *it, struct pk_gauss_work *w);
enum pk_status pk_gauss_finish(struct pk_integrator *it, struct pk_gauss_work *w);

/* Computes Q, P, F and G from V. Returns 0 if G is not finite. */
int pk_gauss_residual(struct pk_integrator *it, struct pk_gauss_work *w);
/* Computes V -= (matrix)^-1 G, and replaces G by that correction. */
void pk_gauss_correct(struct pk_integrator *it, struct pk_gauss_work *w, enum pk_gauss_mode mode);
/* Corrects V and P of quadratures by their residual, after V solves the other equations. */
void pk_gauss_settle(const struct pk_integrator *it, const struct pk_gauss_work *w);
/* Sets w->scale, the scale of the rate of each coordinate, from V and q/h. */
void pk_gauss_set_scale(const struct pk_integrator *it, struct pk_gauss_work *w);
/* Iterates from V. Returns 0 if the iteration does not converge. */
int pk_gauss_iterate(struct pk_integrator *it, struct pk_gauss_work *w, enum pk_gauss_mode mode);

/* pk_gauss_mass() evaluates M, the other M, p_q, pdot_q, pdot_v into J, w->nn numbers each. */
void pk_gauss_mass(struct pk_integrator *it, pk_real t, const pk_real *q, const pk_real *v,
                   pk_real *M);
void pk_gauss_derivatives(struct pk_integrator *it, const struct pk_gauss_work *w, pk_real t,
                          const pk_real *q, const pk_real *v, pk_real *J);
/* Evaluates the derivatives at each stage into w->jacobian. */
void pk_gauss_stage_derivatives(struct pk_integrator *it, struct pk_gauss_work *w);
/* Assembles Newton's matrix for a step of tau h, with `mass` times M; does not factor it.
 * Derivatives of stage j are at J + j * stride; stride 0: one set for all stages. */
void pk_gauss_matrix(const struct pk_gauss_work *w, const pk_real *J, size_t stride, pk_real tau,
                     pk_real mass, const struct pk_band *matrix);
/* Computes and factors the matrix of `mode` in w->lu, for BY_MASS in w->jacobian. Returns 0 if it
 * is singular. */
int pk_gauss_refactor(struct pk_integrator *it, struct pk_gauss_work *w, enum pk_gauss_mode mode);
/* The function pk_method.equations: returns the dense w->lu of the last step, or NULL. */
const pk_real *pk_gauss_equations(struct pk_integrator *it);
/* Returns whether a new matrix costs less than an iteration or two. It is then computed with the
 * derivatives at each predicted stage, and recomputed as soon as convergence is slower. */
int pk_gauss_small(const struct pk_gauss_work *w);
/* Factors M = L D L^T in place; returns 0, or a PK_FAILURE_MASS with the coordinate whose pivot is
 * not positive. mass_solve() computes x = M^-1 x with the factors, x in the order of
 * coordinates. */
int pk_gauss_mass_factor(const struct pk_gauss_work *w, pk_real *M);
void pk_gauss_mass_solve(const struct pk_gauss_work *w, pk_real *M, pk_real *x);
/* Replaces M by its comparison matrix, whose inverse is entrywise at least |M^-1| if the comparison
 * matrix is positive definite: A. M. Ostrowski, Comment. Math. Helv. 10 (1937) 69. */
void pk_gauss_compare(const struct pk_gauss_work *w, pk_real *M);
/* Returns the number of first variables, of n, that occur in Newton's equations. */
static inline size_t pk_gauss_read(const struct pk_gauss_work *w)
{
    return w->pattern.dense ? w->places : w->n;
}
/* lu_solve() computes x = lu^-1 x for s stages, x in the order of coordinates. solve_with()
 * computes y = lu^-1 (y + A x) for one stage; if dense, also y + A x for the quadratures. */
void pk_gauss_lu_solve(const struct pk_gauss_work *w, const struct pk_band *lu, size_t s,
                       pk_real *x);
void pk_gauss_solve_with(const struct pk_gauss_work *w, pk_real *A, const pk_real *x,
                         const struct pk_band *lu, pk_real *y);
/* In gauss_places.c: pk_gauss_band() returns the matrix whose entries are at `numbers`; the others
 * copy a vector of s stages from the order of coordinates to that of the unknowns, and back. */
struct pk_band pk_gauss_band(const struct pk_gauss_work *w, pk_real *numbers);
void pk_gauss_to_places(const struct pk_gauss_work *w, size_t s, const pk_real *x, pk_real *y);
void pk_gauss_to_coordinates(const struct pk_gauss_work *w, size_t s, const pk_real *y, pk_real *x);

/* Returns twice the spectral radius of J1^-1 J2 - I, J1 factored in w->lu, J2 in w->other,
 * estimated by a power iteration. */
pk_real pk_gauss_radius(const struct pk_gauss_work *w);
/* Returns a bound of the contraction factor of the fixed-point iteration with `count` sets of
 * derivatives; not finite if M is not positive definite. May overwrite w->lu if not dense. */
pk_real pk_gauss_contraction(const struct pk_integrator *it, const struct pk_gauss_work *w,
                             const pk_real *J, size_t count);
/* Returns the least of max_i (|M^-1 X| x)_i / x_i over several x > 0, a bound of M^-1 X in a norm
 * with weights 1/x. X is w->other, M of each stage is factored in w->M; M = 1 if NULL. */
pk_real pk_gauss_norm(const struct pk_gauss_work *w, const pk_real *M);

/* Certifies that V is on the branch of short steps. Otherwise replaces V by the solution there, or
 * returns PK_AMBIGUOUS_STEP, with the longest step that has one in the reason. */
enum pk_status pk_gauss_certify(struct pk_integrator *it, struct pk_gauss_work *w);

#endif

/* Constraints of a state: their residuals, the projection onto them (project.c), the check of a
 * start and reasons of failures (constraint.c).
 */
#ifndef PK_PROJECT_H
#define PK_PROJECT_H

#include "internal.h"

/* n: length of v; its first m entries, rates of coordinates and body rates, have momenta. c: number
 * of constraint rows; the first h are holonomic. */
struct pk_projection {
    const struct pk_system *system;
    const void *params;
    const pk_real *u;
    pk_real t;
    size_t n, m, c, h, rotation; /* rotation: index of the first body rate (n_q) */
    int whole;                   /* 1: M and J are stored; 0 in systems of variable size */
    pk_real *M;                  /* M, m by m, factored; if not `whole`, its diagonal */
    pk_real *J, *W, *A;          /* J; M^-1 J^T, row i is M^-1 J_i; J M^-1 J^T, factored */
    pk_real *phi, *rate;         /* residuals of phi; residuals of J v + j0 */
    pk_real *phi_size;           /* sizes of the terms of phi; rate_size: of J v + j0 */
    pk_real *rate_size;
    pk_real *mu, *d;          /* multipliers; corrections and work (2 n numbers) */
    pk_real *gram;            /* J J^T with scaled columns, factored */
    pk_real *sizes, *columns; /* upper bounds of the largest |J_ik| so far; column scales */
    pk_real *sines;           /* squared sine of the angle of each row to previous rows */
    pk_real *pivots, *norms;  /* if not `whole`: pivots and diagonal of J M^-1 J^T */
    pk_real *most;            /* largest squared lengths of rows so far */
    int inertia;              /* if not `whole`: failure of M in pk_project_factor() */
    pk_real *depends; /* 1 + a dependent row, or 0; then the coefficients of the other rows in it */
    size_t r;         /* number of redundant rows */
    /* Redundant rows: 2 r residuals; 2 r sizes of their terms; J; pk_project_slopes() of J. */
    pk_real *off, *off_size, *off_rows, *off_slopes;
};

/* Returns whether the system has rolling constraints, which are not time derivatives of phi. */
static inline int pk_rolls(const struct pk_system *system)
{
    return system->constraints.n > system->constraints.n_holonomic;
}

/* Returns the number of pk_real for v of length n; 0 if there are no constraints and rotations. */
size_t pk_project_size(const struct pk_problem *problem, size_t n);
/* Returns the number of pk_real for any system, also without constraints. */
size_t pk_project_room(const struct pk_problem *problem, size_t n);
struct pk_projection pk_project_parts(const struct pk_problem *problem, size_t n, pk_real *room);
/* pk_project_inertia() factors M at a state; returns 0 or the failure of M. The next two compute J
 * and all residuals, and the sizes of their terms, which determine their rounding. */
int pk_project_inertia(struct pk_projection *w, const pk_real *q, const pk_real *v);
void pk_project_rows(struct pk_projection *w, const pk_real *q, const pk_real *v);
void pk_project_terms(struct pk_projection *w, const pk_real *q, const pk_real *v);
/* Returns the largest residual relative to its terms (or a NaN), and its row in *which. The size of
 * the terms is at least the rounding of the other rows' terms. */
pk_real pk_project_worst(const pk_real *residual, const pk_real *terms, size_t rows, size_t *which);
/* Factors J M^-1 J^T of the first `rows` rows, all or only holonomic rows, with the current J.
 * Returns 0, or 1 + the index of a row that depends on the others. */
size_t pk_project_factor(struct pk_projection *w, size_t rows, const pk_real *q, const pk_real *v);
/* Computes the squared sines of all rows of the current J, reduced if a row is shorter than before.
 * They do not depend on masses or units, except in systems of variable size, where the metric is
 * M^-1. */
void pk_project_rank(struct pk_projection *w);
/* Computes d = M^-1 J^T mu for the factored rows, such that J d = r. */
void pk_project_solve(struct pk_projection *w, size_t rows, const pk_real *r);
/* Returns M_kk. pk_project_slopes() computes sum_k |J_ik| / sqrt(M_kk) for `rows` rows of J, or for
 * the system's rows if not `whole`; uses d as work. */
static inline pk_real pk_project_mass(const struct pk_projection *w, size_t k)
{
    return w->whole ? pk_ldl_diagonal(w->M, w->m, k) : w->M[k];
}
/* Compute out = |J| x, `rows` numbers, and out = J^T x, m numbers; J as in pk_project_slopes(). */
void pk_project_spread(const struct pk_projection *w, const pk_real *q, const pk_real *v,
                       const pk_real *J, size_t rows, const pk_real *x, pk_real *out);
void pk_project_pull(const struct pk_projection *w, const pk_real *q, const pk_real *v,
                     const pk_real *J, size_t rows, const pk_real *x, pk_real *out);
void pk_project_slopes(struct pk_projection *w, const pk_real *q, const pk_real *v,
                       const pk_real *J, size_t rows, pk_real *out);
#define PK_DEPENDENT PK_C(1e-12) /* least squared sine; step sizes underflow before it is reached */
#define PK_NEAR PK_C(0.2)        /* sines below it are monitored (fixed steps: below 2 PK_NEAR) */
#define PK_FAR PK_C(0.9)         /* a fixed step meets no singular position if sines are larger */
/* Sine below which the rounding of positions, about PK_EPS / sine^2 in rates, exceeds the error of
 * steps: there rates are not projected, and J M^-1 J^T is not used. */
#define PK_SINGULAR (PK_C(10.0) * PK_F(sqrt)(PK_F(sqrt)(PK_EPS)))
/* Bits of it->own->passing.seen for the end of a step: sines were computed; a sine is < 2 PK_NEAR;
 * a sine is < PK_FAR. passing.near is set if the start of the step is near a singular position, or
 * unknown. */
enum { PK_SEEN = 1, PK_SEEN_LOW = 2, PK_SEEN_DIPS = 4 };
void pk_project_seen(struct pk_integrator *it, struct pk_projection *w);
/* Writes w->depends: the row as a combination x of earlier rows, with (J M^-1 J^T) x = J M^-1 row^T
 * by the factors of the leading block (row stride c); x_i is scaled by the rows' lengths. */
void pk_project_explain(struct pk_projection *w, size_t c, size_t row);

/* Projects q and v onto the constraints; low_q and low_v, their compensations, may be NULL. Sets
 * *moved if q or v changed. Uses the memory it->own->project. Fails with PK_NOT_FINITE, the status
 * of a singular M, or PK_NO_PROJECTION, with kinds of reasons in internal.h. */
enum pk_status pk_project(struct pk_integrator *it, pk_real t, pk_real *q, pk_real *v,
                          pk_real *low_q, pk_real *low_v, int *moved);
/* Projects the state in it->own->next, before it becomes the integrator's state. */
enum pk_status pk_project_step(struct pk_integrator *it);
/* Returns the status of an acceleration that failed because of dependent rows. */
enum pk_status pk_project_singular(struct pk_integrator *it, const pk_real *q, const pk_real *v);
/* Called after an underflow: returns whether constraint rows are nearly dependent at the state, and
 * sets the reason to the row. */
int pk_project_dependent(struct pk_integrator *it);
/* Checks the state at a start: refuses it if it violates constraints or rows are dependent;
 * otherwise projects it, which removes the rounding of its numbers. */
enum pk_status pk_project_start(struct pk_integrator *it);
/* Returns the first row whose residual is more than rounding, or `rows`. x is positions, where
 * attitudes count as 1, or rates; M is factored. */
#define PK_WRITTEN pk_max(PK_C(1e-8), 64 * PK_EPS) /* residual relative to the sizes of its terms */
size_t pk_project_broken(const struct pk_projection *w, const pk_real *residual,
                         const pk_real *terms, const pk_real *slopes, size_t rows, const pk_real *x,
                         int of_rates);
/* Returns the norm, in the metric of M, of rates that move the state by no more than rounding in a
 * step; the rates of a rigid truss are no larger. */
pk_real pk_project_rest(const struct pk_integrator *it, const struct pk_projection *w,
                        const pk_real *q);
/* Checks redundant rows: at a start to PK_WRITTEN, later to rounding. Fails with PK_OFF_CONSTRAINTS
 * or PK_NO_PROJECTION. */
enum pk_status pk_project_redundant(struct pk_integrator *it, pk_real t, const pk_real *q,
                                    const pk_real *v, enum pk_status broken);
/* Passage through a position where rows are dependent: number of pk_real; reset at a start; update
 * after each step; whether the next step is a passage, which sets it->own->next_t; that step, into
 * it->own->next; and dense output within it. */
size_t pk_singular_crossing_size(const struct pk_system *system, size_t n_q, size_t n);
void pk_singular_crossing_forget(struct pk_integrator *it);
void pk_singular_crossing_note(struct pk_integrator *it);
/* Fails if the fixed step in it->own->next may have turned into another branch of the motion. */
enum pk_status pk_singular_crossing_judge(struct pk_integrator *it);
/* Called if nothing had to be corrected, so that J M^-1 J^T was not factored; J and M are current.
 * Factors it in every second call. */
void pk_singular_crossing_unseen(struct pk_integrator *it, struct pk_projection *w,
                                 const pk_real *q, const pk_real *v);
int pk_singular_crossing_due(struct pk_integrator *it, pk_real limit);
/* Limits an adaptive step to half the distance to a singular position. */
pk_real pk_singular_crossing_limit(const struct pk_integrator *it, pk_real limit);
/* PK_NO_CONVERGENCE: an adaptive step over the position is too long; step closer to it first. */
enum pk_status pk_singular_crossing_step(struct pk_integrator *it);
void pk_singular_crossing_at(struct pk_integrator *it, pk_real t, pk_real *q, pk_real *v);
int pk_project_reason(const struct pk_integrator *it, char *text, size_t size);

#endif

/* Constraints of a state: their residuals, the projection onto them (project.c), the check of a
 * start and reasons of failures (constraint.c).
 */
#ifndef PK_PROJECT_H
#define PK_PROJECT_H

#include "internal.h"

/* n: length of v; its first m entries have momenta: rates of coordinates and body rates. c:
 * constraint rows, of which the first h are holonomic. */
struct pk_projection {
    const struct pk_system *system;
    const void *params;
    const pk_real *u;
    pk_real t;
    size_t n, m, c, h, rotation; /* rotation: number of coordinates, index of the first body rate */
    int whole;                   /* whether there are matrices; not with families kept as loops */
    pk_real *M;                  /* m by m, factored; without matrices its diagonal */
    pk_real *J, *W, *A;          /* J; M^-1 J^T by rows; J M^-1 J^T, factored */
    pk_real *phi, *rate;         /* residuals of phi and of J v + j0 */
    pk_real *phi_size;           /* sizes of the terms of these residuals */
    pk_real *rate_size;
    pk_real *mu, *d;          /* multipliers; 2 n numbers: a correction, then work */
    pk_real *gram;            /* J J^T with scaled columns, factored */
    pk_real *sizes, *columns; /* largest |J_ik| so far, rounded up; column scales */
    pk_real *sines;           /* squared sines of the angles between each row and all before it */
    pk_real *pivots, *norms;  /* without matrices: pivots of A, and its diagonal */
    pk_real *most;            /* largest squared lengths of rows so far */
    int inertia;      /* without matrices: the failure of M that pk_project_factor() has met */
    pk_real *depends; /* 1 + the dependent row, or 0; then its coefficients by the others */
    size_t r;         /* number of redundant rows */
    /* Redundant rows: residuals and sizes of their terms, 2 r each; their J, and slopes. */
    pk_real *off, *off_size, *off_rows, *off_slopes;
};

/* Whether there are rolling rows, which are not rates of phi; the same at all sizes. */
static inline int pk_rolls(const struct pk_system *system)
{
    return system->constraints.n > system->constraints.n_holonomic;
}

/* Returns the pk_real for a system with v of length n; 0 if there is nothing to project. */
size_t pk_project_size(const struct pk_problem *problem, size_t n);
/* Returns the same for any system, also without constraints. */
size_t pk_project_room(const struct pk_problem *problem, size_t n);
struct pk_projection pk_project_parts(const struct pk_problem *problem, size_t n, pk_real *room);
/* Computes M at a state, factored; returns 0 or its failure. Then: J and all residuals; the sizes
 * of their terms, to which rounding is relative. */
int pk_project_inertia(struct pk_projection *w, const pk_real *q, const pk_real *v);
void pk_project_rows(struct pk_projection *w, const pk_real *q, const pk_real *v);
void pk_project_terms(struct pk_projection *w, const pk_real *q, const pk_real *v);
/* Returns the largest residual relative to its terms, or a NaN, and its row in *which. Terms
 * smaller than the rounding of other rows' terms count as that rounding. */
pk_real pk_project_worst(const pk_real *residual, const pk_real *terms, size_t rows, size_t *which);
/* Factors J M^-1 J^T of the first `rows` rows, all or the holonomic ones, for the current J.
 * Returns 0, or 1 + the row that depends on others. */
size_t pk_project_factor(struct pk_projection *w, size_t rows, const pk_real *q, const pk_real *v);
/* Computes the sines of all rows of the current J, reduced if a row is shorter than it was. They do
 * not depend on masses or units; with families kept as loops they are those in the metric of M. */
void pk_project_rank(struct pk_projection *w);
/* d = M^-1 J^T mu for these rows, with J d = r. */
void pk_project_solve(struct pk_projection *w, size_t rows, const pk_real *r);
/* Returns M_kk. pk_project_slopes(): sum_k |J_ik| / sqrt(M_kk) for `rows` rows J, or for the
 * system's rows without matrices; uses d as work. */
static inline pk_real pk_project_mass(const struct pk_projection *w, size_t k)
{
    return w->whole ? pk_ldl_diagonal(w->M, w->m, k) : w->M[k];
}
/* out = |J| x, `rows` numbers; out = J^T x, m numbers; J as in pk_project_slopes(). */
void pk_project_spread(const struct pk_projection *w, const pk_real *q, const pk_real *v,
                       const pk_real *J, size_t rows, const pk_real *x, pk_real *out);
void pk_project_pull(const struct pk_projection *w, const pk_real *q, const pk_real *v,
                     const pk_real *J, size_t rows, const pk_real *x, pk_real *out);
void pk_project_slopes(struct pk_projection *w, const pk_real *q, const pk_real *v,
                       const pk_real *J, size_t rows, pk_real *out);
#define PK_DEPENDENT PK_C(1e-12) /* sigma^2; step sizes underflow before it gets this small */
#define PK_NEAR PK_C(0.2) /* sigma below which it is monitored; twice that with fixed steps */
#define PK_FAR PK_C(0.9)  /* sigma above which a fixed step meets no singular position */
/* Sigma below which rounding of positions, about PK_EPS / sigma^2 in rates, exceeds the error of
 * steps: rates are not projected there, and solutions with J M^-1 J^T are lost. */
#define PK_SINGULAR (PK_C(10.0) * PK_F(sqrt)(PK_F(sqrt)(PK_EPS)))
/* The closeness to a singular position at the end of a step, in it->own->passing.seen. it->own->passing.near is set
 * if the start of the step is near one, or unknown. */
enum { PK_SEEN = 1, PK_SEEN_LOW = 2, PK_SEEN_DIPS = 4 };
void pk_project_seen(struct pk_integrator *it, struct pk_projection *w);
/* Writes w->depends: the row as a combination x of earlier rows, (J M^-1 J^T) x = J M^-1 row^T by
 * the factors of the leading block (row stride c); x_i is scaled by the rows' norms. */
void pk_project_explain(struct pk_projection *w, size_t c, size_t row);

/* Projects q and v onto the constraints; low_q and low_v, their compensations, may be NULL. *moved:
 * whether anything changed. Uses the memory it->own->project. PK_NOT_FINITE, the failure of a
 * singular M, or PK_NO_PROJECTION: see the kinds of reasons in internal.h. */
enum pk_status pk_project(struct pk_integrator *it, pk_real t, pk_real *q, pk_real *v,
                          pk_real *low_q, pk_real *low_v, int *moved);
/* Projects the step in it->own->next, before it becomes the state. */
enum pk_status pk_project_step(struct pk_integrator *it);
/* Returns the status of an acceleration that found dependent rows, at the time of it->reason. */
enum pk_status pk_project_singular(struct pk_integrator *it, const pk_real *q, const pk_real *v);
/* After an underflow: whether constraint rows are nearly dependent here; then the reason has the
 * row. */
int pk_project_dependent(struct pk_integrator *it);
/* Checks the state at a start: refused if it violates constraints, or if these are dependent;
 * otherwise projected, which removes its rounding. */
enum pk_status pk_project_start(struct pk_integrator *it);
/* Returns the first row whose residual is more than rounding, or `rows`. x are positions, where
 * attitudes count as 1, or rates; M is factored. */
#define PK_WRITTEN pk_max(PK_C(1e-8), 64 * PK_EPS) /* of its terms */
size_t pk_project_broken(const struct pk_projection *w, const pk_real *residual,
                         const pk_real *terms, const pk_real *slopes, size_t rows, const pk_real *x,
                         int of_rates);
/* Returns the rate, in the metric of M, that moves the state by no more than rounding in the step:
 * the rates of a truss, which cannot move, are no larger. */
pk_real pk_project_rest(const struct pk_integrator *it, const struct pk_projection *w,
                        const pk_real *q);
/* Checks that redundant rows hold: at the start to the digits with which it is written, later to
 * rounding. PK_OFF_CONSTRAINTS or PK_NO_PROJECTION. */
enum pk_status pk_project_redundant(struct pk_integrator *it, pk_real t, const pk_real *q,
                                    const pk_real *v, enum pk_status broken);
/* Passage through positions where rows are dependent for an instant: memory size; at a start; after
 * each step; whether the next step is a passage, and then it->own->next_t; that step, into
 * it->own->next; and the motion within it. */
size_t pk_singular_crossing_size(const struct pk_system *system, size_t n_q, size_t n);
void pk_singular_crossing_forget(struct pk_integrator *it);
void pk_singular_crossing_note(struct pk_integrator *it);
/* Whether the fixed step in it->own->next may have turned into another branch. */
enum pk_status pk_singular_crossing_judge(struct pk_integrator *it);
/* Called if A was not factored, since nothing was to be corrected: J and M are current. Factors A
 * in every second such call. */
void pk_singular_crossing_unseen(struct pk_integrator *it, struct pk_projection *w,
                                 const pk_real *q, const pk_real *v);
int pk_singular_crossing_due(struct pk_integrator *it, pk_real limit);
/* Limits an adaptive step: half the way to a singular position. */
pk_real pk_singular_crossing_limit(const struct pk_integrator *it, pk_real limit);
/* PK_NO_CONVERGENCE: an adaptive step over the position is too long yet; go nearer first. */
enum pk_status pk_singular_crossing_step(struct pk_integrator *it);
void pk_singular_crossing_at(struct pk_integrator *it, pk_real t, pk_real *q, pk_real *v);
int pk_project_reason(const struct pk_integrator *it, char *text, size_t size);

#endif

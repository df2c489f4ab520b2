/* Constraints of a state: their residuals, the projection onto them (project.c), the check of a
 * start and reasons of failures (constraint.c). */
#ifndef PK_PROJECT_H
#define PK_PROJECT_H

#include "internal.h"

/* Work memory for the constraints of one state. n: length of v; the first m entries of v, the rates
 * of coordinates and body rates, have momenta. c: number of rows, the first h holonomic. */
struct pk_projection {
    const struct pk_system *system;
    const void *params;
    const pk_real *u;
    pk_real t;
    size_t n, m, c, h, rotation; /* rotation: index in v of the first body rate, which is n_q */
    int whole;                   /* 1: M and J are stored; 0 in systems of variable size */
    pk_real *M;                  /* if `whole`: M, m by m, factored; else the diagonal of M */
    /* J: the constraint matrix; W = M^-1 J^T, whose row i is M^-1 J_i; A = J M^-1 J^T, factored */
    pk_real *J, *W, *A;
    pk_real *phi, *rate; /* residuals of phi (phi) and of J v + j0 (rate) */
    pk_real *phi_size;   /* sizes of the terms of phi */
    pk_real *rate_size;  /* sizes of the terms of J v + j0 */
    /* mu: multipliers; d: corrections of q or v, and work memory (2 n numbers) */
    pk_real *mu, *d;
    pk_real *gram; /* J J^T with scaled columns, factored */
    /* sizes: upper bounds of the largest |J_ik| so far; columns: scales of the columns of J */
    pk_real *sizes, *columns;
    pk_real *sines;          /* squared sine of the angle of each row to the rows before it */
    pk_real *pivots, *norms; /* if `whole` is 0: pivots and diagonal entries of J M^-1 J^T */
    pk_real *most;           /* largest squared length so far of each row of J */
    int inertia;             /* if not `whole`: failure of M in pk_project_factor(), or 0 */
    /* first number: 1 + the index of a dependent row, or 0; then the coefficients of the linear
     * combination of other rows that equals this row */
    pk_real *depends;
    int all;       /* flag: rows that do not hold now are kept too */
    pk_real *rows; /* the numbers of the rows in the system, if some do not hold */
    size_t r;      /* number of redundant rows */
    /* For the r redundant rows: off has 2 r residuals, off_size the 2 r sizes of their terms,
     * off_rows their rows of J, and off_slopes their pk_project_slopes(). */
    pk_real *off, *off_size, *off_rows, *off_slopes;
};

/* Returns whether the system has rolling constraints, which are not time derivatives of phi. */
static inline int pk_rolls(const struct pk_system *system)
{
    return system->constraints.n > system->constraints.n_holonomic;
}

/* Returns the number of pk_real of work memory; 0 without constraints and rotations. */
size_t pk_project_size(const struct pk_problem *problem, size_t n);
/* Returns the number of pk_real of the complete work memory, for any system. */
size_t pk_project_room(const struct pk_problem *problem, size_t n);
struct pk_projection pk_project_parts(const struct pk_problem *problem, size_t n, pk_real *room);
static inline struct pk_projection pk_projection(const struct pk_integrator *it)
{
    return pk_project_parts(&it->problem, it->n, it->own->project);
}
/* pk_project_inertia() factors M at a state; returns 0 or the failure of M. pk_project_rows()
 * computes J and all residuals; pk_project_terms() computes the sizes of the terms of the
 * residuals, which determine how much the residuals are rounded. */
int pk_project_inertia(struct pk_projection *w, const pk_real *q, const pk_real *v);
void pk_project_rows(struct pk_projection *w, const pk_real *q, const pk_real *v);
void pk_project_terms(struct pk_projection *w, const pk_real *q, const pk_real *v);
/* Returns the number in the system of a row of J. */
size_t pk_project_row(const struct pk_projection *w, size_t row);
/* Returns the largest ratio of a residual to the size of its terms (or NaN), and the index of that
 * row in *which. The size is at least PK_EPS times that of the other rows' terms, so that
 * a row of tiny terms has no large ratio. */
pk_real pk_project_worst(const pk_real *residual, const pk_real *terms, size_t rows, size_t *which);
/* Factors J M^-1 J^T of the first `rows` rows, all or only holonomic rows, with the current J.
 * Returns 0, or 1 + the index of a row that depends on the others. */
size_t pk_project_factor(struct pk_projection *w, size_t rows, const pk_real *q, const pk_real *v);
/* Computes the squared sines of all rows of the current J. The sine of a row is reduced if the row
 * has become shorter than it was earlier in the run. Sines do not depend on masses or units, except
 * in systems of variable size, where they are measured in the metric of M^-1. */
void pk_project_rank(struct pk_projection *w);
/* Computes d = M^-1 J^T mu and mu such that J d = r; J has the rows that are factored. */
void pk_project_solve(struct pk_projection *w, size_t rows, const pk_real *r);
/* pk_project_mass() returns M_kk. pk_project_slopes() computes sum_k |J_ik| / sqrt(M_kk) for `rows`
 * rows of J, or for the system's rows if not `whole`; uses d as work. */
static inline pk_real pk_project_mass(const struct pk_projection *w, size_t k)
{
    return w->whole ? pk_ldl_diagonal(w->M, w->m, k) : w->M[k];
}
/* pk_project_spread() computes out = |J| x, `rows` numbers; pk_project_pull() computes out = J^T x,
 * m numbers. J is chosen as in pk_project_slopes(). */
void pk_project_spread(const struct pk_projection *w, const pk_real *q, const pk_real *v,
                       const pk_real *J, size_t rows, const pk_real *x, pk_real *out);
void pk_project_pull(const struct pk_projection *w, const pk_real *q, const pk_real *v,
                     const pk_real *J, size_t rows, const pk_real *x, pk_real *out);
void pk_project_slopes(struct pk_projection *w, const pk_real *q, const pk_real *v,
                       const pk_real *J, size_t rows, pk_real *out);
/* a row with a smaller squared sine counts as dependent; adaptive step sizes underflow before */
#define PK_DEPENDENT PK_C(1e-12)
/* smaller sines (of a row to the span of the others) are watched; with fixed steps 2 PK_NEAR */
#define PK_NEAR PK_C(0.2)
/* if all sines are larger, a fixed step cannot meet a singular position */
#define PK_FAR PK_C(0.9)
/* If a sine is below PK_SINGULAR, the rounding of positions changes rates by about PK_EPS / sine^2,
 * more than the error of a step. There rates are not projected, and J M^-1 J^T is not used. */
#define PK_SINGULAR (10 * PK_F(sqrt)(PK_F(sqrt)(PK_EPS)))
/* Bits of it->own->passing.seen, which describe the end of a step. PK_SEEN: sines were computed;
 * PK_SEEN_LOW: a sine is < 2 PK_NEAR; PK_SEEN_DIPS: a sine is < PK_FAR. passing.near is set if the
 * start of the step is, or may be, near a singular position. */
enum { PK_SEEN = 1, PK_SEEN_LOW = 2, PK_SEEN_DIPS = 4 };
void pk_project_seen(struct pk_integrator *it, struct pk_projection *w);
/* Writes to w->depends how `row` is a linear combination of earlier rows. Its coefficients x solve
 * (J M^-1 J^T) x = J M^-1 row^T; the factors of J M^-1 J^T in w->A have c numbers per row. x_i is
 * then multiplied by the length of row i over that of `row`. */
void pk_project_explain(struct pk_projection *w, size_t c, size_t row);

/* Projects q and v onto the constraints; low_q and low_v, their compensations, may be NULL. Sets
 * *moved if q or v changed. Uses the memory it->own->project. Fails with PK_NOT_FINITE, the status
 * of a singular M, or PK_NO_PROJECTION, with kinds of reasons in internal.h. */
enum pk_status pk_project(struct pk_integrator *it, pk_real t, pk_real *q, pk_real *v,
                          pk_real *low_q, pk_real *low_v, int *moved);
/* Projects rates at positions that hold, however far the rates are off, in the metric of M. */
enum pk_status pk_project_rates(struct pk_integrator *it, pk_real *q, pk_real *v);
/* Projects the state in it->own->next, before it becomes the integrator's state. */
enum pk_status pk_project_step(struct pk_integrator *it);
/* Returns the status of an acceleration that failed because of dependent rows. */
enum pk_status pk_project_singular(struct pk_integrator *it, const pk_real *q, const pk_real *v);
/* Called after the step size underflowed: returns whether constraint rows are nearly dependent at
 * the state, and if so records the dependent row in it->reason. */
int pk_project_dependent(struct pk_integrator *it);
/* Checks the state at a start: refuses it if it violates constraints or rows are dependent;
 * otherwise projects it, which removes the rounding of its numbers. */
enum pk_status pk_project_start(struct pk_integrator *it);
/* Moves q and v to the nearest state on the constraints (`start consistent`); returns whether it is
 * found. q0 is work memory as long as q. */
int pk_project_nearest(struct pk_projection *w, pk_real *q, pk_real *v, pk_real *q0);
/* Returns the index of the first row whose residual is more than rounding; `rows` if there is none.
 * x has rates if `of_rates`, otherwise positions, where an attitude counts as 1. Rounding is that
 * of the largest component of x, which counts as at least `least`; M must be factored. */
#define PK_WRITTEN pk_max(PK_C(1e-8), 64 * PK_EPS) /* residual relative to the sizes of its terms */
size_t pk_project_broken(const struct pk_projection *w, const pk_real *residual,
                         const pk_real *terms, const pk_real *slopes, size_t rows, const pk_real *x,
                         int of_rates, pk_real least);
/* Returns the size of the positions where the last step began, 0 before the first: all positions
 * may vanish where a run begins again at a switch. */
pk_real pk_project_passed(const struct pk_integrator *it, const struct pk_projection *w);
/* Returns the norm, in the metric of M, of rates so small that they move the state by no more than
 * its rounding in a step. If constraints allow no motion, as in a truss, rates are below that. */
pk_real pk_project_rest(const struct pk_integrator *it, const struct pk_projection *w,
                        const pk_real *q);
/* Checks whether redundant rows are satisfied: to the tolerance PK_WRITTEN at a start, to rounding
 * later. Fails with PK_OFF_CONSTRAINTS or PK_NO_PROJECTION. */
enum pk_status pk_project_redundant(struct pk_integrator *it, pk_real t, const pk_real *q,
                                    const pk_real *v, enum pk_status broken);
/* Passage through a position where constraint rows are dependent. _size() returns the number of
 * pk_real of its memory; _forget() resets it at a start; _note() updates it after each step; _due()
 * returns whether the next step is a passage, and then sets it->own->next_t; _step() makes that
 * step and writes it to it->own->next; _at() gives dense output within it. */
size_t pk_singular_crossing_size(const struct pk_system *system, size_t n_q, size_t n);
void pk_singular_crossing_forget(struct pk_integrator *it);
void pk_singular_crossing_note(struct pk_integrator *it);
/* Fails if the fixed step in it->own->next may have left a singular position by a wrong branch. */
enum pk_status pk_singular_crossing_judge(struct pk_integrator *it);
/* Called if a step needed no correction, so that J M^-1 J^T was not factored and dependent rows
 * were not noticed. J and M are those of the current state. Every second call factors J M^-1
 * J^T. */
void pk_singular_crossing_unseen(struct pk_integrator *it, struct pk_projection *w,
                                 const pk_real *q, const pk_real *v);
int pk_singular_crossing_due(struct pk_integrator *it, pk_real limit);
/* Limits an adaptive step to half the distance to a singular position. */
pk_real pk_singular_crossing_limit(const struct pk_integrator *it, pk_real limit);
/* PK_NO_CONVERGENCE: the adaptive step across the singular position is too long; the caller must
 * first step closer to that position. */
enum pk_status pk_singular_crossing_step(struct pk_integrator *it);
void pk_singular_crossing_at(struct pk_integrator *it, pk_real t, pk_real *q, pk_real *v);
int pk_project_reason(const struct pk_integrator *it, char *text, size_t size);

#endif

/* Constraints of a state: their residuals, the return to them (project.c), the check of a start and
 * what failed in words (constraint.c).
 */
#ifndef PK_PROJECT_H
#define PK_PROJECT_H

#include "internal.h"

/* n degrees of freedom, of which the first m have momenta: coordinates and body rates; c rows, of
 * which h are of positions. */
struct pk_projection {
    const struct pk_system *system;
    const void *params;
    const pk_real *u;
    pk_real t;
    size_t n, m, c, h, rotation; /* rotation: coordinates, where body rates begin */
    int whole;                   /* whether the matrices are here: not of families kept as loops */
    pk_real *M;                  /* m by m, factored; else its diagonal */
    pk_real *J, *W, *A;          /* J; M^-1 of each row of it; J M^-1 J^T, factored */
    pk_real *phi, *rate;         /* residuals of position and of the rates */
    pk_real *phi_size;           /* of the terms that a residual is made of */
    pk_real *rate_size;
    pk_real *mu, *d;          /* multipliers; 2 n numbers: a correction, and what is behind it */
    pk_real *gram;            /* of J with scaled columns, factored */
    pk_real *sizes, *columns; /* the largest |J_ik| of the motion, rounded up; scales of columns */
    pk_real *sines;           /* squares of the sines between each row and those before it */
    pk_real *pivots, *norms;  /* of a family's A: the pivots, and the diagonal that it had */
    pk_real *most;            /* the squares of the rows' largest lengths */
    int inertia;      /* the failure of M that pk_project_factor met, where M is not whole */
    pk_real *depends; /* 1 + the row that depends on others, or 0; by how much of each */
    size_t r;         /* redundant rows */
    /* What these are off, 2 r, and of what sizes; their J, and slopes as those of the others. */
    pk_real *off, *off_size, *off_rows, *off_slopes;
};

/* Whether there are rows of rates that are no rates of positions: as many at all sizes or none. */
static inline int pk_rolls(const struct pk_system *system)
{
    return system->constraints.n > system->constraints.n_holonomic;
}

/* pk_real of room for a system of n degrees of freedom; 0 where there is nothing to project. */
size_t pk_project_size(const struct pk_problem *problem, size_t n);
/* The same room for any system, also without constraints. */
size_t pk_project_room(const struct pk_problem *problem, size_t n);
struct pk_projection pk_project_parts(const struct pk_problem *problem, size_t n, pk_real *room);
/* The inertia there, factored: 0, or a failure. Then J and all residuals; and
 * the sizes of their terms, which rounding is to be measured by. */
int pk_project_inertia(struct pk_projection *w, const pk_real *q, const pk_real *v);
void pk_project_rows(struct pk_projection *w, const pk_real *q, const pk_real *v);
void pk_project_terms(struct pk_projection *w, const pk_real *q, const pk_real *v);
/* The largest residual beside its terms, or what is no number, and of which row it is. What the
 * rounding of other rows' terms moves is no term of its own. */
pk_real pk_project_worst(const pk_real *residual, const pk_real *terms, size_t rows, size_t *which);
/* J M^-1 J^T of the first rows, all or those of positions, at a state: factored: 0, or 1 + the row
 * that depends on others. J is there. */
size_t pk_project_factor(struct pk_projection *w, size_t rows, const pk_real *q, const pk_real *v);
/* The sines of all rows, J being there, less where a row is shorter than it was in the motion. They
 * do not depend on masses or units; of families kept as loops they are those in the metric of M. */
void pk_project_rank(struct pk_projection *w);
/* d = M^-1 J^T mu of these rows, with J d = r. */
void pk_project_solve(struct pk_projection *w, size_t rows, const pk_real *r);
/* M_kk; and of so many rows J, the rows' own where there are no matrices, sum_k |J_ik| / sqrt(M_kk).
 * It takes d. */
static inline pk_real pk_project_mass(const struct pk_projection *w, size_t k)
{
    return w->whole ? pk_ldl_diagonal(w->M, w->m, k) : w->M[k];
}
/* out = |J| x, a number a row, and out = J^T x, m numbers, of J as of pk_project_slopes(). */
void pk_project_spread(const struct pk_projection *w, const pk_real *q, const pk_real *v,
                       const pk_real *J, size_t rows, const pk_real *x, pk_real *out);
void pk_project_pull(const struct pk_projection *w, const pk_real *q, const pk_real *v,
                     const pk_real *J, size_t rows, const pk_real *x, pk_real *out);
void pk_project_slopes(struct pk_projection *w, const pk_real *q, const pk_real *v,
                       const pk_real *J, size_t rows, pk_real *out);
#define PK_DEPENDENT PK_C(1e-12) /* sigma^2; steps underflow before rows are this close */
#define PK_NEAR PK_C(0.2) /* sigma, below which it is watched to fall; of fixed steps twice that */
#define PK_FAR PK_C(0.9)  /* sigma, above which a fixed step meets no such place */
/* sigma, below which rounding of positions, some PK_EPS / sigma^2 of rates, is more than steps err:
 * rates are not projected there, and what J M^-1 J^T is solved for is lost. */
#define PK_SINGULAR (PK_C(10.0) * PK_F(sqrt)(PK_F(sqrt)(PK_EPS)))
/* The rank at a step's end: how near it is to such a position, in it->own->seen.
 * it->own->near is that of the step's start, where not far, or not known. */
enum { PK_SEEN = 1, PK_SEEN_LOW = 2, PK_SEEN_DIPS = 4 };
void pk_project_seen(struct pk_integrator *it, struct pk_projection *w);
/* w->depends: the row as a combination x of earlier rows, (J M^-1 J^T) x = J M^-1 row^T by the
 * factors of the leading block (row stride c); x_i is scaled by the rows' norms. */
void pk_project_explain(struct pk_projection *w, size_t c, size_t row);

/* q and v onto the constraints; low_q and low_v, their compensations, may be NULL. *moved: whether
 * anything changed. It takes the room it->own->project. PK_NOT_FINITE, what M is singular for, or
 * PK_NO_PROJECTION: it->where is a row, or c + a row of the rates; and with PK_OFF_CONSTRAINTS, of
 * a start, 2 c + a rotation. */
enum pk_status pk_project(struct pk_integrator *it, pk_real t, pk_real *q, pk_real *v,
                          pk_real *low_q, pk_real *low_v, int *moved);
/* The step in it->own->next, before it becomes the state. */
enum pk_status pk_project_step(struct pk_integrator *it);
/* The status of an acceleration that found the constraints dependent, it->where its row, at the
 * time it->detail. */
enum pk_status pk_project_singular(struct pk_integrator *it, const pk_real *q, const pk_real *v);
/* After an underflow: whether constraints all but depend on each other here, it->where on which
 * row. */
int pk_project_dependent(struct pk_integrator *it);
/* The state where the integrator starts: refused where it breaks constraints, or they depend on
 * each other; else moved onto them by what rounding left. */
enum pk_status pk_project_start(struct pk_integrator *it);
/* The row whose residual is no rounding, or `rows`, of those whose derivatives are J. x are
 * positions, where attitudes count as 1, or rates; M is factored. */
#define PK_WRITTEN pk_max(PK_C(1e-8), 64 * PK_EPS) /* of its terms */
size_t pk_project_broken(const struct pk_projection *w, const pk_real *residual,
                         const pk_real *terms, const pk_real *slopes, size_t rows, const pk_real *x,
                         int of_rates);
/* The rate, in the metric of M, that moves nothing but by rounding in the step: all that there is
 * of a truss, which cannot move. */
pk_real pk_project_rest(const struct pk_integrator *it, const struct pk_projection *w,
                        const pk_real *q);
/* Whether redundant rows hold where all others do: at the start as its numbers are written, later as
 * the rounding of those lets them. PK_OFF_CONSTRAINTS or PK_NO_PROJECTION, it->where behind what
 * the other rows and rotations have. */
enum pk_status pk_project_redundant(struct pk_integrator *it, pk_real t, const pk_real *q,
                                    const pk_real *v, enum pk_status broken);
/* Through positions where rows depend on each other for an instant: numbers needed; at a start, and
 * after each step; whether the next step is to be made here, and then it->own->next_t; that step,
 * into it->own->next; and the motion within it. */
size_t pk_passage_size(const struct pk_system *system, size_t n_q, size_t n);
void pk_passage_forget(struct pk_integrator *it);
void pk_passage_note(struct pk_integrator *it);
/* Of the step in it->own->next, by a fixed step: whether it may have turned into another branch. */
enum pk_status pk_passage_judge(struct pk_integrator *it);
/* A has not been factored, for nothing was to be put right: J and M are there, and each second time
 * A is made. */
void pk_passage_unseen(struct pk_integrator *it, struct pk_projection *w, const pk_real *q,
                       const pk_real *v);
int pk_passage_due(struct pk_integrator *it, pk_real limit);
/* How far an adaptive step may go: half of the way to such a position. */
pk_real pk_passage_limit(const struct pk_integrator *it, pk_real limit);
/* PK_NO_CONVERGENCE: an adaptive step over the place is not exact enough yet, so come nearer. */
enum pk_status pk_passage_step(struct pk_integrator *it);
void pk_passage_at(struct pk_integrator *it, pk_real t, pk_real *q, pk_real *v);
int pk_project_reason(const struct pk_integrator *it, char *text, size_t size);

#endif

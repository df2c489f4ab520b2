/* A search for equilibria: shared by where to seek them (equilibria_box.c), how they are found
 * (equilibria.c), and what else there is with rotations and constraints (equilibria_bound.c). Not
 * installed.
 */
#ifndef PK_GSL_EQUILIBRIA_SEARCH_H
#define PK_GSL_EQUILIBRIA_SEARCH_H

#include <math.h>

#include <gsl/gsl_matrix.h>

#include <pk/integrator.h>

#include "../src/core/internal.h"

static const double TWO_PI = 6.283185307179586476925;

/* The problem, a state to write to, and room for the kernels' results. */
struct search {
    const struct pk_problem *problem;
    size_t n;
    double *q, *v;               /* the state tried; what is not sought stays as in the start */
    double *kept;                /* momenta of the start */
    double *step;                /* Newton's, to be taken back */
    double *along;               /* where nothing leads back to a root, by pk_bound_correct() */
    double energy;               /* the start's, as a size */
    size_t slack;                /* in so many directions */
    double *box, *middle;        /* where to seek each unknown */
    size_t rows;                 /* equations: n, or more with constraints */
    double *p, *pdot, *pivot;    /* n */
    double *F, *scale;           /* rows; the size of each equation in the box */
    double *rest, *r_t;          /* n zeros; n */
    double *M, *p_q, *F_q, *F_v; /* rows by n, of which n by n are used */
    double *J;                   /* rows by n */
    gsl_matrix *A, *C;           /* with rotations or constraints: pk/rates.h; else NULL */
    unsigned char *turns;        /* q_i + 2 pi is the same place */
    unsigned char *unread;       /* a first-order variable that no rate depends on */
    size_t *primes;              /* n + 1, the bases of Halton's points */
    double *slope;               /* of the factor of deflation, by each unknown */
    const struct pk_equilibria *known; /* roots to keep away from; NULL: none */
};

static inline size_t coordinates(const struct search *s)
{
    return pk_system_coordinates(s->problem->system, s->problem->params);
}

static inline int is_cyclic(const struct search *s, size_t i)
{
    const unsigned char *cyclic = s->problem->system->cyclic;
    return cyclic && i < coordinates(s) && cyclic[i];
}

/* There are rotations or constraints. */
static inline int is_bound(const struct search *s)
{
    return s->problem->system->n_rotations || s->problem->system->constraints.n;
}

/* The first quaternion among v. */
static inline size_t quaternions(const struct search *s)
{
    return coordinates(s) + 3 * s->problem->system->n_rotations;
}

static inline int is_body_rate(const struct search *s, size_t i)
{
    return i < quaternions(s) && i + 3 * s->problem->system->n_rotations >= quaternions(s);
}

/* 1 - (Q.R)^2 beside |Q| = 1, the squared sine of half the turn between them. */
static inline double turned(const double *Q, const double *R)
{
    const double same = Q[0] * R[0] + Q[1] * R[1] + Q[2] * R[2] + Q[3] * R[3];
    return Q[0] * Q[0] + Q[1] * Q[1] + Q[2] * Q[2] + Q[3] * Q[3] - same * same;
}

/* What is sought of i is v_i: where it is cyclic, and of first-order variables. */
static inline int is_by_rate(const struct search *s, size_t i)
{
    return i >= coordinates(s) || is_cyclic(s, i);
}

/* Unknown i of the state: q_i or v_i. */
static inline double *unknown(struct search *s, size_t i)
{
    return (is_by_rate(s, i) ? s->v : s->q) + i;
}

/* The length that a difference of unknown i is small or large beside. */
static inline double reach(struct search *s, size_t i)
{
    return fmax(s->box[i], fabs(*unknown(s, i) - s->middle[i]));
}

/* As GSL calls F and J. */
typedef int pk_gsl_vector(const gsl_vector *z, void *search, gsl_vector *f);
typedef int pk_gsl_matrix(const gsl_vector *z, void *search, gsl_matrix *J);

/* With rotations or constraints: F; J; and from the state to where the equations hold best. */
int pk_bound_equations(struct search *s);
int pk_bound_derivatives(struct search *s);
void pk_bound_solve(struct search *s, pk_gsl_vector *f, pk_gsl_matrix *df);
/* Newton's shortest correction by J into F, which has n numbers then; 0 where there is none. */
int pk_bound_correct(struct search *s);

/* F at the state; 0 where it is not finite. */
static inline int equations(struct search *s)
{
    const struct pk_problem *problem = s->problem;
    const struct pk_system *system = problem->system;
    if (is_bound(s))
        return pk_bound_equations(s);
    system->canonical(problem->params, 0, s->q, s->v, NULL, s->p, s->pdot);
    if (system->n_first_order) /* pdot at rest, and the rates of the others */
        system->force(problem->params, 0, s->q, s->v, NULL, s->pdot);
    for (size_t i = 0; i < s->n; i++)
        s->F[i] = is_cyclic(s, i) ? s->p[i] - s->kept[i]
                  : s->unread[i]  ? s->v[i] - s->middle[i]
                                  : s->pdot[i];
    return pk_all_finite(s->F, s->n);
}

/* A box about the start, which coordinates are angles in it, the momenta to keep and the size of
 * each equation. The state is then at rest but for what is cyclic. */
void pk_equilibria_box(struct search *s, const double *q0, const double *v0);
/* Quaternions of length 1. */
void pk_equilibria_normalise(struct search *s);
/* Point k of the search as unknowns of the state; 0 is the start. */
void pk_equilibria_place(struct search *s, size_t k);
/* prod (1 + 1/|z - z_k|^2) over the known roots, in reaches, infinite at one; its logarithm's
 * derivative by each unknown into s->slope. */
double pk_equilibria_deflated(struct search *s);

/* The energy at q and v, or 0 without one. */
double pk_equilibria_energy(const struct search *s, const double *q, const double *v);
/* Whether the state is one of those found, or of the continuum of one. */
int pk_equilibria_known(struct search *s, const struct pk_equilibria *found);
/* Puts it where its energy belongs; equal ones stay in the order in which they came. */
void pk_equilibria_insert(struct search *s, struct pk_equilibria *found);

#endif

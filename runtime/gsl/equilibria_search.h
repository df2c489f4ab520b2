/* The search for equilibria, shared by its files: starting points (equilibria_box.c), Newton's
 * method (equilibria.c), deflation (equilibria_deflate.c), the list of roots (equilibria_known.c),
 * rotations and constraints (equilibria_bound.c). Not installed. */
#ifndef PK_GSL_EQUILIBRIA_SEARCH_H
#define PK_GSL_EQUILIBRIA_SEARCH_H

#include <math.h>

#include <gsl/gsl_matrix.h>

#include <pk/integrator.h>

#include "../src/core/internal.h"

static const double TWO_PI = 6.283185307179586476925;

/* The problem, the current state, and memory for the kernels' results. */
struct search {
    const struct pk_problem *problem;
    size_t n;
    double *q, *v;            /* the current state; its entries that are not unknowns stay fixed */
    double *kept;             /* initial momenta */
    double *step;             /* Newton's last correction */
    double *along;            /* a direction in the null space of J, from pk_bound_correct() */
    double energy;            /* |energy| of the initial state */
    size_t slack;             /* dimension of the null space of J */
    double *box, *middle;     /* unknown i is sought in middle_i +- box_i */
    size_t rows;              /* number of equations: n, or more with constraints */
    double *p, *pdot, *pivot; /* n */
    double *F, *scale;        /* residual and scale of each of these equations */
    /* n numbers each; `rest` holds zeros, as the accelerations of a state at rest */
    double *rest, *r_t;
    double *M, *p_q, *F_q, *F_v; /* work arrays of `rows` by n numbers */
    double *J;                   /* the Jacobian matrix dF/d(unknowns), `rows` by n */
    unsigned char *turns;        /* whether q_i is an angle: q_i + 2 pi is the same position */
    unsigned char *unread;       /* whether variable i is a quadrature: no rate depends on it */
    size_t *primes; /* n + 1 primes, the bases of Halton's sequence for starting points */
    double *slope;  /* gradient of the logarithm of pk_equilibria_deflated() */
    const struct pk_equilibria *known; /* roots to deflate, or NULL */
};

static inline size_t coordinates(const struct search *s) { return pk_coordinates_of(s->problem); }

static inline int is_cyclic(const struct search *s, size_t i)
{
    const unsigned char *cyclic = s->problem->system->cyclic;
    return cyclic && i < coordinates(s) && cyclic[i];
}

/* Returns whether there are rotations or constraints. */
static inline int is_bound(const struct search *s)
{
    return s->problem->system->n_rotations || s->problem->system->constraints.n;
}

/* Returns the index of the first quaternion in v. */
static inline size_t quaternions(const struct search *s)
{
    return coordinates(s) + 3 * s->problem->system->n_rotations;
}

static inline int is_body_rate(const struct search *s, size_t i)
{
    return i < quaternions(s) && i + 3 * s->problem->system->n_rotations >= quaternions(s);
}

/* Returns |Q|^2 - (Q.R)^2: for unit quaternions, the squared sine of half the angle from Q to R. */
static inline double turned(const double *Q, const double *R)
{
    const double same = pk_dot(Q, R, 4);
    return pk_dot(Q, Q, 4) - same * same;
}

/* Returns whether unknown i is v_i (cyclic coordinates, first-order variables); else it is q_i. */
static inline int is_by_rate(const struct search *s, size_t i)
{
    return i >= coordinates(s) || is_cyclic(s, i);
}

/* Returns the address of unknown i in the state: q_i or v_i. */
static inline double *unknown(struct search *s, size_t i)
{
    return (is_by_rate(s, i) ? s->v : s->q) + i;
}

/* Returns the length scale of unknown i: its box or, if larger, its distance from the middle. */
static inline double reach(struct search *s, size_t i)
{
    return fmax(s->box[i], fabs(*unknown(s, i) - s->middle[i]));
}

/* Callbacks by which GSL's solvers compute the residuals F and their Jacobian matrix J. */
typedef int pk_gsl_vector(const gsl_vector *z, void *search, gsl_vector *f);
typedef int pk_gsl_matrix(const gsl_vector *z, void *search, gsl_matrix *J);

/* These functions are for systems with rotations or constraints. pk_bound_equations() computes the
 * residuals F of the equations, pk_bound_derivatives() computes their Jacobian matrix J, and
 * pk_bound_solve() minimises |F| from the current state. */
int pk_bound_equations(struct search *s);
int pk_bound_derivatives(struct search *s);
void pk_bound_solve(struct search *s, pk_gsl_vector *f, pk_gsl_matrix *df);
/* Sets the first n numbers of F to Newton's correction of least norm; returns 0 on failure. */
int pk_bound_correct(struct search *s);

/* The arguments of a kernel at the current state. */
#define OF(s) (s)->problem->params, 0, (s)->q, (s)->v, NULL

/* Computes the residuals F at the current state; returns 0 if one of them is not finite. */
static inline int equations(struct search *s)
{
    const struct pk_problem *problem = s->problem;
    const struct pk_system *system = problem->system;
    if (is_bound(s))
        return pk_bound_equations(s);
    system->canonical(OF(s), s->p, s->pdot);
    /* f of M a = f: for coordinates pdot at rest, for first-order variables their rates */
    if (system->n_first_order)
        system->force(OF(s), s->pdot);
    for (size_t i = 0; i < s->n; i++)
        s->F[i] = is_cyclic(s, i) ? s->p[i] - s->kept[i]
                  : s->unread[i]  ? s->v[i] - s->middle[i]
                                  : s->pdot[i];
    return pk_all_finite(s->F, s->n);
}

/* Sets the box, the angles, the initial momenta and the scale of each equation. Entries of the
 * state that are not unknowns are set: positions to their initial values, rates to 0. */
void pk_equilibria_box(struct search *s, const double *q0, const double *v0);
/* Scales quaternions to length 1. */
void pk_equilibria_normalise(struct search *s);
/* Sets the unknowns of the state to point k of the search; point 0 is the middle of the box. */
void pk_equilibria_place(struct search *s, size_t k);
/* Returns the deflation factor, the product of 1 + 1/|z - z_k|^2 over the known roots z_k, where z
 * are the unknowns and distances are in units of the box. The factor is infinite at a root. Sets
 * s->slope to the gradient of its logarithm. */
double pk_equilibria_deflated(struct search *s);

/* Returns the energy at q and v, or 0 if the system has none. */
double pk_equilibria_energy(const struct search *s, const double *q, const double *v);
/* Returns whether the state is a known root, or on the same continuum as one. */
int pk_equilibria_known(struct search *s, const struct pk_equilibria *found);
/* Inserts the state into the list, sorted by energy; roots of equal energy keep their order. */
void pk_equilibria_insert(struct search *s, struct pk_equilibria *found);

#endif

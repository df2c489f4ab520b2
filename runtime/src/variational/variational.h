/* Shared by the variational methods: the step (variational.c), its equations
 * (variational_equations.c), their solution (variational_solve.c, variational_matrix.c), and the
 * end of the step, where rates come from momenta (variational_end.c).
 */
#ifndef PK_VARIATIONAL_H
#define PK_VARIATIONAL_H

#include "../core/attitude.h"
#include "../core/project.h"
#include "../core/tableau.h"

/* An iteration ends at this relative error: see newton.c. */
#define PK_VARIATIONAL_BIAS (PK_EPS / PK_C(8192.0))
/* Fraction of the largest scale that is added to each unknown's own scale: forces, as differences
 * of coordinates, and M mix the round-off of all unknowns. */
#define PK_VARIATIONAL_SHARE (PK_C(1.0) / 1024)

/* A composition of steps with the discrete Lagrangian of L at the middle, or at both ends. */
struct pk_variational {
    const struct pk_splitting *parts; /* drift: the fractions of the step */
    int ends;
};

/* n degrees of freedom. The first m have momenta: coordinates, then body rates. Quaternions follow,
 * then other states. */
struct pk_variational_work {
    const struct pk_variational *table;
    size_t n, m, c;          /* c: constraint rows */
    size_t rotation, states; /* index of the first body rate; of the first other state */
    size_t turned;           /* number of rotations */
    pk_real t, end, h;       /* start, end and size of this part of the step */
    pk_real *to;             /* a state like it->own->next: at first the start, at last the end */
    pk_real jump, worst;     /* size of the first correction; worst rate of corrections above FAR */
    /* M: at the start, and from pk_variational_rates() on at the end, factored. All else in it:
     * constraints at the end. */
    struct pk_projection at;
    /* Arrays of n each, those of q of `rotation`. */
    pk_real *V, *dV, *scale;        /* unknown rates, of states too; correction; scale */
    pk_real *p, *f, *p_end, *f_end; /* momenta and forces at the middle or the start; at the end */
    pk_real *f_start;               /* forces at the start of this part */
    pk_real *q_at, *v_at;           /* middle; with `ends`, v_at: start with rates V */
    pk_real *q_end, *v_end, *low_q, *low_v; /* end and its low parts */
    pk_real *kick, *pull, *root, *spare;    /* mu, J^T mu; square roots of the diagonal of M */
    pk_real *last_V, *last_h;               /* of the last part, for the guess; 1 number */
    pk_real *kept, *kept_kick, *slope; /* when following: last V and kick, dV/d(part) */
    pk_real *pivot, *A_pivot;          /* pivots of lu; of at.A within the step */
    /* n by n: J at the start; factored matrix of Newton. Not for families: these are solved by M,
     * or under constraints by [M J^T; J 0], in the memory of the system. */
    pk_real *J, *lu;
    int whole;
};

/* Returns a part of w->to. */
static inline pk_real *pk_variational_to(const struct pk_variational_work *w, int part)
{
    return pk_part(w->to, w->rotation, w->n, part);
}
/* Returns where rotation r is among rates. */
static inline struct pk_turning pk_variational_turning(const struct pk_variational_work *w,
                                                       size_t r)
{
    return pk_system_turning(w->at.system, w->at.params, r);
}

/* Returns the work arrays of it->own->work. */
struct pk_variational_work pk_variational_parts(const struct pk_integrator *it);
size_t pk_variational_size(const struct pk_method *method, const struct pk_problem *problem,
                           size_t n);
/* Evaluates p and dp/dt of L alone at a state, n each; for quaternions and states themselves and
 * their rates. */
void pk_variational_momenta(struct pk_integrator *it, pk_real t, const pk_real *q, const pk_real *v,
                            pk_real *p, pk_real *pdot);
/* Factors M at a state, of families under constraints with their rows, and sets w->root. Returns
 * PK_SINGULAR_MASS, PK_NOT_FINITE, PK_NO_PROJECTION. pk_variational_by_mass(): x = M^-1 x with that
 * M, for such families restricted to motion that the rows allow. */
enum pk_status pk_variational_mass(struct pk_integrator *it, struct pk_variational_work *w,
                                   pk_real t, const pk_real *q, const pk_real *v);
/* With M factored: evaluates the residuals of the rows and factors J M^-1 J^T. */
enum pk_status pk_variational_rows(struct pk_integrator *it, struct pk_variational_work *w,
                                   const pk_real *q, const pk_real *v);
void pk_variational_by_mass(const struct pk_variational_work *w, pk_real *x);
/* Computes the end of the step from V, and its middle. */
void pk_variational_reach(struct pk_variational_work *w);
/* Evaluates momenta and forces from V, at the middle, or at the start and at the end. Returns
 * whether they are finite. */
int pk_variational_evaluate(struct pk_integrator *it, struct pk_variational_work *w);
/* Computes r(V), n numbers, from the result of pk_variational_evaluate(); 0 for quaternions. */
void pk_variational_residual(const struct pk_variational_work *w, pk_real *out);
/* Returns the largest of w->scale. */
pk_real pk_variational_most(const struct pk_variational_work *w);
/* Replaces r(V) in w->dV by the correction of V, and corrects w->kick: with the matrix M, or by
 * Newton's method. phi and J are those at the end. Returns the sign of the determinant, 1 at h = 0;
 * 0 if the matrix is singular. */
int pk_variational_correction(struct pk_integrator *it, struct pk_variational_work *w, int newton);
/* Solves for V and w->kick of the part of the step from w->to; leaves p and f of that V, and the
 * end. Returns PK_NO_CONVERGENCE or PK_AMBIGUOUS_STEP on failure. */
enum pk_status pk_variational_solve(struct pk_integrator *it, struct pk_variational_work *w);
/* Solves for v from p, n each, at the end w->to; moves both so that J v + j0 = 0; low_p compensates
 * p. Returns PK_NO_CONVERGENCE, PK_NO_PROJECTION, PK_NOT_FINITE, or as pk_variational_mass(). */
enum pk_status pk_variational_rates(struct pk_integrator *it, struct pk_variational_work *w,
                                    pk_real *p, pk_real *low_p);

#endif

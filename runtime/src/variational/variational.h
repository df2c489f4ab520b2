/* Shared by the variational methods: the step (variational.c), its equations
 * (variational_equations.c), their solution (variational_solve.c, variational_matrix.c), and the
 * end of the step, where rates are computed from momenta (variational_end.c). */
#ifndef PK_VARIATIONAL_H
#define PK_VARIATIONAL_H

#include "../core/attitude.h"
#include "../core/project.h"
#include "../core/tableau.h"

/* An iteration ends at this relative error; see newton.c. */
#define PK_VARIATIONAL_BIAS (PK_EPS / PK_C(8192.0))
/* Forces (as differences of coordinates) and M mix the round-off of all unknowns. So this fraction
 * of the largest scale is added to each unknown's own scale. */
#define PK_VARIATIONAL_SHARE (PK_C(1.0) / 1024)

/* A composition of steps, called parts. The discrete Lagrangian is that of L at the middle of a
 * part, or with `ends` at both ends. */
struct pk_variational {
    /* parts->drift: lengths of the parts, as fractions of the step */
    const struct pk_splitting *parts;
    int ends;
};

/* There are n rates and other first-order variables. The first m of them have momenta: rates of
 * coordinates, then body rates. Quaternions follow, then other first-order variables. */
struct pk_variational_work {
    const struct pk_variational *table;
    size_t n, m, c; /* c: number of constraint rows */
    /* index of the first body rate; of the first variable after quaternions */
    size_t rotation, states;
    size_t turned;     /* number of rotations */
    pk_real t, end, h; /* start time, end time and length of this part of the step */
    /* a state, laid out like it->own->next: at the start of the part of the step, later at its end */
    pk_real *to;
    pk_real jump, worst; /* size of the first correction; largest ratio of corrections above FAR */
    /* `at` holds M at the start, factored; after pk_variational_rates() it holds M at the end. Its
     * other members are the constraints at the end. */
    struct pk_projection at;
    /* Arrays of n numbers each; those for coordinates have `rotation` numbers. */
    pk_real *V, *dV, *scale; /* unknown rates; their correction; their scale */
    /* momenta, forces: at the middle (with `ends`: start); at the end */
    pk_real *p, *f, *p_end, *f_end;
    pk_real *f_start;     /* forces at the start of this part */
    pk_real *q_at, *v_at; /* state at the middle; with `ends`, v_at is v at the start with V */
    /* state at the end; low parts of its compensated sums */
    pk_real *q_end, *v_end, *low_q, *low_v;
    pk_real *kick, *pull, *root, *spare; /* mu; J^T mu; roots of M's diagonal; scratch memory */
    pk_real *last_V, *last_h;            /* V and length of the last part, for the guess */
    /* for follow(): V and kick at its last point; slope of V over the fraction of the step */
    pk_real *kept, *kept_kick, *slope;
    pk_real *pivot, *A_pivot; /* pivots of lu; pivots of at.A in this step */
    /* n by n matrices: J at the start; Newton's matrix, factored. Families have neither: their
     * matrix is M or, with constraints, [M J^T; J 0], in the memory of the system. */
    pk_real *J, *lu;
    int whole;
};

/* Returns the address of a part of w->to (PK_Q, PK_V, ...). */
static inline pk_real *pk_variational_to(const struct pk_variational_work *w, int part)
{
    return pk_part(w->to, w->rotation, w->n, part);
}
/* Returns the indices of rotation r among the rates. */
static inline struct pk_turning pk_variational_turning(const struct pk_variational_work *w,
                                                       size_t r)
{
    return pk_system_turning(w->at.system, w->at.params, r);
}

/* Sets y to h/4 times the rates of a body, half the vector whose Cayley transform turns it. */
static inline void pk_variational_y(const struct pk_variational_work *w, const pk_real *omega,
                                    pk_real y[3])
{
    for (size_t i = 0; i < 3; i++)
        y[i] = w->h * omega[i] / 4;
}

/* Returns the work arrays, which are in it->own->work. */
struct pk_variational_work pk_variational_parts(const struct pk_integrator *it);
size_t pk_variational_size(const struct pk_method *method, const struct pk_problem *problem,
                           size_t n);
/* Evaluates p and dp/dt of L at a state, n numbers each; for quaternions and other first-order
 * variables these are their values and rates. */
void pk_variational_momenta(struct pk_integrator *it, pk_real t, const pk_real *q, const pk_real *v,
                            pk_real *p, pk_real *pdot);
/* Factors M at a state (for families under constraints, [M J^T; J 0]), and sets w->root. Returns
 * PK_SINGULAR_MASS, PK_NOT_FINITE or PK_NO_PROJECTION on failure. pk_variational_by_mass() sets x =
 * M^-1 x; for families under constraints, x is then only the motion that the rows allow. */
enum pk_status pk_variational_mass(struct pk_integrator *it, struct pk_variational_work *w,
                                   pk_real t, const pk_real *q, const pk_real *v);
/* Evaluates the residuals of the constraint rows and factors J M^-1 J^T; M must be factored. */
enum pk_status pk_variational_rows(struct pk_integrator *it, struct pk_variational_work *w,
                                   const pk_real *q, const pk_real *v);
void pk_variational_by_mass(const struct pk_variational_work *w, pk_real *x);
/* Computes the end and the middle of the step from V. */
void pk_variational_reach(struct pk_variational_work *w);
/* Evaluates momenta and forces from V at the middle, or at the start and at the end. Returns
 * whether they are finite. */
int pk_variational_evaluate(struct pk_integrator *it, struct pk_variational_work *w);
/* Computes the residual r(V), n numbers, after pk_variational_evaluate(); 0 for quaternions. */
void pk_variational_residual(const struct pk_variational_work *w, pk_real *out);
/* Replaces r(V) in w->dV by the correction of V, and corrects w->kick: by Newton's method if
 * `newton` is nonzero, otherwise with the matrix M. phi and J are those at the end. Returns the
 * sign of the determinant of the matrix (1 at h = 0), or 0 if it is singular. */
int pk_variational_correction(struct pk_integrator *it, struct pk_variational_work *w, int newton);
/* Solves for V and w->kick of one part of the step, which begins at w->to. Also sets momenta and
 * forces for this V, and the state at the end. May return PK_NO_CONVERGENCE or
 * PK_AMBIGUOUS_STEP. */
enum pk_status pk_variational_solve(struct pk_integrator *it, struct pk_variational_work *w);
/* Solves for the rates v that have the momenta p (n numbers each) at the end w->to, and corrects
 * both so that J v + j0 = 0; low_p holds the low part of p. Returns PK_NO_CONVERGENCE,
 * PK_NO_PROJECTION, PK_NOT_FINITE, or a failure of pk_variational_mass(). */
enum pk_status pk_variational_rates(struct pk_integrator *it, struct pk_variational_work *w,
                                    pk_real *p, pk_real *low_p);

#endif

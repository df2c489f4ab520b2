/* What the variational steps share: the step (variational.c), its equations
 * (variational_equations.c) how they are solved (variational_solve.c, variational_matrix.c), its
 * end, where rates come from momenta (variational_end.c).
 */
#ifndef PK_VARIATIONAL_H
#define PK_VARIATIONAL_H

#include "../core/attitude.h"
#include "../core/project.h"
#include "../core/tableau.h"

/* What an iteration may leave undone: see newton.c. */
#define PK_VARIATIONAL_BIAS (PK_EPS / PK_C(8192.0))
/* Of the largest scale, beside one's own: what forces, as differences of coordinates, and M mix is
 * rounded by others too. */
#define PK_VARIATIONAL_SHARE (PK_C(1.0) / 1024)

/* A composition of steps, each the discrete Lagrangian of L at the middle, or of both ends. */
struct pk_variational {
    const struct pk_splitting *parts; /* drift: their fractions */
    int ends;
};

/* n degrees of freedom, of which the first m have momenta: coordinates, then body rates; behind
 * them quaternions, then other states. */
struct pk_variational_work {
    const struct pk_variational *table;
    size_t n, m, c;          /* c: rows of constraints */
    size_t rotation, states; /* coordinates, where body rates begin; where other states do */
    size_t turned;           /* rotations */
    pk_real t, end, h;       /* of this part of the step */
    pk_real *to;             /* a state, as it->own->next is: the start, and at last the end */
    pk_real jump, worst;     /* the first correction; the rate of those that are not small */
    /* Its M: at the start, and from pk_variational_rates() on at the end, factored. The rest: the
     * constraints at the end. */
    struct pk_projection at;
    /* n each, `rotation` of what is of q. */
    pk_real *V, *dV, *scale;        /* the unknown rates, of states too; what they are judged by */
    pk_real *p, *f, *p_end, *f_end; /* momenta and forces at the middle or the start; at the end */
    pk_real *f_start;               /* forces where this part begins */
    pk_real *q_at, *v_at;           /* the middle; of ends, the start by V */
    pk_real *q_end, *v_end, *low_q, *low_v; /* the end and its low parts */
    pk_real *kick, *pull, *root, *spare;    /* mu, J^T mu; roots of the diagonal of M */
    pk_real *last_V, *last_h;               /* of the part before, for the guess; 1 number */
    pk_real *kept, *kept_kick, *slope; /* of a shorter step: V, kick, how V goes on from there */
    pk_real *pivot, *A_pivot;          /* of lu; of at.A in the step */
    /* n by n: J at the start; the matrix of Newton's method, factored. Not of families, which are
     * solved by M, or [M J^T; J 0] where there are rows, in the memory of the system. */
    pk_real *J, *lu;
    int whole;
};

/* A part of w->to. */
static inline pk_real *pk_variational_to(const struct pk_variational_work *w, int part)
{
    return pk_part(w->to, w->rotation, w->n, part);
}
/* Where rotation r is among rates. */
static inline struct pk_turning pk_variational_turning(const struct pk_variational_work *w,
                                                       size_t r)
{
    return pk_system_turning(w->at.system, w->at.params, r);
}

/* Where all that stands in it->own->work. */
struct pk_variational_work pk_variational_parts(const struct pk_integrator *it);
size_t pk_variational_size(const struct pk_method *method, const struct pk_problem *problem,
                           size_t n);
/* n each: p and dp/dt of L alone at a state; of quaternions and states themselves and their rates.
 */
void pk_variational_momenta(struct pk_integrator *it, pk_real t, const pk_real *q, const pk_real *v,
                            pk_real *p, pk_real *pdot);
/* M there, factored, of families under constraints with their rows, and w->root; PK_SINGULAR_MASS,
 * PK_NOT_FINITE, PK_NO_PROJECTION. x = M^-1 x by it, of such families as far as rows let it move. */
enum pk_status pk_variational_mass(struct pk_integrator *it, struct pk_variational_work *w,
                                   pk_real t, const pk_real *q, const pk_real *v);
/* Of M that is there, the rows: their residuals, and J M^-1 J^T factored. */
enum pk_status pk_variational_rows(struct pk_integrator *it, struct pk_variational_work *w,
                                   const pk_real *q, const pk_real *v);
void pk_variational_by_mass(const struct pk_variational_work *w, pk_real *x);
/* The end of the step by V, and its middle. */
void pk_variational_reach(struct pk_variational_work *w);
/* Momenta and forces by V, at the middle, or at the start and at the end; whether they are finite.
 */
int pk_variational_evaluate(struct pk_integrator *it, struct pk_variational_work *w);
/* r(V), n numbers, of what pk_variational_evaluate() left; 0 of quaternions. */
void pk_variational_residual(const struct pk_variational_work *w, pk_real *out);
/* The largest of w->scale. */
pk_real pk_variational_most(const struct pk_variational_work *w);
/* w->dV, which holds r(V), becomes the correction of V, and w->kick is corrected: by M, or by
 * Newton's method. phi and J are those at the end. The sign of the determinant, 1 at h = 0; 0 where
 * there is none. */
int pk_variational_correction(struct pk_integrator *it, struct pk_variational_work *w, int newton);
/* V and w->kick of the part of the step from w->to; p and f are then of V, and the end is known.
 * PK_NO_CONVERGENCE, PK_AMBIGUOUS_STEP. */
enum pk_status pk_variational_solve(struct pk_integrator *it, struct pk_variational_work *w);
/* v from p, n each, at the end w->to; both are moved so that J v + j0 = 0, low_p compensates p.
 * PK_NO_CONVERGENCE, PK_NO_PROJECTION, PK_NOT_FINITE, or as pk_variational_mass(). */
enum pk_status pk_variational_rates(struct pk_integrator *it, struct pk_variational_work *w,
                                    pk_real *p, pk_real *low_p);

#endif

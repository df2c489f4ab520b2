/* What the variational steps share: the step (variational.c), its equations (variational_equations.c)
 * and how they are solved (variational_solve.c), its end, where rates come from momenta
 * (variational_end.c).
 */
#ifndef PK_VARIATIONAL_H
#define PK_VARIATIONAL_H

#include "attitude.h"
#include "project.h"
#include "tableau.h"

/* Corrections below this, relative, that no longer shrink are round-off. */
#define PK_VARIATIONAL_ROUND (PK_C(16384.0) * PK_EPS)
/* What an iteration may leave undone: see newton.c. */
#define PK_VARIATIONAL_BIAS (PK_EPS / PK_C(8192.0))

/* A composition of steps, each the discrete Lagrangian of L at the middle, or of both ends. */
struct pk_variational {
    const struct pk_splitting *parts; /* drift: their fractions */
    int ends;
};

struct pk_variational_work {
    const struct pk_variational *table;
    size_t n, m, c;         /* m have momenta; rows of constraints */
    size_t rotation, first; /* coordinates; where quaternions begin */
    size_t turned;          /* rotations */
    size_t states;          /* where other states begin */
    pk_real t, end, h;      /* of this part of the step */
    pk_real *to;            /* a state, as it->next is: the start, and at last the end */
    /* n each. V: the unknown rates, of states too; dV; scale; momenta and forces at the middle or the
     * start, and at the end; that place; the end and its low parts; V and the kick of a shorter
     * step, and how V goes on from there. */
    pk_real *V, *dV, *scale, *last_V, *p, *f, *p_end, *f_end, *q_at, *v_at;
    pk_real *q_end, *v_end, *low_q, *low_v, *kept, *kept_kick, *slope;
    pk_real *f_start; /* forces where this part begins */
    pk_real *M, *lu, *pivot; /* factored: M at the start; the matrix of Newton's method */
    pk_real *J, *J_end, *by_kick, *S, *S_pivot, *kick, *phi, *spare;
    pk_real *last_h; /* of the part before, for the guess */
    pk_real jump, worst; /* the first correction; the rate of those that are not small */
    pk_real *stages; /* 2 + 2 n numbers each */
};

struct pk_variational_work pk_variational_parts(const struct pk_integrator *it);
void pk_variational_momenta(struct pk_integrator *it, pk_real t, const pk_real *q,
                            const pk_real *v, pk_real *p, pk_real *pdot);
/* M there, factored into w->M. */
enum pk_status pk_variational_mass(struct pk_integrator *it, struct pk_variational_work *w,
                                   pk_real t, const pk_real *q, const pk_real *v);
/* The end of the step by V, and its middle. */
void pk_variational_reach(struct pk_variational_work *w);
/* Momenta and forces by V, at the middle, or at the start and at the end; whether they are finite. */
int pk_variational_evaluate(struct pk_integrator *it, struct pk_variational_work *w);
void pk_variational_residual(const struct pk_variational_work *w, pk_real *r);
/* V and w->kick of the part of the step from w->to; p and f are then of V, and the end is known. */
enum pk_status pk_variational_solve(struct pk_integrator *it, struct pk_variational_work *w);
/* v from p at the end w->to; both are moved so that J v + j0 = 0. w->M is then M there. */
enum pk_status pk_variational_rates(struct pk_integrator *it, struct pk_variational_work *w,
                                    pk_real *p, pk_real *low_p);

#endif

/* What gauss.c and newton.c share. */
#ifndef PK_GAUSS_H
#define PK_GAUSS_H

#include "internal.h"
#include "tableau.h"

/* Corrections below this, relative, that no longer shrink are round-off, not divergence. */
#define PK_GAUSS_ROUND (PK_C(16384.0) * PK_EPS)
/* What an iteration may leave undone: the error of 1e8 steps is then still of round-off. */
#define PK_GAUSS_BIAS (PK_EPS / PK_C(8192.0))
/* A step so much longer than the last one is not predicted from it. */
#define PK_GAUSS_REACH PK_C(64.0)

struct pk_gauss_work {
    const struct pk_gauss *table;
    size_t s;
    pk_real *V, *Q, *P, *F, *G; /* stages: rates, coordinates, momenta, h b pdot, residual */
    pk_real *last_V;            /* of the last step made, for the predictor */
    pk_real *jacobian;          /* s of: M, p_q, pdot_q, pdot_v, one spare */
    pk_real *lu, *pivot, *mass, *mean_q, *mean_v, *scale;
    pk_real *mu, *hA, *hb, *predict;
    pk_real *mu_columns, *rest; /* of gauss8: mu for the lanes; work of gauss_nystrom.c */
    pk_real *slow_h;            /* the step at which that did not converge */
    /* The step that hA, and that lu, was made for; that of the predictor over the last one's;
     * iterations with a new matrix; steps for which it is still to be made anew, and how many
     * these were. */
    pk_real *h, *lu_h, *ratio, *last_h, *best, *wait, *patience;
};

struct pk_gauss_work pk_gauss_parts(struct pk_integrator *it);
size_t pk_gauss_nystrom_size(size_t n);
enum pk_status pk_gauss_nystrom_step(struct pk_integrator *it, const struct pk_gauss_work *w);
/* Stage rates V, and Q, P, F at them, from the V given as a guess. */
enum pk_status pk_gauss_solve(struct pk_integrator *it, struct pk_gauss_work *w);

#endif

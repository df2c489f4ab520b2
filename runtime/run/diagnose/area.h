/* Poincare's integral invariant of an ensemble whose initial states form a closed loop. */
#ifndef RUN_DIAGNOSE_AREA_H
#define RUN_DIAGNOSE_AREA_H

#include "parts.h"

/* q and p of all members at the rows that all of them write; the members enclose an area. */
struct loop {
    size_t members, rows, n; /* `n`: number of coordinates; first-order variables have no momenta */
    double *x;               /* [rows][q or p][n][members]; see area_series() */
    double *t;               /* time of each row; row 0 is the start */
    size_t *came;            /* number of rows that each member has written so far */
    pk_real *work;    /* for each member: memory for p and pdot, since members run in parallel */
    size_t whole;     /* number of components of p, which includes first-order variables */
    const char *gone; /* text that says why members may have ended early, for messages */
};

/* Returns q_i, or p_i, of all members at one row, in member order. */
static inline double *area_series(const struct loop *l, size_t row, size_t i, int momentum)
{
    return l->x + ((2 * row + (size_t)momentum) * l->n + i) * l->members;
}

#endif

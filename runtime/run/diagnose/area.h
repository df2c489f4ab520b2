/* Poincare's integral invariant of an ensemble whose members are a closed loop of starts. */
#ifndef RUN_DIAGNOSE_AREA_H
#define RUN_DIAGNOSE_AREA_H

#include "parts.h"

/* q and p of all members at the rows that they have in common, as far as each has come. */
struct loop {
    size_t members, rows, n; /* n: coordinates; states have no momenta */
    double *x;               /* of each row: q of all members for each coordinate, then p */
    double *t;               /* of the start and each row */
    size_t *came;            /* how many rows each member has */
    pk_real *work;           /* of each member, who may run beside others: p and pdot */
    size_t whole;            /* of these: coordinates and states */
    const char *gone;        /* what may have become of members that have not come to the end */
};

/* Of one of them at one row, in member order. */
static inline double *area_series(const struct loop *l, size_t row, size_t i, int momentum)
{
    return l->x + ((2 * row + (size_t)momentum) * l->n + i) * l->members;
}

#endif

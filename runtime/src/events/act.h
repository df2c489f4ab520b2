/* The constraint rows of a state, and what contacts do to them; see pk/act.h. */
#ifndef PK_SRC_ACT_H
#define PK_SRC_ACT_H

#include <pk/act.h>
#include <pk/constraint.h>

#include "../core/project.h"

enum { PK_MOST_ROWS = 64 };

struct rows {
    struct pk_projection w; /* with all rows, whatever their modes */
    /* for each row the number of its contact, or contacts.n, and its mode */
    size_t of[PK_MOST_ROWS], mode[PK_MOST_ROWS];
    /* rounding errors of gaps, rates and accelerations of the rows */
    pk_real of_gap[PK_MOST_ROWS], of_rate[PK_MOST_ROWS], of_acceleration[PK_MOST_ROWS];
    pk_real before[PK_MOST_ROWS],
        acceleration[PK_MOST_ROWS]; /* before: the rates before impulses */
};

/* Returns whether the rate of a row is 0 up to rounding. */
static inline int pk_act_still(const struct rows *r, size_t row)
{
    return pk_abs(r->w.rate[row]) <= r->of_rate[row];
}

/* Computes the rows at a->next, and A = J M^-1 J^T. */
enum pk_status pk_act_rows(struct pk_actor *a, struct pk_integrator *it, struct rows *r);
/* Changes the rates in a->next, and r->w.rate, by the impulses of closed contacts. */
enum pk_status pk_impact(struct pk_actor *a, struct pk_integrator *it, struct rows *r);
/* Finds which contacts and frictions hold. a->state has, for each, 1 if it may hold, else 0, or 2
 * or -2 for a friction that slips forwards or backwards. Afterwards it has 1 if the row holds, 2 or
 * -2 for a friction that slips, and 0 for no force. Sets r->acceleration. */
enum pk_status pk_reactions(struct pk_actor *a, struct pk_integrator *it, struct rows *r);

#endif

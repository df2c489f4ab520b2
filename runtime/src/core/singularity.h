/* Shared by singularity.c and singularity_search.c: parts of it->own->singularities. */
#ifndef PK_SINGULARITY_H
#define PK_SINGULARITY_H

#include "internal.h"

/* Parts with one number for each singularity. _NOW and _SLOPE: value and slope at the state; _NEXT
 * and _NEXT_SLOPE: value and slope at the end of a trial step; _MOST: largest value since the
 * start. They are followed by the memory of the search: states and a derivative. */
enum {
    PK_SINGULARITY_NOW,
    PK_SINGULARITY_SLOPE,
    PK_SINGULARITY_NEXT,
    PK_SINGULARITY_NEXT_SLOPE,
    PK_SINGULARITY_MOST,
    PK_SINGULARITY_PARTS
};
enum { PK_SINGULARITY_SEARCH_PARTS = 5 };

#define PK_SINGULARITY_DEEP \
    PK_C(1e-12) /* a divisor counts as 0 below this fraction of its value at the start */
#define PK_SINGULARITY_SHALLOW \
    PK_C(1e-3) /* the same fraction if step sizes underflow: round-off stops the search */

static inline pk_real *pk_singularity_part(const struct pk_integrator *it, int which)
{
    return it->own->singularities + (size_t)which * it->own->n_singularities;
}

void pk_singularity_evaluate(struct pk_integrator *it, pk_real t, const pk_real *q,
                             const pk_real *v, pk_real *out);
/* Evaluates the singularities at time t + d, with the coordinates moved to q + d v. */
void pk_singularity_along(struct pk_integrator *it, pk_real t, const pk_real *q, const pk_real *v,
                          pk_real d, pk_real *out);
/* Returns t if it lies between first and last, else first, since a computed t may be round-off. */
pk_real pk_singularity_within(pk_real t, pk_real first, pk_real last);
/* Searches for a singularity that falls to `depth` times its present value before t_end. The
 * counters of the integrator and the reason of a failure are unchanged. */
struct pk_singularity_search {
    enum {
        PK_SINGULARITY_UNDECIDED, /* step sizes underflow, or it takes too many steps */
        PK_SINGULARITY_STAYS,     /* t_end is reached, and no singularity comes near zero */
        PK_SINGULARITY_VANISHES
    } found;
    size_t which;
    pk_real when; /* time at which the singularity vanishes */
    int bounded;  /* 1: the acceleration does not grow towards the singularity */
};
struct pk_singularity_search pk_singularity_search(struct pk_integrator *it, pk_real t_end,
                                                   pk_real depth);

#endif

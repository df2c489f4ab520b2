/* Shared by singularity.c and singularity_search.c: parts of it->own->singularities. */
#ifndef PK_SINGULARITY_H
#define PK_SINGULARITY_H

#include "internal.h"

/* For each singularity: value and slope at the state, value and slope at the end of a trial step,
 * largest value since the start; then states and a slope for the search. */
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
    PK_C(1e-12) /* a singularity vanishes where it has this fraction of its start value */
#define PK_SINGULARITY_SHALLOW \
    PK_C(1e-3) /* the same fraction if step sizes underflow: round-off stops the search */

static inline pk_real *pk_singularity_part(const struct pk_integrator *it, int which)
{
    return it->own->singularities + (size_t)which * it->own->n_singularities;
}

void pk_singularity_evaluate(struct pk_integrator *it, pk_real t, const pk_real *q,
                             const pk_real *v, pk_real *out);
/* Evaluates the singularities at time distance d along the tangent of the motion. */
void pk_singularity_along(struct pk_integrator *it, pk_real t, const pk_real *q, const pk_real *v,
                          pk_real d, pk_real *out);
/* Returns t if it lies between first and last, else first, since a computed t may be round-off. */
pk_real pk_singularity_within(pk_real t, pk_real first, pk_real last);
/* Searches whether, and which, singularity falls to `depth` times its value at the state before
 * t_end. Leaves counters and the reason of a failure unchanged. */
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

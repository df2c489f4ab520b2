/* Shared by the two files of singularities: parts of it->own->singularities. Not installed. */
#ifndef PK_SINGULARITY_H
#define PK_SINGULARITY_H

#include "internal.h"

/* Values and slopes at the state, then at the end of a trial step, and largest values since the
 * start, one number for each singularity; then states and a slope for the search. */
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
    PK_C(1e-12) /* of its value at the start of the search: it vanishes, \
                                         */
#define PK_SINGULARITY_SHALLOW \
    PK_C(1e-3) /* or, if step sizes underflow already, it is small enough to count */

static inline pk_real *pk_singularity_part(const struct pk_integrator *it, int which)
{
    return it->own->singularities + (size_t)which * it->own->n_singularities;
}

void pk_singularity_evaluate(struct pk_integrator *it, pk_real t, const pk_real *q,
                             const pk_real *v, pk_real *out);
/* Evaluates the singularities at distance d along the tangent. */
void pk_singularity_along(struct pk_integrator *it, pk_real t, const pk_real *q, const pk_real *v,
                          pk_real d, pk_real *out);
/* Returns t if it lies between first and last, else first: a tangent may be round-off. */
pk_real pk_singularity_within(pk_real t, pk_real first, pk_real last);
/* Searches whether a singularity falls to `depth` of its value at the state on the way to t_end,
 * and which. Leaves counters and the reason of a failure unchanged. */
struct pk_singularity_search {
    enum {
        PK_SINGULARITY_UNDECIDED, /* step sizes underflow, or too many steps are needed */
        PK_SINGULARITY_STAYS,     /* t_end is reached, and none comes near zero on the way */
        PK_SINGULARITY_VANISHES
    } found;
    size_t which;
    pk_real when; /* the time at which it vanishes */
    int bounded;  /* the acceleration does not grow on the way there */
};
struct pk_singularity_search pk_singularity_search(struct pk_integrator *it, pk_real t_end,
                                                   pk_real depth);

#endif

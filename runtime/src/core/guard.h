/* What the two files of guards share: parts of it->own->guards. Not installed. */
#ifndef PK_GUARD_H
#define PK_GUARD_H

#include "internal.h"

/* Values and slopes at the state, then at the end of a trial step, the largest values of all states
 * since the start, a number a guard each; behind them a state and a slope for the search, n each. */
enum {
    PK_GUARD_NOW,
    PK_GUARD_SLOPE,
    PK_GUARD_NEXT,
    PK_GUARD_NEXT_SLOPE,
    PK_GUARD_MOST,
    PK_GUARD_PARTS
};
enum { PK_GUARD_SEARCH_PARTS = 10 };

#define PK_GUARD_DEEP PK_C(1e-12)   /* of its value at the start of the search: it vanishes, */
#define PK_GUARD_SHALLOW PK_C(1e-3) /* or where steps underflow already, and it is small already */

static inline pk_real *pk_guard_part(const struct pk_integrator *it, int which)
{
    return it->own->guards + (size_t)which * it->own->n_guards;
}

void pk_guard_evaluate(struct pk_integrator *it, pk_real t, const pk_real *q, const pk_real *v,
                       pk_real *out);
/* The guards at d along the tangent. */
void pk_guard_along(struct pk_integrator *it, pk_real t, const pk_real *q, const pk_real *v,
                    pk_real d, pk_real *out);
/* A time from a tangent that is no more than round-off may be anything: then the first of two. */
pk_real pk_guard_within(pk_real t, pk_real first, pk_real last);
/* Whether a guard falls to `depth` of its value at the state on the way to t_end, and which. Leaves
 * counters and the reason of a failure as they were. */
struct pk_guard_search {
    enum { PK_GUARD_UNDECIDED, /* steps underflow, or there would be too many */
           PK_GUARD_STAYS,     /* they arrive, and none comes near to zero on the way */
           PK_GUARD_VANISHES } found;
    size_t which;
    pk_real when; /* it vanishes */
    int bounded;  /* the acceleration does not grow on the way there */
};
struct pk_guard_search pk_guard_search(struct pk_integrator *it, pk_real t_end, pk_real depth);

#endif

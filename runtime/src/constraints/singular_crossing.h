/* Shared by the monitor of singular positions (near_singular.c) and the step across one
 * (singular_crossing.c). */
#ifndef PK_SINGULAR_CROSSING_H
#define PK_SINGULAR_CROSSING_H

#include "../core/project.h"

enum { PK_SINGULAR_CROSSING_STAGES = 8 };

struct pk_singular_crossing {
    pk_real sigma; /* least singular value of the scaled J M^-1/2, when it was last computed */
    pk_real at;    /* if sigma falls: predicted time at which it is 0 */
    pk_real falls; /* whether sigma falls */
    pk_real t, h;  /* start time and size of the crossing, a step across the singular position */
    pk_real stages;
    /* error, in tolerances, of the last attempt at a crossing, which was too long */
    pk_real error;
    pk_real tried, length; /* sigma at the start of this attempt; size of the attempt */
    pk_real passing;       /* whether a crossing has begun and not reached its end */
    pk_real row;           /* index of the constraint row for which sigma is least */
    pk_real unseen;        /* whether the last step did not compute sigma */
};

struct pk_singular_crossing_parts {
    struct pk_singular_crossing *is;
    pk_real *q, *v;     /* state at the start of the crossing */
    pk_real *Q, *V, *A; /* states and accelerations at the stages of the crossing */
    pk_real *q_here, *v_here, *a_here;
    pk_real c[PK_SINGULAR_CROSSING_STAGES], b[PK_SINGULAR_CROSSING_STAGES];
};

struct pk_singular_crossing_parts pk_singular_crossing_parts(const struct pk_integrator *it);

static inline struct pk_singular_crossing *pk_singular_crossing_of(const struct pk_integrator *it)
{
    /* the struct is the head of the block; its arrays follow */
    return (struct pk_singular_crossing *)(void *)it->own->crossing;
}

/* Returns sigma at the state (t, q, v), or 1 if M is singular. */
pk_real pk_singular_crossing_sigma(struct pk_integrator *it, pk_real t, const pk_real *q,
                                   const pk_real *v);
/* Fails because the branch after the singular position, at time t, is undetermined. */
enum pk_status pk_singular_crossing_fail(struct pk_integrator *it, pk_real t);

#endif

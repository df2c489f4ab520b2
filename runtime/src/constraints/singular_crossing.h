/* Shared by the monitoring of singular positions (near_singular.c) and the step over one (singular_crossing.c). */
#ifndef PK_SINGULAR_CROSSING_H
#define PK_SINGULAR_CROSSING_H

#include "../core/project.h"

enum { PK_SINGULAR_CROSSING_STAGES = 8 };

struct pk_singular_crossing {
    pk_real sigma; /* sigma at the last look */
    pk_real at;    /* predicted time of its root, if it falls */
    pk_real falls; /* whether it falls */
    pk_real t, h;  /* start and size of the step over the root */
    pk_real stages;
    pk_real error;         /* of a step over it that was too long, relative to the tolerance; */
    pk_real tried, length; /* sigma at its start, and its size */
    pk_real passing;       /* the step is made, and its end not yet reached */
    pk_real row;           /* the row with the last sigma */
    pk_real unseen;        /* whether the last step did not compute sigma */
};

struct pk_singular_crossing_parts {
    struct pk_singular_crossing *is;
    pk_real *q, *v;     /* at the start of the step */
    pk_real *Q, *V, *A; /* at its stages */
    pk_real *q_here, *v_here, *a_here;
    pk_real c[PK_SINGULAR_CROSSING_STAGES], b[PK_SINGULAR_CROSSING_STAGES];
};

struct pk_singular_crossing_parts pk_singular_crossing_parts(const struct pk_integrator *it);

static inline struct pk_singular_crossing *pk_singular_crossing_of(const struct pk_integrator *it)
{
    return (struct pk_singular_crossing *)(void *)it->own->crossing; /* first in its memory */
}

/* Returns sigma at (t, q, v); 1 if M is singular. */
pk_real pk_singular_crossing_sigma(struct pk_integrator *it, pk_real t, const pk_real *q,
                                   const pk_real *v);
/* Fails because the branch behind the singular position, at time t, is undetermined. */
enum pk_status pk_singular_crossing_fail(struct pk_integrator *it, pk_real t);

#endif

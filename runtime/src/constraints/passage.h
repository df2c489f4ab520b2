/* What the watch for singular positions (near.c) and the step over one (passage.c) share. */
#ifndef PK_PASSAGE_H
#define PK_PASSAGE_H

#include "../core/project.h"

enum { PK_PASSAGE_STAGES = 8 };

struct pk_passage {
    pk_real sigma; /* the last one */
    pk_real at;    /* when it vanishes, while it falls */
    pk_real falls; /* whether it does */
    pk_real t, h;  /* of the step over it */
    pk_real stages;
    pk_real error;         /* in tolerances, of a step over it that was too long; */
    pk_real tried, length; /* the sigma where it began, and its h */
    pk_real passing;       /* it is made, and its end is still to come */
    pk_real row;           /* which of them has the last sigma */
    pk_real unseen;        /* whether the last step left it unknown */
};

struct pk_passage_parts {
    struct pk_passage *is;
    pk_real *q, *v;     /* where the step begins */
    pk_real *Q, *V, *A; /* at its stages */
    pk_real *q_here, *v_here, *a_here;
    pk_real c[PK_PASSAGE_STAGES], b[PK_PASSAGE_STAGES];
};

struct pk_passage_parts pk_passage_parts(const struct pk_integrator *it);

static inline struct pk_passage *pk_passage_of(const struct pk_integrator *it)
{
    return (struct pk_passage *)(void *)it->own->passage; /* it is laid out first */
}

/* sigma at (t, q, v); 1 where M is singular. */
pk_real pk_passage_sigma(struct pk_integrator *it, pk_real t, const pk_real *q, const pk_real *v);
/* it->where, of a branch that cannot be told: behind all else, and which row. */
size_t pk_passage_told(const struct pk_integrator *it);

#endif

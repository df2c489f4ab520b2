/* Shared by the monitoring of singular positions (near.c) and the step over one (passage.c). */
#ifndef PK_PASSAGE_H
#define PK_PASSAGE_H

#include "../core/project.h"

enum { PK_PASSAGE_STAGES = 8 };

struct pk_passage {
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

struct pk_passage_parts {
    struct pk_passage *is;
    pk_real *q, *v;     /* at the start of the step */
    pk_real *Q, *V, *A; /* at its stages */
    pk_real *q_here, *v_here, *a_here;
    pk_real c[PK_PASSAGE_STAGES], b[PK_PASSAGE_STAGES];
};

struct pk_passage_parts pk_passage_parts(const struct pk_integrator *it);

static inline struct pk_passage *pk_passage_of(const struct pk_integrator *it)
{
    return (struct pk_passage *)(void *)it->own->passage; /* first in its memory */
}

/* Returns sigma at (t, q, v); 1 if M is singular. */
pk_real pk_passage_sigma(struct pk_integrator *it, pk_real t, const pk_real *q, const pk_real *v);
/* Returns it->where for an undetermined branch: after all other indices, plus the row. */
size_t pk_passage_told(const struct pk_integrator *it);

#endif

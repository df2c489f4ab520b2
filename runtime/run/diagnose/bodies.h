/* The particles along a run, which is made again from its start, step by step. */
#ifndef RUN_DIAGNOSE_BODIES_H
#define RUN_DIAGNOSE_BODIES_H

#include "parts.h"

#define BODIES_NONE                                                                  \
    "the kinetic energy is not seen to be a sum of m/2 r'^2 over particles; named, " \
    "it says why"

/* The particles at a state. */
struct bodies {
    struct pk_run *run;
    struct pk_system system; /* the model's, with the event `pericentre` alone, if any */
    struct pk_problem problem;
    struct pk_integrator it; /* which follows them */
    size_t n;
    pk_real *m, *r, *v, *a; /* n, and 3 n each; to be freed: m */
    pk_real *qa, *u;        /* of the coordinates */
    /* Called after each step; and, if there is one, where two are nearest. */
    void (*see)(void *context, struct bodies *b, pk_real t);
    void (*pericentre)(void *context, struct bodies *b, pk_real t);
    void *context;
};

/* At the start. 0: there are none. */
int bodies_begin(struct bodies *b, struct pk_run *run);
/* Through all steps, as far as the run came. */
enum pk_status bodies_follow(struct bodies *b);
/* Of the second from the first of two; of one from the origin. And r.r' of these. */
void bodies_relative(const struct bodies *b, const pk_real *x, pk_real *out);
pk_real bodies_approach(const struct bodies *b);

#endif

/* The particles of a model along a run. The run is integrated again, step by step. */
#ifndef RUN_DIAGNOSE_BODIES_H
#define RUN_DIAGNOSE_BODIES_H

#include "parts.h"

#define BODIES_NONE                                                                  \
    "the kinetic energy is not seen to be a sum of m/2 r'^2 over particles; named, " \
    "it says why"

/* The particles at one state of the run. */
struct bodies {
    struct pk_run *run;
    struct pk_system system; /* the model without its events; `pericentre` may be added */
    struct pk_problem problem;
    struct pk_integrator it; /* integrates the run again */
    size_t n;
    /* masses (n) and components (3 n) of positions r, velocities r' and accelerations r'' */
    pk_real *m, *r, *v, *a;
    pk_real *qa, *u; /* `qa`: accelerations of the coordinates; `u`: values of the inputs */
    /* Callbacks after each step and, if not NULL, at each pericentre. */
    void (*see)(void *context, struct bodies *b, pk_real t);
    void (*pericentre)(void *context, struct bodies *b, pk_real t);
    void *context;
};

/* Sets the particles to the start of the run. Returns 0 if the model has no particles. */
int bodies_begin(struct bodies *b, struct pk_run *run);
/* Repeats all steps to the end of the run. */
enum pk_status bodies_follow(struct bodies *b);
/* x is r, v or a: a vector for each particle. bodies_relative() sets `out` to the second particle's
 * vector minus the first's, or to the vector of a single particle. bodies_approach() returns r.r'
 * of the relative position r and velocity r'. */
void bodies_relative(const struct bodies *b, const pk_real *x, pk_real *out);
pk_real bodies_approach(const struct bodies *b);

#endif

/* A motion of energy h with one degree of freedom, with t held constant: L = M v^2/2 + b v - W,
 * where W is the potential; and its turning points, the roots of h - W. */
#ifndef RUN_DIAGNOSE_WELL_H
#define RUN_DIAGNOSE_WELL_H

#include <pk/integrator.h>

#define TURN (2 * PK_PI)

struct well {
    const struct pk_system *system;
    const void *params;
    pk_real t;
    const pk_real *u;
    pk_real longest;     /* length of the longest panel (interval) of a march */
    pk_real most, least; /* largest h - W on the march; least local minimum of h - W */
};

/* A root of h - W, or a full turn, that a march has found. */
struct end {
    pk_real y; /* distance from the start of the march */
    int turns, found;
};

pk_real force_at(const struct well *w, pk_real q); /* dL/dq at v = 0, which is -dW/dq */
pk_real mass_at(const struct well *w, pk_real q);
pk_real linear_at(const struct well *w, pk_real q); /* b */
/* Integrates the force at q + x over x from a to b, by the Gauss-Legendre rule of order 12. */
pk_real well_work(const struct well *w, pk_real q, pk_real a, pk_real b);
/* Marches from q, where h - W is U, in one direction until h - W is 0 or a turn is complete. */
struct end well_march(struct well *w, pk_real q, pk_real U, pk_real direction);

#endif

/* One degree of freedom with t held: L = M v^2/2 + b v - W, and how far its motion goes. */
#ifndef PK_WELL_H
#define PK_WELL_H

#include <pk/integrator.h>

#define PK_TURN (2 * PK_PI)

struct pk_well {
    const struct pk_system *system;
    const void *params;
    pk_real t;
    const pk_real *u;
    pk_real longest;     /* panel of a march */
    pk_real most, least; /* of h - W on the way: the largest, the smallest where it has a minimum */
};

/* Where h - W is 0, or the whole way round. */
struct pk_end {
    pk_real y; /* from the start */
    int turns, found;
};

pk_real pk_well_force(const struct pk_well *w, pk_real q); /* dL/dq at v = 0, -dW/dq */
pk_real pk_well_mass(const struct pk_well *w, pk_real q);
pk_real pk_well_linear(const struct pk_well *w, pk_real q); /* b */
/* Integral of the force at q + x over x from a to b, by Gauss and Legendre's rule of order 12. */
pk_real pk_well_work(const struct pk_well *w, pk_real q, pk_real a, pk_real b);
/* From q, where h - W is U, in one direction until it is 0. */
struct pk_end pk_well_march(struct pk_well *w, pk_real q, pk_real U, pk_real direction);

#endif

/* What scale.c and rounding.c share: the work of absolute tolerances. */
#ifndef PK_SCALE_H
#define PK_SCALE_H

#include "project.h"

/* 2 n each: tolerances, these without rounding, largest values, whose unit is shared, a state; n
 * each: what rounding does to accelerations, an acceleration, what rounding of momenta does to
 * rates, accelerations beside, two and their noise; and a mass matrix. */
enum { ATOL = 0, OWN = 2, MOST = 4, GROUP = 6, MOVED = 8, NOISE = 10, A, BY_P, BESIDE, PARTS = 16 };

static inline pk_real *part(const struct pk_integrator *it, int which)
{
    return it->own->atol + (size_t)which * it->n;
}

/* Whether there is an acceleration. */
int pk_scale_acceleration(struct pk_integrator *it, pk_real t, const pk_real *q, pk_real *a);
/* NOISE, A and BY_P of the state. */
void pk_scale_look(struct pk_integrator *it);

#endif

/* What scale.c and rounding.c share: the work of absolute tolerances. */
#ifndef PK_SCALE_H
#define PK_SCALE_H

#include "project.h"

/* Of q, then v: tolerances, these without rounding, largest values, whose unit is shared, a state; n
 * each: what rounding does to accelerations, an acceleration, what rounding of momenta does to
 * rates, accelerations beside, two and their noise; and a mass matrix. */
enum { ATOL, OWN, MOST, GROUP, MOVED, NOISE, A, BY_P, BESIDE, PARTS = BESIDE + 3 };

static inline size_t parts_before(size_t n_q, size_t n, int which)
{
    return (size_t)(which < NOISE ? which : NOISE) * n_q + (size_t)which * n;
}

static inline pk_real *part(const struct pk_integrator *it, int which)
{
    return it->own->atol + parts_before(it->n_q, it->n, which);
}

/* Whether there is an acceleration. */
int pk_scale_acceleration(struct pk_integrator *it, pk_real t, const pk_real *q, pk_real *a);
/* NOISE, A and BY_P of the state. */
void pk_scale_look(struct pk_integrator *it);

#endif

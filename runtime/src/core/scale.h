/* Shared by scale.c and rounding.c: the memory of absolute tolerances. */
#ifndef PK_SCALE_H
#define PK_SCALE_H

#include "project.h"

/* Numbers of the arrays in the memory. Arrays of length n_q + n are ATOL: tolerances; OWN:
 * tolerances without those for rounding; MOST: largest values so far; GROUP: for each number the
 * index of the first number of the same unit; MOVED: a state. Arrays of length n are NOISE:
 * rounding errors of accelerations; A: an acceleration; BY_P: rounding errors of rates computed
 * from momenta; BESIDE: three work vectors. A mass matrix is at PARTS. */
enum { ATOL, OWN, MOST, GROUP, MOVED, NOISE, A, BY_P, BESIDE, PARTS = BESIDE + 3 };

static inline size_t parts_before(size_t n_q, size_t n, int which)
{
    return (size_t)(which < NOISE ? which : NOISE) * n_q + (size_t)which * n;
}

static inline pk_real *part(const struct pk_integrator *it, int which)
{
    return it->own->atol + parts_before(it->n_q, it->n, which);
}

/* Computes the acceleration. Returns 0 if it is not defined. */
int pk_scale_acceleration(struct pk_integrator *it, pk_real t, const pk_real *q, pk_real *a);
/* Computes NOISE, A and BY_P (rounding errors and acceleration) for the state. */
void pk_scale_look(struct pk_integrator *it);

#endif

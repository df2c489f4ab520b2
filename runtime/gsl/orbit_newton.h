/* State and functions shared by the files of pk/gsl_orbits.h. Not installed. */
#ifndef PK_GSL_ORBIT_NEWTON_H
#define PK_GSL_ORBIT_NEWTON_H

#include <gsl/gsl_matrix.h>

#include <pk/gsl_orbits.h>

struct closing {
    const struct pk_problem *problem;
    const struct pk_closed_orbits *asked;
    struct pk_integrator it;
    size_t n, d, steps;   /* degrees of freedom, unknowns, steps of the orbit */
    size_t *of;           /* index of unknown k in the 2 n numbers of the state */
    unsigned char *turns; /* unknown k + 2 pi is the same position */
    double h;
    double *y, *end;             /* 2 n: the start, and the state after the steps */
    double *gap, *other, *ahead; /* d: end - y, in boxes, of the start and of two shifted starts */
    double *u;                   /* inputs */
    double *known;               /* 2 n each: states to deflate */
    size_t n_known;
    gsl_matrix *J, *U, *V; /* d(gap)/d(unknowns), d by d; SVD: U d or d + 1 by d, V d by d */
    gsl_vector *singular, *work, *right, *step; /* d, d, d, d or d + 1 (with h) */
};

/* Makes the steps from y and sets x->end; returns 0 if one fails. */
int pk_orbit_advance(struct closing *x, const double *y, double h, size_t steps);
/* Returns b - a of unknown k, in boxes; an angle is taken modulo 2 pi. */
double pk_orbit_apart(const struct closing *x, size_t k, const double *a, const double *b);
/* Changes x->y and x->h until the gap closes, and sets x->J there; returns 0 on failure. */
int pk_orbit_newton(struct closing *x);

#endif

/* What the files of pk/gsl_orbits.h share. Not installed. */
#ifndef PK_GSL_ORBIT_NEWTON_H
#define PK_GSL_ORBIT_NEWTON_H

#include <gsl/gsl_matrix.h>

#include <pk/gsl_orbits.h>

struct closing {
    const struct pk_problem *problem;
    const struct pk_closed_orbits *asked;
    struct pk_integrator it;
    size_t n, d, steps;   /* coordinates, unknowns, steps after which it is to close */
    size_t *of;           /* which of the 2 n numbers unknown k is */
    unsigned char *turns; /* of unknown k: 2 pi further is the same place */
    double h;
    double *y, *end;             /* 2 n: where it begins, and is after the steps */
    double *gap, *other, *ahead; /* d: end - y, in boxes, of this start and two beside it */
    double *u;                   /* inputs */
    double *known;               /* 2 n each: states that are to be left out */
    size_t n_known;
    gsl_matrix *J, *U, *V; /* d by d: of the gap; its singular vectors, d + 1 by d and d by d */
    gsl_vector *singular, *work, *right, *step; /* d, d, d, d + 1 */
};

/* After the steps, in x->end; 0 where one fails. */
int pk_orbit_advance(struct closing *x, const double *y, double h, size_t steps);
/* b - a of an unknown, in boxes, by the shorter way round. */
double pk_orbit_apart(const struct closing *x, size_t k, const double *a, const double *b);
/* From x->y, x->h to where the gap closes; 0 where it does not. x->J is the derivative there. */
int pk_orbit_newton(struct closing *x);

#endif

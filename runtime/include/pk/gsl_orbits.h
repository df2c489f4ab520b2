/* Orbits of a method's step map that close after some steps, and their multipliers: fixed points
 * and 2-cycles that the equations do not have (ghosts), cycles, motions in phase with a drive.
 * Newton's method is applied to the map itself: its derivative by central differences, minimal
 * corrections by singular values (orbits may come in families), known roots deflated. double only;
 * link libpk_gsl.a before libpk.a.
 *
 * A state is q, then v: 2 n numbers. The unknowns are those on which something depends. A closed
 * orbit may advance a cyclic coordinate or a quadrature, and may advance by multiples of 2 pi a
 * coordinate in which the equations have that period.
 *
 * References: P. E. Farrell, A. Birkisson, S. W. Funke, SIAM J. Sci. Comput. 37 (2015) A2026; A. R.
 * Humphries, IMA J. Numer. Anal. 13 (1993) 263 (spurious solutions).
 */
#ifndef PK_GSL_ORBITS_H
#define PK_GSL_ORBITS_H

#include <pk/integrator.h>

PK_BEGIN

struct pk_closed_orbit {
    size_t steps;    /* number of steps after which it first closes */
    double h;        /* step size */
    double *y;       /* its start; then its next states, PK_CLOSED_STATES at most in all */
    double *re, *im; /* multipliers, the largest modulus first */
    int rests;       /* the equations themselves rest there: no ghost */
    double residual; /* of the closing condition, in units of the box */
};
enum { PK_CLOSED_STATES = 4 };

struct pk_closed_orbits {
    const struct pk_method *method; /* if adaptive: orbits of the motion, integrated over h */
    const struct pk_options *options;
    double h;                   /* step size; a first guess if `free` */
    size_t first, last;         /* orbits close after first, first + 1, ..., last steps */
    size_t tries;               /* starts after the given one: Halton's points in the box */
    int free;                   /* h is an unknown too: for a cycle of unknown period */
    const double *middle, *box; /* of each number of a state: box > 0 is its scale */
    size_t most;                /* entries of `list` */
    struct pk_closed_orbit *list;
    size_t count, failed, multipliers; /* orbits; starts without one; multipliers per orbit */
};

/* Returns the numbers that one orbit of n coordinates needs; pk_gsl_orbits() distributes them. */
static inline size_t pk_orbit_size(size_t n) { return (PK_CLOSED_STATES + 2) * 2 * n; }
/* Finds which of the 2 n numbers are unknowns, `of`, and whether each has the period 2 pi, `turns`,
 * each with room for 2 n. Returns the number of unknowns; 0: none, or no memory. */
size_t pk_closed_unknowns(const struct pk_problem *problem, const double *middle, const double *box,
                          size_t *of, unsigned char *turns);
/* Searches from y0 = (q0, v0). `room` has `most` times pk_orbit_size(n) numbers. PK_NO_MEMORY, or
 * the failure of pk_integrator_init(); PK_REFUSED if the system depends on time and the steps are
 * not its period, or h is free. There is no guarantee that all orbits are found. */
enum pk_status pk_gsl_orbits(const struct pk_problem *problem, const double *y0,
                             struct pk_closed_orbits *orbits, double *room);

PK_END

#endif

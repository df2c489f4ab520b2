/* Orbits of a method's step map that close after some steps, and their multipliers: fixed points
 * and 2-cycles that the equations do not have (ghosts), cycles, motions in step with what drives
 * them. By Newton's method on the map itself, its derivative by central differences, least
 * corrections by singular values (orbits may come in families), known roots deflated. double only;
 * link libpk_gsl.a before libpk.a.
 *
 * A state is q, then v: 2 n numbers, of which the unknowns are those on which something depends. A
 * cyclic coordinate, or a state that only sums up, may have gone on; what the equations have in
 * with the period 2 pi may have turned.
 *
 * References: P. E. Farrell, A. Birkisson, S. W. Funke, SIAM J. Sci. Comput. 37 (2015) A2026;
 * A. R. Humphries, IMA J. Numer. Anal. 13 (1993) 263 (spurious solutions).
 */
#ifndef PK_GSL_ORBITS_H
#define PK_GSL_ORBITS_H

#include <pk/integrator.h>

PK_BEGIN

struct pk_closed_orbit {
    size_t steps;    /* after which it closes, and not before */
    double h;        /* of a step */
    double *y;       /* where it begins; then its other states, up to PK_CLOSED_STATES in all */
    double *re, *im; /* multipliers, the largest modulus first */
    int rests;       /* the equations themselves rest there: no ghost */
    double residual; /* of closing, in boxes */
};
enum { PK_CLOSED_STATES = 4 };

struct pk_closed_orbits {
    const struct pk_method *method; /* of variable steps: that of the motion, in one go over h */
    const struct pk_options *options;
    double h;                   /* a step; with `free` a first guess, sought with the state */
    size_t first, last;         /* steps after which orbits close: first, first + 1, ..., last */
    size_t tries;               /* starts beside the given one, Halton's points in the box */
    int free;                   /* h is sought too: of a cycle whose period nobody knows */
    const double *middle, *box; /* of each unknown: the box is the unit it is measured in, > 0 */
    size_t most;                /* room in `list` */
    struct pk_closed_orbit *list;
    size_t count, failed, multipliers; /* found; starts that led nowhere; of each orbit */
};

/* Numbers that one orbit of n coordinates needs at `y`; pk_gsl_orbits() shares them out. */
static inline size_t pk_orbit_size(size_t n) { return (PK_CLOSED_STATES + 2) * 2 * n; }
/* Which of the 2 n numbers are unknowns, and of which of these 2 pi more is the same place: their
 * count. `of` and `turns` have room for 2 n. 0: none, or no memory. */
size_t pk_closed_unknowns(const struct pk_problem *problem, const double *middle, const double *box,
                          size_t *of, unsigned char *turns);
/* Sought from y0 = (q0, v0). `room`: most times pk_orbit_size(n). PK_NO_MEMORY, or what refused
 * the method; PK_REFUSED where it depends on time and the steps are not its period, or h is sought
 * then. That all are found cannot be promised. */
enum pk_status pk_gsl_orbits(const struct pk_problem *problem, const double *y0,
                             struct pk_closed_orbits *orbits, double *room);

PK_END

#endif

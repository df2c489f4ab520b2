/* The particles of a model along a run, with masses m at r, velocities r' and accelerations r''.
 * The run is integrated again, step by step. */
#ifndef RUN_DIAGNOSE_BODIES_H
#define RUN_DIAGNOSE_BODIES_H

#include "../../src/core/attitude.h"
#include "parts.h"

/* The particles at one state of the run. */
struct bodies {
    struct pk_run *run;
    struct pk_system system; /* the model without its events; `pericentre` may be added */
    struct pk_problem problem;
    struct motion motion; /* integrates the run again */
    size_t n;
    /* masses (n) and components (3 n) of positions r, velocities r' and accelerations r'' */
    pk_real *m, *r, *v, *a;
    pk_real *qa, *u; /* `qa`: accelerations of the coordinates; `u`: values of the inputs */
    /* Callbacks after each step and, if not NULL, at each pericentre. */
    void (*see)(void *context, struct bodies *b, pk_real t);
    void (*pericentre)(void *context, struct bodies *b, pk_real t);
    void *context;
};

/* Sets the particles to the start of the run. Returns 0, and says so, for none or over `most`. */
int bodies_begin(struct bodies *b, struct diagnostics *d, size_t most);
/* Repeats all steps to the end of the run. */
enum pk_status bodies_follow(struct bodies *b);
/* A vector for the motion of one particle about the origin, or of the second about the first. */
struct relative {
    pk_real r[3], v[3], a[3];
};
struct relative bodies_relative(const struct bodies *b);

static inline pk_real norm(const pk_real *a) { return PK_F(sqrt)(pk_dot3(a, a)); }

/* Computes the sum of m r x v about the origin, or about the centre of mass with its motion
 * subtracted, and in *size the scale of the sum, the sum of m |r| |v|. r'' as v gives the
 * torque. */
void angular_momentum(size_t n, const pk_real *m, const pk_real *r, const pk_real *v,
                      int about_centre, pk_real L[3], pk_real *size);

/* The Laplace-Runge-Lenz vector divided by the force constant: with r'' = -k r/|r|^3 at the start,
 *
 *     e = r' x (r x r')/k - r/|r|
 *
 * points to the pericentre of the orbit, and |e| is its eccentricity. In a force of 1/r^2 it is
 * constant; in other central forces it turns, in the plane of the initial motion, by `angle`,
 * positive in the direction of the motion and without jumps of 2 pi between updates. Reference: H.
 * Goldstein, C. Poole, J. Safko, Classical Mechanics, 3.9 and 3.12. */
struct lrl {
    pk_real k;
    pk_real e[3], eccentricity, angle; /* values at the last update */
    /* |de/dt| |r|/|r'|, the dimensionless rate of change of e, from the acceleration */
    pk_real rate;
    pk_real along[3], across[3]; /* unit vectors: e at the start, e turned by 90 degrees */
};

/* Returns 0 if the particle is not attracted to the origin. On a circular orbit e is only
 * round-off, so that `angle` is meaningless. */
int lrl_begin(struct lrl *lrl, const struct relative *x);
void lrl_update(struct lrl *lrl, const struct relative *x);

#endif

/* Vectors of particles with masses m at r, with velocities r' and accelerations r'', from the
 * kernel `particles` of struct pk_system: n masses, and x, y, z of each particle. The functions
 * compute the angular momentum, sum of m r x r', and its torque, sum of m r x r''. The
 * Laplace-Runge-Lenz vector of one particle about the origin, or of two about each other, divided
 * by the force constant: with r the vector between the particles, and r'' = -k r/|r|^3 at the
 * start,
 *
 *     e = r' x (r x r')/k - r/|r|
 *
 * points to the pericentre of the orbit, and |e| is its eccentricity. In a force of 1/r^2 it is
 * constant; in other central forces it turns, in the plane of the initial motion, by `angle`,
 * positive in the direction of the motion and without jumps of 2 pi between updates.
 *
 * Reference: H. Goldstein, C. Poole, J. Safko, Classical Mechanics, 3.9 and 3.12. */
#ifndef PK_PARTICLES_H
#define PK_PARTICLES_H

#include <stddef.h>

#include <pk/real.h>
#include <pk/status.h>

PK_BEGIN

/* Computes the sum of m r x v about the origin, or about the centre of mass with its motion
 * subtracted, and in *size the scale of the sum, the sum of m |r| |v|. If r'' is passed as v, the
 * result is the torque. */
void pk_angular_momentum(size_t n, const pk_real *m, const pk_real *r, const pk_real *v,
                         int about_centre, pk_real L[3], pk_real *size);

struct pk_lrl {
    pk_real k;
    pk_real e[3], eccentricity, angle; /* values at the last update */
    /* |de/dt| |r|/|r'|, the dimensionless rate of change of e, from the acceleration; 0 if e is
     * constant */
    pk_real rate;
    pk_real along[3], across[3]; /* unit vectors: e at the start, e turned by 90 degrees */
};

/* PK_REFUSED: the particle is not attracted to the origin. On a circular orbit e is only round-off,
 * so that `angle` is meaningless. */
enum pk_status pk_lrl_init(struct pk_lrl *lrl, const pk_real r[3], const pk_real v[3],
                           const pk_real a[3]);
void pk_lrl_update(struct pk_lrl *lrl, const pk_real r[3], const pk_real v[3], const pk_real a[3]);

PK_END

#endif

/* Vectors of particles with masses m at r, with velocities r' and accelerations r'', from the
 * kernel `particles` of struct pk_system: n masses, and x, y, z of each particle.
 *
 * The angular momentum, sum of m r x r', and its torque, sum of m r x r''. The Laplace-Runge-Lenz
 * vector of one particle about the origin, or of two about each other, divided by its force
 * constant: with r from one to the other, and r'' = -k r/|r|^3 at the start,
 *
 *     e = r' x (r x r')/k - r/|r|
 *
 * points to the pericentre, and |e| is the eccentricity. In a force of 1/r^2 it is constant; in a
 * similar force it turns, in the plane of the start, by `angle`, positive in the direction of the
 * motion and unwrapped from one update to the next.
 *
 * Reference: H. Goldstein, C. Poole, J. Safko, Classical Mechanics, 3.9 and 3.12.
 */
#ifndef PK_PARTICLES_H
#define PK_PARTICLES_H

#include <stddef.h>

#include <pk/real.h>
#include <pk/status.h>

PK_BEGIN

/* Computes the sum of m r x v, about the origin or the centre of mass (its own motion subtracted),
 * and in *size its scale, the sum of m |r| |v|. With r'' in place of v: the torque. */
void pk_angular_momentum(size_t n, const pk_real *m, const pk_real *r, const pk_real *v,
                         int about_centre, pk_real L[3], pk_real *size);

struct pk_lrl {
    pk_real k;
    pk_real e[3], eccentricity, angle; /* current values */
    pk_real rate; /* |e'| |r|/|r'|, by the acceleration, not by steps: 0 if e is constant */
    pk_real along[3], across[3]; /* direction of e at the start, and a quarter turn ahead */
};

/* PK_REFUSED if the particle is not attracted to the origin. For a circle e is round-off, and
 * `angle` is meaningless. */
enum pk_status pk_lrl_init(struct pk_lrl *lrl, const pk_real r[3], const pk_real v[3],
                           const pk_real a[3]);
void pk_lrl_update(struct pk_lrl *lrl, const pk_real r[3], const pk_real v[3], const pk_real a[3]);

PK_END

#endif

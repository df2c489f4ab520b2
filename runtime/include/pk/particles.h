/* What is known of particles of masses m at r, with velocities r' and accelerations r'', as
 * struct pk_system has them in its kernel `particles`: n masses, and x, y, z of each.
 *
 * Angular momentum, sum of m r x r', and its torque, sum of m r x r''. The vector of Laplace, Runge
 * and Lenz of one particle about the origin, or of two about each other, over its force: with r of
 * one from the other, r'' = -k r/|r|^3 at the start,
 *
 *     e = r' x (r x r')/k - r/|r|
 *
 * points to the pericentre and is as long as the orbit is eccentric. In a force of 1/r^2 it is
 * constant; in one that is nearly so it turns, in the plane of the start, by `angle`, counted the
 * way of the motion and unwrapped from one update to the next.
 *
 * Reference: H. Goldstein, C. Poole, J. Safko, Classical Mechanics, 3.9 and 3.12.
 */
#ifndef PK_PARTICLES_H
#define PK_PARTICLES_H

#include <stddef.h>

#include <pk/real.h>
#include <pk/status.h>

PK_BEGIN

/* Sum of m r x v, about the origin or the centre of mass (its own motion taken away), and what it
 * is to be compared with, the sum of m |r| |v|. With r'' in the place of v the torque. */
void pk_angular_momentum(size_t n, const pk_real *m, const pk_real *r, const pk_real *v,
                         int about_centre, pk_real L[3], pk_real *size);

struct pk_lrl {
    pk_real k;
    pk_real e[3], eccentricity, angle; /* now */
    pk_real rate; /* |e'| |r|/|r'|: 0 where e is constant, by the acceleration and not by steps */
    pk_real along[3], across[3]; /* of e at the start, and a quarter turn on */
};

/* PK_REFUSED: what is at r is not drawn to the origin. Of a circle, where e is round-off, `angle`
 * means nothing. */
enum pk_status pk_lrl_init(struct pk_lrl *lrl, const pk_real r[3], const pk_real v[3],
                           const pk_real a[3]);
void pk_lrl_update(struct pk_lrl *lrl, const pk_real r[3], const pk_real v[3], const pk_real a[3]);

PK_END

#endif

/* Complete elliptic integrals of parameter m = k^2, by the arithmetic-geometric mean:
 *
 *     K(m) = integral of 1/sqrt(1 - m sin^2 s)  over s from 0 to pi/2
 *     E(m) = integral of   sqrt(1 - m sin^2 s)
 *
 * and from them periods and actions of the pendulum theta'' = -omega0^2 sin theta: periods in units
 * of 1/omega0, actions (1/2 pi) closed integral of p dtheta in units of m l^2 omega0. A motion is
 * given by its amplitude, or by its energy above the upright rest in units of m l^2 omega0^2: from
 * -2, hanging at rest, to 0 it swings, above 0 it rotates. At 0 the period is infinite, and the
 * action is that of the swings, 8/pi; the action of a rotation tends to half of that, 4/pi.
 *
 * Reference: M. Abramowitz, I. Stegun, Handbook of Mathematical Functions, 17.3 and 17.6.
 */
#ifndef PK_ELLIPTIC_H
#define PK_ELLIPTIC_H

#include <pk/begin.h>
#include <pk/real.h>

PK_BEGIN

struct pk_elliptic {
    pk_real k, e;
    pk_real b; /* E - (1 - m) K, computed without its cancellation at small m */
};

/* For m <= 1 and its complement 1 - m, both given, since near m = 1 the difference has no digits.
 * K(1) is infinite; for m > 1 all results are NaN. */
void pk_elliptic_find(pk_real m, pk_real complement, struct pk_elliptic *found);
pk_real pk_elliptic_k(pk_real m);
pk_real pk_elliptic_e(pk_real m);

pk_real pk_pendulum_period(pk_real amplitude); /* in radians, below pi */
pk_real pk_pendulum_action(pk_real amplitude);
/* `above`: energy above the upright rest. The period of a rotation is that of one turn. */
pk_real pk_pendulum_energy_period(pk_real above);
pk_real pk_pendulum_energy_action(pk_real above);

PK_END

#endif

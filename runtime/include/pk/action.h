/* Action and period of a motion of one degree of freedom, at the energy of a given state and with t
 * held fixed:
 *
 *     J = (1/2 pi) closed integral of p dq,     T = closed integral of dq/v = 2 pi dJ/dh,
 *
 * for L = M(q) v^2/2 + b(q) v - W(q), where p = M v + b and h is the energy. The motion oscillates
 * between two positions with v = 0 (libration), or q grows by 2 pi in each period if the equations
 * have the period 2 pi in q (rotation). For a libration, with q = middle + amplitude sin s, the
 * integrands are smooth and periodic in s; for a rotation they are smooth and periodic in q. Sums
 * over equidistant nodes then converge geometrically: the number of nodes is doubled until the
 * result converges. The kinetic energy at q, h - W, is computed by integrating from the ends of the
 * libration, where it is 0, so that no digits are lost for small librations.
 *
 * If L depends on time slowly, J is an adiabatic invariant of the motion.
 *
 * References: L. Landau, E. Lifshitz, Mechanics, 49 and 50; L. N. Trefethen, J. A. C. Weideman, The
 * exponentially convergent trapezoidal rule, SIAM Rev. 56 (2014) 385. */
#ifndef PK_ACTION_H
#define PK_ACTION_H

#include <pk/integrator.h>

PK_BEGIN

#define PK_ORBITS(X)                                                                      \
    X(PK_ORBIT_LIBRATION, "to and fro")                                                   \
    X(PK_ORBIT_ROTATION, "round and round")                                               \
    X(PK_ORBIT_EQUILIBRIUM, "at rest in an equilibrium: it has no orbit")                 \
    X(PK_ORBIT_SEPARATRIX, "on a separatrix, as far as rounding tells: it never returns") \
    X(PK_ORBIT_UNBOUNDED, "not periodic: it goes to infinity or into a singularity")      \
    X(PK_ORBIT_UNSETTLED, "not smooth enough for the sums to settle")                     \
    X(PK_ORBIT_SEVERAL, "not of one degree of freedom")                                   \
    X(PK_ORBIT_NOT_QUADRATIC, "of an L that is not of second degree in the rate")         \
    X(PK_ORBIT_NO_KERNELS, "compiled without its kernels gradient, mass and canonical")

enum pk_orbit { PK_ORBITS(PK_EACH_NAME) PK_ORBIT_COUNT };

struct pk_action {
    enum pk_orbit orbit;
    pk_real action, period;
    pk_real lo, hi; /* the two positions between which a libration oscillates */
    /* estimated relative error of action and period: their change when the number of nodes was
     * doubled last; near a separatrix it includes the effect of rounding of the energy */
    pk_real error;
    size_t nodes;
};

/* Computes action and period of the motion through (q, v) at t. u: inputs, or NULL. PK_REFUSED: the
 * action of this motion is not defined or cannot be computed; found->orbit is the reason. */
enum pk_status pk_action_find(struct pk_action *found, const struct pk_problem *problem, pk_real t,
                              const pk_real *q, const pk_real *v, const pk_real *u);
const char *pk_orbit_text(enum pk_orbit orbit);

PK_END

#endif

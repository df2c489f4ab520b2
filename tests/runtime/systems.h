/* Systems written by hand from textbooks, independent of the generator, as the runtime's tests
 * need them. All share one struct of parameters.
 */
#ifndef TEST_SYSTEMS_H
#define TEST_SYSTEMS_H

#include <pk/subsystems.h>

struct test_params {
    pk_real g;           /* gravity, or the oscillator's omega^2, or mu */
    pk_real limit;       /* where `broken` and `folded` break */
    pk_real hoisted[40]; /* as many as a model's, of what depends on parameters alone */
};

/* The arguments of a kernel, and what says that it does not read them all. */
#define ARGS const void *params, pk_real t, const pk_real *q, const pk_real *v, const pk_real *u
#define UNUSED ((void)params, (void)t, (void)q, (void)v, (void)u)

/* theta'' = -g sin theta, separable. */
extern const struct pk_system pendulum_system;
/* q'' = -g q. */
extern const struct pk_system oscillator_system;
/* q'' = -g (q + q^3): what grows, grows to what is no number. */
extern const struct pk_system stiffening_system;
/* Two unit masses on unit rods (textbook formulas), M(q). */
extern const struct pk_system double_pendulum_system;
/* Planar Kepler, Cartesian. */
extern const struct pk_system kepler_system;
/* Restricted three bodies in the rotating frame, a closed orbit; HNW II.0 (0.1)-(0.2). For explicit
 * methods alone: only its acceleration is its own. */
extern const struct pk_system arenstorf_system;
/* L = -sqrt(1 - v^2) - g q^2/2: M(v) = (1 - v^2)^(-3/2). */
extern const struct pk_system relativistic_system;
/* M = limit - q, L = M v^2/2: singular where q reaches limit; q moves on if not seen. */
extern const struct pk_system folded_system;
/* a = sqrt(limit - t): no number after t = limit. */
extern const struct pk_system broken_system;
/* q'' = -g q + cos(3 t), exact: see driven_exact(). Separable, not autonomous. */
extern const struct pk_system driven_system;
void driven_exact(pk_real t, pk_real *q, pk_real *v);
/* L = exp(t/2) (1 + q^2) v^2/2 - g cos(t) q^2/2, D = .3 (2 + cos t) v^2/2,
 * Q = .2 sin(3 t) - v^3/9: explicit time everywhere, M(q), forces without a Lagrangian. */
extern const struct pk_system forced_system;
/* q'' = g (1 - q^2) q' - q. */
extern const struct pk_system van_der_pol_system;
/* A pendulum and a mass, between them a spring g and a damper `limit`. */
extern const struct pk_system damped_system;
/* L = M(t) v^2/2 with M = 1 but about t = limit, where M < 0: p is constant. */
extern const struct pk_system dipping_system;
/* Planar Kepler as its radius alone, g the square of the angular momentum; and with its angle, a
 * state that nothing reads, which starts at .25: once round in 2 pi. */
extern const struct pk_system radial_system, turning_system;
/* q'' = -limit q; and both it and the pendulum, which can be integrated apart alone. */
extern const struct pk_system spring_system, pair_system;
extern const struct pk_part pair_parts[2];
/* The Brusselator, of two states; a pendulum held back by a Maxwell element, which is a state. */
extern const struct pk_system brusselator_system, maxwell_system;
/* A bead before a hill of .8 at 1.3, `limit` wide, which is a mark. */
extern const struct pk_system barred_system;
/* q'' = u: an input. */
extern const struct pk_system pushed_system;

/* Of systems_rotation.c: one body that is free, I = (1, 2, 3); a heavy symmetric top; two bodies in
 * free space; a coordinate beside a body, with M(R), drag, and forces of time. */
extern const struct pk_system free_body_system, metered_system, top_system, bodies_system,
    carriage_system;
/* Of systems_swift.c: a relativistic charge on a rod. */
extern const struct pk_system swift_system;
/* Of systems_constraint.c: a mass on a rod, on a circle through 0, with the rod twice over; two on
 * rods; a bead on a wire that is turned; the top as a free body held at a point; Chaplygin's
 * sleigh; a ball that rolls on a turntable. */
extern const struct pk_system rod_system, circle_system, twice_system, rods_system, wire_system,
    jointed_system;
extern const struct pk_system sleigh_system, ball_system;

#endif

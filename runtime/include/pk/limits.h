/* What a method does to linear equations: the map of one step on the oscillator, and how long a
 * step may be.
 *
 *     q'' = -q  in a step of y = h omega:   (q1, v1) = map (q0, v0), row by row
 *     u' = -u   in a step of z:             u1 = R(-z) u0
 *
 * The limit on the imaginary axis is the end of the first interval 0 < y < limit where the powers
 * of the map stay bounded: |R(iy)| <= 1 for Runge-Kutta methods, |trace| <= 2 for compositions of
 * shears, whose determinant is 1. A double eigenvalue at an isolated point does not end it if both
 * eigenvalues stay on the unit circle. The limit on the real axis is that of |R(-z)| <= 1. It is 0
 * where any step grows, infinite where none does, and no number (x != x) where the question has no
 * answer: a splitting method takes no damping, a method of variable order has no one map, and GSL
 * keeps its tables. An adaptive method's is its formula's, at a fixed step.
 *
 * Of methods that are tables, explicit Runge-Kutta and splitting, limits are roots of polynomials
 * made from the table, good to some 100 PK_EPSILON. Of all others the step itself is run on the
 * equation and its map read off; growth below 1e-10 a step (in float, 1e-3) is not seen then, a
 * limit is as good as that growth tells, and "infinite" means: none found up to 1e4. That is exact
 * for the A-stable ones and for those of determinant 1.
 *
 * Reference: E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, IV.2; R. I.
 * McLachlan, S. K. Gray, Appl. Numer. Math. 25 (1997) 275.
 */
#ifndef PK_LIMITS_H
#define PK_LIMITS_H

#include <pk/method.h>

PK_BEGIN

enum pk_axis { PK_AXIS_IMAGINARY, PK_AXIS_REAL };

pk_real pk_method_limit(const struct pk_method *method, enum pk_axis axis);

/* The first interval at or above `from` where steps grow, infinite numbers where there is none: the
 * limit is the first number from 0. Growth may end again: blanes_moan6 grows from 3.14143 to
 * 3.14232 by 4e-4 a step, where two steps are one period, and then from 6.3479 on only. Returns 0
 * where the limit is no number. */
int pk_method_growth(const struct pk_method *method, enum pk_axis axis, pk_real from,
                     pk_real growth[2]);

/* The map of one step, y > 0. PK_REFUSED where there is none, or what the step failed of. */
enum pk_status pk_method_oscillator(const struct pk_method *method, pk_real y, pk_real map[4]);
/* The same of q'' = -stiffness q - damping q', h > 0, always by the step itself. */
enum pk_status pk_method_spring(const struct pk_method *method, pk_real stiffness, pk_real damping,
                                pk_real h, pk_real map[4]);
/* R(-z) of u' = -u, z > 0; the same statuses. */
enum pk_status pk_method_decay(const struct pk_method *method, pk_real z, pk_real *factor);

/* The larger modulus of a map's eigenvalues: what a step multiplies amplitudes by. */
pk_real pk_map_growth(const pk_real map[4]);
/* The angle that a step turns by, in [0, pi]; 0 or pi where the eigenvalues are real. Of a method's
 * map at y < pi, angle / y is its own frequency over the true one. */
pk_real pk_map_angle(const pk_real map[4]);

PK_END

#endif

/* Linear stability of a method: the map of one step on the oscillator, and how long a step may be.
 *
 *     q'' = -q  in a step of y = h omega:   (q1, v1) = map (q0, v0), map row-major
 *     u' = -u   in a step of z:             u1 = R(-z) u0
 *
 * The limit on the imaginary axis is the end of the first interval 0 < y < limit in which the
 * powers of the map stay bounded: |R(iy)| <= 1 for Runge-Kutta methods, |trace| <= 2 for
 * compositions of shears, whose determinant is 1. A double eigenvalue at an isolated y does not end
 * the interval if both eigenvalues stay on the unit circle. The limit on the real axis is the end
 * of the first interval with |R(-z)| <= 1. A limit is 0 if steps of any size amplify, infinite if
 * none does, and NaN if it is undefined: splitting methods do not apply to damping, methods of
 * variable order have no single map, and the tables of GSL's methods are private. The limit of an
 * adaptive method is the limit of its formula with a fixed step size.
 *
 * For explicit Runge-Kutta and splitting methods limits are roots of polynomials made from the
 * table, accurate to about 100 PK_EPSILON. For all other methods the map is computed by steps on
 * the equation. Amplification by less than 1e-10 per step (1e-3 in float) is then not detected,
 * which limits the accuracy of the limits. A limit is reported as infinite if no amplification was
 * found up to y or z = 1e4. They are exact for A-stable methods and maps of determinant 1.
 *
 * Reference: E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, IV.2; R. I.
 * McLachlan, S. K. Gray, Appl. Numer. Math. 25 (1997) 275. */
#ifndef PK_LIMITS_H
#define PK_LIMITS_H

#include <pk/method.h>

PK_BEGIN

enum pk_axis { PK_AXIS_IMAGINARY, PK_AXIS_REAL };

pk_real pk_method_limit(const struct pk_method *method, enum pk_axis axis);

/* Writes the first interval with lower end >= from in which steps amplify, infinite numbers if
 * there is no such interval. With from = 0 the lower end of the interval is the limit on the
 * imaginary axis. The interval may be short: blanes_moan6 amplifies by 4e-4 a step from 3.14143 to
 * 3.14232, where two steps are one period, then from 6.3479 on. Returns 0 if the limit is NaN. */
int pk_method_growth(const struct pk_method *method, enum pk_axis axis, pk_real from,
                     pk_real growth[2]);

/* Computes the map of one step of size y > 0 for q'' = -q. Returns PK_REFUSED if the method has no
 * map, or the status of the step if it fails. */
enum pk_status pk_method_oscillator(const struct pk_method *method, pk_real y, pk_real map[4]);
/* Computes the map of a step of size h > 0 for q'' = -stiffness q - damping q'. This function
 * always makes a step of the method. */
enum pk_status pk_method_spring(const struct pk_method *method, pk_real stiffness, pk_real damping,
                                pk_real h, pk_real map[4]);
/* Computes R(-z) for u' = -u, z > 0. Returns the statuses of pk_method_oscillator(). */
enum pk_status pk_method_decay(const struct pk_method *method, pk_real z, pk_real *factor);

/* Returns the larger modulus of a map's eigenvalues, the amplification in a step. */
pk_real pk_map_growth(const pk_real map[4]);
/* Returns the rotation angle of a map, in [0, pi]; 0 or pi if the eigenvalues are real. For a
 * method's map at y < pi, angle / y is the ratio of its frequency to the true one. */
pk_real pk_map_angle(const pk_real map[4]);

PK_END

#endif

/* Unit quaternions Q = (w, x, y, z), which rotate from body to space: products, rotations of
 * vectors, and updates by the rotation in a step. Outputs may alias inputs. For half a step, x = h
 * omega/2, the Cayley quaternion is
 *
 *     c = (1, y)/sqrt(1 + |y|^2),  y = x/2;    its square: c^2 = ((1 - |y|^2), 2 y)/(1 + |y|^2),
 *
 * which is rational. Functions named _added compute the increment of a vector or quaternion, so
 * that the caller can add it with a compensated sum. References: A. Iserles, H. Munthe-Kaas, S. P.
 * Norsett, A. Zanna, Acta Numerica 9 (2000) 215, 8.3; N. Bou-Rabee, J. E. Marsden, Found. Comput.
 * Math. 9 (2009) 197. */
#ifndef PK_ATTITUDE_H
#define PK_ATTITUDE_H

#include <pk/step/state.h>

static inline pk_real pk_dot3(const pk_real *a, const pk_real *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void pk_cross(const pk_real *a, const pk_real *b, pk_real *out)
{
    const pk_real x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
    out[0] = x;
    out[1] = y;
}

/* Computes out = Q (s, u), the product of Q and the quaternion of scalar s and vector u. */
static inline void pk_quaternion_times(const pk_real *Q, pk_real s, const pk_real *u, pk_real *out)
{
    const pk_real w = s * Q[0] - (Q[1] * u[0] + Q[2] * u[1] + Q[3] * u[2]);
    const pk_real x = s * Q[1] + (Q[0] * u[0] + (Q[2] * u[2] - Q[3] * u[1]));
    const pk_real y = s * Q[2] + (Q[0] * u[1] + (Q[3] * u[0] - Q[1] * u[2]));
    out[3] = s * Q[3] + (Q[0] * u[2] + (Q[1] * u[1] - Q[2] * u[0]));
    out[0] = w;
    out[1] = x;
    out[2] = y;
}

/* Computes d = R p - p, where R is the rotation of the quaternion (s, u). */
static inline void pk_turn_added(pk_real s, const pk_real *u, const pk_real *p, pk_real *d)
{
    pk_real one[3], two[3];
    pk_cross(u, p, one);
    pk_cross(u, one, two);
    for (int i = 0; i < 3; i++)
        d[i] = 2 * (s * one[i] + two[i]);
}

/* Rotates p by the Cayley quaternion c (see above), out = cay(2 y) p; sign = -1: by its inverse. */
static inline void pk_cayley_turn(const pk_real *y, int sign, const pk_real *p, pk_real *out)
{
    const pk_real weight = 2 / (1 + pk_dot3(y, y));
    pk_real one[3], two[3];
    pk_cross(y, p, one);
    pk_cross(y, one, two);
    for (int i = 0; i < 3; i++)
        out[i] = p[i] + weight * ((sign > 0 ? one[i] : -one[i]) + two[i]);
}

/* Computes the increment of Q by exp(theta), theta a rotation vector. With a half the angle of
 * rotation, it needs sin(a)/a and cos(a) - 1; the latter from sin(a/2), without cancellation. */
static inline void pk_exponential_added(const pk_real *Q, const pk_real *theta, pk_real *d)
{
    const pk_real angle = PK_F(sqrt)(pk_dot3(theta, theta)) / 2, quarter = PK_F(sin)(angle / 2);
    const pk_real sinc = angle > 0 ? PK_F(sin)(angle) / angle : 1;
    const pk_real u[3] = {sinc * theta[0] / 2, sinc * theta[1] / 2, sinc * theta[2] / 2};
    pk_quaternion_times(Q, -2 * quarter * quarter, u, d);
}

/* Computes theta' for the attitude R0 exp(theta) and body rates omega, by the inverse of d(exp),
 *
 *     omega + theta x omega/2 + (1 - x cot x)/(4 x^2) theta x (theta x omega),  x = |theta|/2.
 *
 * The last coefficient is 1/12 + s/720 + s^2/30240 + s^3/1209600 + ..., s = |theta|^2; this series
 * is used where its first omitted term, s^4/1209600 relative to omega, is below round-off. */
static inline void pk_dexp_inverse(const pk_real *theta, const pk_real *omega, pk_real *out)
{
    const pk_real s = pk_dot3(theta, theta), x = PK_F(sqrt)(s) / 2;
    const pk_real weight = s * s * s * s > PK_C(1e6) * PK_EPS
                               ? (1 - x * PK_F(cos)(x) / PK_F(sin)(x)) / s
                               : PK_C(1.0) / 12 + s * (PK_C(1.0) / 720 + s / 30240);
    pk_real one[3], two[3];
    pk_cross(theta, omega, one);
    pk_cross(theta, one, two);
    for (int i = 0; i < 3; i++)
        out[i] = omega[i] + one[i] / 2 + weight * two[i];
}

/* Copies `count` numbers from[0], from[step], from[2 step], ... */
static inline void pk_gather(pk_real *to, const pk_real *from, size_t count, size_t step)
{
    for (size_t k = 0; k < count; k++)
        to[k] = from[k * step];
}

/* Normalises Q if its norm differs from 1 by more than a few roundings, and then clears the
 * compensations `low` (NULL: none) of its sums. Entries are at distances `stride`. Returns 1 if Q
 * was scaled, 0 if not; -1, with Q unchanged, if its square underflows or is not finite. */
static inline int pk_normalise(pk_real *Q, pk_real *low, size_t stride)
{
    pk_real norm2 = 0;
    for (size_t i = 0; i < 4; i++)
        norm2 += Q[i * stride] * Q[i * stride];
    if (pk_abs(norm2 - 1) <= 8 * PK_EPS)
        return 0;
    if (!(norm2 > PK_TINY) || !pk_finite(norm2))
        return -1;
    const pk_real scale = 1 / PK_F(sqrt)(norm2);
    for (size_t i = 0; i < 4; i++) {
        Q[i * stride] *= scale;
        if (low)
            low[i * stride] = 0;
    }
    return 1;
}

#endif

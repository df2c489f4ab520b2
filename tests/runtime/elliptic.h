/* Closed forms for tests: the pendulum theta'' = -sin theta by complete elliptic integrals K and E
 * of m, from the arithmetic-geometric mean. With a_0 = 1, b_0 = sqrt(1 - m), c_0^2 = m and
 *
 *     a_n+1 = (a_n + b_n)/2,  b_n+1 = sqrt(a_n b_n),  c_n+1 = (a_n - b_n)/2 = c_n^2/(4 a_n+1)
 *
 *     K = pi/(2 a),   E = K (1 - S),   E - (1 - m) K = K (m - S),   S = sum of 2^(n-1) c_n^2
 *
 * (Abramowitz, Stegun 17.6.3 and 17.6.4). Near m = 1, where both differences cancel, Legendre's
 * relation (17.3.13) is a sum, with K' and S' of 1 - m: E = pi/(2 K') + K S'.
 */
#ifndef TEST_ELLIPTIC_H
#define TEST_ELLIPTIC_H

#include <math.h>

struct elliptic {
    double k, e, b; /* b: E - (1 - m) K */
};

/* Returns K; *rest is S without its first term m/2. */
static double means(double m, double complement, double *rest)
{
    double a = 1, b = sqrt(complement), c = m / (2 * (1 + b)), weight = 1;
    *rest = 0;
    for (int n = 1; n < 64; n++, weight *= 2) {
        const double mean = (a + b) / 2;
        b = sqrt(a * b);
        a = mean;
        *rest += weight * c * c;
        c = c * c / (2 * (a + b));
    }
    return 3.14159265358979323846 / (2 * a);
}

static struct elliptic elliptic(double m, double complement)
{
    double rest, other;
    const double k = means(m, complement, &rest), k1 = means(complement, m, &other);
    const double legendre = 3.14159265358979323846 / (2 * k1);
    if (complement >= 0.125)
        return (struct elliptic){k, k * (1 - m / 2 - rest), k * (m / 2 - rest)};
    return (struct elliptic){k, legendre + k * (complement / 2 + other),
                             legendre + k * (other - complement / 2)};
}

static double pendulum_period(double amplitude)
{
    return 4 * elliptic(pow(sin(amplitude / 2), 2), pow(cos(amplitude / 2), 2)).k;
}

static double pendulum_action(double amplitude)
{
    const double pi = 3.14159265358979323846;
    return 8 / pi * elliptic(pow(sin(amplitude / 2), 2), pow(cos(amplitude / 2), 2)).b;
}

/* Of a rotation, by its energy above the upright rest. */
static double turn_period(double above)
{
    return 2 * sqrt(2 / (2 + above)) * elliptic(2 / (2 + above), above / (2 + above)).k;
}

static double turn_action(double above)
{
    const double pi = 3.14159265358979323846, root = sqrt(2 / (2 + above));
    return 4 / (pi * root) * elliptic(2 / (2 + above), above / (2 + above)).e;
}

#endif

/* Complete elliptic integrals; see pk/elliptic.h. With a_0 = 1, b_0 = sqrt(1 - m), c_0^2 = m and
 *
 *     a_n+1 = (a_n + b_n)/2,  b_n+1 = sqrt(a_n b_n),  c_n+1 = (a_n - b_n)/2 = c_n^2/(4 a_n+1)
 *
 *     K = pi/(2 a),   E = K (1 - S),   E - (1 - m) K = K (m - S),   S = sum of 2^(n-1) c_n^2
 *
 * (Abramowitz, Stegun 17.6.3 and 17.6.4). Near m = 1 both differences cancel. There Legendre's
 * relation (17.3.13) is a sum, with K' and S' of 1 - m: E = pi/(2 K') + K S'.
 */
#include <pk/elliptic.h>

enum { MOST = 64 };      /* iterations; once b is near a each doubles the digits */
#define NEAR PK_C(0.125) /* 1 - m below which E is found by Legendre's relation */

/* Returns K; *rest is S without its first term m/2. */
static pk_real means(pk_real m, pk_real complement, pk_real *rest)
{
    pk_real a = 1, b = PK_F(sqrt)(complement), weight = 1;
    pk_real c = m / (2 * (1 + b));
    *rest = 0;
    for (int n = 1; n < MOST; n++, weight *= 2) {
        const pk_real mean = (a + b) / 2;
        b = PK_F(sqrt)(a * b);
        a = mean;
        *rest += weight * c * c;
        if (PK_F(fabs)(c) <= PK_EPSILON * a)
            break;
        c = c * c / (2 * (a + b));
    }
    return PK_PI / (2 * a);
}

void pk_elliptic_find(pk_real m, pk_real complement, struct pk_elliptic *found)
{
    pk_real rest, other;
    found->k = means(m, complement, &rest);
    if (complement >= NEAR || !(complement > 0)) {
        found->e = found->k * (1 - m / 2 - rest);
        found->b = found->k * (m / 2 - rest);
    } else {
        const pk_real k = means(complement, m, &other);
        found->e = PK_PI / (2 * k) + found->k * (complement / 2 + other);
        found->b = PK_PI / (2 * k) + found->k * (other - complement / 2);
    }
    if (!(complement > 0 || complement < 0)) {
        found->k = m / complement; /* infinite; NaN for NaN */
        found->e = found->b = m;
    }
}

pk_real pk_elliptic_k(pk_real m)
{
    struct pk_elliptic found;
    pk_elliptic_find(m, 1 - m, &found);
    return found.k;
}

pk_real pk_elliptic_e(pk_real m)
{
    struct pk_elliptic found;
    pk_elliptic_find(m, 1 - m, &found);
    return found.e;
}

/* Swings: m = sin^2 of half the amplitude, period 4 K, action (8/pi) (E - (1 - m) K). */
static struct pk_elliptic swing(pk_real amplitude)
{
    struct pk_elliptic found;
    if (!(PK_F(fabs)(amplitude) < PK_PI)) { /* no swing: m > 1, where all is NaN */
        pk_elliptic_find(2, -1, &found);
        return found;
    }
    const pk_real s = PK_F(sin)(amplitude / 2), c = PK_F(cos)(amplitude / 2);
    pk_elliptic_find(s * s, c * c, &found);
    return found;
}

pk_real pk_pendulum_period(pk_real amplitude) { return 4 * swing(amplitude).k; }
pk_real pk_pendulum_action(pk_real amplitude) { return 8 / PK_PI * swing(amplitude).b; }

/* Below the energy of the upright rest m = 1 + above/2. Above it 1/m takes the place of m: theta' =
 * 2 sqrt(1/m) sqrt(1 - m sin^2(theta/2)), so that the period is 2 sqrt(m) K and the action 4 E/(pi
 * sqrt(m)). */
static pk_real by_energy(pk_real above, struct pk_elliptic *found)
{
    if (above <= 0) {
        if (above < -2) /* below the least energy */
            pk_elliptic_find(2, -1, found);
        else
            pk_elliptic_find(1 + above / 2, PK_F(fabs)(above) / 2, found);
        return 0;
    }
    pk_elliptic_find(2 / (2 + above), above / (2 + above), found);
    return PK_F(sqrt)(2 / (2 + above));
}

pk_real pk_pendulum_energy_period(pk_real above)
{
    struct pk_elliptic found;
    const pk_real root = by_energy(above, &found);
    return root > 0 ? 2 * root * found.k : 4 * found.k;
}

pk_real pk_pendulum_energy_action(pk_real above)
{
    struct pk_elliptic found;
    const pk_real root = by_energy(above, &found);
    return root > 0 ? 4 * found.e / (PK_PI * root) : 8 / PK_PI * found.b;
}

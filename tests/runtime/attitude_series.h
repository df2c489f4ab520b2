/* The formulas of attitude.h against their series, in any scalar type: the largest error of exp and
 * of the inverse of d(exp), in units of PK_EPS, for angles from 7 * 2^(-k/2), k >= first, down to
 * the smallest. Seven Bernoulli numbers |B_2k|/(2k)! of the second are enough to an angle of 1/8 in
 * double, of 1/64 in __float128.
 */
#ifndef TEST_ATTITUDE_SERIES_H
#define TEST_ATTITUDE_SERIES_H

#include "core/attitude.h"

static pk_real series_of_exp(const pk_real *theta, pk_real angle)
{
    static const pk_real one[] = {1, 0, 0, 0};
    const pk_real a2 = angle * angle / 4;
    pk_real d[4], sinc = 1, cosine = 1, worst;
    for (int k = 12; k > 0; k--) {
        sinc = 1 - a2 / (2 * k * (2 * k + 1)) * sinc;
        cosine = 1 - a2 / ((2 * k + 1) * (2 * k + 2)) * cosine;
    }
    pk_exponential_added(one, theta, d);
    worst = a2 > PK_TINY / PK_EPS ? pk_abs(d[0] / (-a2 / 2 * cosine) - 1) : pk_abs(d[0]);
    for (int i = 0; i < 3; i++)
        worst = pk_max(worst, pk_abs(d[1 + i] / (sinc * theta[i] / 2) - 1));
    return worst / PK_EPS;
}

static pk_real series_of_dexp(const pk_real *theta, pk_real angle)
{
    static const pk_real below[] = {
        12, 720, 30240, 1209600, 47900160, PK_C(1307674368000.0) / 691, PK_C(74724249600.0)};
    static const pk_real omega[] = {PK_C(0.75), PK_C(-0.5), PK_C(0.25)};
    pk_real one[3], two[3], out[3], weight = 0, worst = 0;
    for (int k = 6; k >= 0; k--)
        weight = 1 / below[k] + angle * angle * weight;
    pk_dexp_inverse(theta, omega, out);
    pk_cross(theta, omega, one);
    pk_cross(theta, one, two);
    for (int i = 0; i < 3; i++)
        worst = pk_max(worst, pk_abs(out[i] - (omega[i] + one[i] / 2 + weight * two[i])));
    return worst / PK_EPS;
}

/* An axis of length 7. */
static void series_of_attitudes(int first, pk_real *exp_off, pk_real *dexp_off)
{
    pk_real c = PK_F(pow)(PK_C(2.0), -(pk_real)first / 2);
    *exp_off = *dexp_off = 0;
    for (int k = 0; c > 2 * PK_TINY; k++, c *= k < 400 ? PK_F(sqrt)(PK_C(0.5)) : PK_C(0.001)) {
        const pk_real theta[] = {2 * c, 3 * c, 6 * c};
        *exp_off = pk_max(*exp_off, series_of_exp(theta, 7 * c));
        *dexp_off = pk_max(*dexp_off, series_of_dexp(theta, 7 * c));
    }
}

#endif

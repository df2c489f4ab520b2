/* pk/sincos.h for the tests: the pair, the pair as a lane has it, and its limit. */
#include <stddef.h>

#include <pk/real.h>
#include <pk/sincos.h>

void pair(size_t n, const pk_real *x, pk_real *s, pk_real *c)
{
    for (size_t i = 0; i < n; i++)
        pk_sincos(x[i], &s[i], &c[i]);
}

void in_lanes(size_t n, const pk_real *restrict x, pk_real *restrict s, pk_real *restrict c,
              pk_bits *restrict bad)
{
    PK_LANE_LOOP
    for (size_t i = 0; i < n; i++)
        bad[i] = pk_sincos_pass(PK_IN_LANE, x[i], &s[i], &c[i]);
}

pk_real limit(void)
{
    return PK_SINCOS_MAX;
}

#ifdef PK_FLOAT
static void compare(float got, double exact, float x, double *worst, double *at)
{
    int exponent;
    double error;

    frexp(exact, &exponent);
    error = fabs((double)got - exact) / ldexp(1, (exponent < -125 ? -125 : exponent) - 24);
    if (!(error <= *worst)) {
        *worst = error;
        *at = (double)x;
    }
}

/* Every step-th float from 2^-40 to the limit against libm in double; returns how many. Below,
 * sin x is x and cos x is 1 in any arithmetic. */
unsigned long every(unsigned step, double *worst, double *at)
{
    const float low = 0x1p-40F, high = PK_SINCOS_MAX;
    unsigned long count = 0;
    uint32_t bits, end;

    memcpy(&bits, &low, sizeof bits);
    memcpy(&end, &high, sizeof end);
    worst[0] = worst[1] = 0;
    for (; bits <= end; bits += step, count++) {
        float x, s, c;
        memcpy(&x, &bits, sizeof x);
        pk_sincos(x, &s, &c);
        compare(s, sin((double)x), x, &worst[0], &at[0]);
        compare(c, cos((double)x), x, &worst[1], &at[1]);
    }
    return count;
}
#endif

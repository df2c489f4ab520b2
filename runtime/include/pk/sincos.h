/* Sine and cosine of an angle, inline, in float and double, without calls and branches, so that
 * compilers vectorise loops over angles. The error is at most 1.5 units in the last place of each
 * result, also near multiples of pi/2. In long double and __float128, and if the compiler computes
 * in excess precision, libm is called.
 *
 *     |x| = k pi/2 + r,  |r| <= pi/4        k mod 4 says which of +-sin r, +-cos r is which
 *
 * The reduction is that of W. J. Cody and W. Waite, "Software Manual for the Elementary Functions"
 * (1980): pi/2 is split into parts of so few bits that k times a part is exact; these products are
 * subtracted one by one, and the rounding errors of the later subtractions are added to sin r. k
 * has 20 bits at most (10 in float), so a part of pi/2 may have 33 bits (14 in float). With fma()
 * the first part may have all 53 bits (24 in float), so that three parts suffice instead of four.
 * The last part matters if |x| is near a multiple of pi/2: the double nearest to a multiple is
 * 2^-60 away from it (29 pi/2). Above PK_SINCOS_MAX libm is called; with -DPK_BOUNDED_ANGLES the
 * results are NaN instead.
 *
 * The polynomials are minimax in the relative error of sin r and cos r (tools/minimax.py):
 *
 *     sin r = r + r z S(z),  cos r = 1 - z/2 + z^2 C(z),  z = r^2
 *
 * MIT-0: pkgen pastes this text into the files that it generates; see LICENSE. */
#ifndef PK_SINCOS_H
#define PK_SINCOS_H

#if !defined PK_LONG_DOUBLE && !defined PK_FLOAT128 && defined FLT_EVAL_METHOD
#if FLT_EVAL_METHOD == 0
#define PK_SINCOS_INLINE
#endif
#endif

#if defined PK_BOUNDED_ANGLES && !defined PK_SINCOS_INLINE
#error "bounded angles are for float and double, without excess precision"
#endif
#ifdef PK_SINCOS_INLINE
#include <string.h>

/* fma() is an instruction, not a library call. (clang does not define FP_FAST_FMA.) */
#if (defined __FP_FAST_FMA || defined FP_FAST_FMA || defined __FMA__ || \
     defined __ARM_FEATURE_FMA) &&                                      \
    !defined PK_PORTABLE
#define PK_SINCOS_FMA(a, b, c) PK_F(fma)(a, b, c)
#define PK_SINCOS_HAS_FMA
#else
#define PK_SINCOS_FMA(a, b, c) ((a) * (b) + (c))
#endif

/* pi/2 = P1 + P2 + P3 (+ P4). Adding PK_SINCOS_ROUND to a number rounds it to an integer, which is
 * then in the last bits of the sum. */
#ifdef PK_FLOAT
#define PK_SINCOS_MAX PK_C(0x1.8p10)
#define PK_SINCOS_ROUND PK_C(0x1.8p23)
#define PK_SINCOS_SIGN 31
#ifdef PK_SINCOS_HAS_FMA
#define PK_SINCOS_P1 PK_C(0x1.921fb4p0)
#define PK_SINCOS_P2 PK_C(0x1.444p-24)
#define PK_SINCOS_P3 PK_C(0x1.68c234p-39)
#else
#define PK_SINCOS_P1 PK_C(0x1.9218p0)
#define PK_SINCOS_P2 PK_C(0x1.ed5p-14)
#define PK_SINCOS_P3 PK_C(0x1.10bp-30)
#define PK_SINCOS_P4 PK_C(0x1.184698p-44)
#endif
#else
#define PK_SINCOS_MAX PK_C(0x1.8p20)
#define PK_SINCOS_ROUND PK_C(0x1.8p52)
#define PK_SINCOS_SIGN 63
#ifdef PK_SINCOS_HAS_FMA
#define PK_SINCOS_P1 PK_C(0x1.921fb54442d18p0)
#define PK_SINCOS_P2 PK_C(0x1.1a626331p-54)
#define PK_SINCOS_P3 PK_C(0x1.1701b839a2520p-88)
#else
#define PK_SINCOS_P1 PK_C(0x1.921fb544p0)
#define PK_SINCOS_P2 PK_C(0x1.0b4611a6p-34)
#define PK_SINCOS_P3 PK_C(0x1.3198a2ep-69)
#define PK_SINCOS_P4 PK_C(0x1.b839a252049c1p-104)
#endif
#endif

/* The polynomials S and C, with pairs of terms: half the latency of Horner's rule. */
PK_INLINE static pk_real pk_sincos_s(pk_real z)
{
#ifdef PK_FLOAT
    const pk_real s0 = PK_SINCOS_FMA(PK_C(0x1.1106c6p-7), z, -PK_C(0x1.555544p-3));
    return PK_SINCOS_FMA(-PK_C(0x1.991c2ap-13), z * z, s0);
#else
    const pk_real z2 = z * z;
    const pk_real s0 = PK_SINCOS_FMA(PK_C(0x1.111111110f750p-7), z, -PK_C(0x1.5555555555548p-3));
    const pk_real s2 = PK_SINCOS_FMA(PK_C(0x1.71de3558eb5ddp-19), z, -PK_C(0x1.a01a019bed4e5p-13));
    const pk_real s4 = PK_SINCOS_FMA(PK_C(0x1.5d8c3c5be351dp-33), z, -PK_C(0x1.ae5e4e8ac796ap-26));
    return PK_SINCOS_FMA(z2, PK_SINCOS_FMA(z2, s4, s2), s0);
#endif
}

PK_INLINE static pk_real pk_sincos_c(pk_real z)
{
#ifdef PK_FLOAT
    const pk_real c0 = PK_SINCOS_FMA(-PK_C(0x1.6c0c26p-10), z, PK_C(0x1.55554ap-5));
    return PK_SINCOS_FMA(PK_C(0x1.99e684p-16), z * z, c0);
#else
    const pk_real z2 = z * z;
    const pk_real c0 = PK_SINCOS_FMA(-PK_C(0x1.6c16c16c14e00p-10), z, PK_C(0x1.555555555554ap-5));
    const pk_real c2 = PK_SINCOS_FMA(-PK_C(0x1.27e4f7cd25aefp-22), z, PK_C(0x1.a01a019c5c32cp-16));
    const pk_real c4 = PK_SINCOS_FMA(-PK_C(0x1.8f99c237a1f64p-37), z, PK_C(0x1.1ee9c32a6292ep-29));
    return PK_SINCOS_FMA(z2, PK_SINCOS_FMA(z2, c4, c2), c0);
#endif
}

/* Computes sine and cosine of x. The results are arbitrary unless |x| <= PK_SINCOS_MAX. `sine` or
 * `cosine` may be NULL if that result is not needed. */
PK_INLINE static void pk_sincos_bounded(pk_real x, pk_real *sine, pk_real *cosine)
{
    const pk_real rounded = PK_SINCOS_FMA(x, PK_C(0x1.45f306dc9c883p-1), PK_SINCOS_ROUND);
    const pk_real k = rounded - PK_SINCOS_ROUND; /* x/(pi/2) rounded to an integer */
    pk_bits j, s_bits, c_bits, differ;
    pk_real z, s, c;

    /* x - k pi/2 = r + lost, where `lost` is the rounding of r. With fma() the cosine ignores
     * `lost`, which causes an error of 0.4 units in the last place. To make sin(-0) = -0, `lost`
     * must be -0 at x = -0 and r z must be +0, so 0 is added to r z. */
#ifdef PK_SINCOS_HAS_FMA
    const pk_real r1 = PK_F(fma)(-k, PK_SINCOS_P1, x);
    const pk_real r = r1 - k * PK_SINCOS_P2;
    const pk_real lost = PK_F(fma)(-k, PK_SINCOS_P3, -((r - r1) + k * PK_SINCOS_P2));
    z = r * r;
    s = r + PK_F(fma)(PK_F(fma)(r, z, 0), pk_sincos_s(z), lost);
    c = PK_F(fma)(z, PK_F(fma)(z, pk_sincos_c(z), -PK_C(0.5)), 1);
#else
    const pk_real r1 = x - k * PK_SINCOS_P1;
    const pk_real r2 = r1 - k * PK_SINCOS_P2;
    const pk_real r = r2 - k * PK_SINCOS_P3;
    const pk_real lost =
        -(((r2 - r1) + k * PK_SINCOS_P2) + ((r - r2) + k * PK_SINCOS_P3) + k * PK_SINCOS_P4);
    pk_real half, high;
    z = r * r;
    s = r + ((r * z + 0) * pk_sincos_s(z) + lost);
    half = PK_C(0.5) * z;
    high = 1 - half;
    c = high + (((1 - high) - half) + (z * z * pk_sincos_c(z) - r * lost));
#endif

    /* The bits j of `rounded` end with those of k, so j mod 4 is k mod 4. If k is odd, sine and
     * cosine are exchanged. */
    memcpy(&j, &rounded, sizeof j);
    memcpy(&s_bits, &s, sizeof s_bits);
    memcpy(&c_bits, &c, sizeof c_bits);
    differ = (s_bits ^ c_bits) & (0 - (j & 1));
    s_bits ^= differ ^ (j >> 1 << PK_SINCOS_SIGN);
    c_bits ^= differ ^ ((j + 1) >> 1 << PK_SINCOS_SIGN);
    if (sine)
        memcpy(sine, &s_bits, sizeof s_bits);
    if (cosine)
        memcpy(cosine, &c_bits, sizeof c_bits);
}

/* Returns nonzero if pk_sincos_bounded() must not be used, also for NaN. */
PK_INLINE static pk_bits pk_sincos_far(pk_real x)
{
    return (pk_bits) !(PK_F(fabs)(x) <= PK_SINCOS_MAX);
}

#endif

/* Computes sine and cosine of x, without branches unless `pass` is PK_CAREFULLY. Returns nonzero if
 * the results are invalid; after a careful pass they are always valid. */
PK_INLINE static pk_bits pk_sincos_pass(enum pk_pass pass, pk_real x, pk_real *sine,
                                        pk_real *cosine)
{
#ifdef PK_SINCOS_INLINE
    if (pass != PK_CAREFULLY) {
        pk_sincos_bounded(x, sine, cosine);
        return pk_sincos_far(x);
    }
#else
    (void)pass;
#endif
#ifdef PK_BOUNDED_ANGLES
    pk_sincos_bounded(pk_sincos_far(x) ? PK_INFINITY - PK_INFINITY : x, sine, cosine);
#else
    if (sine)
        *sine = PK_F(sin)(x);
    if (cosine)
        *cosine = PK_F(cos)(x);
#endif
    return 0;
}

/* Does the same as pk_sincos_pass() for two angles. If pass is PK_ONCE, the compiler turns the loop
 * over both angles into operations on one vector. */
PK_INLINE static pk_bits pk_sincos_pass_2(enum pk_pass pass, pk_real x, pk_real y, pk_real *sin_x,
                                          pk_real *cos_x, pk_real *sin_y, pk_real *cos_y)
{
#ifdef PK_SINCOS_INLINE
    if (pass == PK_ONCE) {
        const pk_real angle[2] = {x, y};
        pk_real s[2], c[2];
        int i;

        for (i = 0; i < 2; i++)
            pk_sincos_bounded(angle[i], &s[i], &c[i]);
        if (sin_x)
            *sin_x = s[0];
        if (cos_x)
            *cos_x = c[0];
        if (sin_y)
            *sin_y = s[1];
        if (cos_y)
            *cos_y = c[1];
        return pk_sincos_far(x) | pk_sincos_far(y);
    }
#endif
    return pk_sincos_pass(pass, x, sin_x, cos_x) | pk_sincos_pass(pass, y, sin_y, cos_y);
}

PK_INLINE static void pk_sincos(pk_real x, pk_real *sine, pk_real *cosine)
{
    if (pk_sincos_pass(PK_ONCE, x, sine, cosine))
        (void)pk_sincos_pass(PK_CAREFULLY, x, sine, cosine);
}

PK_INLINE static void pk_sincos_2(pk_real x, pk_real y, pk_real *sin_x, pk_real *cos_x,
                                  pk_real *sin_y, pk_real *cos_y)
{
    if (pk_sincos_pass_2(PK_ONCE, x, y, sin_x, cos_x, sin_y, cos_y))
        (void)pk_sincos_pass_2(PK_CAREFULLY, x, y, sin_x, cos_x, sin_y, cos_y);
}

#endif

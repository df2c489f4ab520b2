/* Vectors of PK_WIDE numbers, one for each state, for Taylor coefficients of several states at
 * once. They are extensions of gcc and clang for float and double. */
#ifndef PK_STEP_WIDE_H
#define PK_STEP_WIDE_H

#include <stdint.h>
#include <string.h>

#include <pk/real.h>

#if defined __GNUC__ && !defined PK_LONG_DOUBLE && !defined PK_FLOAT128
#if defined __FMA__ && defined __AVX__ && !defined PK_PORTABLE
#include <immintrin.h>
#endif

#pragma GCC diagnostic ignored "-Wpsabi" /* all functions here are inlined */
#define PK_WIDE 4
typedef pk_real pk_wide __attribute__((vector_size(PK_WIDE * sizeof(pk_real))));
#ifdef PK_FLOAT
typedef int32_t pk_wide_bits __attribute__((vector_size(PK_WIDE * sizeof(pk_real))));
#else
typedef int64_t pk_wide_bits __attribute__((vector_size(PK_WIDE * sizeof(pk_real))));
#endif

static inline pk_wide pk_wide_of(pk_real x) { return (pk_wide){x, x, x, x}; }
static inline pk_wide pk_wide_at(const pk_real *x)
{
    pk_wide y;
    memcpy(&y, x, sizeof y);
    return y;
}
static inline void pk_wide_put(pk_real *to, pk_wide x) { memcpy(to, &x, sizeof x); }

#ifdef PK_FLOAT
#define PK_WIDE_X86(name) _mm_##name##_ps
#else
#define PK_WIDE_X86(name) _mm256_##name##_pd
#endif

/* Returns a b + c, rounded as by PK_JET_ADD of the generated C. */
static inline pk_wide pk_wide_add(pk_wide a, pk_wide b, pk_wide c)
{
#if defined PK_PORTABLE
    return a * b + c;
#elif defined __FMA__ && defined __AVX__
    return PK_WIDE_X86(fmadd)(a, b, c);
#elif !(defined PK_FLOAT ? defined FP_FAST_FMAF : defined FP_FAST_FMA)
    return a * b + c;
#else
    for (int l = 0; l < PK_WIDE; l++)
        a[l] = PK_F(fma)(a[l], b[l], c[l]);
    return a;
#endif
}

/* Returns the bits of the vectors whose number is nonzero. */
static inline unsigned pk_wide_mask(pk_wide_bits x)
{
    unsigned found = 0;
    for (unsigned l = 0; l < PK_WIDE; l++)
        found |= (unsigned)(x[l] != 0) << l;
    return found;
}

#define PK_WIDE_FUNCTION(name)                      \
    static inline pk_wide pk_wide_##name(pk_wide x) \
    {                                               \
        for (int l = 0; l < PK_WIDE; l++)           \
            x[l] = PK_F(name)(x[l]);                \
        return x;                                   \
    }
PK_WIDE_FUNCTION(sin)
PK_WIDE_FUNCTION(cos)
PK_WIDE_FUNCTION(tan)
PK_WIDE_FUNCTION(atan)
PK_WIDE_FUNCTION(sinh)
PK_WIDE_FUNCTION(cosh)
PK_WIDE_FUNCTION(tanh)
PK_WIDE_FUNCTION(exp)
PK_WIDE_FUNCTION(log)
PK_WIDE_FUNCTION(sqrt)
static inline pk_wide pk_wide_pow(pk_wide x, pk_wide y)
{
    for (int l = 0; l < PK_WIDE; l++)
        x[l] = PK_F(pow)(x[l], y[l]);
    return x;
}
#endif
#endif

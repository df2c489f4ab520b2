/* Random numbers of white noise. They are functions of a seed, a member of an ensemble, a step and
 * an index alone, so they do not depend on threads or on the order of calls. The generator is
 * Philox4x32-10: J. K. Salmon, M. A. Moraes, R. O. Dror, D. E. Shaw, Parallel random numbers: as
 * easy as 1, 2, 3, SC11 (2011). */
#ifndef PK_NOISE_H
#define PK_NOISE_H

#include <stddef.h>
#include <stdint.h>

#include <pk/real.h>

/* Replaces the four words of the counter x by random words. */
static inline void pk_philox(uint32_t x[4], uint32_t key0, uint32_t key1)
{
    for (int round = 0; round < 10; round++) {
        const uint64_t a = (uint64_t)0xD2511F53u * x[0], b = (uint64_t)0xCD9E8D57u * x[2];
        x[0] = (uint32_t)(b >> 32) ^ x[1] ^ key0;
        x[2] = (uint32_t)(a >> 32) ^ x[3] ^ key1;
        x[1] = (uint32_t)b;
        x[3] = (uint32_t)a;
        key0 += 0x9E3779B9u;
        key1 += 0xBB67AE85u;
    }
}

/* Returns (k + 1/2) / 2^53, where k is the first 53 bits of two words. */
static inline pk_real pk_uniform(uint32_t high, uint32_t low)
{
    const uint64_t k = ((uint64_t)high << 32 | low) >> 11;
    return ((pk_real)k + PK_C(0.5)) / PK_C(9007199254740992.0);
}

/* Writes `count` independent numbers of the standard normal distribution (Box, Muller 1958) for a
 * step. The counter has 48 bits of the step and 48 of the member. */
static inline void pk_normal(uint64_t seed, uint64_t member, uint64_t step, size_t count,
                             pk_real *out)
{
    for (size_t k = 0; k < count; k += 2) {
        uint32_t x[4] = {(uint32_t)step, (uint32_t)(k / 2), (uint32_t)member,
                         (uint32_t)(step >> 32 << 16) | (uint32_t)(member >> 32 & 0xFFFF)};
        pk_philox(x, (uint32_t)seed, (uint32_t)(seed >> 32));
        const pk_real r = PK_F(sqrt)(-2 * PK_F(log)(pk_uniform(x[0], x[1])));
        const pk_real angle = 2 * PK_PI * pk_uniform(x[2], x[3]);
        out[k] = r * PK_F(cos)(angle);
        if (k + 1 < count)
            out[k + 1] = r * PK_F(sin)(angle);
    }
}

#endif

/* Points that fill a box evenly and are the same each time: coordinate i of point k is digit by digit
 * k mirrored at the point, in base prime(i). Reference: J. H. Halton, Numer. Math. 2 (1960) 84.
 */
#ifndef PK_GSL_HALTON_H
#define PK_GSL_HALTON_H

#include <stddef.h>

/* Number k of Halton's sequence in a base, in (0, 1). */
static inline double halton(size_t k, size_t base)
{
    double x = 0, digit = 1;
    for (; k; k /= base) {
        digit /= (double)base;
        x += digit * (double)(k % base);
    }
    return x;
}

static inline size_t prime(size_t index)
{
    size_t candidate = 2;
    for (;; candidate++) {
        size_t d = 2;
        while (d * d <= candidate && candidate % d)
            d++;
        if (d * d > candidate && index-- == 0)
            return candidate;
    }
}

#endif

/* Halton's sequence: deterministic points that fill a box evenly. Coordinate i of point k is the
 * radical inverse of k (its digits mirrored at the radix point) in the i-th prime base. Reference:
 * J. H. Halton, Numer. Math. 2 (1960) 84. */
#ifndef PK_GSL_HALTON_H
#define PK_GSL_HALTON_H

#include <stddef.h>

/* Returns number k of Halton's sequence in a base, in (0, 1). */
static inline double halton(size_t k, size_t base)
{
    double x = 0, digit = 1;
    for (; k; k /= base) {
        digit /= (double)base;
        x += digit * (double)(k % base);
    }
    return x;
}

/* Sets list to the first `count` primes, in order. */
static inline void primes(size_t *list, size_t count)
{
    for (size_t found = 0, candidate = 2; found < count; candidate++) {
        size_t k = 0;
        while (k < found && list[k] * list[k] <= candidate && candidate % list[k])
            k++;
        if (k == found || list[k] * list[k] > candidate)
            list[found++] = candidate;
    }
}

#endif

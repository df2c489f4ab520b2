/* Values of terms in a buffer, for rows and numbers that are sums of several terms.
 *
 * MIT-0: pkgen pastes this text into the files that it generates; see LICENSE. */
#ifndef PK_MEMBERS_ROWS_H
#define PK_MEMBERS_ROWS_H

#include <pk/members.h>

#define PK_MOST_VALUES 256

/* Writes the `count` values of a term for m = from .. from + n - 1: value r to e[r * width],
 * e[r * width + 1], ...; 0 where m is not in lo .. hi. */
PK_INLINE static void pk_fill(const struct pk_members *x, pk_values *values, int count,
                              ptrdiff_t lo, ptrdiff_t hi, ptrdiff_t from, ptrdiff_t n, pk_real *e,
                              ptrdiff_t width)
{
    const ptrdiff_t first = pk_least(pk_most(lo, from), from + n);
    const ptrdiff_t end = pk_most(first, pk_least(hi + 1, from + n));
    pk_real *o[PK_MOST_VALUES];
    ptrdiff_t m, k, step;
    int r;

    for (r = 0; r < count; r++) {
        o[r] = e + r * width + (first - from);
        for (k = 0; k < first - from; k++)
            e[r * width + k] = 0;
        for (k = end - from; k < n; k++)
            e[r * width + k] = 0;
    }
    for (m = first; m < end; m += step) {
        step = pk_least(pk_step(m, lo, hi), end - m);
        values(x, 0, m, step, o);
        for (r = 0; r < count; r++)
            o[r] += step;
    }
}

/* Moves the last `kept` of kept + n columns of e to the front. */
PK_INLINE static void pk_keep(pk_real *e, int count, ptrdiff_t width, ptrdiff_t n, ptrdiff_t kept)
{
    ptrdiff_t k;
    int r;

    for (r = 0; r < count; r++)
        for (k = 0; k < kept; k++)
            e[r * width + k] = e[r * width + k + n];
}

/* Adds n numbers, times a sign, to eight partial sums. */
PK_INLINE static void pk_add_up(const pk_real *e, ptrdiff_t n, pk_real sign, pk_real *eight)
{
    ptrdiff_t k, l;

    for (k = 0; k + 8 <= n; k += 8)
        for (l = 0; l < 8; l++)
            eight[l] += sign * e[k + l];
    for (l = 0; k + l < n; l++)
        eight[l] += sign * e[k + l];
}

PK_INLINE static pk_real pk_whole(const pk_real *s)
{
    return ((s[0] + s[1]) + (s[2] + s[3])) + ((s[4] + s[5]) + (s[6] + s[7]));
}

#endif

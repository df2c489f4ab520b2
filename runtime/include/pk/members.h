/* Sums of terms over the members of families, such as sum(f(q[i], q[i+1]), i = 0..N). A model has
 * a C function for each term, which computes it for n successive members at once.
 *
 * MIT-0: pkgen pastes this text into the files that it generates; see LICENSE. */
#ifndef PK_MEMBERS_H
#define PK_MEMBERS_H

#define PK_BLOCK 512 /* the most members that a term is computed for at a time */

/* The arguments of a kernel; `at` has indices for tables. */
struct pk_members {
    const void *params;
    const ptrdiff_t *at;
    pk_real t;
    const pk_real *q, *v, *u;
};

/* A term: writes its values for m = from .. from + n - 1 to o[0][0], o[0][1], ...; o[1][0], ... A
 * term of pairs writes those of the pairs m = row, j = from .. from + n - 1. */
typedef void pk_values(const struct pk_members *x, ptrdiff_t row, ptrdiff_t from, ptrdiff_t n,
                       pk_real *const *o);
#define PK_TERM(name)                                                                 \
    static void name(PK_PERHAPS const struct pk_members *x, PK_PERHAPS ptrdiff_t row, \
                     PK_PERHAPS ptrdiff_t from, ptrdiff_t n, pk_real *const *o)

PK_INLINE static ptrdiff_t pk_most(ptrdiff_t a, ptrdiff_t b) { return a > b ? a : b; }
PK_INLINE static ptrdiff_t pk_least(ptrdiff_t a, ptrdiff_t b) { return a < b ? a : b; }

/* Returns the members from .. from + n - 1 of a family with the indices lo .. hi, whose array
 * begins at `array`: in place, or else copied to `room`. An index beyond lo .. hi has the value
 * read(x, i), or 0 if read is NULL. */
PK_INLINE static const pk_real *pk_row(const struct pk_members *x, const pk_real *array,
                                       pk_real (*read)(const struct pk_members *x, ptrdiff_t i),
                                       ptrdiff_t lo, ptrdiff_t hi, ptrdiff_t from, ptrdiff_t n,
                                       pk_real *room)
{
    const ptrdiff_t below = pk_least(n, lo - from), end = pk_least(n, hi + 1 - from);
    ptrdiff_t k;

    if (below <= 0 && end == n)
        return array + (from - lo);
    for (k = 0; k < below; k++)
        room[k] = read ? read(x, from + k) : 0;
    PK_LANE_LOOP
    for (; k < end; k++)
        room[k] = array[from - lo + k];
    for (; k < n; k++)
        room[k] = read ? read(x, from + k) : 0;
    return room;
}

/* Returns how many of the indices m .. hi a term computes next. In a long range lo .. hi the first
 * and the last call compute 8: only these then copy what they read. */
PK_INLINE static ptrdiff_t pk_step(ptrdiff_t m, ptrdiff_t lo, ptrdiff_t hi)
{
    const ptrdiff_t n = pk_least(PK_BLOCK, hi + 1 - m);
    return n <= 256 || (m > lo && m + n <= hi) ? n : m == lo ? 8 : n - 8;
}

/* Returns the sum of the value of a term for m = lo .. hi, added up as eight partial sums. */
PK_PERHAPS static pk_real pk_sum(const struct pk_members *x, pk_values *values, ptrdiff_t lo,
                                 ptrdiff_t hi)
{
    pk_real e[PK_BLOCK + 7], *const o = e, s[8] = {0};
    ptrdiff_t m, n, k, l;

    for (m = lo; m <= hi; m += n) {
        n = pk_step(m, lo, hi);
        values(x, 0, m, n, &o);
        for (k = n; k % 8; k++)
            e[k] = 0;
        for (k = 0; k < n; k += 8)
            for (l = 0; l < 8; l++)
                s[l] += e[k + l];
    }
    return ((s[0] + s[1]) + (s[2] + s[3])) + ((s[4] + s[5]) + (s[6] + s[7]));
}

#endif

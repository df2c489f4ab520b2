/* Sums of terms over the members of families, such as sum(f(q[i], q[i+1]), i = 0..N), for every
 * length of the families.
 *
 * A model has a C function for each term. It computes the values of the term for n successive
 * members at once. It reads members from their array, or from a copy in which members beyond the
 * ends of the family are included. A scalar is a family of one member, whose index is 0.
 *
 * MIT-0: pkgen pastes this text into the files that it generates; see LICENSE. */
#ifndef PK_MEMBERS_H
#define PK_MEMBERS_H

#ifdef __GNUC__
#define PK_PERHAPS __attribute__((unused))
#else
#define PK_PERHAPS
#endif
#ifndef PK_BLOCK
#define PK_BLOCK 512 /* the most members that a term is computed for at a time */
#endif
#define PK_MOST_VALUES 256

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

/* A term with angles is computed with a fast sine, and again with care if an angle is too large. */
#define PK_TERM_PASS(name)                                                                         \
    PK_INLINE static pk_bits name##_pass(enum pk_pass pass, PK_PERHAPS const struct pk_members *x, \
                                         PK_PERHAPS ptrdiff_t row, PK_PERHAPS ptrdiff_t from,      \
                                         ptrdiff_t n, pk_real *const *o)
#define PK_TERM_OF_PASSES(name)                                  \
    PK_TERM(name)                                                \
    {                                                            \
        if (name##_pass(PK_IN_LANE, x, row, from, n, o))         \
            (void)name##_pass(PK_CAREFULLY, x, row, from, n, o); \
    }

PK_INLINE static ptrdiff_t pk_most(ptrdiff_t a, ptrdiff_t b) { return a > b ? a : b; }

PK_INLINE static ptrdiff_t pk_least(ptrdiff_t a, ptrdiff_t b) { return a < b ? a : b; }

/* Returns the members from .. from + n - 1 of a family with the indices lo .. hi, whose array
 * begins at `array`: in place, or else copied to `room`, where read() returns those beyond. */
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
        room[k] = read(x, from + k);
    PK_LANE_LOOP
    for (k = pk_most(0, below); k < end; k++)
        room[k] = array[from - lo + k];
    for (k = pk_most(0, end); k < n; k++)
        room[k] = read(x, from + k);
    return room;
}

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
        step = pk_least(PK_BLOCK, end - m);
        if (m == lo && step > 64)
            step = 8; /* terms at an end read a copy: make it a short one */
        else if (m + step == hi + 1 && step > 64)
            step -= 8;
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

/* Adds the value of a term for m = lo .. hi to eight partial sums. */
PK_PERHAPS static void pk_sum(const struct pk_members *x, pk_values *values, ptrdiff_t lo,
                              ptrdiff_t hi, pk_real *eight)
{
    pk_real e[PK_BLOCK], *const o = e;
    ptrdiff_t n;

    for (; lo <= hi; lo += n) {
        n = pk_least(PK_BLOCK, hi + 1 - lo);
        values(x, 0, lo, n, &o);
        pk_add_up(e, n, 1, eight);
    }
}

#endif

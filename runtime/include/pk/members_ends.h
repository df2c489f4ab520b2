/* The ends of families, and values that are added to single members.
 *
 * MIT-0: pkgen pastes this text into the files that it generates; see LICENSE. */
#ifndef PK_MEMBERS_ENDS_H
#define PK_MEMBERS_ENDS_H

#include <pk/members.h>

/* Returns the index of the member for which index i stands, lo - 1 if there is none. A ring
 * continues with its own members. The free ends repeat the first member for `below` indices, the
 * last one for `above`. */
PK_PERHAPS static ptrdiff_t pk_home(ptrdiff_t i, ptrdiff_t lo, ptrdiff_t hi, int ring,
                                    ptrdiff_t below, ptrdiff_t above)
{
    if (i >= lo && i <= hi)
        return i;
    if (ring) {
        const ptrdiff_t n = hi - lo + 1, r = (i - lo) % n;
        return lo + (r < 0 ? r + n : r);
    }
    if (i < lo)
        return i + below >= lo ? lo : lo - 1;
    return i - above <= hi ? hi : lo - 1;
}

/* A value that is added to one member of a family, apart from the terms of successive members. */
struct pk_added {
    int family, output;
    ptrdiff_t i;
    pk_real value;
};

/* Appends a value for member i to a list of `count`, if i is in first .. end - 1 and in the
 * family, whose least index is lo. Returns the new count. */
PK_PERHAPS static int pk_append(struct pk_added *found, int count, int family, int output,
                                ptrdiff_t i, ptrdiff_t lo, ptrdiff_t first, ptrdiff_t end,
                                pk_real value)
{
    if (i < lo || i < first || i >= end)
        return count;
    found[count].family = family;
    found[count].output = output;
    found[count].i = i;
    found[count].value = value;
    return count + 1;
}

/* Adds the values of a family's members from .. from + n - 1 to r[output * width + i - from]. */
PK_PERHAPS static void pk_add_to(const struct pk_added *found, int count, int family,
                                 ptrdiff_t from, ptrdiff_t n, pk_real *r, ptrdiff_t width)
{
    int b;

    for (b = 0; b < count; b++)
        if (found[b].family == family && found[b].i >= from && found[b].i < from + n)
            r[found[b].output * width + found[b].i - from] += found[b].value;
}

#endif

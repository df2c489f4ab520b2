/* Lists of terms with a value for each member or pair.
 *
 * MIT-0: pkgen pastes this text into the files that it generates; see LICENSE. */
#ifndef PK_MEMBERS_LIST_H
#define PK_MEMBERS_LIST_H

#include <pk/members.h>

/* A term with the indices m = at[over] .. at[over + 1]; one of pairs has j = at[over + 2] + first
 * * m .. at[over + 3] + last * m too. */
struct pk_terms {
    pk_values *values;
    int n_values, over, pairs, first, last;
};

/* Returns how many pairs the member m has, and the least index *j of its partners. */
PK_PERHAPS static ptrdiff_t pk_partners(const struct pk_members *x, const struct pk_terms *of,
                                        ptrdiff_t m, ptrdiff_t *j)
{
    const ptrdiff_t first = x->at[of->over + 2] + of->first * m;
    const ptrdiff_t end = x->at[of->over + 3] + of->last * m + 1;
    *j = first;
    return end > first ? end - first : 0;
}

/* Writes the values of some terms, each with one for each member or pair, one behind the other.
 * With `out` NULL it only counts them. */
PK_PERHAPS static size_t pk_list(const struct pk_members *x, const struct pk_terms *of, int count,
                                 pk_real *out)
{
    size_t found = 0;
    ptrdiff_t m, j, n, left;

    for (; count-- > 0; of++)
        for (m = x->at[of->over]; m <= x->at[of->over + 1]; m += of->pairs ? 1 : left) {
            left = x->at[of->over + 1] + 1 - m;
            j = m;
            if (of->pairs)
                left = pk_partners(x, of, m, &j);
            for (n = 0; out && n < left; n += PK_BLOCK) {
                pk_real *const to = out + found + n;
                of->values(x, m, j + n, pk_least(PK_BLOCK, left - n), &to);
            }
            found += (size_t)left;
        }
    return found;
}

/* Returns the member, or pair, that value number k of pk_list() belongs to. */
PK_PERHAPS static void pk_listed(const struct pk_members *x, const struct pk_terms *of, size_t k,
                                 ptrdiff_t *i, ptrdiff_t *j)
{
    *j = 0;
    *i = x->at[of->over];
    if (!of->pairs) {
        *i += (ptrdiff_t)k;
        return;
    }
    for (;; ++*i) {
        const size_t n = (size_t)pk_partners(x, of, *i, j);
        if (k < n)
            break;
        k -= n;
    }
    *j += (ptrdiff_t)k;
}

#endif

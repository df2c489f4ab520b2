/* Values that are defined along the members of a family, as unknowns of a matrix: each has a row
 * that says how it depends on others (C), with its own entry first.
 *
 * MIT-0: pkgen pastes this text into the files that it generates; see LICENSE. */
#ifndef PK_MEMBERS_CHAIN_H
#define PK_MEMBERS_CHAIN_H

#include <pk/members_band.h>

/* Writes the entries r of the row at index m, and the places c of their columns. The place of a
 * given member is -1. Returns the number of entries. */
PK_PERHAPS static int pk_made_row(const struct pk_members *x, const struct pk_places *p,
                                  const struct pk_matrix *of, ptrdiff_t m, ptrdiff_t *c, pk_real *r)
{
    pk_real values[PK_MOST_VALUES], *o[PK_MOST_VALUES];
    int k, n = 0, last = -1;

    for (k = 0; k < of->n_entries; k++) {
        const struct pk_entry *entry = of->entries + k;
        const struct pk_terms *terms = of->terms + entry->terms;
        int i;
        if (m < x->at[terms->over] || m > x->at[terms->over + 1])
            continue;
        for (i = 0; entry->terms != last && i < terms->n_values; i++)
            o[i] = values + i;
        if (entry->terms != last)
            terms->values(x, 0, m, 1, o);
        last = entry->terms;
        c[n] = pk_place(x, p, entry->column.unknown, pk_cell_index(x, &entry->column, m));
        r[n++] = (pk_real)entry->sign * values[entry->value];
    }
    return n;
}

/* The least and the greatest index of the rows of some matrices. */
PK_PERHAPS static void pk_made_range(const struct pk_members *x, const struct pk_matrix *of,
                                     ptrdiff_t *lo, ptrdiff_t *hi)
{
    int k;

    for (k = 0; k < of->n_terms; k++) {
        *lo = pk_least(*lo, x->at[of->terms[k].over]);
        *hi = pk_most(*hi, x->at[of->terms[k].over + 1]);
    }
}

/* The diagonal entry of place i among matrices in bands. */
PK_INLINE static pk_real *pk_in_band(const struct pk_places *p, pk_real *M, ptrdiff_t i)
{
    const ptrdiff_t width = p->of->width, border = p->all - p->banded;

    if (i < p->banded)
        return M + i * (2 * width + 1) + width;
    return M + p->banded * (2 * width + 1) + (p->banded + i) * border + i - p->banded;
}

/* Returns half the inertia of the value c[0] itself, or without one the inertia of its columns by
 * their squared slopes. */
PK_PERHAPS static pk_real pk_weight(const struct pk_ldl *A, int n, const ptrdiff_t *c,
                                    const pk_real *r)
{
    const pk_real weight = *pk_ldl_entry(A, c[0], c[0]) / 2;
    pk_real own = 0, slopes = 0;
    int i;

    for (i = 1; i < n && !(weight > 0); i++)
        if (c[i] >= 0) {
            const pk_real of_i = *pk_ldl_entry(A, c[i], c[i]);
            own += of_i;
            slopes += of_i > 0 ? r[i] * r[i] : r[i] * r[i] / 1024;
        }
    if (weight > 0)
        return weight;
    return own > 0 && slopes > PK_C(1e-30) * own ? own / slopes : 1;
}

/* Adds C^T W C to M, for the rows of `count` matrices: to M = K with C behind it, or, if `banded`,
 * to M among matrices in bands, which have C already. */
PK_PERHAPS static void pk_made(const struct pk_members *x, const struct pk_places *p,
                               const struct pk_matrix *const *of, int count, int banded, pk_real *M)
{
    const struct pk_ldl A = pk_lower(p, M);
    ptrdiff_t lo = PTRDIFF_MAX, hi = PTRDIFF_MIN, m, c[PK_MOST_VALUES];
    pk_real r[PK_MOST_VALUES];
    int g, i, j;

    for (g = 0; g < count; g++)
        pk_made_range(x, of[g], &lo, &hi);
    for (m = hi; m >= lo; m--)
        for (g = count - 1; g >= 0; g--) {
            const int n = pk_made_row(x, p, of[g], m, c, r);
            pk_real weight;
            ptrdiff_t row;
            if (!n)
                continue;
            if (banded) {
                weight = *pk_in_band(p, M, c[0]) / 2;
                weight = weight > 0 ? weight : 1;
                for (i = 0; i < n; i++)
                    for (j = 0; j < n; j++)
                        if (c[i] >= 0 && c[j] >= 0)
                            pk_to_band(p, M, c[i], c[j], weight * r[i] * r[j]);
                continue;
            }
            weight = pk_weight(&A, n, c, r);
            row = pk_place(x, p, of[g]->entries->row.unknown, m);
            *pk_ldl_entry(&A, row, row) = 0;
            for (i = 0; i < n; i++) {
                if (c[i] < 0)
                    continue;
                *pk_ldl_entry(&A, pk_most(row, c[i]), pk_least(row, c[i])) += r[i];
                for (j = 0; j <= i; j++)
                    if (c[j] >= 0)
                        *pk_ldl_entry(&A, pk_most(c[i], c[j]), pk_least(c[i], c[j])) += weight *
                                                                                        r[i] * r[j];
            }
        }
}

/* Bounds each value by the sizes x of the coordinates that it depends on, `count` of them, added
 * to its own size (own, NULL: 0). */
PK_PERHAPS static void pk_spread_over(const struct pk_members *x, const struct pk_places *p,
                                      const struct pk_matrix *const *of, int count, ptrdiff_t n,
                                      const pk_real *sizes, const pk_real *own, pk_real *out)
{
    ptrdiff_t lo = PTRDIFF_MAX, hi = PTRDIFF_MIN, m, c[PK_MOST_VALUES];
    pk_real r[PK_MOST_VALUES];
    int g, k;

    for (m = 0; m < n; m++)
        out[m] = PK_F(fabs)(sizes[m]);
    for (g = 0; g < count; g++)
        pk_made_range(x, of[g], &lo, &hi);
    for (m = lo; m <= hi; m++)
        for (g = 0; g < count; g++) {
            const int entries = pk_made_row(x, p, of[g], m, c, r);
            pk_real sum = 0;
            ptrdiff_t to;
            if (!entries)
                continue;
            to = pk_in_place(x, p, c[0]);
            sum = own ? PK_F(fabs)(own[to]) : 0;
            for (k = 1; k < entries; k++)
                if (c[k] >= 0)
                    sum += PK_F(fabs)(r[k]) * out[pk_in_place(x, p, c[k])];
            out[to] = sum;
        }
}

/* Eliminates the unknown c[0] = -sum r[k] x[c[k]] from M, whose entries go over to the c[k].
 * Returns the entry of the diagonal that it had. */
PK_PERHAPS static pk_real pk_taken(const struct pk_ldl *A, int n, const ptrdiff_t *c,
                                   const pk_real *r)
{
    const ptrdiff_t i = c[0], all = A->rows + A->border;
    const ptrdiff_t last = i < A->rows ? pk_least(i + A->width + 1, A->rows) : all;
    const pk_real own = *pk_ldl_entry(A, i, i);
    ptrdiff_t j;
    int k, l;

    for (j = i < A->rows ? pk_ldl_first(A, i) : 0; j < all;
         j = j + 1 == last ? pk_most(last, A->rows) : j + 1) {
        const pk_real of_j = *pk_ldl_entry(A, pk_most(i, j), pk_least(i, j));
        if (j == i || of_j == 0)
            continue;
        for (k = 1; k < n; k++)
            if (c[k] >= 0)
                *pk_ldl_entry(A, pk_most(c[k], j), pk_least(c[k], j)) -=
                    (pk_real)(c[k] == j ? 2 : 1) * r[k] * of_j;
        *pk_ldl_entry(A, pk_most(i, j), pk_least(i, j)) = 0;
    }
    for (k = 1; k < n; k++)
        for (l = 1; l <= k; l++)
            if (c[k] >= 0 && c[l] >= 0)
                *pk_ldl_entry(A, pk_most(c[k], c[l]), pk_least(c[k], c[l])) += r[k] * r[l] * own;
    *pk_ldl_entry(A, i, i) = 0;
    return own;
}

/* Writes the diagonal of M of the `n` coordinates, without values that are defined by others:
 * from the last place to the first. M is overwritten. */
PK_PERHAPS static void pk_diagonal(const struct pk_members *x, const struct pk_places *p,
                                   const struct pk_matrix *const *of, int count, ptrdiff_t n,
                                   pk_real *M, pk_real *out)
{
    const struct pk_ldl A = pk_lower(p, M);
    const ptrdiff_t slots = p->of->slots;
    ptrdiff_t i, k, c[PK_MOST_VALUES];
    pk_real r[PK_MOST_VALUES];
    int g;

    for (i = p->places - slots; i >= 0; i -= slots) {
        for (g = count - 1; g >= 0; g--) {
            const int entries = pk_made_row(x, p, of[g], p->base + i / slots, c, r);
            if (entries)
                (void)pk_taken(&A, entries, c, r);
        }
        for (k = i; k < i + slots; k++) {
            const ptrdiff_t own = pk_in_place(x, p, k);
            if (own >= 0 && own < n)
                out[own] = pk_taken(&A, 1, &k, NULL);
        }
    }
    for (i = p->places; i < p->all; i++)
        if (pk_in_place(x, p, i) >= 0)
            out[pk_in_place(x, p, i)] = *pk_ldl_entry(&A, i, i);
}

#endif

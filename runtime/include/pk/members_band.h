/* Matrices of models with families: a band with a border of dense rows, to which terms add
 * entries.
 *
 * The unknowns of the band are ordered by index: at each index the members of all families,
 * then one row of every family of constraints, which belongs to the largest index of a coordinate
 * in it. The factorization L D L^T of K = [M J^T; J 0] then needs no pivoting: each leading block
 * of K is regular if the rows are independent. Behind the band come rows that reach around the
 * end of a ring, then scalar coordinates and single rows.
 *
 * MIT-0: pkgen pastes this text into the files that it generates; see LICENSE. */
#ifndef PK_MEMBERS_BAND_H
#define PK_MEMBERS_BAND_H

#include <pk/ldl.h>
#include <pk/members_ends.h>
#include <pk/members_list.h>
#include <pk/members_rows.h>

/* The ends of a family: see pk_home(). Its range is in the array `at` of struct pk_members: the
 * number of its first member in arrays, its least and its greatest index. */
struct pk_family {
    int ring;
    ptrdiff_t below, above;
};

PK_INLINE static const ptrdiff_t *pk_range_of_family(const struct pk_members *x, int family)
{
    return x->at + 3 * family;
}

/* Kinds of unknowns: coordinates, rows of constraints, other unknowns, and places that are none. */
enum pk_unknown_kind { PK_COORDINATE, PK_ROW, PK_OTHER, PK_NONE };

/* Unknowns of a family: that of index i lies at i + ahead. Rows with an index below one of
 * at[wraps], ... (n_wraps of them) reach around the end of a ring and lie behind all others. */
struct pk_unknown {
    enum pk_unknown_kind kind;
    int family;
    int homed; /* an index beyond an end stands for a member, or for none */
    ptrdiff_t ahead;
    int wraps, n_wraps;
};

/* The order of unknowns: `slots` at each index, then `border` of which there is one each. */
struct pk_layout {
    const struct pk_family *families;
    const struct pk_unknown *unknowns;
    int slots, border;
    ptrdiff_t width;
    int spares; /* the last of the border: for rows whose pivot is 0 until scalars are eliminated */
    int carried; /* whether unknowns of kind PK_NONE are rows that define others */
};

struct pk_places {
    const struct pk_layout *of;
    ptrdiff_t base, span, places, banded, all;
};

PK_PERHAPS static int pk_wrapped(const struct pk_members *x, const struct pk_unknown *of,
                                 ptrdiff_t i)
{
    int k;

    for (k = 0; k < of->n_wraps; k++)
        if (i < x->at[of->wraps + k])
            return 1;
    return 0;
}

PK_PERHAPS static struct pk_places pk_places_of(const struct pk_members *x,
                                                const struct pk_layout *of)
{
    struct pk_places p = {of, PTRDIFF_MAX, 0, 0, 0, 0};
    ptrdiff_t top = PTRDIFF_MIN, ring = PTRDIFF_MAX, count = 0;
    int k, c;

    for (k = 0; k < of->slots; k++) {
        const ptrdiff_t *range = pk_range_of_family(x, of->unknowns[k].family);
        p.base = pk_least(p.base, range[1] + of->unknowns[k].ahead);
        if (of->unknowns[k].kind == PK_COORDINATE) {
            top = pk_most(top, range[2]);
            if (of->families[of->unknowns[k].family].ring)
                ring = pk_least(ring, range[2]);
        }
    }
    p.span = top - p.base + 1;
    for (k = 0; k < of->slots; k++) {
        const struct pk_unknown *u = of->unknowns + k;
        const ptrdiff_t hi = pk_range_of_family(x, u->family)[2];
        count = pk_most(count, hi + u->ahead - p.base + 1 + (pk_wrapped(x, u, hi) ? p.span : 0));
        for (c = 0; c < u->n_wraps; c++)
            count = pk_most(count,
                            pk_least(hi, x->at[u->wraps + c] - 1) + u->ahead + p.span - p.base + 1);
    }
    p.places = pk_most(count, p.span) * of->slots;
    p.banded = p.places;
    if (ring < PTRDIFF_MAX)
        p.banded = pk_most(0, (ring - p.base + 1) * of->slots - of->width);
    p.all = p.places + of->border;
    return p;
}

/* The index of the member that index i of an unknown stands for; below the least if none. */
PK_PERHAPS static ptrdiff_t pk_member(const struct pk_members *x, const struct pk_places *p,
                                      const struct pk_unknown *of, ptrdiff_t i)
{
    const struct pk_family *own = p->of->families + of->family;
    const ptrdiff_t *range = pk_range_of_family(x, of->family);
    return pk_home(i, range[1], range[2], own->ring, own->below, own->above);
}

/* The place of an unknown at index i; -1 if it is given. */
PK_PERHAPS static ptrdiff_t pk_place(const struct pk_members *x, const struct pk_places *p,
                                     int unknown, ptrdiff_t i)
{
    const struct pk_unknown *u = p->of->unknowns + unknown;

    if (unknown >= p->of->slots)
        return p->places + unknown - p->of->slots;
    if (u->homed) {
        i = pk_member(x, p, u, i);
        if (i < pk_range_of_family(x, u->family)[1])
            return -1;
    }
    return (i + u->ahead + (pk_wrapped(x, u, i) ? p->span : 0) - p->base) * p->of->slots + unknown;
}

/* A walk over all places: the place, its unknown, and the index there. */
struct pk_walk {
    ptrdiff_t i, m;
    int unknown;
};

PK_PERHAPS static struct pk_walk pk_walk_at(const struct pk_places *p, ptrdiff_t i)
{
    const ptrdiff_t slots = p->of->slots;
    struct pk_walk at = {i, p->base, (int)(slots + i - p->places)};
    if (i < p->places) {
        at.m += i / slots;
        at.unknown = (int)(i % slots);
    }
    return at;
}

PK_INLINE static void pk_walk_on(const struct pk_places *p, struct pk_walk *at)
{
    at->unknown++;
    if (++at->i <= p->places && at->unknown == p->of->slots) {
        at->m++;
        at->unknown = at->i < p->places ? 0 : p->of->slots;
    }
}

/* Returns the number of the coordinate in a place; -2 - k for row k of constraints (in K); -2 for
 * another unknown (in Jacobians); -1 for none. */
PK_INLINE static ptrdiff_t pk_there(const struct pk_members *x, const struct pk_places *p,
                                    struct pk_walk at)
{
    const struct pk_unknown *u = p->of->unknowns + at.unknown;
    const ptrdiff_t *range = pk_range_of_family(x, u->family);
    ptrdiff_t m = range[1];

    if (u->kind == PK_NONE)
        return -1;
    if (at.unknown < p->of->slots) {
        m = at.m - u->ahead;
        if (u->n_wraps && (m > range[2] || m < range[1] || pk_wrapped(x, u, m)))
            m -= p->span;
        if (m < range[1] || m > range[2] || (u->n_wraps && pk_place(x, p, at.unknown, m) != at.i))
            return -1;
    }
    if (u->kind == PK_OTHER)
        return -2;
    return u->kind == PK_ROW ? -2 - (range[0] + m - range[1]) : range[0] + m - range[1];
}

PK_PERHAPS static ptrdiff_t pk_in_place(const struct pk_members *x, const struct pk_places *p,
                                        ptrdiff_t i)
{
    return pk_there(x, p, pk_walk_at(p, i));
}

/* -- entries --------------------------------------------------------------------------------- */

/* A row or column: an unknown of the layout, at index of_m * m + shift + at[extra]. */
struct pk_cell {
    int unknown, of_m;
    ptrdiff_t shift;
    int extra;
};

/* Value number `value` of terms, times `sign`, is added to an entry of output number `output`. */
struct pk_entry {
    int terms, value, sign, output;
    struct pk_cell row, column;
};

struct pk_matrix {
    const struct pk_terms *terms;
    const struct pk_entry *entries;
    int n_terms, n_entries, most; /* values of one term */
    ptrdiff_t chunk;
};

/* Uses of the entries of M or J: M to the lower triangle of K; J to K; the diagonal of M by
 * coordinates; |J| x and J^T x, added to out; the bands of `matrices` (struct pk_pattern). */
enum pk_use { PK_TO_M, PK_TO_K, PK_TO_DIAGONAL, PK_TO_SIZES, PK_TO_PULL, PK_TO_BANDS };
struct pk_into {
    enum pk_use use;
    struct pk_ldl A;
    const pk_real *x;
    pk_real *out, *matrices[3];
};

PK_PERHAPS static struct pk_into pk_into_of(enum pk_use use)
{
    const struct pk_ldl none = {0, 0, 0, 0, 0, 0, 0, NULL, NULL, NULL};
    struct pk_into to;

    to.use = use;
    to.A = none;
    to.x = NULL;
    to.out = to.matrices[0] = to.matrices[1] = to.matrices[2] = NULL;
    return to;
}

PK_PERHAPS static ptrdiff_t pk_cell_index(const struct pk_members *x, const struct pk_cell *of,
                                          ptrdiff_t m)
{
    return of->of_m * m + of->shift + (of->extra ? x->at[of->extra] : 0);
}

/* The number of a coordinate, or of a row of constraints; -1 if it is given. */
PK_PERHAPS static ptrdiff_t pk_number(const struct pk_members *x, const struct pk_places *p,
                                      int unknown, ptrdiff_t i)
{
    const struct pk_unknown *u = p->of->unknowns + unknown;
    const ptrdiff_t *range = pk_range_of_family(x, u->family);

    if (unknown >= p->of->slots)
        i = range[1];
    else if (u->homed)
        i = pk_member(x, p, u, i);
    return i < range[1] ? -1 : range[0] + i - range[1];
}

PK_PERHAPS static void pk_to_band(const struct pk_places *p, pk_real *A, ptrdiff_t i, ptrdiff_t j,
                                  pk_real x)
{
    const ptrdiff_t rows = p->banded, width = p->of->width, border = p->all - rows;
    const ptrdiff_t right = rows * (2 * width + 1);

    if (i < rows && j < rows)
        A[i * (2 * width + 1) + j - i + width] += x;
    else if (i < rows)
        A[right + i * border + j - rows] += x;
    else if (j < rows)
        A[right + (rows + j) * border + i - rows] += x;
    else
        A[right + (2 * rows + i - rows) * border + j - rows] += x;
}

/* Narrows the members m + lo .. m + hi - 1 to those at which a cell is a member itself, in the
 * band; *place is its place at m, and steps by the slots. */
PK_PERHAPS static void pk_straight(const struct pk_members *x, const struct pk_places *p,
                                   const struct pk_cell *of, ptrdiff_t m, ptrdiff_t *lo,
                                   ptrdiff_t *hi, ptrdiff_t *place)
{
    const struct pk_unknown *u = p->of->unknowns + of->unknown;
    const ptrdiff_t *range = pk_range_of_family(x, u->family), i = pk_cell_index(x, of, m);

    if (of->unknown >= p->of->slots || of->of_m != 1 || u->n_wraps) {
        *hi = *lo;
        return;
    }
    *place = (i + u->ahead - p->base) * p->of->slots + of->unknown;
    *lo = pk_most(*lo, range[1] - i);
    *hi = pk_least(*hi, range[2] + 1 - i);
    *hi = pk_least(*hi, (p->banded - 1 - *place) / p->of->slots + (p->banded > *place));
}

/* Adds x at places that are a step apart. */
PK_PERHAPS static void pk_add_steps(pk_real *to, ptrdiff_t step, ptrdiff_t n, pk_real sign,
                                    const pk_real *x)
{
    ptrdiff_t c;

    for (c = 0; c < n; c++)
        to[c * step] += sign * x[c];
}

/* Adds all entries of a matrix. */
PK_PERHAPS static void pk_scatter(const struct pk_members *x, const struct pk_places *p,
                                  const struct pk_matrix *of, pk_real *e, const struct pk_into *to)
{
    const int numbers = to->use >= PK_TO_DIAGONAL && to->use <= PK_TO_PULL;
    const ptrdiff_t width = p->of->width, slots = p->of->slots;
    pk_real *o[PK_MOST_VALUES];
    int g, k, next = 0;

    for (k = 0; k < of->most; k++)
        o[k] = e + k * of->chunk;
    for (g = 0; g < of->n_terms; g++) {
        const struct pk_terms *terms = of->terms + g;
        const int first = next;
        ptrdiff_t m, n, c;
        while (next < of->n_entries && of->entries[next].terms == g)
            next++;
        for (m = x->at[terms->over]; m <= x->at[terms->over + 1]; m += n) {
            n = pk_least(pk_least(of->chunk, PK_BLOCK), x->at[terms->over + 1] + 1 - m);
            terms->values(x, 0, m, n, o);
            for (k = first; k < next; k++) {
                const struct pk_entry *entry = of->entries + k;
                const pk_real sign = (pk_real)entry->sign, *value = o[entry->value];
                ptrdiff_t lo = 0, hi = numbers ? 0 : n, of_row = 0, of_column = 0;
                pk_straight(x, p, &entry->row, m, &lo, &hi, &of_row);
                pk_straight(x, p, &entry->column, m, &lo, &hi, &of_column);
                if (lo < hi && to->use == PK_TO_BANDS)
                    pk_add_steps(to->matrices[entry->output] + of_row * (2 * width + 1) +
                                     of_column - of_row + width + lo * slots * (2 * width + 1),
                                 slots * (2 * width + 1), hi - lo, sign, value + lo);
                else if (lo < hi && (to->use == PK_TO_K || of_row >= of_column))
                    pk_add_steps(pk_ldl_entry(&to->A, pk_most(of_row, of_column) + lo * slots,
                                              pk_least(of_row, of_column) + lo * slots),
                                 slots * to->A.apart, hi - lo, sign, value + lo);
                for (c = 0; c < n; c++) {
                    ptrdiff_t row, column, i, j;
                    pk_real one;
                    if (c == lo && lo < hi && (c = hi) >= n)
                        break;
                    row = pk_cell_index(x, &entry->row, m + c);
                    column = pk_cell_index(x, &entry->column, m + c);
                    i = (numbers ? pk_number : pk_place)(x, p, entry->row.unknown, row);
                    j = (numbers ? pk_number : pk_place)(x, p, entry->column.unknown, column);
                    one = sign * value[c];
                    if (i < 0 || j < 0)
                        continue;
                    switch (to->use) {
                    case PK_TO_M:
                        if (i >= j)
                            *pk_ldl_entry(&to->A, i, j) += one;
                        break;
                    case PK_TO_K:
                        *pk_ldl_entry(&to->A, pk_most(i, j), pk_least(i, j)) += one;
                        break;
                    case PK_TO_DIAGONAL:
                        if (i == j)
                            to->out[i] += one;
                        break;
                    case PK_TO_SIZES:
                        to->out[i] += PK_F(fabs)(one) * to->x[j];
                        break;
                    case PK_TO_PULL:
                        to->out[j] += one * to->x[i];
                        break;
                    default:
                        pk_to_band(p, to->matrices[entry->output], i, j, one);
                    }
                }
            }
        }
    }
}

/* -- M and K --------------------------------------------------------------------------------- */

PK_PERHAPS static size_t pk_matrix_size(const struct pk_places *p)
{
    return (size_t)(p->banded * (p->of->width + 1) + (p->all - p->banded) * p->all);
}

PK_PERHAPS static struct pk_ldl pk_lower(const struct pk_places *p, pk_real *M)
{
    const ptrdiff_t width = p->of->width, all = p->all;
    struct pk_ldl A = {0, 0, 0, 0, 0, 1, 0, NULL, NULL, NULL};

    A.rows = p->banded, A.width = width, A.border = all - p->banded;
    A.apart = width + 1, A.down = A.across = all;
    A.band = M + width;
    A.below = M + p->banded * (width + 1);
    A.corner = A.below + p->banded;
    return A;
}

/* Writes M, in the shape of K: 1 on the diagonal where nothing is, 0 in rows of constraints. */
PK_PERHAPS static void pk_inertia(const struct pk_members *x, const struct pk_places *p,
                                  const struct pk_matrix *mass, pk_real *e, pk_real *M)
{
    const size_t size = pk_matrix_size(p);
    struct pk_into to = pk_into_of(PK_TO_M);
    struct pk_walk at = pk_walk_at(p, 0);
    size_t k;

    to.A = pk_lower(p, M);
    for (k = 0; k < size; k++)
        M[k] = 0;
    for (; at.i < p->all; pk_walk_on(p, &at))
        if (pk_there(x, p, at) < 0)
            *pk_ldl_entry(&to.A, at.i, at.i) = 1;
    pk_scatter(x, p, mass, e, &to);
}

/* Adds the entries of J to K; clears the diagonal of its rows. */
PK_PERHAPS static void pk_tie(const struct pk_members *x, const struct pk_places *p,
                              const struct pk_matrix *J, pk_real *e, pk_real *K)
{
    struct pk_into to = pk_into_of(PK_TO_K);
    int k;

    to.A = pk_lower(p, K);
    for (k = 0; k < J->n_entries; k++) {
        const struct pk_entry *entry = J->entries + k;
        const int over = J->terms[entry->terms].over;
        ptrdiff_t m;
        if (k && entry[-1].terms == entry->terms && entry[-1].row.unknown == entry->row.unknown)
            continue;
        for (m = x->at[over]; m <= x->at[over + 1]; m++) {
            const ptrdiff_t i =
                pk_place(x, p, entry->row.unknown, pk_cell_index(x, &entry->row, m));
            *pk_ldl_entry(&to.A, i, i) = 0;
        }
    }
    pk_scatter(x, p, J, e, &to);
}

/* Returns the sum of J_k^2 / M_k over the scalars k of row i. */
PK_PERHAPS static pk_real pk_by_scalars(const struct pk_members *x, const struct pk_places *p,
                                        const struct pk_ldl *A, ptrdiff_t i)
{
    pk_real sum = 0;
    ptrdiff_t k;

    for (k = p->places; k < p->all; k++) {
        const pk_real of_i = *pk_ldl_entry(A, k, i), own = *pk_ldl_entry(A, k, k);
        if (pk_in_place(x, p, k) >= 0)
            sum += own > 0 ? of_i * of_i / own : 0;
    }
    return sum;
}

/* Returns the coordinate that an error message names for place i: one at its index, or the last
 * before it. Coordinates are numbered before carried values, from `count` on. */
PK_PERHAPS static ptrdiff_t pk_moved(const struct pk_members *x, const struct pk_places *p,
                                     ptrdiff_t count, ptrdiff_t i)
{
    const ptrdiff_t slots = p->of->slots, last = i < p->places ? i - i % slots + slots : i + 1;
    ptrdiff_t j, own;

    for (j = i; j < last; j++)
        if ((own = pk_in_place(x, p, j)) >= 0 && own < count)
            return own;
    for (j = i; j-- > 0;)
        if ((own = pk_in_place(x, p, j)) >= 0 && own < count)
            return own;
    return 0;
}

/* The diagonal entry of J M^-1 J^T for one constraint row, without the other rows. */
PK_PERHAPS static pk_real pk_norm(const struct pk_members *x, const struct pk_places *p,
                                  const struct pk_ldl *A, ptrdiff_t i)
{
    pk_real sum = 0;
    ptrdiff_t j;

    for (j = i < A->rows ? pk_ldl_first(A, i) : 0; j < i; j++) {
        const pk_real of_j = *pk_ldl_entry(A, i, j);
        if (pk_in_place(x, p, j) >= -1)
            sum += of_j * of_j / *pk_ldl_entry(A, j, j);
    }
    return sum;
}

/* Factors K = L D L^T in place. Returns 0, or the failure of a pivot that is not positive, or of
 * a row of constraints not negative. `count` is the number of coordinates. Writes the pivots of
 * rows, and what these are without other rows, unless both are NULL.
 *
 * A row may be regular by a scalar coordinate alone, which comes behind it. Its pivot d, about
 * 0, is lowered by s. One more unknown z, behind all others, restores s: its equation is s x = s
 * z. The pivot of z is -s t / (s + t), where t is the row's own behind all others. `spared` has
 * the place of the row for each such z. */
PK_PERHAPS static int pk_factored(const struct pk_members *x, const struct pk_places *p,
                                  ptrdiff_t count, pk_real *K, pk_real *spared, pk_real *pivots,
                                  pk_real *norms)
{
    const struct pk_ldl A = pk_lower(p, K);
    const int spares = p->of->spares, carried = p->of->carried;
    const ptrdiff_t all = p->all;
    struct pk_walk walk = pk_walk_at(p, 0);
    ptrdiff_t i, used = 0;

    for (i = 0; i < spares; i++)
        spared[i] = -1;
    for (i = 0; i < all; pk_walk_on(p, &walk), i++) {
        const pk_real diagonal = *pk_ldl_entry(&A, i, i);
        const ptrdiff_t own = pk_there(x, p, walk), row = -2 - own, spare = i - all + spares;
        pk_real added, pivot = pk_ldl_pivot(&A, i, &added);
        if (carried && diagonal == 0 && own == -1 && spare < 0) {
            if (!(pivot < 0))
                return PK_FAILED(PK_FAILURE_MASS, pk_moved(x, p, count, i));
        } else if (!(diagonal > 0) && own < -1) {
            pk_real more = 0;
            if (i < p->places && used < spares)
                more = pk_by_scalars(x, p, &A, i) + (carried ? added : 0);
            if (more > 0 && -pivot < PK_C(1e-4) * more) {
                const ptrdiff_t at = all - spares + used;
                spared[used++] = (pk_real)i;
                *pk_ldl_entry(&A, at, i) = more;
                *pk_ldl_entry(&A, at, at) = -more;
                pivot -= more;
                if (norms)
                    norms[row] = (carried ? pk_norm(x, p, &A, i) : added) + more;
            } else {
                if (!(-pivot > PK_PIVOT_MIN * added))
                    return PK_FAILED(PK_FAILURE_CONSTRAINT, row);
                if (pivots)
                    pivots[row] = -pivot, norms[row] = carried ? pk_norm(x, p, &A, i) : added;
            }
        } else if (spare >= 0 && spared[spare] >= 0) {
            const ptrdiff_t of = -2 - pk_in_place(x, p, (ptrdiff_t)spared[spare]);
            if (!(-pivot > PK_PIVOT_MIN * -diagonal))
                return PK_FAILED(PK_FAILURE_CONSTRAINT, of);
            if (pivots)
                pivots[of] = pivot * diagonal / (pivot - diagonal);
        } else if (!(diagonal > 0 && pivot > PK_PIVOT_MIN * diagonal))
            return PK_FAILED(PK_FAILURE_MASS, carried ? pk_moved(x, p, count, i) : own);
        *pk_ldl_entry(&A, i, i) = 1 / pivot;
    }
    return 0;
}

/* Solves M d - J^T mu = f, J d = r, for factored K; f NULL means 0; r and mu are not used without
 * rows. z has room for all unknowns. */
PK_PERHAPS static void pk_solved(const struct pk_members *x, const struct pk_places *p,
                                 ptrdiff_t count, pk_real *K, pk_real *z, const pk_real *f,
                                 const pk_real *r, pk_real *d, pk_real *mu)
{
    const struct pk_ldl A = pk_lower(p, K);
    struct pk_walk at = pk_walk_at(p, 0);

    for (; at.i < p->all; pk_walk_on(p, &at)) {
        const ptrdiff_t own = pk_there(x, p, at);
        z[at.i] = own >= 0 ? (f ? f[own] : 0) : own < -1 ? r[-2 - own] : 0;
    }
    pk_ldl_substitute(&A, z);
    for (at = pk_walk_at(p, 0); at.i < p->all; pk_walk_on(p, &at)) {
        const ptrdiff_t own = pk_there(x, p, at);
        if (own >= 0 && own < count)
            d[own] = z[at.i];
        else if (own < -1)
            mu[-2 - own] = -z[at.i];
    }
}

/* For the row of constraints that had no pivot: L^T z = its unit vector, so that K z = 0. Writes
 * the coefficients of the rows, that of the row itself 1. */
PK_PERHAPS static void pk_shares(const struct pk_members *x, const struct pk_places *p, pk_real *K,
                                 pk_real *z, const pk_real *spared, ptrdiff_t rows, ptrdiff_t row,
                                 pk_real *out)
{
    const struct pk_ldl A = pk_lower(p, K);
    ptrdiff_t i, last = 0;

    for (i = 0; i < p->all; i++) {
        const ptrdiff_t own = pk_in_place(x, p, i);
        z[i] = 0;
        if (own < -1)
            out[-2 - own] = 0;
        if (own == -2 - row)
            last = i;
    }
    for (i = 0; i < p->of->spares; i++)
        if ((ptrdiff_t)spared[i] == last)
            last = p->all - p->of->spares + i;
    z[last] = 1;
    pk_ldl_back(&A, last + 1, z);
    for (i = 0; i <= last; i++) {
        const ptrdiff_t own = pk_in_place(x, p, i);
        if (own < -1)
            out[-2 - own] = z[i];
    }
    for (i = 0; i < rows; i++)
        z[i] = out[i] / out[row];
    for (i = 0; i < rows; i++)
        out[i] = z[i];
}

/* D of M = L D L^T by coordinate: 0 where it is not positive, behind that the diagonal of M. */
PK_PERHAPS static void pk_pivots(const struct pk_members *x, const struct pk_places *p,
                                 ptrdiff_t count, pk_real *K, int failed, pk_real *out)
{
    const struct pk_ldl A = pk_lower(p, K);
    ptrdiff_t i;
    int behind = 0;

    for (i = 0; i < p->all; i++) {
        const ptrdiff_t own = pk_in_place(x, p, i);
        const pk_real kept = *pk_ldl_entry(&A, i, i);
        if (own < 0 || own >= count)
            continue;
        out[own] = failed && own == PK_FAILURE_AT(failed) ? 0 : behind ? kept : 1 / kept;
        behind |= failed && own == PK_FAILURE_AT(failed);
    }
}

/* -- Jacobians ------------------------------------------------------------------------------- */

/* Writes matrices in bands. With `ones` the diagonal of the first is 1 where no unknown is; with
 * ones > 1 wherever no coordinate is. */
PK_PERHAPS static void pk_bands(const struct pk_members *x, const struct pk_places *p,
                                const struct pk_matrix *of, pk_real *e, int ones, int n, pk_real *a,
                                pk_real *b, pk_real *c)
{
    const ptrdiff_t border = p->all - p->banded;
    const ptrdiff_t size = p->banded * (2 * p->of->width + 1) + (2 * p->banded + border) * border;
    struct pk_into to = pk_into_of(PK_TO_BANDS);
    struct pk_walk at;
    ptrdiff_t i;
    int k;

    to.matrices[0] = a, to.matrices[1] = b, to.matrices[2] = c;
    for (k = 0; k < n; k++)
        for (i = 0; i < size; i++)
            to.matrices[k][i] = 0;
    for (at = pk_walk_at(p, 0); ones && at.i < p->all; pk_walk_on(p, &at)) {
        const ptrdiff_t own = pk_there(x, p, at);
        if (own == -1 || (ones > 1 && own < 0))
            pk_to_band(p, a, at.i, at.i, 1);
    }
    pk_scatter(x, p, of, e, &to);
}

#endif

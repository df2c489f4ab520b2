/* LU factorisation of a band matrix with a border; see band.h. Elimination of the band updates the
 * border's rows and columns and leaves a dense system for the border's unknowns. Rows are exchanged
 * only within the band, so a pivot may be small although the whole matrix is regular. Examples are
 * the last pivot of the band of a cyclic chain, and pivots of saddle-point matrices. If the pivot
 * of column k is small, a number s is added to it, where |s| is the largest entry of the column. To
 * correct for this, z = s x_k becomes an additional unknown with column -e_k and row s e_k in a
 * spare part of the border. This is exact, and no pivot is much smaller than its column.
 *
 * References: G. H. Golub, C. F. Van Loan, Matrix Computations, 4th ed., 4.3.3 (band elimination
 * with pivoting); W. Govaerts, J. D. Pryce, IMA J. Numer. Anal. 13 (1993) 161, for bordered systems
 * whose block is nearly singular. */
#include <string.h>

#include "band.h"

#include <pk/ldl.h>

/* A pivot below SMALL times the largest entry of its column would cost a quarter of the digits. */
#define SMALL PK_F(sqrt)(PK_F(sqrt)(PK_EPS))

static size_t stride(const struct pk_band *b)
{
    return b->border + (b->pivoting && b->rows ? PK_BAND_SPARE : 0);
}

/* Returns row i of the band, so that [j] is the entry in column j. */
static pk_real *row(const struct pk_band *b, size_t i)
{
    const size_t width = b->below + 1 + b->above + (b->pivoting ? b->below : 0);
    return b->entries + (ptrdiff_t)(i * width + b->below) - (ptrdiff_t)i;
}

static size_t least(size_t a, size_t b) { return a < b ? a : b; }
static size_t first(const struct pk_band *b, size_t i) { return i > b->below ? i - b->below : 0; }
static size_t last(const struct pk_band *b, size_t i) { return least(b->rows, i + b->above + 1); }

size_t pk_band_lay_out(struct pk_band *b, pk_real *base)
{
    const size_t n = b->rows, k = stride(b), more = b->pivoting ? 1 : 0;
    /* clang-format off */
    const struct pk_slot slots[] = {
        {&b->entries, n * (b->below + 1 + b->above + more * b->below)}, {&b->right, n * k},
        {&b->bottom, n * k}, {&b->corner, k * k}, {&b->pivot, more * (n + k)},
        {&b->column, more * n}, {&b->rest, more * k}, {&b->used, more}};
    /* clang-format on */
    return PK_LAY_OUT(base, slots);
}

void pk_band_clear(const struct pk_band *b)
{
    pk_zero(b->entries, (size_t)(b->corner - b->entries));
    pk_zero(b->corner, stride(b) * stride(b));
    if (b->pivoting)
        *b->used = (pk_real)b->border;
}

pk_real *pk_band_entry(const struct pk_band *b, size_t i, size_t j)
{
    const size_t n = b->rows, k = stride(b);
    if (i < n && j < n)
        return j + b->below >= i && j <= i + b->above ? row(b, i) + j : NULL;
    if (i < n)
        return b->right + i * k + (j - n);
    return j < n ? b->bottom + j * k + (i - n) : b->corner + (i - n) * k + (j - n);
}

#define ADD_PRODUCT(name, of)                                        \
    void name(const struct pk_band *b, const pk_real *x, pk_real *y) \
    {                                                                \
        const size_t n = b->rows, k = stride(b);                     \
        for (size_t c = 0; c < b->border; c++)                       \
            for (size_t d = 0; d < b->border; d++)                   \
                y[n + c] += of(b->corner[c * k + d]) * x[n + d];     \
        for (size_t i = 0; i < n; i++) {                             \
            for (size_t j = first(b, i); j < last(b, i); j++)        \
                y[i] += of(row(b, i)[j]) * x[j];                     \
            for (size_t c = 0; c < b->border; c++) {                 \
                y[i] += of(b->right[i * k + c]) * x[n + c];          \
                y[n + c] += of(b->bottom[i * k + c]) * x[i];         \
            }                                                        \
        }                                                            \
    }
ADD_PRODUCT(pk_band_add_product, )
ADD_PRODUCT(pk_band_add_sizes, pk_abs)

/* Computes the largest entry of each column of the band, including the border's rows. */
static void measure_columns(const struct pk_band *b)
{
    const size_t n = b->rows, k = stride(b);
    for (size_t j = 0; j < n; j++) {
        b->column[j] = 0;
        for (size_t c = 0; c < b->border; c++)
            b->column[j] = pk_max(b->column[j], pk_abs(b->bottom[j * k + c]));
    }
    for (size_t i = 0; i < n; i++) {
        const pk_real *A = row(b, i);
        for (size_t j = first(b, i); j < last(b, i); j++)
            b->column[j] = pk_max(b->column[j], pk_abs(A[j]));
    }
}

static void exchange(pk_real *x, pk_real *y, size_t count)
{
    for (size_t j = 0; j < count; j++) {
        const pk_real swap = x[j];
        x[j] = y[j];
        y[j] = swap;
    }
}

/* Makes the pivot of column k as large as `size`, the largest entry of this column, by an additional
 * unknown. */
static void mend(const struct pk_band *b, size_t k, pk_real size)
{
    const size_t width = stride(b), z = pk_index(*b->used, width);
    pk_real *pivot = row(b, k) + k;
    const pk_real added = size > 0 ? size : 1, pull = *pivot < 0 ? -added : added;
    *pivot += pull;
    *b->used += 1;
    b->right[k * width + z] = -1;
    b->bottom[k * width + z] = pull;
    b->corner[z * width + z] = -1;
}

int pk_band_factor(const struct pk_band *b)
{
    const size_t n = b->rows, width = stride(b);
    /* filled: all rows up to the current one are 0 from this column on */
    size_t filled = 0, used = b->border;
    *b->used = (pk_real)used;
    measure_columns(b);
    for (size_t k = 0; k < n; k++) {
        const size_t end = least(n, k + b->below + 1);
        size_t best = k;
        for (size_t i = k + 1; i < end; i++)
            if (pk_abs(row(b, i)[k]) > pk_abs(row(b, best)[k]))
                best = i;
        b->pivot[k] = (pk_real)best; /* stored as pk_real, like the rest of the work memory */
        const size_t reach = last(b, best);
        filled = reach > filled ? reach : filled;
        const pk_real size = b->column[k];
        b->column[k] = (pk_real)filled;
        if (best != k) {
            exchange(row(b, k) + k, row(b, best) + k, filled - k);
            exchange(b->right + k * width, b->right + best * width, used);
        }
        if (!(pk_abs(row(b, k)[k]) > SMALL * size) && used < width) {
            mend(b, k, size);
            used++;
        }
        const pk_real *U = row(b, k), d = U[k], *right = b->right + k * width;
        pk_real *L = row(b, k) + k - b->below; /* room for the multipliers of column k */
        if (!(pk_abs(d) > 0) || !pk_finite(d))
            return 0;
        for (size_t i = k + 1; i < end; i++) {
            pk_real *A = row(b, i);
            const pk_real l = A[k] / d;
            L[i - k - 1] = l;
            if (pk_abs(l) <= 0) /* most entries inside a band of several stages are 0 */
                continue;
            for (size_t j = k + 1; j < filled; j++)
                A[j] -= l * U[j];
            for (size_t c = 0; c < used; c++)
                b->right[i * width + c] -= l * right[c];
        }
        for (size_t c = 0; c < used; c++) {
            const pk_real l = b->bottom[k * width + c] / d;
            b->bottom[k * width + c] = l;
            for (size_t j = k + 1; j < filled; j++)
                b->bottom[j * width + c] -= l * U[j];
            for (size_t e = 0; e < used; e++)
                b->corner[c * width + e] -= l * right[e];
        }
    }
    /* removes the unused spare columns: the rows become contiguous */
    for (size_t c = 0; c < used && width > used; c++)
        memmove(b->corner + c * used, b->corner + c * width, used * sizeof *b->corner);
    return pk_lu_factor(b->corner, b->pivot + n, used);
}

/* Returns the scalar product of two vectors, in four sums that do not wait for each other. */
static pk_real product(const pk_real *x, const pk_real *y, size_t count)
{
    pk_real sums[4] = {0, 0, 0, 0};
    size_t j = 0;
    for (; j + 4 <= count; j += 4)
        for (size_t c = 0; c < 4; c++)
            sums[c] += x[j + c] * y[j + c];
    for (; j < count; j++)
        sums[0] += x[j] * y[j];
    return (sums[0] + sums[1]) + (sums[2] + sums[3]);
}

void pk_band_solve(const struct pk_band *b, pk_real *x)
{
    const size_t n = b->rows, width = stride(b), used = pk_index(*b->used, width + 1);
    pk_real *y = b->rest;
    if (!n) {
        pk_lu_solve(b->corner, b->pivot, used, x);
        return;
    }
    for (size_t c = 0; c < used; c++)
        y[c] = c < b->border ? x[n + c] : 0;
    for (size_t k = 0; k < n; k++) {
        const size_t best = pk_index(b->pivot[k], n), end = least(n, k + b->below + 1);
        const pk_real swap = x[k];
        x[k] = x[best];
        x[best] = swap;
        const pk_real *L = row(b, k) + k - b->below;
        for (size_t i = k + 1; i < end; i++)
            x[i] -= L[i - k - 1] * x[k];
        for (size_t c = 0; c < used; c++)
            y[c] -= b->bottom[k * width + c] * x[k];
    }
    pk_lu_solve(b->corner, b->pivot + n, used, y);
    pk_copy(x + n, y, b->border);
    for (size_t k = n; k-- > 0;) {
        const pk_real *U = row(b, k);
        const size_t start = k + 1, end = pk_index(b->column[k], n + 1);
        const size_t count = end > start ? end - start : 0; /* a restored value may be invalid */
        for (size_t c = 0; c < used; c++)
            x[k] -= b->right[k * width + c] * y[c];
        x[k] = (x[k] - product(U + start, x + start, count)) / U[k];
    }
}

static struct pk_ldl lower(const struct pk_band *b)
{
    const ptrdiff_t k = (ptrdiff_t)stride(b);
    return (struct pk_ldl){(ptrdiff_t)b->rows,
                           (ptrdiff_t)b->below,
                           (ptrdiff_t)b->border,
                           (ptrdiff_t)(b->below + 1 + b->above),
                           1,
                           k,
                           k,
                           b->entries + b->below,
                           b->bottom,
                           b->corner};
}

size_t pk_band_ldl_factor(const struct pk_band *b, const pk_real *place)
{
    if (!b->rows)
        return pk_ldl_factor(b->corner, b->border);
    const struct pk_ldl A = lower(b);
    for (ptrdiff_t i = 0; i < A.rows + A.border; i++) {
        pk_real *diagonal = pk_ldl_entry(&A, i, i), added;
        const pk_real pivot = pk_ldl_pivot(&A, i, &added);
        const int row = place && place[i] < 0 && pivot < 0;
        if (!pk_finite(pivot) || !(row || (pivot > PK_PIVOT_MIN * *diagonal && pivot > 0)))
            return 1 + (size_t)i;
        *diagonal = 1 / pivot;
    }
    return 0;
}

void pk_band_ldl_solve(const struct pk_band *b, pk_real *x)
{
    const struct pk_ldl A = lower(b);
    if (b->rows)
        pk_ldl_substitute(&A, x);
    else
        pk_ldl_solve(b->corner, b->border, x);
}

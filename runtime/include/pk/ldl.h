/* Factors a symmetric matrix as L D L^T in place, row by row without pivoting: a band, followed by
 * a border of dense rows. Entry (i, j) of the lower triangle is
 *
 *     band[i * apart + j - i],  i - width <= j                 i < rows
 *     below[(i - rows) * down + j * along],  j < rows          else
 *     corner[(i - rows) * across + j - rows]
 *
 * 1/D is stored in place of D. The caller checks the pivots.
 *
 * Reference: G. H. Golub, C. F. Van Loan, Matrix Computations, 4th ed., 4.3.
 *
 * MIT-0: pkgen pastes this text into the files that it generates; see LICENSE. */
#ifndef PK_LDL_H
#define PK_LDL_H

struct pk_ldl {
    ptrdiff_t rows, width, border, apart, down, along, across;
    pk_real *band, *below, *corner;
};

/* Returns the first column of a row of the band. */
PK_INLINE static ptrdiff_t pk_ldl_first(const struct pk_ldl *A, ptrdiff_t i)
{
    return i > A->width ? i - A->width : 0;
}

/* Returns a pointer x to row i of the band: x[j] is the entry in column j. */
PK_INLINE static pk_real *pk_ldl_row(const struct pk_ldl *A, ptrdiff_t i)
{
    return A->band + i * (A->apart - 1);
}

/* Returns entry (i, j), j <= i. */
PK_INLINE static pk_real *pk_ldl_entry(const struct pk_ldl *A, ptrdiff_t i, ptrdiff_t j)
{
    const ptrdiff_t n = A->rows;
    if (i < n)
        return pk_ldl_row(A, i) + j;
    return j < n ? A->below + (i - n) * A->down + j * A->along
                 : A->corner + (i - n) * A->across + j - n;
}

/* Pointers to one row of the matrix, with A->rows rows in the band: the entry in column j is row[j
 * * step] if j < A->rows, otherwise corner[j]. */
struct pk_ldl_parts {
    pk_real *row, *corner;
    ptrdiff_t step, from, to; /* stored columns of the band: from .. to - 1 */
};
PK_INLINE static struct pk_ldl_parts pk_ldl_parts(const struct pk_ldl *A, ptrdiff_t i)
{
    const ptrdiff_t n = A->rows;
    struct pk_ldl_parts of = {pk_ldl_row(A, i), pk_ldl_row(A, i), 1, pk_ldl_first(A, i), i};
    if (i >= n) {
        of.row = A->below + (i - n) * A->down;
        of.corner = A->corner + (i - n) * A->across - n;
        of.step = A->along;
        of.from = 0;
        of.to = n;
    }
    return of;
}

/* Replaces the entries of a row in the columns before A->rows by the entries of L D. */
PK_INLINE static void pk_ldl_multiply(const struct pk_ldl *A, pk_real *row, ptrdiff_t step,
                                      ptrdiff_t from, ptrdiff_t to)
{
    ptrdiff_t j, k;
    for (j = from; j < to; j++) {
        const pk_real *other = pk_ldl_row(A, j);
        const ptrdiff_t first = pk_ldl_first(A, j);
        pk_real sum = row[j * step];
        for (k = first > from ? first : from; k < j; k++)
            sum -= row[k * step] * other[k];
        row[j * step] = sum;
    }
}

/* Replaces *x, an entry of L D, by the entry of L, its product with `inverse` = 1/D. Returns the
 * product of both entries, which is to be subtracted from the pivot of the row. */
PK_INLINE static pk_real pk_ldl_scale(pk_real *x, pk_real inverse)
{
    const pk_real scaled = *x;
    *x = scaled * inverse;
    return scaled * *x;
}

/* Replaces row i by the row of L; all rows before it must have been replaced. Returns the pivot of
 * row i: its diagonal entry less a sum of terms. *added is the sum of the positive ones of these
 * terms. */
PK_INLINE static pk_real pk_ldl_pivot(const struct pk_ldl *A, ptrdiff_t i, pk_real *added)
{
    const ptrdiff_t n = A->rows;
    const struct pk_ldl_parts of = pk_ldl_parts(A, i);
    pk_real pivot = of.corner[i], less, more = 0;
    ptrdiff_t j, k;

    if (i < n)
        pk_ldl_multiply(A, of.row, 1, of.from, i);
    else
        pk_ldl_multiply(A, of.row, of.step, 0, n);
    for (j = n; j < i; j++) {
        const struct pk_ldl_parts other = pk_ldl_parts(A, j);
        pk_real sum = of.corner[j];
        for (k = 0; k < n; k++)
            sum -= of.row[k * of.step] * other.row[k * of.step];
        for (k = n; k < j; k++)
            sum -= of.corner[k] * other.corner[k];
        of.corner[j] = sum;
    }
    for (j = of.from; j < of.to; j++) {
        less = pk_ldl_scale(&of.row[j * of.step], A->band[j * A->apart]);
        pivot -= less;
        more += less > 0 ? less : 0;
    }
    for (j = n; j < i; j++) {
        less = pk_ldl_scale(&of.corner[j], A->corner[(j - n) * (A->across + 1)]);
        pivot -= less;
        more += less > 0 ? less : 0;
    }
    *added = more;
    return pivot;
}

/* Solves L^T y = x in place; only x[0 .. end - 1] may be nonzero. */
PK_INLINE static void pk_ldl_back(const struct pk_ldl *A, ptrdiff_t end, pk_real *x)
{
    ptrdiff_t i, j;
    for (i = end; i-- > 0;) {
        const struct pk_ldl_parts of = pk_ldl_parts(A, i);
        for (j = A->rows; j < i; j++)
            x[j] -= of.corner[j] * x[i];
        for (j = of.from; j < of.to; j++)
            x[j] -= of.row[j * of.step] * x[i];
    }
}

/* Solves A y = x in place. */
PK_INLINE static void pk_ldl_substitute(const struct pk_ldl *A, pk_real *x)
{
    const ptrdiff_t all = A->rows + A->border;
    ptrdiff_t i, j;
    for (i = 0; i < all; i++) {
        const struct pk_ldl_parts of = pk_ldl_parts(A, i);
        for (j = of.from; j < of.to; j++)
            x[i] -= of.row[j * of.step] * x[j];
        for (j = A->rows; j < i; j++)
            x[i] -= of.corner[j] * x[j];
    }
    for (i = 0; i < all; i++)
        x[i] *= *pk_ldl_entry(A, i, i);
    pk_ldl_back(A, all, x);
}

#endif

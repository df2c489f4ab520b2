/* Linear systems in O(N): a band with a border of dense rows and columns behind it. Partial
 * pivoting within the band. The band alone may be singular, as that of a ring is: see band.c.
 */
#ifndef PK_BAND_H
#define PK_BAND_H

#include "internal.h"

/* So many rows of a band that is to be factored may have no pivot of their own. */
enum { PK_BAND_SPARE = 4 };

/* The unknowns are rows + border; row i of the band reaches columns i - below .. i + above. A dense
 * matrix has no rows but its border: `corner` is that matrix, row-major. */
struct pk_band {
    size_t rows, below, above, border;
    int pivoting; /* whether there is memory for pk_band_factor() */
    /* Rows of below + 1 + above, and where pivoting as many as `below` for what that fills; the
     * columns of the border, one row of the matrix after the other; its rows, one column after the
     * other; what both share, by rows. */
    pk_real *entries, *right, *bottom, *corner;
    pk_real *pivot, *column, *rest; /* where pivoting */
    pk_real *used; /* likewise: columns of the border and spare ones, kept as a number */
};

/* The numbers of a matrix as a kernel of that pattern writes it: a band without pivoting. */
static inline size_t pk_pattern_numbers(const struct pk_pattern *p)
{
    return p->rows * (2 * p->width + 1) + (2 * p->rows + p->border) * p->border;
}

/* Lays out the memory of a matrix of the shape in `band`, the four parts in their order first;
 * numbers of pk_real, all there is where base is NULL. */
size_t pk_band_lay_out(struct pk_band *band, pk_real *base);
/* All entries 0: before they are set, again after each factorisation. */
void pk_band_clear(const struct pk_band *band);
/* Entry (i, j), i and j < rows + border; NULL of one that is 0 by the shape. */
pk_real *pk_band_entry(const struct pk_band *band, size_t i, size_t j);
/* y += A x, or |A| x; not of what is factored. */
void pk_band_add_product(const struct pk_band *band, const pk_real *x, pk_real *y);
void pk_band_add_sizes(const struct pk_band *band, const pk_real *x, pk_real *y);
/* In place, where pivoting; 0 where A is singular. Backward errors are up to PK_EPS^(3/4), most of
 * them far less. */
int pk_band_factor(const struct pk_band *band);
/* x = A^-1 x of what is factored. */
void pk_band_solve(const struct pk_band *band, pk_real *x);
/* A = L D L^T in place, A symmetric: what is above the diagonal is not read, nor `right`. 0, or
 * 1 + i where pivot i is not positive, as of pk_ldl_factor(); where place[i] < 0 (NULL: nowhere) it
 * may be negative, of a row that is no coordinate's. */
size_t pk_band_ldl_factor(const struct pk_band *band, const pk_real *place);
void pk_band_ldl_solve(const struct pk_band *band, pk_real *x);

#endif

/* Linear systems in O(N): a band matrix with a border of dense rows and columns after the band.
 * Pivoting is partial, within the band. The band itself may be singular: see band.c. */
#ifndef PK_BAND_H
#define PK_BAND_H

#include "internal.h"

/* The number of spare columns: the most columns of the band whose pivot may be too small. */
enum { PK_BAND_SPARE = 4 };

/* There are rows + border unknowns; row i of the band has columns i - below .. i + above. A dense
 * matrix has rows = 0: then `corner` is that matrix, row-major. */
struct pk_band {
    size_t rows, below, above, border;
    int pivoting; /* 1: memory for pk_band_factor() is available */
    /* entries: the rows of the band, each of below + 1 + above numbers, and, if `pivoting`, `below`
     * more for fill-in. right: the columns of the border beside the band, stored row by row.
     * bottom: the rows of the border below the band, column by column. corner: the block where rows
     * and columns of the border meet, row-major. */
    pk_real *entries, *right, *bottom, *corner;
    pk_real *pivot, *column, *rest; /* work memory, used only if `pivoting` */
    /* one number, used only if `pivoting`: columns of the border and spare ones in use */
    pk_real *used;
};

/* Returns the number of entries of a matrix with this pattern, as kernels write it. */
static inline size_t pk_pattern_numbers(const struct pk_pattern *p)
{
    return p->rows * (2 * p->width + 1) + (2 * p->rows + p->border) * p->border;
}

/* Divides the memory at `base` among the arrays of a matrix whose shape is set in `band`; entries,
 * right, bottom and corner come first. Returns the number of pk_real; base may be NULL. */
size_t pk_band_lay_out(struct pk_band *band, pk_real *base);
/* Sets all entries to 0; needed before entries are set, also after a factorisation. */
void pk_band_clear(const struct pk_band *band);
/* Returns entry (i, j), i and j < rows + border; NULL if it is outside band and border. */
pk_real *pk_band_entry(const struct pk_band *band, size_t i, size_t j);
/* Compute y += A x and y += |A| x; A must not be factored. */
void pk_band_add_product(const struct pk_band *band, const pk_real *x, pk_real *y);
void pk_band_add_sizes(const struct pk_band *band, const pk_real *x, pk_real *y);
/* Factors A in place, with pivoting. Returns 0 if A is singular. Errors are below PK_EPS^(3/4). */
int pk_band_factor(const struct pk_band *band);
/* Computes x = A^-1 x with the factors of A. */
void pk_band_solve(const struct pk_band *band, pk_real *x);
/* Factors A = L D L^T in place, A symmetric; entries above the diagonal and `right` are not read.
 * Returns 0, or 1 + i if pivot i is not positive, as pk_ldl_factor(). If place[i] < 0, unknown i is
 * no coordinate but an additional unknown, whose pivot may be negative. place may be NULL. */
size_t pk_band_ldl_factor(const struct pk_band *band, const pk_real *place);
void pk_band_ldl_solve(const struct pk_band *band, pk_real *x);

#endif

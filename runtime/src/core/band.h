/* Linear systems in O(N): a band with a border of dense rows and columns behind it. Partial
 * pivoting within the band. The band alone may be singular, as that of a ring is: see band.c.
 */
#ifndef PK_BAND_H
#define PK_BAND_H

#include "internal.h"

/* So many rows of the band may have no pivot of their own. */
enum { PK_BAND_SPARE = 4 };

/* The unknowns are rows + border; row i of the band reaches columns i - below .. i + above. */
struct pk_band {
    size_t rows, below, above, border;
    pk_real *entries; /* rows of below + 1 + above + below; the last for what pivoting fills */
    pk_real *right, *bottom; /* the border: a row of the matrix after the other; likewise */
    pk_real *corner, *pivot, *column, *rest;
    size_t used; /* columns of the border and spare ones */
};

/* Lays out the memory of a matrix of the shape in `band`; numbers of pk_real, all there is where
 * base is NULL. */
size_t pk_band_lay_out(struct pk_band *band, pk_real *base);
/* All entries 0: before they are set, again after each factorisation. */
void pk_band_clear(struct pk_band *band);
/* Entry (i, j), i and j < rows + border; NULL of one that is 0 by the shape. Not once factored. */
pk_real *pk_band_entry(const struct pk_band *band, size_t i, size_t j);
/* y = A x; not once factored. */
void pk_band_multiply(const struct pk_band *band, const pk_real *x, pk_real *y);
/* In place; 0 where A is singular. Backward errors are up to PK_EPS^(3/4), most of them far less. */
int pk_band_factor(struct pk_band *band);
/* x = A^-1 x of what is factored. */
void pk_band_solve(const struct pk_band *band, pk_real *x);

#endif

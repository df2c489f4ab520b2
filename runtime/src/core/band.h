/* Linear systems in O(N): a band with a border of dense rows and columns behind it. Partial
 * pivoting within the band. The band alone may be singular, like that of a ring: see band.c.
 */
#ifndef PK_BAND_H
#define PK_BAND_H

#include "internal.h"

/* Most rows of a band without a usable pivot. */
enum { PK_BAND_SPARE = 4 };

/* There are rows + border unknowns; row i of the band has columns i - below .. i + above. A dense
 * matrix has rows = 0: then `corner` is that matrix, row-major. */
struct pk_band {
    size_t rows, below, above, border;
    int pivoting; /* whether there is memory for pk_band_factor() */
    /* Band rows of below + 1 + above entries, with pivoting `below` more for fill-in; the columns
     * of the border, by rows of the matrix; its rows, by columns of the matrix; the corner, by
     * rows. */
    pk_real *entries, *right, *bottom, *corner;
    pk_real *pivot, *column, *rest; /* only with pivoting */
    pk_real *used; /* likewise: number of border columns plus spare columns in use */
};

/* Returns the size of a matrix as a kernel of that pattern writes it: a band without pivoting. */
static inline size_t pk_pattern_numbers(const struct pk_pattern *p)
{
    return p->rows * (2 * p->width + 1) + (2 * p->rows + p->border) * p->border;
}

/* Lays out the memory of a matrix with the shape in `band`, its four parts first. Returns the
 * number of pk_real; base NULL: only that. */
size_t pk_band_lay_out(struct pk_band *band, pk_real *base);
/* Sets all entries to 0, before they are set and after each factorisation. */
void pk_band_clear(const struct pk_band *band);
/* Returns entry (i, j), i and j < rows + border; NULL if it is 0 by the shape. */
pk_real *pk_band_entry(const struct pk_band *band, size_t i, size_t j);
/* y += A x, or y += |A| x; not for a factored matrix. */
void pk_band_add_product(const struct pk_band *band, const pk_real *x, pk_real *y);
void pk_band_add_sizes(const struct pk_band *band, const pk_real *x, pk_real *y);
/* Factors A in place, with pivoting. Returns 0 if A is singular. Backward errors are at most
 * PK_EPS^(3/4), mostly far less. */
int pk_band_factor(const struct pk_band *band);
/* x = A^-1 x by the factors. */
void pk_band_solve(const struct pk_band *band, pk_real *x);
/* A = L D L^T in place, A symmetric; entries above the diagonal and `right` are not read. Returns
 * 0, or 1 + i if pivot i is not positive, as pk_ldl_factor(). If place[i] < 0 (place NULL:
 * nowhere), row i belongs to no coordinate, and its pivot may be negative. */
size_t pk_band_ldl_factor(const struct pk_band *band, const pk_real *place);
void pk_band_ldl_solve(const struct pk_band *band, pk_real *x);

#endif

/* A table of the language: piecewise polynomials of one or two variables; lookup.h evaluates it.
 *
 * Piece n of an axis lies between the knots x[n] and x[n + 1]. Piece -1 lies below the first knot,
 * piece count - 1 above the last one. In a periodic axis the pieces repeat for all n.
 *
 * MIT-0: pkgen pastes this text into the headers that it generates; see LICENSE. */
#ifndef PK_TABLE_H
#define PK_TABLE_H

struct pk_table_axis {
    size_t count;     /* number of knots, at least 2 */
    const pk_real *x; /* the knots, ascending */
    pk_real period;   /* 0: the axis is not periodic */
    int strict;       /* 1: the table has no values beyond the knots, only NaN */
};

struct pk_table {
    struct pk_table_axis axes[2]; /* in a table of one variable, axes[1].count is 0 */
    /* Coefficients by rising powers of the distance from the piece's lower knot (for piece -1, from
     * the first knot). Piece n of one variable has c[4*(n + 1) + power]. The piece (n, m) of two
     * variables has c[16*((n + 1)*(axes[1].count + 1) + m + 1) + 4*power + power of the second]. */
    const pk_real *c;
};

#endif

/* Evaluates tables (table.h).
 *
 * MIT-0: pkgen pastes this text into the files that it generates; see LICENSE. */
#ifndef PK_LOOKUP_H
#define PK_LOOKUP_H

/* Returns a continuous rising function of x that is n at knot n, so that its floor is the number of
 * the piece. The search begins at the place of x among evenly spaced knots. */
static inline pk_real pk_axis_place(const struct pk_table_axis *a, pk_real x)
{
    const pk_real *k = a->x, last = (pk_real)(a->count - 1);
    pk_real turns = 0;
    if (a->period > 0) {
        turns = PK_F(floor)((x - k[0]) / a->period);
        x -= turns * a->period;
        if (x < k[0]) /* by rounding */
            x = k[0];
        turns *= last;
    }
    const size_t end = a->count - 1;
    if (!(x >= k[0])) /* between -1/2 and 0; NaN for NaN */
        return turns - (k[0] - x) / (k[0] - x + (k[1] - k[0])) / 2;
    if (x >= k[end]) /* between last and last + 1/2 */
        return turns + last + (x - k[end]) / (x - k[end] + (k[end] - k[end - 1])) / 2;
    size_t lo = (size_t)((x - k[0]) / (k[end] - k[0]) * last), hi, width = 1;
    if (lo > end - 1)
        lo = end - 1;
    for (hi = lo + 1; k[lo] > x; width *= 2) {
        hi = lo;
        lo = lo > width ? lo - width : 0;
    }
    for (; k[hi] <= x; width *= 2) {
        lo = hi;
        hi = end - hi > width ? hi + width : end;
    }
    while (hi - lo > 1) {
        const size_t middle = lo + (hi - lo) / 2;
        if (k[middle] <= x)
            lo = middle;
        else
            hi = middle;
    }
    return turns + ((pk_real)lo + (x - k[lo]) / (k[hi] - k[lo]));
}

/* Returns n + 1 for piece n, and in *s the distance of x from the piece's lower knot. *s is NaN
 * where the table has no value. */
static inline size_t pk_axis_piece(const struct pk_table_axis *a, pk_real x, pk_real n, pk_real *s)
{
    const pk_real *k = a->x, last = (pk_real)(a->count - 1);
    if (a->period > 0) {
        const pk_real turns = PK_F(floor)(n / last);
        n -= turns * last;
        x -= turns * a->period;
    }
    *s = (pk_real)NAN;
    if (!(n >= -1 && n <= last)) /* NaN */
        return 0;
    if (!a->strict || (n >= 0 && n < last) || (x >= k[0] && x <= k[a->count - 1]))
        *s = x - k[n > 0 ? (size_t)n : 0];
    return (size_t)(n + 1);
}

/* Returns the derivative of order d of a polynomial of third degree; NaN for NaN. */
static inline pk_real pk_cubic(const pk_real *c, int d, pk_real s)
{
    if (d == 0)
        return ((c[3] * s + c[2]) * s + c[1]) * s + c[0];
    if (d == 1)
        return (3 * c[3] * s + 2 * c[2]) * s + c[1];
    return d == 2 ? 6 * c[3] * s + 2 * c[2] : 6 * c[3] + 0 * s;
}

/* Returns the derivative of order d of a table at x, in piece n. */
static inline pk_real pk_lookup(const struct pk_table *table, int d, pk_real x, pk_real n)
{
    pk_real s;
    const size_t piece = pk_axis_piece(&table->axes[0], x, n, &s);
    return pk_cubic(table->c + 4 * piece, d, s);
}

/* Returns the derivative of order d by x and e by y, in piece (n, m). */
static inline pk_real pk_lookup2(const struct pk_table *table, int d, int e, pk_real x, pk_real y,
                                 pk_real n, pk_real m)
{
    pk_real s, r, by_x[4];
    const size_t row = pk_axis_piece(&table->axes[0], x, n, &s);
    const size_t piece = row * (table->axes[1].count + 1) +
                         pk_axis_piece(&table->axes[1], y, m, &r);
    for (size_t i = 0; i < 4; i++)
        by_x[i] = pk_cubic(table->c + 16 * piece + 4 * i, e, r);
    return pk_cubic(by_x, d, s);
}

#endif

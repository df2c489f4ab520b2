/* Matrices in twice the precision, and the matrix exponential by scaling and squaring:
 *
 *     exp(X) = exp(X / 2^s)^(2^s),   exp of the small matrix by its Taylor series
 *
 * It works on exp - 1, so that entries small relative to 1 keep their digits: D becomes 2 D + D^2.
 * If the small matrix has norm 1/2, a few terms of the series are as accurate as double-double
 * numbers (pairs), and the scheme of Paterson and Stockmeyer sums it in few products. The usual
 * diagonal Pade approximants need a solve, which would need more code for pairs.
 *
 * References: N. J. Higham, SIAM J. Matrix Anal. Appl. 26 (2005) 1179; A. H. Al-Mohy, N. J. Higham,
 * SIAM J. Matrix Anal. Appl. 31 (2009) 970; M. S. Paterson, L. J. Stockmeyer, SIAM J. Comput. 2
 * (1973) 60. */

#include "double_double.h"

enum { POWERS = 4 }; /* number of stored powers of the small matrix */

void pk_pairs_settle(struct pk_pairs x, size_t count)
{
    PK_LANE_LOOP
    for (size_t i = 0; i < count; i++)
        x.hi[i] = pk_pair_sum(x.hi[i], x.lo[i], &x.lo[i]);
}

void pk_pairs_add(struct pk_pairs y, pk_real c, pk_real c_lo, struct pk_pairs x, size_t count)
{
    PK_LANE_LOOP
    for (size_t i = 0; i < count; i++)
        pk_pair_add(&y.hi[i], &y.lo[i], c, c_lo, x.hi[i], x.lo[i]);
    pk_pairs_settle(y, count);
}

void pk_pairs_multiply(struct pk_pairs Y, struct pk_pairs X, struct pk_pairs M, size_t rows,
                       size_t m)
{
    for (size_t i = 0; i < rows; i++) {
        pk_real *restrict hi = Y.hi + i * m, *restrict lo = Y.lo + i * m;
        pk_zero(hi, m);
        pk_zero(lo, m);
        for (size_t k = 0; k < m; k++) {
            const pk_real a = X.hi[i * m + k], a_lo = X.lo[i * m + k];
            const pk_real *restrict b = M.hi + k * m, *restrict b_lo = M.lo + k * m;
            if (!(a > 0) && !(a < 0) && pk_finite(a))
                continue; /* skips zeros, which are many in matrices of chains */
            PK_LANE_LOOP
            for (size_t j = 0; j < m; j++)
                pk_pair_add(&hi[j], &lo[j], a, a_lo, b[j], b_lo[j]);
        }
    }
    pk_pairs_settle(Y, rows * m);
}

static struct pk_pairs take(pk_real **room, size_t count)
{
    const struct pk_pairs x = {*room, *room + count};
    *room += 2 * count;
    return x;
}

static void copy(struct pk_pairs to, struct pk_pairs from, size_t count)
{
    pk_copy(to.hi, from.hi, count);
    pk_copy(to.lo, from.lo, count);
}

static void clear(struct pk_pairs x, size_t count)
{
    pk_zero(x.hi, count);
    pk_zero(x.lo, count);
}

/* Computes 1/k! from 1/(k-1)!. */
static void divide(pk_real *c, pk_real *c_lo, int k)
{
    const pk_real d = (pk_real)k, hi = *c / d, back = hi * d;
    const pk_real left = (*c - back) - PK_PAIR_REST(hi, d, back);
    *c = pk_pair_sum(hi, (left + *c_lo) / d, c_lo);
}

/* halvings() returns how often `size` must be halved to be at most 1/2. terms() returns the number
 * of terms that the series of exp needs for a matrix of the given norm, so that the rest is below
 * the round-off of double-double numbers. */
static int halvings(pk_real size)
{
    int s = 0;
    for (; size > PK_C(0.5); size /= 2)
        s++;
    return s;
}

static int terms(pk_real norm)
{
    int k = 0;
    for (pk_real term = 1; term > PK_EPS * PK_EPS / 16; k++)
        term *= norm / (pk_real)(k + 1);
    return k;
}

static pk_real halved(pk_real h, int s)
{
    while (s-- > 0)
        h /= 2;
    return h;
}

size_t pk_expm_room(size_t m) { return 2 * m * m * (POWERS + 1); }

enum pk_status pk_expm(struct pk_pairs D, struct pk_pairs L, pk_real norm, pk_real h, size_t m,
                       pk_real *room)
{
    const size_t mm = m * m;
    struct pk_pairs X[POWERS], T;
    /* 1/k! for the terms of the series; about 50 terms are needed for pairs of __float128 */
    pk_real c[64], c_lo[64];
    if (!pk_finite(pk_abs(h) * norm))
        return PK_NOT_FINITE;
    const int s = halvings(pk_abs(h) * norm), last = (terms(PK_C(0.5)) + POWERS) / POWERS * POWERS;
    for (int k = 0; k < POWERS; k++)
        X[k] = take(&room, mm);
    T = take(&room, mm);
    clear(X[0], mm);
    pk_pairs_add(X[0], halved(h, s), 0, L, mm);
    for (int k = 1; k < POWERS; k++)
        pk_pairs_multiply(X[k], X[k - 1], X[0], m, m);
    c[0] = 1, c_lo[0] = 0;
    for (int k = 1; k <= last; k++) {
        c[k] = c[k - 1], c_lo[k] = c_lo[k - 1];
        divide(&c[k], &c_lo[k], k);
    }
    clear(D, mm);
    for (int first = last - POWERS; first >= 0; first -= POWERS) {
        if (first < last - POWERS) {
            pk_pairs_multiply(T, D, X[POWERS - 1], m, m);
            copy(D, T, mm);
        }
        for (int k = 0; k < POWERS; k++)
            pk_pairs_add(D, c[first + k + 1], c_lo[first + k + 1], X[k], mm);
    }
    for (int k = 0; k < s; k++) {
        pk_pairs_multiply(T, D, D, m, m);
        pk_pairs_add(T, 2, 0, D, mm);
        copy(D, T, mm);
    }
    return pk_all_finite(D.hi, mm) && pk_all_finite(D.lo, mm) ? PK_DONE : PK_NOT_FINITE;
}

void pk_expm_series(struct pk_pairs x, struct pk_pairs L, pk_real piece, size_t m, pk_real *room)
{
    const struct pk_pairs next = take(&room, m);
    for (int k = 1, last = terms(PK_EXPM_PIECE); k <= last; k++) {
        pk_real c = 1, c_lo = 0;
        divide(&c, &c_lo, k);
        pk_pairs_multiply(next, x, L, 1, m);
        x.hi += m, x.lo += m;
        clear(x, m);
        pk_pairs_add(x, c * piece, c_lo * piece, next, m);
    }
}

enum pk_status pk_expm_sum(struct pk_pairs y, struct pk_pairs x, pk_real s, size_t m)
{
    clear(y, m);
    for (int k = terms(PK_EXPM_PIECE * pk_abs(s)); k >= 0; k--) {
        const pk_real *hi = x.hi + (size_t)k * m, *lo = x.lo + (size_t)k * m;
        PK_LANE_LOOP
        for (size_t j = 0; j < m; j++) {
            const pk_real product = y.hi[j] * s, rest = PK_PAIR_REST(y.hi[j], s, product);
            pk_real rounded;
            y.hi[j] = pk_pair_sum(hi[j], product, &rounded);
            y.lo[j] = rounded + (rest + y.lo[j] * s + lo[j]);
        }
    }
    pk_pairs_settle(y, m);
    return pk_all_finite(y.hi, m) ? PK_DONE : PK_NOT_FINITE;
}

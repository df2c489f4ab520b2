/* Numbers of twice the precision (double-double), as unevaluated sums hi + lo, and dense matrices
 * of them, row-major. Not installed.
 *
 * References: T. J. Dekker, Numer. Math. 18 (1971) 224, for the product; D. E. Knuth, The Art of
 * Computer Programming 2, 4.2.2, for the sum; T. Ogita, S. M. Rump, S. Oishi, SIAM J. Sci. Comput.
 * 26 (2005) 1955, for sums of products. */
#ifndef PK_PAIRS_H
#define PK_PAIRS_H

#include "internal.h"

struct pk_pairs {
    pk_real *hi, *lo;
};

#ifdef PK_HAVE_FMA
#define PK_PAIR_REST(a, b, p) PK_F(fma)(a, b, -(p))
#else
/* 2^k + 1, where k is half the number of bits of a pk_real, rounded up, splits a number. */
#if defined PK_FLOAT
#define PK_PAIR_SPLIT PK_C(4097.0)
#elif defined PK_FLOAT128 || (defined PK_LONG_DOUBLE && LDBL_MANT_DIG == 113)
#define PK_PAIR_SPLIT PK_C(144115188075855873.0)
#elif defined PK_LONG_DOUBLE
#define PK_PAIR_SPLIT PK_C(4294967297.0)
#else
#define PK_PAIR_SPLIT PK_C(134217729.0)
#endif
static inline pk_real pk_pair_upper(pk_real a)
{
    const pk_real c = PK_PAIR_SPLIT * a;
    return c - (c - a);
}
static inline pk_real pk_pair_rest(pk_real a, pk_real b, pk_real p)
{
    const pk_real a1 = pk_pair_upper(a), a2 = a - a1, b1 = pk_pair_upper(b), b2 = b - b1;
    return ((a1 * b1 - p) + a1 * b2 + a2 * b1) + a2 * b2;
}
#define PK_PAIR_REST(a, b, p) pk_pair_rest(a, b, p)
#endif

/* Computes (hi, lo) += (a, a_lo) (b, b_lo). `lo` accumulates the rounding errors of `hi` and may
 * become large; pk_pairs_settle() makes it small relative to `hi` again. */
static inline void pk_pair_add(pk_real *hi, pk_real *lo, pk_real a, pk_real a_lo, pk_real b,
                               pk_real b_lo)
{
    pk_real rest;
    const pk_real product = a * b, of_product = PK_PAIR_REST(a, b, product);
    *hi = pk_pair_sum(*hi, product, &rest);
    *lo += rest + (of_product + (a * b_lo + a_lo * b));
}

void pk_pairs_settle(struct pk_pairs x, size_t count);
/* Computes y += c x. */
void pk_pairs_add(struct pk_pairs y, pk_real c, pk_real c_lo, struct pk_pairs x, size_t count);
/* Computes Y = X M, X rows by m, M m by m; Y must not alias X or M. */
void pk_pairs_multiply(struct pk_pairs Y, struct pk_pairs X, struct pk_pairs M, size_t rows,
                       size_t m);

/* Computes D = exp(h L) - 1 for an m by m matrix L; norm: upper bound of the largest absolute row
 * sum of L; room: pk_expm_room(m) numbers. PK_NOT_FINITE if the result overflows. */
size_t pk_expm_room(size_t m);
enum pk_status pk_expm(struct pk_pairs D, struct pk_pairs L, pk_real norm, pk_real h, size_t m,
                       pk_real *room);
/* The power series in s, |s| <= 1, of x exp(s piece L) for a row vector x and a matrix L. `piece`
 * is a power of two with piece |L| <= PK_EXPM_PIECE. pk_expm_series() writes its terms as rows
 * after x, in PK_EXPM_TERMS rows of memory; pk_expm_sum() sums them to y. room: 2 m numbers. */
enum { PK_EXPM_TERMS = 80 }; /* largest number of terms; 71 for pairs of __float128 */
#define PK_EXPM_PIECE PK_C(2.0)
void pk_expm_series(struct pk_pairs x, struct pk_pairs L, pk_real piece, size_t m, pk_real *room);
enum pk_status pk_expm_sum(struct pk_pairs y, struct pk_pairs x, pk_real s, size_t m);

#endif

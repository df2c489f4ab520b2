/* LU of a band with a border; see band.h.
 *
 * The border's rows and columns are carried along as the band is eliminated; what is left is a dense
 * system of them. Rows are exchanged within the band alone, so that a pivot may be small though the
 * matrix is regular: the last one of a ring's band, or of a saddle point. Such a pivot d becomes
 * d + s, s as large as its column, which subtracts s x_k from the equations; z = s x_k is then one
 * more unknown, with a column -e_k and a row s e_k: a spare part of the border. That is exact, and
 * no pivot is much smaller than its column.
 *
 * References: G. H. Golub, C. F. Van Loan, Matrix Computations, 4th ed., 4.3.3 (band elimination
 * with pivoting); W. Govaerts, J. D. Pryce, IMA J. Numer. Anal. 13 (1993) 161, for bordered systems
 * whose block is nearly singular.
 */
#include <string.h>

#include "band.h"

/* A pivot this far below its column costs a quarter of the digits. */
#define SMALL PK_F(sqrt)(PK_F(sqrt)(PK_EPS))

static size_t width(const struct pk_band *b) { return 2 * b->below + b->above + 1; }
static size_t most(const struct pk_band *b) { return b->border + PK_BAND_SPARE; }

/* Row i, so that its column j is row(b, i)[j]. */
static pk_real *row(const struct pk_band *b, size_t i)
{
    return b->entries + (ptrdiff_t)(i * width(b) + b->below) - (ptrdiff_t)i;
}

static size_t least(size_t a, size_t b) { return a < b ? a : b; }

size_t pk_band_lay_out(struct pk_band *b, pk_real *base)
{
    const size_t n = b->rows, k = most(b);
    const struct pk_slot slots[] = {
        {&b->entries, n * width(b)}, {&b->right, n * k}, {&b->bottom, n * k}, {&b->corner, k * k},
        {&b->pivot, n + k},          {&b->column, n},    {&b->rest, k}};
    b->used = b->border;
    return PK_LAY_OUT(base, slots);
}

void pk_band_clear(struct pk_band *b)
{
    const size_t n = b->rows, k = most(b);
    memset(b->entries, 0, n * width(b) * sizeof *b->entries);
    memset(b->right, 0, n * k * sizeof *b->right);
    memset(b->bottom, 0, n * k * sizeof *b->bottom);
    memset(b->corner, 0, k * k * sizeof *b->corner);
    b->used = b->border;
}

pk_real *pk_band_entry(const struct pk_band *b, size_t i, size_t j)
{
    const size_t n = b->rows, k = most(b);
    if (i < n && j < n)
        return j + b->below >= i && j <= i + b->above ? row(b, i) + j : NULL;
    if (i < n)
        return b->right + i * k + (j - n);
    return j < n ? b->bottom + j * k + (i - n) : b->corner + (i - n) * k + (j - n);
}

void pk_band_multiply(const struct pk_band *b, const pk_real *x, pk_real *y)
{
    const size_t n = b->rows, k = most(b);
    for (size_t c = 0; c < b->border; c++) {
        y[n + c] = 0;
        for (size_t d = 0; d < b->border; d++)
            y[n + c] += b->corner[c * k + d] * x[n + d];
    }
    for (size_t i = 0; i < n; i++) {
        const pk_real *A = row(b, i);
        const size_t end = least(n, i + b->above + 1);
        y[i] = 0;
        for (size_t j = i > b->below ? i - b->below : 0; j < end; j++)
            y[i] += A[j] * x[j];
        for (size_t c = 0; c < b->border; c++) {
            y[i] += b->right[i * k + c] * x[n + c];
            y[n + c] += b->bottom[i * k + c] * x[i];
        }
    }
}

/* The largest entry of each column of the band, the border's rows among them. */
static void measure_columns(const struct pk_band *b)
{
    const size_t n = b->rows, k = most(b);
    for (size_t j = 0; j < n; j++) {
        b->column[j] = 0;
        for (size_t c = 0; c < b->border; c++)
            b->column[j] = pk_max(b->column[j], pk_abs(b->bottom[j * k + c]));
    }
    for (size_t i = 0; i < n; i++) {
        const pk_real *A = row(b, i);
        const size_t end = least(n, i + b->above + 1);
        for (size_t j = i > b->below ? i - b->below : 0; j < end; j++)
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

/* Gives column k a pivot that is as large as the column was. */
static void mend(struct pk_band *b, size_t k)
{
    const size_t stride = most(b), z = b->used++;
    pk_real *pivot = row(b, k) + k;
    const pk_real size = b->column[k] > 0 ? b->column[k] : 1, s = *pivot < 0 ? -size : size;
    *pivot += s;
    b->right[k * stride + z] = -1;
    b->bottom[k * stride + z] = s;
    b->corner[z * stride + z] = -1;
}

int pk_band_factor(struct pk_band *b)
{
    const size_t n = b->rows, stride = most(b);
    size_t filled = 0; /* no row so far reaches this column */
    measure_columns(b);
    for (size_t k = 0; k < n; k++) {
        const size_t end = least(n, k + b->below + 1);
        size_t best = k;
        for (size_t i = k + 1; i < end; i++)
            if (pk_abs(row(b, i)[k]) > pk_abs(row(b, best)[k]))
                best = i;
        b->pivot[k] = (pk_real)best; /* kept as a number, so that the work is one array */
        const size_t reach = least(n, best + b->above + 1);
        filled = reach > filled ? reach : filled;
        if (best != k) {
            exchange(row(b, k) + k, row(b, best) + k, filled - k);
            exchange(b->right + k * stride, b->right + best * stride, b->used);
        }
        if (!(pk_abs(row(b, k)[k]) > SMALL * b->column[k]) && b->used < stride)
            mend(b, k);
        const pk_real *U = row(b, k), d = U[k];
        const pk_real *right = b->right + k * stride;
        if (!(pk_abs(d) > 0) || !pk_finite(d))
            return 0;
        for (size_t i = k + 1; i < end; i++) {
            pk_real *A = row(b, i);
            const pk_real l = A[k] / d;
            A[k] = l;
            for (size_t j = k + 1; j < filled; j++)
                A[j] -= l * U[j];
            for (size_t c = 0; c < b->used; c++)
                b->right[i * stride + c] -= l * right[c];
        }
        for (size_t c = 0; c < b->used; c++) {
            const pk_real l = b->bottom[k * stride + c] / d;
            b->bottom[k * stride + c] = l;
            for (size_t j = k + 1; j < filled; j++)
                b->bottom[j * stride + c] -= l * U[j];
            for (size_t e = 0; e < b->used; e++)
                b->corner[c * stride + e] -= l * right[e];
        }
    }
    for (size_t c = 0; c < b->used; c++) /* from rows of `stride` to rows of `used` */
        memmove(b->corner + c * b->used, b->corner + c * stride, b->used * sizeof *b->corner);
    return pk_lu_factor(b->corner, b->pivot + n, b->used);
}

void pk_band_solve(const struct pk_band *b, pk_real *x)
{
    const size_t n = b->rows, stride = most(b);
    pk_real *y = b->rest;
    for (size_t c = 0; c < b->used; c++)
        y[c] = c < b->border ? x[n + c] : 0;
    for (size_t k = 0; k < n; k++) {
        const size_t best = (size_t)b->pivot[k], end = least(n, k + b->below + 1);
        const pk_real swap = x[k];
        x[k] = x[best];
        x[best] = swap;
        for (size_t i = k + 1; i < end; i++)
            x[i] -= row(b, i)[k] * x[k];
        for (size_t c = 0; c < b->used; c++)
            y[c] -= b->bottom[k * stride + c] * x[k];
    }
    pk_lu_solve(b->corner, b->pivot + n, b->used, y);
    memcpy(x + n, y, b->border * sizeof *x);
    for (size_t k = n; k-- > 0;) {
        const pk_real *U = row(b, k);
        const size_t end = least(n, k + b->below + b->above + 1);
        for (size_t c = 0; c < b->used; c++)
            x[k] -= b->right[k * stride + c] * y[c];
        for (size_t j = k + 1; j < end; j++)
            x[k] -= U[j] * x[j];
        x[k] /= U[k];
    }
}

/* Small dense linear algebra: LU with partial pivoting for the matrices of Newton's method, and L D
 * L^T without pivoting for the mass matrix, whose pivots show whether it is positive definite.
 * Reference: G. H. Golub, C. F. Van Loan, Matrix Computations, 4th ed., 3.4 and 4.1. */
#include "internal.h"

void pk_add_product(pk_real *y, const pk_real *A, const pk_real *x, size_t n)
{
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < n; j++)
            y[i] += A[i * n + j] * x[j];
}

int pk_lu_factor(pk_real *A, pk_real *pivot, size_t m)
{
    for (size_t k = 0; k < m; k++) {
        size_t best = k;
        for (size_t i = k + 1; i < m; i++)
            if (pk_abs(A[i * m + k]) > pk_abs(A[best * m + k]))
                best = i;
        pivot[k] = (pk_real)best; /* stored as pk_real, like the rest of the work memory */
        if (best != k)
            for (size_t j = 0; j < m; j++) {
                const pk_real swap = A[k * m + j];
                A[k * m + j] = A[best * m + j];
                A[best * m + j] = swap;
            }
        const pk_real d = A[k * m + k];
        if (!(pk_abs(d) > 0) || !pk_finite(d))
            return 0;
        for (size_t i = k + 1; i < m; i++) {
            const pk_real l = A[i * m + k] / d;
            A[i * m + k] = l;
            for (size_t j = k + 1; j < m; j++)
                A[i * m + j] -= l * A[k * m + j];
        }
    }
    return 1;
}

void pk_lu_solve(const pk_real *A, const pk_real *pivot, size_t m, pk_real *x)
{
    /* all row exchanges are made before the forward substitution */
    for (size_t k = 0; k < m; k++) {
        const size_t best = pk_index(pivot[k], m);
        const pk_real swap = x[k];
        x[k] = x[best];
        x[best] = swap;
    }
    /* Column by column: the subtractions of a column are independent. */
    for (size_t j = 0; j + 1 < m; j++)
        for (size_t i = j + 1; i < m; i++)
            x[i] -= A[i * m + j] * x[j];
    for (size_t j = m; j-- > 0;) {
        x[j] /= A[j * m + j];
        for (size_t i = 0; i < j; i++)
            x[i] -= A[i * m + j] * x[j];
    }
}

pk_real pk_lu_determinant(const pk_real *A, const pk_real *pivot, size_t m, int *sign)
{
    pk_real det = 1;
    *sign = 1;
    for (size_t i = 0; i < m; i++) {
        const pk_real d = pk_index(pivot[i], m) == i ? A[i * m + i] : -A[i * m + i];
        det *= d;
        *sign *= d < 0 ? -1 : 1;
    }
    return det;
}

size_t pk_ldl_factor(pk_real *A, size_t n)
{
    for (size_t j = 0; j < n; j++) {
        const pk_real least = PK_PIVOT_MIN * A[j * n + j]; /* smaller pivots are rounding errors */
        pk_real d = A[j * n + j];
        for (size_t k = 0; k < j; k++)
            d -= A[j * n + k] * A[j * n + k] * A[k * n + k];
        if (!(d > least) || !(d > 0) || !pk_finite(d))
            return 1 + j;
        A[j * n + j] = d;
        for (size_t i = j + 1; i < n; i++) {
            pk_real sum = A[i * n + j];
            for (size_t k = 0; k < j; k++)
                sum -= A[i * n + k] * A[j * n + k] * A[k * n + k];
            A[i * n + j] = sum / d;
        }
    }
    return 0;
}

void pk_ldl_solve(const pk_real *A, size_t n, pk_real *x)
{
    for (size_t i = 1; i < n; i++)
        for (size_t j = 0; j < i; j++)
            x[i] -= A[i * n + j] * x[j];
    for (size_t i = 0; i < n; i++)
        x[i] /= A[i * n + i];
    for (size_t i = n; i-- > 0;)
        for (size_t j = i + 1; j < n; j++)
            x[i] -= A[j * n + i] * x[j];
}

pk_real pk_ldl_diagonal(const pk_real *A, size_t n, size_t k)
{
    pk_real sum = A[k * n + k];
    for (size_t j = 0; j < k; j++)
        sum += A[k * n + j] * A[k * n + j] * A[j * n + j];
    return sum;
}

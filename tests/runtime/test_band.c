/* Bands with borders against dense LU, of random matrices, of such whose band alone is singular, and
 * of singular ones.
 */
#include "core/band.h"
#include "fixture.h"

enum { MOST = 80, MEMORY = 16384 };
static double dense[MOST * MOST], memory[MEMORY], pivot[MOST];
static unsigned long long seed;

static double noise(void)
{
    seed = seed * 6364136223846793005ull + 1442695040888963407ull;
    return (double)(seed >> 11) / 4503599627370496.0 - 1;
}

static struct pk_band shape(size_t rows, size_t below, size_t above, size_t border)
{
    struct pk_band b = {
        .rows = rows, .below = below, .above = above, .border = border, .pivoting = 1};
    CU_ASSERT_FATAL(pk_band_lay_out(&b, NULL) <= MEMORY && rows + border <= MOST);
    pk_band_lay_out(&b, memory);
    pk_band_clear(&b);
    return b;
}

static void set(struct pk_band *b, size_t i, size_t j, double x)
{
    pk_real *entry = pk_band_entry(b, i, j);
    CU_ASSERT_PTR_NOT_NULL_FATAL(entry);
    *entry = x;
    dense[i * (b->rows + b->border) + j] = x;
}

/* |A x - b| over |A| |x| + |b|, the worst row's: the backward error. */
static double residual(const double *A, size_t m, const double *x, const double *b)
{
    double worst = 0;
    for (size_t i = 0; i < m; i++) {
        double r = -b[i], size = fabs(b[i]);
        for (size_t j = 0; j < m; j++) {
            r += A[i * m + j] * x[j];
            size += fabs(A[i * m + j] * x[j]);
        }
        worst = fmax(worst, fabs(r) / (size + 1e-300));
    }
    return worst;
}

/* The product, the solution and its residual; the parts of the solution's error beside dense LU's. */
static double solved(struct pk_band *b, double *error)
{
    static double x[MOST], y[MOST], right[MOST], lu[MOST * MOST];
    const size_t m = b->rows + b->border;
    double size = 0;
    for (size_t i = 0; i < m; i++)
        right[i] = x[i] = noise();
    memset(y, 0, sizeof y);
    pk_band_add_product(b, x, y);
    CU_ASSERT(residual(dense, m, x, y) < 1e-14);
    CU_ASSERT_FATAL(pk_band_factor(b));
    pk_band_solve(b, x);
    memcpy(lu, dense, m * m * sizeof *lu);
    memcpy(y, right, m * sizeof *y);
    CU_ASSERT_FATAL(pk_lu_factor(lu, pivot, m));
    pk_lu_solve(lu, pivot, m, y);
    for (size_t i = 0; i < m; i++)
        size = fmax(size, fabs(y[i]));
    for (size_t i = 0; i < m; i++)
        *error = fmax(*error, fabs(x[i] - y[i]) / size);
    return residual(dense, m, x, right);
}

TEST("as dense LU")
{
    double worst = 0, error = 0;
    for (seed = 1; seed < 400; seed++) {
        const unsigned long long of = seed;
        const size_t rows[] = {1, 2, 3, 7, 20, 60};
        const size_t n = rows[of % 6], below = of / 6 % 4, above = of / 24 % 4, k = of / 96 % 4;
        struct pk_band b = shape(n, below, above, k);
        memset(dense, 0, sizeof dense);
        for (size_t i = 0; i < n + k; i++)
            for (size_t j = 0; j < n + k; j++)
                if (pk_band_entry(&b, i, j))
                    set(&b, i, j, noise() + (i == j ? 3.0 : 0.0));
        worst = fmax(worst, solved(&b, &error));
        seed = of;
    }
    CU_ASSERT(worst > 0 && worst < 1e-13);
    CU_ASSERT(error > 0 && error < 1e-12);
}

/* Springs in a ring, of which the last mass is the border: free, the band is a chain's with nothing
 * that holds it, but for a little. And rows of zeros on the diagonal, as multipliers have. */
TEST("the band alone is singular")
{
    double error = 0;
    for (int little = 0; little < 3; little++) {
        struct pk_band b = shape(40, 1, 1, 1);
        const double held = little == 0 ? 0 : little == 1 ? 1e-15 : 1e-9;
        memset(dense, 0, sizeof dense);
        for (size_t i = 0; i + 1 < 40; i++) {
            set(&b, i, i, (i ? 2 : 1) + (i == 17 ? held : 0));
            set(&b, i, i + 1, -1);
            set(&b, i + 1, i, -1);
        }
        set(&b, 39, 39, 1);
        set(&b, 40, 12, 1);
        set(&b, 12, 40, 1);
        set(&b, 40, 40, 0.5);
        CU_ASSERT(solved(&b, &error) < 1e-13);
        CU_ASSERT(*b.used == 2);
    }
    for (seed = 1; seed < 100; seed++) {
        const unsigned long long of = seed;
        struct pk_band b = shape(30, 2, 2, 2);
        memset(dense, 0, sizeof dense);
        for (size_t i = 0; i < 32; i++)
            for (size_t j = 0; j < 32; j++)
                if (pk_band_entry(&b, i, j) && (i != j || i % 3) && i != 11)
                    set(&b, i, j, noise());
        set(&b, 11, 30, 1); /* two columns that the band leaves without a pivot */
        CU_ASSERT(solved(&b, &error) < 1e-11);
        seed = of;
    }
    CU_ASSERT(error < 1e-9);
}

TEST("units do not matter")
{
    double error = 0;
    struct pk_band b = shape(30, 2, 1, 2);
    memset(dense, 0, sizeof dense);
    seed = 5;
    for (size_t i = 0; i < 32; i++)
        for (size_t j = 0; j < 32; j++)
            if (pk_band_entry(&b, i, j))
                set(&b, i, j, (noise() + (i == j ? 3 : 0)) * pow(10, 5. * (double)(j % 7)));
    CU_ASSERT(solved(&b, &error) < 1e-13);
    CU_ASSERT(*b.used == 2);
}

/* Masses that share inertia, the last ones with all; among them rows of what is no coordinate, with
 * negative pivots. */
TEST("positive definite ones")
{
    double worst = 0;
    for (seed = 1; seed < 200; seed++) {
        const unsigned long long of = seed;
        const size_t rows[] = {0, 1, 2, 7, 40}, n = rows[of % 5], k = of / 5 % 3, m = n + k;
        struct pk_band b = {.rows = n, .below = of / 15 % 4, .above = of / 15 % 4, .border = k};
        double x[MOST], right[MOST], place[MOST];
        pk_band_lay_out(&b, memory);
        pk_band_clear(&b);
        memset(dense, 0, sizeof dense);
        for (size_t i = 0; i < m; i++)
            place[i] = n && of % 2 && i % 3 == 2 ? -2 : (double)i;
        for (size_t i = 0; i < m; i++)
            for (size_t j = 0; j <= i; j++)
                if (pk_band_entry(&b, i, j)) {
                    const double own = place[i] < 0 ? -20 : 20;
                    set(&b, i, j, i == j ? own + noise() : noise());
                    set(&b, j, i, dense[i * m + j]);
                }
        for (size_t i = 0; i < m; i++)
            right[i] = x[i] = noise();
        CU_ASSERT(pk_band_ldl_factor(&b, place) == 0);
        pk_band_ldl_solve(&b, x);
        worst = fmax(worst, residual(dense, m, x, right));
        for (size_t i = m; i-- > 0;) { /* the pivot that fails is told */
            pk_band_clear(&b);
            for (size_t j = 0; j < m; j++)
                set(&b, j, j, j < i);
            CU_ASSERT(pk_band_ldl_factor(&b, place) == i + 1);
        }
        seed = of;
    }
    CU_ASSERT(worst > 0 && worst < 1e-14);
}

TEST("singular matrices")
{
    for (size_t column = 0; column < 12; column += 11) {
        struct pk_band b = shape(10, 1, 1, 2);
        for (size_t i = 0; i < 12; i++)
            for (size_t j = 0; j < 12; j++)
                if (pk_band_entry(&b, i, j))
                    set(&b, i, j, j == column ? 0 : i == j ? 3 : 0.5);
        CU_ASSERT(!pk_band_factor(&b));
    }
    struct pk_band b = shape(10, 1, 1, 0);
    for (size_t i = 0; i < 10; i++)
        set(&b, i, i, i == 4 ? (double)NAN : 1);
    CU_ASSERT(!pk_band_factor(&b));
}

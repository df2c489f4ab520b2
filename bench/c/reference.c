/* A final state in __float128, by the extrapolated midpoint rule of Gragg, Bulirsch and Stoer
 * (Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, II.9): H a big step, the
 * substeps 2, 4, 6, ..., 2 COLUMNS, Aitken-Neville in h^2. It shares nothing with pkgen: neither
 * the equations (derived by SymPy) nor the method.
 *
 * Usage: reference BIG_STEPS T_END PARAMETER... Y0..., numbers decimal or hexadecimal; prints q, q'
 * with 33 digits.
 */
#include <quadmath.h>
#include <stdio.h>
#include <stdlib.h>

typedef __float128 real;
#define sin sinq
#define cos cosq
#include BENCH_EQUATIONS /* N, acceleration(t, q, v, a) */

enum { COLUMNS = 12, DIM = 2 * N };

static void derivative(real t, const real *y, real *dy)
{
    for (int i = 0; i < N; i++) dy[i] = y[N + i];
    acceleration(t, y, y + N, dy + N);
}

static void midpoint(real t, real H, int substeps, const real *y, real *out)
{
    const real h = H / substeps;
    real before[DIM], at[DIM], after[DIM], dy[DIM];

    derivative(t, y, dy);
    for (int i = 0; i < DIM; i++) before[i] = y[i], at[i] = y[i] + h * dy[i];
    for (int k = 1; k < substeps; k++) {
        derivative(t + k * h, at, dy);
        for (int i = 0; i < DIM; i++) {
            after[i] = before[i] + 2 * h * dy[i];
            before[i] = at[i];
            at[i] = after[i];
        }
    }
    /* Gragg's smoothing step; even numbers of substeps give an expansion in h^2. */
    derivative(t + H, at, dy);
    for (int i = 0; i < DIM; i++) out[i] = (at[i] + before[i] + h * dy[i]) / 2;
}

static void big_step(real t, real H, real *y)
{
    real table[COLUMNS][DIM], was[DIM], diagonal[DIM];

    for (int j = 0; j < COLUMNS; j++) {
        midpoint(t, H, 2 * (j + 1), y, diagonal);
        for (int i = 0; i < DIM; i++) {
            real value = diagonal[i];
            for (int k = 0; k < j; k++) {
                const real ratio = (real)(j + 1) / (j - k);
                was[i] = table[k][i];
                table[k][i] = value;
                value += (value - was[i]) / (ratio * ratio - 1);
            }
            table[j][i] = value;
        }
    }
    for (int i = 0; i < DIM; i++) y[i] = table[COLUMNS - 1][i];
}

int main(int argc, char **argv)
{
    real y[DIM];
    char text[64];

    const int parameters = (int)(sizeof bench_parameters / sizeof *bench_parameters);
    if (argc != 3 + parameters + DIM) return 2;
    const long steps = strtol(argv[1], NULL, 10);
    const real t_end = strtoflt128(argv[2], NULL);
    for (int i = 0; i < parameters; i++) bench_parameters[i] = strtoflt128(argv[3 + i], NULL);
    for (int i = 0; i < DIM; i++) y[i] = strtoflt128(argv[3 + parameters + i], NULL);
    for (long k = 0; k < steps; k++) big_step(t_end * k / steps, t_end / steps, y);
    for (int i = 0; i < DIM; i++) {
        quadmath_snprintf(text, sizeof text, "%.33Qg", y[i]);
        printf("%s%c", text, i + 1 < DIM ? ' ' : '\n');
    }
    return 0;
}

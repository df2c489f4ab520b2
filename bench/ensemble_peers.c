/* RK4 on many double pendulums (m = l = 1) as others would write it, for bench/ensemble.py: one
 * after the other with libm, or blocks in lanes with glibc's vector library (libmvec). gcc merges
 * sin and cos of one argument into sincos, which libmvec is not called for, so sines and cosines
 * are made in loops of their own; it also wants -ffast-math to be called at all.
 */
#include <math.h>
#include <stddef.h>

#ifdef PK_FLOAT
typedef float real;
#define SIN sinf
#define COS cosf
#else
typedef double real;
#define SIN sin
#define COS cos
#endif

enum { BLOCK = 64 };
static const real g = (real)9.81;

/* From the sines s and cosines c of both angles. */
static inline void acceleration(const real s[2], const real c[2], const real v[2], real a[2])
{
    const real sine = s[0] * c[1] - c[0] * s[1], cosine = c[0] * c[1] + s[0] * s[1];
    const real f0 = -sine * v[1] * v[1] - 2 * g * s[0], f1 = sine * v[0] * v[0] - g * s[1];
    const real det = 1 / (2 - cosine * cosine);
    a[0] = (f0 - cosine * f1) * det;
    a[1] = (2 * f1 - cosine * f0) * det;
}

#ifndef VECTOR
static void slope(const real y[4], real k[4])
{
    const real s[2] = {SIN(y[0]), SIN(y[1])}, c[2] = {COS(y[0]), COS(y[1])};
    k[0] = y[2];
    k[1] = y[3];
    acceleration(s, c, y + 2, k + 2);
}

void scalar_rk4(real *y, size_t members, size_t steps, real h);
void scalar_rk4(real *y, size_t members, size_t steps, real h)
{
    static const real c[4] = {0, (real)0.5, (real)0.5, 1};
    for (size_t i = 0; i < members; i++)
        for (size_t step = 0; step < steps; step++) {
            real k[4][4], x[4], *y0 = y + 4 * i;
            slope(y0, k[0]);
            for (int stage = 1; stage < 4; stage++) {
                for (int j = 0; j < 4; j++)
                    x[j] = y0[j] + h * c[stage] * k[stage - 1][j];
                slope(x, k[stage]);
            }
            for (int j = 0; j < 4; j++)
                y0[j] += h / 6 * (k[0][j] + 2 * (k[1][j] + k[2][j]) + k[3][j]);
        }
}
#else
static void slopes(real y[4][BLOCK], real k[4][BLOCK])
{
    real s[2][BLOCK], c[2][BLOCK];
    for (int j = 0; j < 2; j++) {
        for (int l = 0; l < BLOCK; l++)
            s[j][l] = SIN(y[j][l]);
        __asm__ volatile("" ::: "memory"); /* two loops stay two */
        for (int l = 0; l < BLOCK; l++)
            c[j][l] = COS(y[j][l]);
    }
    for (int l = 0; l < BLOCK; l++) {
        const real sl[2] = {s[0][l], s[1][l]}, cl[2] = {c[0][l], c[1][l]};
        const real v[2] = {y[2][l], y[3][l]};
        real a[2];
        acceleration(sl, cl, v, a);
        k[0][l] = v[0];
        k[1][l] = v[1];
        k[2][l] = a[0];
        k[3][l] = a[1];
    }
}

void vector_rk4(real *y, size_t members, size_t steps, real h);
void vector_rk4(real *y, size_t members, size_t steps, real h)
{
    static const real c[4] = {0, (real)0.5, (real)0.5, 1};
    for (size_t first = 0; first < members; first += BLOCK) {
        real x[4][BLOCK], y0[4][BLOCK], k[4][4][BLOCK];
        for (int j = 0; j < 4; j++)
            for (size_t l = 0; l < BLOCK; l++)
                y0[j][l] = y[4 * (first + l) + (size_t)j];
        for (size_t step = 0; step < steps; step++) {
            slopes(y0, k[0]);
            for (int stage = 1; stage < 4; stage++) {
                for (int j = 0; j < 4; j++)
                    for (int l = 0; l < BLOCK; l++)
                        x[j][l] = y0[j][l] + h * c[stage] * k[stage - 1][j][l];
                slopes(x, k[stage]);
            }
            for (int j = 0; j < 4; j++)
                for (int l = 0; l < BLOCK; l++)
                    y0[j][l] +=
                        h / 6 * (k[0][j][l] + 2 * (k[1][j][l] + k[2][j][l]) + k[3][j][l]);
        }
        for (int j = 0; j < 4; j++)
            for (size_t l = 0; l < BLOCK; l++)
                y[4 * (first + l) + (size_t)j] = y0[j][l];
    }
}
#endif

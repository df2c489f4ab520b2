/* glibc's vector sine and cosine: members in blocks of 64 as structure of arrays, the textbook's
 * accelerations as plain loops. gcc merges a sine and a cosine of one argument into sincos(), which
 * libmvec has in no usable form, so its functions are called by name, from their own loops.
 */
#include "ensemble.h"

#include <string.h>

#if !defined __AVX2__ || defined BENCH_FLOAT
#error "written for doubles and AVX2"
#endif

enum { BLOCK = 64 };
typedef double four __attribute__((vector_size(32)));
four _ZGVdN4v_sin(four);
four _ZGVdN4v_cos(four);

#define ACROSS(l) for (int l = 0; l < BLOCK; l++)

static void sines(const double *x, double *s)
{
    for (int l = 0; l < BLOCK; l += 4) {
        four a;
        memcpy(&a, x + l, sizeof a);
        a = _ZGVdN4v_sin(a);
        memcpy(s + l, &a, sizeof a);
    }
}

static void cosines(const double *x, double *c)
{
    for (int l = 0; l < BLOCK; l += 4) {
        four a;
        memcpy(&a, x + l, sizeof a);
        a = _ZGVdN4v_cos(a);
        memcpy(c + l, &a, sizeof a);
    }
}

extern double bench_parameters[];
double bench_parameters[] = {1, 1, 1, 1, 9.81};

static void accelerations(double q[2][BLOCK], double v[2][BLOCK], double a[2][BLOCK])
{
    const double m1 = bench_parameters[0], m2 = bench_parameters[1], l1 = bench_parameters[2],
                 l2 = bench_parameters[3], g = bench_parameters[4];
    const double m = m1 + m2, per_l1 = 1 / l1, per_l2 = 1 / l2;
    double d[BLOCK], s[BLOCK], c[BLOCK], s1[BLOCK], s2[BLOCK];

    ACROSS(l) d[l] = q[0][l] - q[1][l];
    sines(d, s);
    cosines(d, c);
    sines(q[0], s1);
    sines(q[1], s2);
    ACROSS(l)
    {
        const double x = 1 / (m - m2 * c[l] * c[l]);
        const double lower = g * s2[l] - l1 * v[0][l] * v[0][l] * s[l];
        const double upper = g * m * s1[l] + l2 * m2 * v[1][l] * v[1][l] * s[l];
        a[0][l] = x * per_l1 * (m2 * c[l] * lower - upper);
        a[1][l] = x * per_l2 * (c[l] * upper - m * lower);
    }
}

static void step(double h, double q[2][BLOCK], double v[2][BLOCK])
{
    double a[4][2][BLOCK], w[4][2][BLOCK], x[2][BLOCK];
    static const double share[4] = {0, 0.5, 0.5, 1};

    for (int s = 0; s < 4; s++) {
        const double hs = h * share[s];
        for (int i = 0; i < 2; i++)
            ACROSS(l)
            {
                x[i][l] = s ? q[i][l] + hs * w[s - 1][i][l] : q[i][l];
                w[s][i][l] = s ? v[i][l] + hs * a[s - 1][i][l] : v[i][l];
            }
        accelerations(x, w[s], a[s]);
    }
    for (int i = 0; i < 2; i++)
        ACROSS(l)
        {
            q[i][l] += h / 6 * (w[0][i][l] + 2 * (w[1][i][l] + w[2][i][l]) + w[3][i][l]);
            v[i][l] += h / 6 * (a[0][i][l] + 2 * (a[1][i][l] + a[2][i][l]) + a[3][i][l]);
        }
}

const char *ensemble_run(size_t members, unsigned long steps, double h, int threads, double *q,
                         double *v)
{
    (void)threads;
    if (members % BLOCK) return "whole blocks of 64 members";
    for (size_t m = 0; m < members; m += BLOCK) {
        double x[2][BLOCK], w[2][BLOCK];
        for (int i = 0; i < 2; i++)
            ACROSS(l) x[i][l] = q[2 * (m + (size_t)l) + (size_t)i],
                      w[i][l] = v[2 * (m + (size_t)l) + (size_t)i];
        for (unsigned long k = 0; k < steps; k++) step(h, x, w);
        for (int i = 0; i < 2; i++)
            ACROSS(l) q[2 * (m + (size_t)l) + (size_t)i] = x[i][l],
                      v[2 * (m + (size_t)l) + (size_t)i] = w[i][l];
    }
    return NULL;
}

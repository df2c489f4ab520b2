/* One member after the other: RK4 over `acceleration()` in the same file, with libm. */
#include "ensemble.h"
#include BENCH_EQUATIONS

static int derivative(double t, const real *y, real *dy)
{
    for (int i = 0; i < DOF; i++) dy[i] = y[DOF + i];
    return acceleration((real)t, y, y + DOF, dy + DOF);
}

static int step(double t, real h, real *y)
{
    real k1[2 * DOF], k2[2 * DOF], k3[2 * DOF], k4[2 * DOF], at[2 * DOF];
    int bad = derivative(t, y, k1);

    for (int i = 0; i < 2 * DOF; i++) at[i] = y[i] + h / 2 * k1[i];
    bad |= derivative(t + h / 2, at, k2);
    for (int i = 0; i < 2 * DOF; i++) at[i] = y[i] + h / 2 * k2[i];
    bad |= derivative(t + h / 2, at, k3);
    for (int i = 0; i < 2 * DOF; i++) at[i] = y[i] + h * k3[i];
    bad |= derivative(t + h, at, k4);
    for (int i = 0; i < 2 * DOF; i++) y[i] += h / 6 * (k1[i] + 2 * (k2[i] + k3[i]) + k4[i]);
    return bad;
}

const char *ensemble_run(size_t members, unsigned long steps, double h, int threads, real *q,
                         real *v)
{
    (void)threads;
    for (size_t m = 0; m < members; m++) {
        real y[2 * DOF] = {q[2 * m], q[2 * m + 1], v[2 * m], v[2 * m + 1]};
        for (unsigned long k = 0; k < steps; k++)
            if (step(h * (double)k, (real)h, y)) return "the acceleration failed";
        for (int i = 0; i < DOF; i++) q[2 * m + (size_t)i] = y[i], v[2 * m + (size_t)i] = y[DOF + i];
    }
    return NULL;
}

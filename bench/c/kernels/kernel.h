/* What a kernel's file defines: KERNEL(q, v, a) and KERNEL_width; -DKERNEL=name. */
#ifndef BENCH_KERNEL_H
#define BENCH_KERNEL_H

#include <math.h>

#define KERNEL_JOIN_(a, b) a##b
#define KERNEL_JOIN(a, b) KERNEL_JOIN_(a, b)

extern const int KERNEL_JOIN(KERNEL, _width);
int KERNEL(const double *q, const double *v, double *a);

#define KERNEL_WIDTH(w) const int KERNEL_JOIN(KERNEL, _width) = w

/* M a = f for two coordinates by L D L^T, unrolled. */
static inline int solve_ldl(const double *M, const double *f, double *a)
{
    const double l = M[2] / M[0], d = M[3] - l * M[1];

    if (!(M[0] > 0) || !(d > 0)) return 1;
    a[1] = (f[1] - l * f[0]) / d;
    a[0] = f[0] / M[0] - l * a[1];
    return 0;
}

#endif

/* pkgen's lane kernel: PK_LANES states a call. */
#include BENCH_EQUATIONS
#include "kernel.h"

KERNEL_WIDTH(PK_LANES);

int KERNEL(const double *q, const double *v, double *a)
{
    static const double t[PK_LANES];

    return lanes(t, q, v, a);
}

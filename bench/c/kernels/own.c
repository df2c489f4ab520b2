/* pkgen's acceleration; the model's file is included, under whatever options it was generated. */
#include BENCH_EQUATIONS
#include "kernel.h"

KERNEL_WIDTH(1);

int KERNEL(const double *q, const double *v, double *a)
{
    return acceleration(0, q, v, a);
}

/* M and f by SymPy's cse, solved by an unrolled L D L^T. */
#include "kernel.h"
#include BENCH_EQUATIONS

KERNEL_WIDTH(1);

int KERNEL(const double *q, const double *v, double *a)
{
    double M[4], f[2];

    mass_and_force(0, q, v, M, f);
    return solve_ldl(M, f, a);
}

/* PyDy's generated C for M and f; its Cython module would solve by NumPy, here an unrolled
 * L D L^T does, to its favour. */
#include "kernel.h"
#define evaluate KERNEL_JOIN(KERNEL, _evaluate)
#include BENCH_EQUATIONS

KERNEL_WIDTH(1);

int KERNEL(const double *q, const double *v, double *a)
{
    double M[4], f[2], q_[2] = {q[0], q[1]}, v_[2] = {v[0], v[1]};

    evaluate(q_, v_, bench_parameters, M, f);
    return solve_ldl(M, f, a);
}

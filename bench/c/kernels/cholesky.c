/* M and f by SymPy's cse, solved by GSL's Cholesky factorisation. */
#include <gsl/gsl_linalg.h>

#include "kernel.h"
#include BENCH_EQUATIONS

KERNEL_WIDTH(1);

int KERNEL(const double *q, const double *v, double *a)
{
    double M[4], f[2];

    mass_and_force(0, q, v, M, f);
    gsl_matrix_view matrix = gsl_matrix_view_array(M, 2, 2);
    const gsl_vector_view force = gsl_vector_view_array(f, 2);
    gsl_vector_view result = gsl_vector_view_array(a, 2);
    return gsl_linalg_cholesky_decomp1(&matrix.matrix) ||
           gsl_linalg_cholesky_solve(&matrix.matrix, &force.vector, &result.vector);
}

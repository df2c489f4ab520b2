/* Solves symmetric eigenproblems by Cholesky factors of M and QR steps (gsl_eigen_gensymmv). */
#include <math.h>
#include <string.h>

#include <gsl/gsl_eigen.h>
#include <gsl/gsl_errno.h>

#include <pk/gsl.h>

/* Returns the factor by which u, column k of U of length 1, is scaled to u.M u = 1. */
static double scale(size_t n, const double *M, const gsl_matrix *U, size_t k)
{
    double square = 0;
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < n; j++)
            square += gsl_matrix_get(U, i, k) * M[i * n + j] * gsl_matrix_get(U, j, k);
    return 1 / sqrt(square);
}

enum pk_status pk_gsl_pencil(size_t n, const double *K, const double *M, double *lambda, double *U)
{
    gsl_error_handler_t *handler = gsl_set_error_handler_off();
    gsl_eigen_gensymmv_workspace *w = gsl_eigen_gensymmv_alloc(n);
    gsl_matrix *A = gsl_matrix_alloc(n, n), *B = gsl_matrix_alloc(n, n),
               *V = gsl_matrix_alloc(n, n);
    gsl_vector_view values = gsl_vector_view_array(lambda, n);
    enum pk_status status = w && A && B && V ? PK_DONE : PK_NO_MEMORY;
    if (status == PK_DONE) {
        memcpy(A->data, K, n * n * sizeof *K);
        memcpy(B->data, M, n * n * sizeof *M);
        if (gsl_eigen_gensymmv(A, B, &values.vector, V, w))
            status = PK_SINGULAR_MASS;
        else
            gsl_eigen_gensymmv_sort(&values.vector, V, GSL_EIGEN_SORT_VAL_ASC);
    }
    for (size_t k = 0; status == PK_DONE && k < n; k++) {
        const double by = scale(n, M, V, k);
        for (size_t i = 0; i < n; i++)
            U[i * n + k] = by * gsl_matrix_get(V, i, k);
    }
    gsl_eigen_gensymmv_free(w);
    gsl_matrix_free(A);
    gsl_matrix_free(B);
    gsl_matrix_free(V);
    gsl_set_error_handler(handler);
    return status;
}

/* The linearised equations z' = A z and the eigenvalues of A; see pk/gsl_equilibria.h. */
#include <math.h>
#include <stdlib.h>

#include <gsl/gsl_eigen.h>
#include <gsl/gsl_errno.h>

#include <pk/gsl_equilibria.h>
#include <pk/linear.h>

#include "rates.h"

enum pk_status pk_gsl_linearised(const struct pk_problem *problem, double t, const double *q,
                                 const double *v, gsl_matrix *A)
{
    const size_t n = pk_count_of(problem), m = pk_coordinates_of(problem);
    double *block =
        (double *)calloc(2 * n * n + 2 * n + pk_system_linear_size(problem), sizeof *block);
    if (!block)
        return PK_NO_MEMORY;
    double *const a_q = block, *const a_v = a_q + n * n, *const a = a_v + n * n;
    const enum pk_status status = pk_system_linear(problem, t, q, v, a, a_q, a_v, a + n, a + 2 * n);
    if (status == PK_DONE) { /* z = (coordinates, first-order variables, rates of coordinates) */
        gsl_matrix_set_zero(A);
        for (size_t i = 0; i < m; i++)
            gsl_matrix_set(A, i, n + i, 1);
        for (size_t i = 0; i < n; i++) {
            const size_t row = i < m ? n + i : i;
            for (size_t j = 0; j < n; j++) {
                if (j < m)
                    gsl_matrix_set(A, row, j, a_q[i * n + j]);
                gsl_matrix_set(A, row, j < m ? n + j : j, a_v[i * n + j]);
            }
        }
    }
    free(block);
    return status;
}

enum pk_status pk_gsl_unread(const struct pk_problem *problem, const double *q, const double *v,
                             unsigned char *unread)
{
    const size_t n = pk_count_of(problem), m = pk_coordinates_of(problem), N = n + m;
    gsl_matrix *A = gsl_matrix_alloc(N, N);
    double *place = (double *)calloc(2 * n, sizeof *place);
    enum pk_status status = A && place ? PK_DONE : PK_NO_MEMORY;
    for (size_t i = 0; i < n; i++)
        unread[i] = i >= m;
    /* k = 0: the given state; k = 1, 2: two states near it */
    for (size_t k = 0; k < 3 && status == PK_DONE; k++) {
        for (size_t i = 0; i < n; i++) {
            place[i] = q[i] + (double)k * (0.01 + 0.013 * (double)i) * (1 + fabs(q[i]));
            place[n + i] = v[i] + (double)k * (0.02 + 0.011 * (double)i) * (1 + fabs(v[i]));
        }
        const enum pk_status known = pk_gsl_linearised(problem, 0, place, place + n, A);
        status = k ? status : known;
        for (size_t j = m; j < n; j++)
            for (size_t i = 0; i < N && unread[j]; i++)
                unread[j] = known == PK_DONE && gsl_matrix_get(A, i, j) == 0;
    }
    gsl_matrix_free(A);
    free(place);
    return status;
}

enum pk_status pk_gsl_rates(const struct pk_problem *problem, double t, const double *q,
                            const double *v, double *growth, double *frequency, size_t *count)
{
    const size_t n = pk_count_of(problem), N = n + pk_coordinates_of(problem);
    gsl_error_handler_t *handler = gsl_set_error_handler_off();
    gsl_eigen_nonsymm_workspace *w = gsl_eigen_nonsymm_alloc(N);
    gsl_matrix *A = gsl_matrix_alloc(N, N);
    gsl_vector_complex *lambda = gsl_vector_complex_alloc(N);
    enum pk_status status = PK_NO_MEMORY;
    *count = 0;
    if (w && A && lambda) {
        gsl_eigen_nonsymm_params(0, 1, w);
        status = pk_gsl_linearised(problem, t, q, v, A);
        if (status == PK_DONE && gsl_eigen_nonsymm(A, lambda, w))
            status = PK_NO_CONVERGENCE;
        for (size_t k = 0; k < N && status == PK_DONE; k++) {
            const gsl_complex l = gsl_vector_complex_get(lambda, k);
            if (GSL_IMAG(l) < 0)
                continue;
            growth[*count] = GSL_REAL(l);
            frequency[*count] = GSL_IMAG(l);
            ++*count;
        }
    }
    gsl_eigen_nonsymm_free(w);
    gsl_matrix_free(A);
    gsl_vector_complex_free(lambda);
    gsl_set_error_handler(handler);
    return status;
}

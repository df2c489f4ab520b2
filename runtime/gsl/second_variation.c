/* The eigenvalues of the second variation; see pk/least_action.h. C a = lambda B a by Cholesky's
 * factors of B and symmetric QR (gsl_eigen_gensymmv).
 */
#include <math.h>

#include <gsl/gsl_eigen.h>
#include <gsl/gsl_errno.h>

#include <pk/gsl.h>

/* The first `modes` modes of each coordinate alone. */
static gsl_matrix *part(const struct pk_least_action *found, const double *from, size_t modes)
{
    const size_t all = found->modes, wide = found->n * all, m = found->n * modes;
    gsl_matrix *to = gsl_matrix_alloc(m, m);
    for (size_t i = 0; to && i < m; i++)
        for (size_t j = 0; j < m; j++) {
            const size_t row = i / modes * all + i % modes, column = j / modes * all + j % modes;
            gsl_matrix_set(to, i, j, from[row * wide + column]);
        }
    return to;
}

/* The first column of U, of which GSL makes the sum of squares 1, so that a.B a is. */
static void normalised(const gsl_matrix *U, const gsl_matrix *B, double *a)
{
    const size_t m = B->size1;
    double square = 0;
    for (size_t i = 0; i < m; i++)
        for (size_t j = 0; j < m; j++)
            square += gsl_matrix_get(U, i, 0) * gsl_matrix_get(B, i, j) * gsl_matrix_get(U, j, 0);
    for (size_t i = 0; i < m; i++)
        a[i] = gsl_matrix_get(U, i, 0) / sqrt(square);
}

enum pk_status pk_gsl_least_action(const struct pk_least_action *found, size_t modes,
                                   double *lambda, double *lowest)
{
    if (!found || !found->C || !modes || modes > found->modes || !lambda)
        return PK_BAD_ARGUMENT;
    gsl_error_handler_t *handler = gsl_set_error_handler_off();
    const size_t m = found->n * modes;
    gsl_matrix *C = part(found, found->C, modes), *B = part(found, found->B, modes);
    gsl_matrix *whole = part(found, found->B, modes); /* B itself is overwritten */
    gsl_matrix *U = gsl_matrix_alloc(m, m);
    gsl_vector *values = gsl_vector_alloc(m);
    gsl_eigen_gensymmv_workspace *w = gsl_eigen_gensymmv_alloc(m);
    enum pk_status status = C && B && whole && U && values && w ? PK_DONE : PK_NO_MEMORY;
    if (status >= 0 && gsl_eigen_gensymmv(C, B, values, U, w))
        status = PK_SINGULAR_MASS; /* B is not positive definite, nor is M */
    if (status >= 0)
        gsl_eigen_gensymmv_sort(values, U, GSL_EIGEN_SORT_VAL_ASC);
    for (size_t i = 0; status >= 0 && i < m; i++)
        lambda[i] = gsl_vector_get(values, i);
    if (status >= 0 && lowest)
        normalised(U, whole, lowest);
    gsl_matrix_free(C);
    gsl_matrix_free(B);
    gsl_matrix_free(U);
    gsl_matrix_free(whole);
    gsl_vector_free(values);
    if (w)
        gsl_eigen_gensymmv_free(w);
    gsl_set_error_handler(handler);
    return status;
}

/* The eigenvalues lambda of the second variation of the action, C a = lambda B a for amplitudes a
 * of modes; pk/least_action.h defines the matrices C and B. */
#include <stdlib.h>

#include <pk/gsl.h>

#include "pencil.h"

/* Copies from a matrix of all modes the rows and columns of the first `modes` modes of each
 * coordinate. */
static void part(const struct pk_least_action *found, const double *from, size_t modes, double *to)
{
    const size_t all = found->modes, wide = found->n * all, m = found->n * modes;
    for (size_t i = 0; i < m; i++)
        for (size_t j = 0; j < m; j++) {
            const size_t row = i / modes * all + i % modes, column = j / modes * all + j % modes;
            to[i * m + j] = from[row * wide + column];
        }
}

enum pk_status pk_gsl_least_action(const struct pk_least_action *found, size_t modes,
                                   double *lambda, double *lowest)
{
    if (!found || !found->C || !modes || modes > found->modes || !lambda)
        return PK_BAD_ARGUMENT;
    const size_t m = found->n * modes;
    double *C = (double *)malloc(3 * m * m * sizeof *C);
    if (!C)
        return PK_NO_MEMORY;
    double *B = C + m * m, *U = B + m * m;
    part(found, found->C, modes, C);
    part(found, found->B, modes, B);
    const enum pk_status status = pk_gsl_pencil(m, C, B, lambda, U); /* fails if M is singular */
    for (size_t i = 0; status >= 0 && lowest && i < m; i++)
        lowest[i] = U[i * m];
    free(C);
    return status;
}

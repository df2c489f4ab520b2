/* The equations of equilibria with rotations and constraints. The unknowns are all numbers of q and
 * v, also off the constraints:
 *
 *     of a coordinate      a_i = 0; if it is cyclic, p_i = its initial value
 *     of a body rate       w_i = 0
 *     of a quaternion      the body's three accelerations = 0, |Q|^2 = 1
 *     in addition          phi = 0, J v + j0 = 0
 *
 * The accelerations contain the multipliers, so J a = 0 too, and rows are linearly dependent; on a
 * continuum of equilibria columns are too. The Levenberg-Marquardt method (gsl_multifit_nlinear)
 * solves them, and Newton's corrections are those of least norm.
 */
#include <string.h>

#include <gsl/gsl_blas.h>
#include <gsl/gsl_errno.h>
#include <gsl/gsl_linalg.h>
#include <gsl/gsl_multifit_nlinear.h>

#include <pk/gsl_equilibria.h>

#include "equilibria_search.h"
#include "rates.h"

enum { ITERATIONS = 100, NEWTON = 6 };
static const double DEPENDENT = 1e-7; /* relative to the largest singular value: smaller are 0 */
static const double BESIDE = 6e-6;    /* difference for derivatives, relative to the reach */

/* Computes the momenta p; only those of cyclic coordinates are used. */
static void momenta(struct search *s, double *p)
{
    const struct pk_problem *problem = s->problem;
    problem->system->unconstrained(problem->params, 0, s->q, s->v, NULL, p, s->rest);
}

int pk_bound_equations(struct search *s)
{
    const struct pk_problem *problem = s->problem;
    const struct pk_system *system = problem->system;
    const size_t n = s->n, Q = quaternions(s), w = Q - 3 * system->n_rotations;
    if (system->acceleration(problem->params, 0, s->q, s->v, NULL, s->pdot))
        return 0;
    momenta(s, s->p);
    memset(s->rest, 0, n * sizeof *s->rest);
    for (size_t i = 0; i < n; i++)
        s->F[i] = is_cyclic(s, i)      ? s->p[i] - s->kept[i]
                  : is_body_rate(s, i) ? s->v[i]
                  : s->unread[i]       ? s->v[i] - s->middle[i]
                                       : s->pdot[i];
    for (size_t r = 0; r < system->n_rotations; r++) {
        const double *q = s->v + Q + 4 * r;
        for (size_t i = 0; i < 3; i++)
            s->F[Q + 4 * r + i] = s->pdot[w + 3 * r + i];
        s->F[Q + 4 * r + 3] = (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] - 1) / 2;
    }
    pk_gsl_residuals(problem, s->q, s->v, s->F + n, s->J);
    return pk_all_finite(s->F, s->rows);
}

/* Returns the column of unknown j in the matrix of pk_gsl_linearised(). */
static size_t column(const struct search *s, size_t j) { return is_cyclic(s, j) ? s->n + j : j; }

/* Computes dp_i of cyclic coordinates by each unknown, by central differences. */
static void momenta_by(struct search *s)
{
    const size_t n = s->n;
    for (size_t j = 0; j < n && s->problem->system->cyclic; j++) {
        double *const x = unknown(s, j), at = *x, d = BESIDE * reach(s, j);
        *x = at + d;
        momenta(s, s->p);
        *x = at - d;
        momenta(s, s->pdot);
        *x = at;
        for (size_t i = 0; i < n; i++)
            if (is_cyclic(s, i))
                s->J[i * n + j] = (s->p[i] - s->pdot[i]) / (2 * d);
    }
    memset(s->rest, 0, n * sizeof *s->rest);
}

int pk_bound_derivatives(struct search *s)
{
    const struct pk_system *system = s->problem->system;
    const size_t n = s->n, Q = quaternions(s), w = Q - 3 * system->n_rotations;
    const size_t m = coordinates(s), c = system->constraints.n;
    if (pk_gsl_linearised(s->problem, 0, s->q, s->v, s->A) != PK_DONE ||
        pk_gsl_kept(s->problem, s->q, s->v, s->C) != PK_DONE)
        return 0;
    momenta_by(s);
    for (size_t i = 0; i < s->rows; i++)
        for (size_t j = 0; j < n; j++) {
            const size_t k = column(s, j), part = i - Q; /* wraps to a huge number for i < Q */
            double *const x = &s->J[i * n + j];
            if (i >= n)
                *x = gsl_matrix_get(s->C, i - n, k);
            else if (part < 4 * system->n_rotations)
                *x = part % 4 < 3
                         ? gsl_matrix_get(s->A, w + 3 * (part / 4) + part % 4, k)
                         : gsl_matrix_get(s->C, system->constraints.n_holonomic + c + part / 4, k);
            else if (is_body_rate(s, i) || s->unread[i])
                *x = i == j;
            else if (!is_cyclic(s, i))
                *x = gsl_matrix_get(s->A, i < m ? n + i : i, k);
        }
    return pk_all_finite(s->J, s->rows * n);
}

void pk_bound_solve(struct search *s, pk_gsl_vector *f, pk_gsl_matrix *df)
{
    const gsl_multifit_nlinear_parameters parameters = gsl_multifit_nlinear_default_parameters();
    gsl_multifit_nlinear_fdf fdf = {f, df, NULL, s->rows, s->n, s, 0, 0, 0};
    gsl_multifit_nlinear_workspace *w =
        gsl_multifit_nlinear_alloc(gsl_multifit_nlinear_trust, &parameters, s->rows, s->n);
    gsl_vector *z = gsl_vector_alloc(s->n);
    int info;
    for (size_t i = 0; z && i < s->n; i++)
        gsl_vector_set(z, i, *unknown(s, i));
    if (w && z && gsl_multifit_nlinear_init(z, &fdf, w) == GSL_SUCCESS) {
        gsl_multifit_nlinear_driver(ITERATIONS, 1e-12, 1e-30, 0, NULL, NULL, &info, w);
        for (size_t i = 0; i < s->n; i++)
            *unknown(s, i) = gsl_vector_get(gsl_multifit_nlinear_position(w), i);
    }
    gsl_multifit_nlinear_free(w);
    gsl_vector_free(z);
    for (size_t k = 0; k < NEWTON; k++) {
        if (!pk_bound_equations(s) || !pk_bound_derivatives(s) || !pk_bound_correct(s) ||
            !pk_all_finite(s->F, s->n))
            break;
        for (size_t i = 0; i < s->n; i++) { /* tiny numbers become 0: squares would underflow */
            const double x = *unknown(s, i) - s->F[i];
            *unknown(s, i) = fabs(x) > 1e-40 * s->box[i] ? x : 0;
        }
    }
}

int pk_bound_correct(struct search *s)
{
    const size_t n = s->n;
    gsl_matrix *U = gsl_matrix_alloc(s->rows, n), *V = gsl_matrix_alloc(n, n);
    gsl_vector *S = gsl_vector_alloc(n), *x = gsl_vector_alloc(n), *f = gsl_vector_alloc(s->rows);
    int good = U && V && S && x && f;
    for (size_t i = 0; i < s->rows && good; i++) {
        gsl_vector_set(f, i, s->F[i] / s->scale[i]);
        for (size_t j = 0; j < n; j++)
            gsl_matrix_set(U, i, j, s->J[i * n + j] * reach(s, j) / s->scale[i]);
    }
    good = good && !gsl_linalg_SV_decomp_jacobi(U, V, S);
    if (good) {
        gsl_blas_dgemv(CblasTrans, 1, U, f, 0, x);
        s->slack = 0;
        for (size_t j = 0; j < n; j++) {
            const double size = gsl_vector_get(S, j);
            const int leads = size > DEPENDENT * gsl_vector_get(S, 0);
            s->slack += !leads;
            gsl_vector_set(x, j, leads ? gsl_vector_get(x, j) / size : 0);
        }
        for (size_t i = 0; i < n; i++) {
            double sum = 0;
            for (size_t j = 0; j < n; j++)
                sum += gsl_matrix_get(V, i, j) * gsl_vector_get(x, j);
            s->F[i] = sum * reach(s, i);
            s->along[i] = gsl_matrix_get(V, i, n - 1) * reach(s, i);
        }
    }
    gsl_matrix_free(U);
    gsl_matrix_free(V);
    gsl_vector_free(S);
    gsl_vector_free(x);
    gsl_vector_free(f);
    return good;
}

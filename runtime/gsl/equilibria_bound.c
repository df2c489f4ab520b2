/* The equations of equilibria of systems with rotations or constraints. The unknowns are the same
 * as without constraints (see equilibria.c): one for each coordinate, body rate and other
 * first-order variable, and 4 for each quaternion. In the equations below, a is the acceleration, p
 * the momentum, w a component of a body's angular velocity, Q its quaternion, phi = 0 a holonomic
 * constraint and J v + j0 = 0 all constraints on rates:
 *
 *     for a coordinate     a_i = 0; if the coordinate is cyclic, p_i = its initial value
 *     for a body rate      w_i = 0
 *     for a quaternion     the body's three angular accelerations = 0, |Q|^2 = 1
 *     for the constraints  phi = 0, J v + j0 = 0
 *
 * The accelerations include constraint forces, so they satisfy J a = 0, and rows of the Jacobian
 * matrix of the equations are linearly dependent. On a continuum of equilibria its columns are
 * linearly dependent, too. The equations are therefore solved by the Levenberg-Marquardt method
 * (gsl_multifit_nlinear) and by Newton's method with corrections of least norm. */
#include <string.h>

#include <gsl/gsl_blas.h>
#include <gsl/gsl_errno.h>
#include <gsl/gsl_linalg.h>
#include <gsl/gsl_multifit_nlinear.h>

#include <pk/gsl_equilibria.h>

#include "equilibria_search.h"

enum { ITERATIONS = 100, NEWTON = 6 };
/* singular values below this fraction of the largest one count as 0 */
static const double DEPENDENT = 1e-7;
static const double BESIDE = 1e-6; /* step of central differences, as a fraction of reach() */

int pk_bound_equations(struct search *s)
{
    const struct pk_problem *problem = s->problem;
    const struct pk_system *system = problem->system;
    const size_t n = s->n, Q = quaternions(s), w = Q - 3 * system->n_rotations;
    if (system->acceleration(OF(s), s->pdot))
        return 0;
    system->unconstrained(OF(s), s->p, s->rest);
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
        s->F[Q + 4 * r + 3] = (pk_dot(q, q, 4) - 1) / 2;
    }
    const struct pk_part_constraints *kept = &system->constraints;
    if (kept->n_holonomic)
        kept->values(OF(s), s->F + n);
    if (kept->n)
        kept->jacobian(OF(s), s->F_v, s->F + n + kept->n_holonomic);
    return pk_all_finite(s->F, s->rows);
}

int pk_bound_derivatives(struct search *s)
{
    const size_t n = s->n;
    int good = 1;
    memcpy(s->M, s->F, s->rows * sizeof *s->F);
    for (size_t j = 0; j < n && good; j++) {
        double *const x = unknown(s, j), at = *x, d = BESIDE * reach(s, j);
        for (int side = 1; side >= -1 && good; side -= 2) {
            *x = at + side * d;
            good = pk_bound_equations(s);
            for (size_t i = 0; i < s->rows; i++) {
                double *const slope = &s->J[i * n + j];
                *slope = side > 0 ? s->F[i] : (*slope - s->F[i]) / (2 * d);
            }
        }
        *x = at;
    }
    memcpy(s->F, s->M, s->rows * sizeof *s->F);
    return good && pk_all_finite(s->J, s->rows * n);
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
        /* Numbers much smaller than the box become 0, since their squares would underflow. */
        for (size_t i = 0; i < s->n; i++) {
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

/* Normal modes at a (relative) equilibrium; see pk/gsl_equilibria.h for the pencil M, C, K.
 *
 * If C vanishes and K is symmetric, as at an equilibrium of a natural system, the modes solve K u =
 * omega^2 M u (gsl_eigen_gensymmv: Cholesky's factors of M, then symmetric QR). Otherwise they are
 * those of the first-order system of twice the size (gsl_eigen_nonsymmv).
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <gsl/gsl_eigen.h>
#include <gsl/gsl_errno.h>

#include <pk/gsl_equilibria.h>

#include "../src/core/internal.h"
#include "pencil.h"
#include "rates.h"

static const double ZERO = 1e-7; /* relative to the largest eigenvalue: smaller ones are 0 */

/* The pencil of the m coordinates that are not cyclic, and R and S that give the rates of the
 * cyclic ones: v_c = R u' + S u. */
struct pencil {
    size_t n, m;
    size_t *map; /* coordinates that are not cyclic, then those that are */
    double *M, *C, *K;
    double *R, *S; /* (n - m) by m */
};

static double *entry(double *A, size_t columns, size_t i, size_t j) { return A + i * columns + j; }

/* Evaluates the kernels' matrices and eliminates the cyclic coordinates (Routh reduction). */
static enum pk_status reduce(struct pencil *x, const struct pk_problem *problem, const double *q,
                             const double *v, double *work)
{
    const struct pk_system *system = problem->system;
    const size_t n = x->n, m = x->m, c = n - m;
    double *M = work, *P = M + n * n, *F = P + n * n, *G = F + n * n;
    double *B = G + n * n, *pivot = B + n * n, *column = pivot + n;
    system->mass(problem->params, 0, q, v, NULL, M);
    system->jacobian(problem->params, 0, q, v, NULL, P, F, G);
    if (!pk_all_finite(M, 4 * n * n))
        return PK_NOT_FINITE;
    memcpy(B, M, n * n * sizeof *B);
    if (pk_ldl_factor(B, n))
        return PK_SINGULAR_MASS;
    for (size_t i = 0; i < c; i++)
        for (size_t j = 0; j < c; j++)
            B[i * c + j] = M[x->map[m + i] * n + x->map[m + j]];
    if (c && !pk_lu_factor(B, pivot, c))
        return PK_SINGULAR_MASS;
    for (size_t j = 0; j < m; j++) {
        const double *const from[] = {M, P};
        double *const to[] = {x->R, x->S};
        for (int part = 0; part < 2; part++) {
            for (size_t i = 0; i < c; i++)
                column[i] = -from[part][x->map[m + i] * n + x->map[j]];
            if (c)
                pk_lu_solve(B, pivot, c, column);
            for (size_t i = 0; i < c; i++)
                *entry(to[part], m, i, j) = column[i];
        }
    }
    for (size_t i = 0; i < m; i++)
        for (size_t j = 0; j < m; j++) {
            const size_t row = x->map[i] * n, a = row + x->map[j];
            double mass = M[a], damping = P[a] - G[a], stiffness = -F[a];
            for (size_t k = 0; k < c; k++) {
                const size_t b = row + x->map[m + k];
                const double r = *entry(x->R, m, k, j), s = *entry(x->S, m, k, j);
                mass += M[b] * r;
                damping += M[b] * s + (P[b] - G[b]) * r;
                stiffness += (P[b] - G[b]) * s;
            }
            *entry(x->M, m, i, j) = mass;
            *entry(x->C, m, i, j) = damping;
            *entry(x->K, m, i, j) = stiffness;
        }
    return PK_DONE;
}

/* Returns whether C is round-off, relative to M and K, and K is symmetric. */
static int is_natural(const struct pencil *x)
{
    const size_t m = x->m;
    const double c = pk_gsl_largest(x->C, m * m), k = pk_gsl_largest(x->K, m * m),
                 M = pk_gsl_largest(x->M, m * m);
    if (c > 1e-12 * sqrt(k * M))
        return 0;
    for (size_t i = 0; i < m; i++)
        for (size_t j = 0; j < i; j++)
            if (fabs(x->K[i * m + j] - x->K[j * m + i]) > 1e-12 * k)
                return 0;
    return 1;
}

/* Stores a mode, given its part u of the coordinates that are not cyclic. The largest component of
 * that part is scaled to 1. Cyclic coordinates have q_c = v_c / lambda, if lambda is not 0. */
static void add(const struct pencil *x, double growth, double frequency, const double *re,
                const double *im, struct pk_mode *mode, double *shape)
{
    const size_t n = x->n, m = x->m;
    const double square = growth * growth + frequency * frequency;
    mode->growth = growth;
    mode->frequency = frequency;
    memset(shape, 0, 2 * n * sizeof *shape);
    for (size_t i = 0; i < m; i++) {
        shape[x->map[i]] = re[i];
        shape[n + x->map[i]] = im[i];
    }
    for (size_t k = 0; k < n - m && square > 0; k++) {
        double a = 0, b = 0; /* R u + S u / lambda */
        for (size_t j = 0; j < m; j++) {
            const double r = x->R[k * m + j], s = x->S[k * m + j] / square;
            a += r * re[j] + s * (re[j] * growth + im[j] * frequency);
            b += r * im[j] + s * (im[j] * growth - re[j] * frequency);
        }
        shape[x->map[m + k]] = a;
        shape[n + x->map[m + k]] = b;
    }
    double most = 0, a = 1, b = 0;
    for (size_t i = 0; i < m; i++) {
        const double u = shape[x->map[i]], w = shape[n + x->map[i]];
        if (hypot(u, w) > most * (1 + 1e-9)) {
            most = hypot(u, w);
            a = u / most;
            b = w / most;
        }
    }
    for (size_t i = 0; i < n && most > 0; i++) { /* rotates phases: the largest becomes real */
        const double u = shape[i] / most, w = shape[n + i] / most;
        shape[i] = u * a + w * b;
        shape[n + i] = w * a - u * b;
    }
}

static int natural_modes(const struct pencil *x, struct pk_mode *modes, double *shapes,
                         size_t *count, double *scratch)
{
    const size_t m = x->m;
    double *square = scratch + 2 * m, *U = square + m;
    const int failed = pk_gsl_pencil(m, x->K, x->M, square, U) < 0;
    const double most = failed ? 0 : pk_gsl_largest(square, m);
    for (size_t k = 0; k < m && !failed; k++) {
        const double s = square[k], rate = sqrt(fabs(s));
        const int zero = rate <= ZERO * sqrt(most);
        for (size_t i = 0; i < m; i++) {
            scratch[i] = U[i * m + k];
            scratch[m + i] = 0;
        }
        for (int sign = 1; sign >= (s > 0 && !zero ? 1 : -1); sign -= 2) {
            add(x, s > 0 || zero ? 0 : sign * rate, s > 0 && !zero ? rate : 0, scratch, scratch + m,
                modes + *count, shapes + 2 * x->n * *count);
            ++*count;
        }
    }
    return failed;
}

/* Computes the modes of z' = A z, or with T of y' = A y and z = T y; the first m numbers of z are
 * the shape. Skips `left` zero eigenvalues. Returns whether it failed. */
static int spectrum(const struct pencil *x, gsl_matrix *A, const gsl_matrix *T, size_t left,
                    struct pk_mode *modes, double *shapes, size_t *count, double *scratch)
{
    const size_t m = x->m, N = A->size1;
    gsl_eigen_nonsymmv_workspace *w = gsl_eigen_nonsymmv_alloc(N);
    gsl_vector_complex *lambda = gsl_vector_complex_alloc(N);
    gsl_matrix_complex *U = gsl_matrix_complex_alloc(N, N);
    int failed = !w || !lambda || !U;
    double most = 0;
    if (!failed) {
        gsl_eigen_nonsymmv_params(1, w);
        failed = gsl_eigen_nonsymmv(A, lambda, U, w);
    }
    for (size_t k = 0; k < N && !failed; k++) {
        const gsl_complex l = gsl_vector_complex_get(lambda, k);
        most = fmax(most, hypot(GSL_REAL(l), GSL_IMAG(l)));
    }
    for (size_t k = 0; k < N && !failed; k++) {
        const gsl_complex l = gsl_vector_complex_get(lambda, k);
        double growth = GSL_REAL(l), frequency = GSL_IMAG(l);
        growth = fabs(growth) <= ZERO * most ? 0 : growth;
        frequency = fabs(frequency) <= ZERO * most ? 0 : frequency;
        if (frequency < 0 || (left && growth == 0 && frequency == 0 && left--))
            continue;
        for (size_t i = 0; i < m; i++) {
            scratch[i] = scratch[m + i] = 0;
            for (size_t j = T ? 0 : i; j < (T ? N : i + 1); j++) {
                const gsl_complex u = gsl_matrix_complex_get(U, j, k);
                const double part = T ? gsl_matrix_get(T, i, j) : 1;
                scratch[i] += part * GSL_REAL(u);
                scratch[m + i] += part * GSL_IMAG(u);
            }
        }
        add(x, growth, frequency, scratch, scratch + m, modes + *count, shapes + 2 * x->n * *count);
        ++*count;
    }
    gsl_eigen_nonsymmv_free(w);
    gsl_vector_complex_free(lambda);
    gsl_matrix_complex_free(U);
    return failed;
}

static int general_modes(const struct pencil *x, struct pk_mode *modes, double *shapes,
                         size_t *count, double *scratch)
{
    const size_t m = x->m;
    double *pivot = scratch + 2 * m, *column = pivot + m;
    gsl_matrix *A = gsl_matrix_calloc(2 * m, 2 * m);
    int failed = !A || !pk_lu_factor(x->M, pivot, m);
    for (size_t j = 0; j < m && !failed; j++) { /* (0 1; -K/M -C/M), a column at a time */
        gsl_matrix_set(A, j, m + j, 1);
        for (int part = 0; part < 2; part++) {
            for (size_t i = 0; i < m; i++)
                column[i] = -(part ? x->C : x->K)[i * m + j];
            pk_lu_solve(x->M, pivot, m, column);
            for (size_t i = 0; i < m; i++)
                gsl_matrix_set(A, m + i, j + (part ? m : 0), column[i]);
        }
    }
    failed = failed || spectrum(x, A, NULL, 0, modes, shapes, count, scratch);
    gsl_matrix_free(A);
    return failed;
}

/* Modes with first-order variables, rotations or constraints: of all variables that a rate depends
 * on, in the tangent space of the constraints. Each cyclic coordinate adds a zero eigenvalue, from
 * its constant momentum, which is skipped. */
static enum pk_status first_order_modes(struct pencil *x, const struct pk_problem *problem,
                                        const double *q, const double *v, struct pk_mode *modes,
                                        double *shapes, size_t *count, double *scratch)
{
    const size_t n = x->n, coordinates = pk_system_coordinates(problem->system, problem->params);
    const size_t N = x->m + coordinates, cyclic = n - x->m;
    size_t left = 0, *const among = (size_t *)calloc(N, sizeof *among);
    gsl_matrix *all = gsl_matrix_alloc(n + coordinates, n + coordinates),
               *A = gsl_matrix_alloc(N, N), *T = NULL;
    enum pk_status status = PK_NO_MEMORY;
    if (all && A && among)
        status = pk_gsl_linearised(problem, 0, q, v, all);
    for (size_t k = 0; k < cyclic; k++)
        left += x->map[x->m + k] < coordinates;
    for (size_t i = 0; i < N && status == PK_DONE; i++)
        among[i] = i < x->m ? x->map[i] : n + i - x->m;
    for (size_t i = 0; i < N && status == PK_DONE; i++)
        for (size_t j = 0; j < N; j++)
            gsl_matrix_set(A, i, j, gsl_matrix_get(all, among[i], among[j]));
    if (status == PK_DONE && pk_gsl_kept_count(problem))
        status = pk_gsl_tangent(problem, q, v, among, &A, &T);
    if (status == PK_DONE && spectrum(x, A, T, left, modes, shapes, count, scratch))
        status = PK_NO_CONVERGENCE;
    gsl_matrix_free(all);
    gsl_matrix_free(A);
    gsl_matrix_free(T);
    free(among);
    return status;
}

/* Sorts by |lambda|, largest first; at equal |lambda| growing modes come before decaying ones. */
static void sort(size_t n, struct pk_mode *modes, double *shapes, size_t count)
{
    for (size_t i = 1; i < count; i++)
        for (size_t k = i; k > 0; k--) {
            const double a = hypot(modes[k].growth, modes[k].frequency);
            const double b = hypot(modes[k - 1].growth, modes[k - 1].frequency);
            if (!(a > b * (1 + 1e-9)) &&
                !(a > b * (1 - 1e-9) && modes[k].growth > modes[k - 1].growth + 1e-9 * b))
                break;
            const struct pk_mode mode = modes[k];
            modes[k] = modes[k - 1];
            modes[k - 1] = mode;
            for (size_t x = 0; x < 2 * n; x++) {
                const double swap = shapes[2 * n * k + x];
                shapes[2 * n * k + x] = shapes[2 * n * (k - 1) + x];
                shapes[2 * n * (k - 1) + x] = swap;
            }
        }
}

enum pk_status pk_gsl_modes(const struct pk_problem *problem, const double *q, const double *v,
                            struct pk_mode *modes, double *shapes, size_t *count)
{
    const struct pk_system *system = problem->system;
    struct pencil x = {0};
    const int first_order = system->n_first_order || system->constraints.n;
    *count = 0;
    if (!first_order && (!system->jacobian || !system->mass))
        return PK_REFUSED;
    x.n = pk_system_count(system, problem->params);
    x.map = (size_t *)calloc(x.n, sizeof *x.map);
    unsigned char *apart = (unsigned char *)calloc(x.n, 1); /* cyclic, or a quadrature */
    double *block = (double *)calloc(10 * x.n * x.n + 6 * x.n, sizeof *block);
    enum pk_status status = x.map && apart && block ? PK_DONE : PK_NO_MEMORY;
    if (status == PK_DONE && system->n_first_order)
        status = pk_gsl_unread(problem, q, v, apart);
    if (status == PK_DONE) {
        const size_t coordinates = pk_system_coordinates(system, problem->params);
        size_t c = 0;
        for (size_t i = 0; i < coordinates; i++)
            apart[i] = system->cyclic && system->cyclic[i];
        for (size_t i = 0; i < x.n; i++)
            if (!apart[i])
                x.map[x.m++] = i;
        for (size_t i = 0; i < x.n; i++)
            if (apart[i])
                x.map[x.m + c++] = i;
        x.M = block;
        x.C = x.M + x.n * x.n;
        x.K = x.C + x.n * x.n;
        x.R = x.K + x.n * x.n;
        x.S = x.R + x.n * x.n;
    }
    double *const scratch = block + 5 * x.n * x.n;
    gsl_error_handler_t *handler = gsl_set_error_handler_off();
    if (status == PK_DONE && first_order) {
        status = first_order_modes(&x, problem, q, v, modes, shapes, count, scratch);
    } else if (status == PK_DONE) {
        status = reduce(&x, problem, q, v, scratch);
        if (status == PK_DONE && x.m &&
            (is_natural(&x) ? natural_modes(&x, modes, shapes, count, scratch)
                            : general_modes(&x, modes, shapes, count, scratch)))
            status = PK_NO_CONVERGENCE;
    }
    gsl_set_error_handler(handler);
    if (status == PK_DONE)
        sort(x.n, modes, shapes, *count);
    free(x.map);
    free(apart);
    free(block);
    return status;
}

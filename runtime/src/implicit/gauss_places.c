/* Matrices and vectors of the implicit methods in the order of unknowns of struct pk_pattern
 * ("places"). With dense derivatives this is the order of coordinates. In the band of Newton's
 * matrix the stages of a place are adjacent, which keeps the band narrow; in the border, and if all
 * is dense, unknowns are in the order of stages. */
#include <string.h>

#include "gauss.h"

struct pk_band pk_gauss_band(const struct pk_gauss_work *w, pk_real *numbers)
{
    struct pk_band band = {.rows = w->pattern.rows,
                           .below = w->pattern.width,
                           .above = w->pattern.width,
                           .border = w->pattern.border};
    pk_band_lay_out(&band, numbers);
    return band;
}

void pk_gauss_to_places(const struct pk_gauss_work *w, size_t s, const pk_real *x, pk_real *y)
{
    const size_t rows = w->pattern.rows, border = w->pattern.border;
    for (size_t i = 0; i < s && w->pattern.dense; i++)
        pk_copy(y + i * border, x + i * w->n, border);
    for (size_t k = 0; k < w->places && !w->pattern.dense; k++)
        for (size_t i = 0; i < s; i++) {
            pk_real *to = y + (k < rows ? k * s + i : rows * s + i * border + (k - rows));
            *to = w->place[k] < 0 ? 0 : x[i * w->n + pk_index(w->place[k], w->n)];
        }
}

void pk_gauss_to_coordinates(const struct pk_gauss_work *w, size_t s, const pk_real *y, pk_real *x)
{
    const size_t rows = w->pattern.rows, border = w->pattern.border;
    for (size_t i = 0; i < s && w->pattern.dense; i++)
        pk_copy(x + i * w->n, y + i * border, border);
    for (size_t k = 0; k < w->places && !w->pattern.dense; k++)
        for (size_t i = 0; i < s; i++)
            if (!(w->place[k] < 0))
                x[i * w->n + pk_index(w->place[k], w->n)] =
                    y[k < rows ? k * s + i : rows * s + i * border + (k - rows)];
}

void pk_gauss_lu_solve(const struct pk_gauss_work *w, const struct pk_band *lu, size_t s,
                       pk_real *x)
{
    if (w->pattern.dense && (s == 1 || w->places == w->n)) {
        pk_band_solve(lu, x);
        return;
    }
    pk_gauss_to_places(w, s, x, w->z);
    pk_band_solve(lu, w->z);
    pk_gauss_to_coordinates(w, s, w->z, x);
}

void pk_gauss_solve_with(const struct pk_gauss_work *w, pk_real *A, const pk_real *x,
                         const struct pk_band *lu, pk_real *y)
{
    const struct pk_band band = pk_gauss_band(w, A);
    pk_real *of_x = w->z, *of_y = w->z + w->places;
    if (w->pattern.dense) {
        for (size_t i = 0; i < w->n; i++)
            for (size_t k = 0; k < w->places; k++)
                y[i] += A[i * w->n + k] * x[k];
        pk_band_solve(lu, y);
        return;
    }
    pk_gauss_to_places(w, 1, x, of_x);
    pk_gauss_to_places(w, 1, y, of_y);
    pk_band_add_product(&band, of_x, of_y);
    pk_band_solve(lu, of_y);
    pk_gauss_to_coordinates(w, 1, of_y, y);
}

int pk_gauss_mass_factor(const struct pk_gauss_work *w, pk_real *M)
{
    const struct pk_band band = pk_gauss_band(w, M);
    for (size_t i = 1; i < w->places && w->pattern.dense && w->places < w->n; i++)
        /* drops the columns of quadratures */
        memmove(M + i * w->places, M + i * w->n, w->places * sizeof *M);
    size_t at = pk_band_ldl_factor(&band, w->pattern.dense ? NULL : w->place);
    if (!at--)
        return 0;
    /* goes back to an unknown that has a coordinate */
    while (!w->pattern.dense && at && w->place[at] < 0)
        at--;
    return PK_FAILED(PK_FAILURE_MASS, w->pattern.dense   ? at
                                      : w->place[at] < 0 ? 0
                                                         : pk_index(w->place[at], w->n));
}

void pk_gauss_mass_solve(const struct pk_gauss_work *w, pk_real *M, pk_real *x)
{
    const struct pk_band band = pk_gauss_band(w, M);
    pk_real *y = !w->pattern.dense ? w->z : x;
    if (!w->pattern.dense)
        pk_gauss_to_places(w, 1, x, y);
    pk_band_ldl_solve(&band, y);
    if (!w->pattern.dense)
        pk_gauss_to_coordinates(w, 1, y, x);
}

void pk_gauss_compare(const struct pk_gauss_work *w, pk_real *M)
{
    const struct pk_band band = pk_gauss_band(w, M);
    for (size_t x = 0; x < w->nn; x++)
        M[x] = -pk_abs(M[x]);
    for (size_t k = 0; k < w->places; k++)
        *pk_band_entry(&band, k, k) *= -1;
}

void pk_gauss_mass(struct pk_integrator *it, pk_real t, const pk_real *q, const pk_real *v,
                   pk_real *M)
{
    const struct pk_system *system = it->problem.system;
    pk_kernel *mass = system->families.pattern ? system->families.mass : system->mass;
    mass(it->problem.params, t, q, v, pk_eval_input(it, t), M);
}

void pk_gauss_derivatives(struct pk_integrator *it, const struct pk_gauss_work *w, pk_real t,
                          const pk_real *q, const pk_real *v, pk_real *J)
{
    const struct pk_system *system = it->problem.system;
    pk_kernel_3 *jacobian = system->families.pattern ? system->families.jacobian : system->jacobian;
    const pk_real *u = pk_eval_input(it, t);
    if (system->families.closed)
        system->families.closed(it->problem.params, t, q, v, u, J);
    else
        pk_gauss_mass(it, t, q, v, J);
    jacobian(it->problem.params, t, q, v, u, J + w->nn, J + 2 * w->nn, J + 3 * w->nn);
    it->count.jacobians++;
}

void pk_gauss_stage_derivatives(struct pk_integrator *it, struct pk_gauss_work *w)
{
    const size_t n = it->n;
    for (size_t i = 0; i < w->s; i++)
        pk_gauss_derivatives(it, w, it->t + w->c[i] * it->own->h, w->Q + i * it->n_q, w->V + i * n,
                             w->jacobian + i * 4 * w->nn);
}

/* Data of block (i, j) of Newton's matrix, for stages i and j. */
struct block {
    const pk_real *Ji, *Jj, *J, *hh;
    size_t s, nn, stride;
    pk_real mass, a, a_p, tau2;
};

/* Computes `count` entries of a block, from entry x on, and writes them to to[0], to[apart], to[2
 * apart], ... in a row of the matrix. */
static inline void fill(const struct block *b, size_t x, size_t count, pk_real *to, size_t apart)
{
    const size_t nn = b->nn;
    for (size_t k = 0; k < count; k++, x++) {
        pk_real sum = 0;
        for (size_t r = 0; r < b->s; r++)
            sum += b->hh[r] * b->J[r * b->stride + 2 * nn + x];
        to[k * apart] = b->mass * b->Ji[x] + b->a * b->Ji[nn + x] - b->a_p * b->Jj[3 * nn + x] -
                        b->tau2 * sum;
    }
}

void pk_gauss_matrix(const struct pk_gauss_work *w, const pk_real *J, size_t stride, pk_real tau,
                     pk_real mass, const struct pk_band *to)
{
    const size_t s = w->s, rows = w->pattern.rows, width = w->pattern.width;
    const size_t border = w->pattern.border, band = 2 * width + 1, right = rows * band;
    const size_t bottom = right + rows * border, corner = bottom + rows * border;
    const size_t across = w->across;
    if (rows)
        pk_band_clear(to);
    for (size_t i = 0; i < s; i++)
        for (size_t j = 0; j < s; j++) {
            const struct block b = {.Ji = J + i * stride,
                                    .Jj = J + j * stride,
                                    .J = J,
                                    .hh = w->hh + (i * s + j) * s,
                                    .s = s,
                                    .nn = w->nn,
                                    .stride = stride,
                                    .mass = i == j ? mass : 0,
                                    .a = tau * w->hA[i * s + j],
                                    .a_p = tau * w->hA_p[i * s + j],
                                    .tau2 = tau * tau};
            const size_t row = rows * s + i * border, column = rows * s + j * border;
            for (size_t k = 0; k < rows; k++) {
                const size_t first = k > width ? k - width : 0;
                const size_t last = k + width < rows ? k + width + 1 : rows;
                pk_real *entry = pk_band_entry(to, k * s + i, first * s + j);
                fill(&b, k * band + first + width - k, last - first, entry, s);
                if (border) {
                    entry = pk_band_entry(to, k * s + i, column);
                    fill(&b, right + k * border, border, entry, 1);
                    fill(&b, bottom + k * border, border, pk_band_entry(to, row, k * s + j), 1);
                }
            }
            for (size_t k = 0; k < border; k++)
                fill(&b, corner + k * across, border, pk_band_entry(to, row + k, column), 1);
        }
}

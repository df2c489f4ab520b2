/* Explicit Runge-Kutta methods on R^n x SO(3)^b (Munthe-Kaas): a rotation is R0 exp(theta), and
 * it is theta, a vector, that the tableau integrates, theta' = d(exp)^-1 omega (pk_dexp_inverse());
 * so quaternions are of unit length at every stage. All else is as in pk/step/erk.h, and without
 * rotations all is. Reference: H. Munthe-Kaas, Appl. Numer. Math. 29 (1999) 115; E. Hairer,
 * C. Lubich, G. Wanner, Geometric Numerical Integration, IV.8.2.
 */
#include <string.h>

#include "../core/attitude.h"
#include "../core/generic.h"
#include "../core/tableau.h"

#include <pk/step/tables.h>

/* Where the quaternion of rotation r, and its rates, are among the 2 n numbers of a state. */
static size_t quaternion(const struct pk_integrator *it, size_t r)
{
    const struct pk_system *system = it->problem.system;
    return 2 * it->n - system->n_first_order + 3 * system->n_rotations + 4 * r;
}
static size_t rates(const struct pk_integrator *it, size_t r)
{
    return 2 * it->n - it->problem.system->n_first_order + 3 * r;
}

/* Slopes k hold theta' in place of Q'. theta of h sum a_j k_j. */
static void rotation_vector(const struct pk_integrator *it, const pk_real *a, int count, size_t r,
                            pk_real *theta)
{
    for (size_t i = 0; i < 3; i++)
        theta[i] = it->own->h *
                   pk_row_sum(a, count, it->own->work, 2 * it->n, quaternion(it, r) + i);
}

/* The argument of stage i. */
static const pk_real *argument(const struct pk_integrator *it, const struct pk_tableau *table,
                               int i, pk_real *y)
{
    const pk_real *a = table->a + i * (i - 1) / 2;
    if (i == 0)
        return it->own->state;
    pk_erk_combine(y, it->own->state, it->own->h, a, i, it->own->work, 2 * it->n);
    for (size_t r = 0; r < it->problem.system->n_rotations; r++) {
        const pk_real *Q = it->own->state + quaternion(it, r);
        pk_real theta[3], added[4];
        rotation_vector(it, a, i, r, theta);
        pk_exponential_added(Q, theta, added);
        for (size_t k = 0; k < 4; k++)
            y[quaternion(it, r) + k] = Q[k] + added[k];
    }
    return y;
}

static enum pk_status rkmk_step(struct pk_integrator *it, pk_real limit)
{
    const struct pk_tableau *table = (const struct pk_tableau *)it->method->table;
    const size_t n = it->n, m = 2 * n, turned = it->problem.system->n_rotations;
    pk_real *y = it->own->next, *low = pk_part(it->own->next, n, PK_LOW_Q), theta[3], added[4];
    (void)limit;
    for (int i = 0; i < table->stages; i++) {
        const pk_real *at = argument(it, table, i, y);
        pk_real *k = it->own->work + (size_t)i * m;
        PK_TRY(generic_slope(it, it->t + table->c[i] * it->own->h, at, k));
        for (size_t r = 0; r < turned; r++) {
            rotation_vector(it, table->a + i * (i - 1) / 2, i, r, theta);
            pk_dexp_inverse(theta, at + rates(it, r), k + quaternion(it, r));
            k[quaternion(it, r) + 3] = 0;
        }
    }
    memcpy(low, pk_part(it->own->state, n, PK_LOW_Q), m * sizeof *low); /* of q and of v */
    for (size_t i = 0; i < m; i++) {
        const pk_real before = low[i]; /* of a quaternion: what is added to it comes below */
        y[i] = pk_sum(it->own->state[i],
                      it->own->h * pk_row_sum(table->b, table->stages, it->own->work, m, i),
                      &low[i]);
        if (turned && i >= quaternion(it, 0) && i < quaternion(it, turned))
            low[i] = before;
    }
    for (size_t r = 0; r < turned; r++) {
        const size_t at = quaternion(it, r);
        rotation_vector(it, table->b, table->stages, r, theta);
        pk_exponential_added(it->own->state + at, theta, added);
        for (size_t k = 0; k < 4; k++)
            y[at + k] = pk_sum(it->own->state[at + k], added[k], &low[at + k]);
    }
    return PK_DONE;
}

#define RKMK(of)                                                                               \
    .needs = PK_NEEDS_RKMK, .table = &pk_##of##_table, .size = pk_erk_size, .step = rkmk_step
PK_METHODS_RKMK(PK_DEFINE_METHOD, RKMK)

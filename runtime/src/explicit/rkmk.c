/* Explicit Runge-Kutta methods on R^n x SO(3)^b (Munthe-Kaas): a rotation is R0 exp(theta), and the
 * tableau integrates the vector theta, theta' = d(exp)^-1 omega (pk_dexp_inverse()), so quaternions
 * have unit length at every stage. Other variables are treated as in pk/step/erk.h. Reference: H.
 * Munthe-Kaas, Appl. Numer. Math. 29 (1999) 115; E. Hairer, C. Lubich, G. Wanner, Geometric
 * Numerical Integration, IV.8.2. */

#include "../core/attitude.h"
#include "../core/generic.h"
#include "../core/tableau.h"

#include <pk/step/tables.h>

static size_t rotations(const struct pk_integrator *it)
{
    return pk_system_rotations(it->problem.system, it->problem.params);
}

/* Returns the indices of the numbers of rotation r in the vector (q, v). */
static struct pk_turning turning(const struct pk_integrator *it, size_t r)
{
    struct pk_turning at = pk_system_turning(it->problem.system, it->problem.params, r);
    at.rate += it->n_q;
    at.number += it->n_q;
    return at;
}

/* Computes theta = h sum a_j k_j. For rotations, the slopes k_j contain theta' in place of Q'. */
static void rotation_vector(const struct pk_integrator *it, const pk_real *a, int count,
                            struct pk_turning at, pk_real *theta)
{
    for (size_t i = 0; i < 3; i++)
        theta[i] = it->own->h *
                   pk_row_sum(a, count, it->own->work, it->n_q + it->n, at.number + i * at.step);
}

/* Computes the increment of Q by the rotation theta = h sum a_j k_j. */
static void added_by(const struct pk_integrator *it, const pk_real *a, int count,
                     struct pk_turning at, pk_real *added)
{
    pk_real Q[4], theta[3];
    pk_gather(Q, it->own->state + at.number, 4, at.step);
    rotation_vector(it, a, count, at, theta);
    pk_exponential_added(Q, theta, added);
}

/* Returns the state (q, v) at which the derivative of stage i is evaluated. */
static const pk_real *argument(const struct pk_integrator *it, const struct pk_tableau *table,
                               int i, pk_real *y)
{
    const pk_real *a = table->a + i * (i - 1) / 2;
    if (i == 0)
        return it->own->state;
    pk_erk_combine(y, it->own->state, it->own->h, a, i, it->own->work, it->n_q + it->n);
    for (size_t r = 0; r < rotations(it); r++) {
        const struct pk_turning at = turning(it, r);
        pk_real added[4];
        added_by(it, a, i, at, added);
        for (size_t k = 0; k < 4; k++)
            y[at.number + k * at.step] = it->own->state[at.number + k * at.step] + added[k];
    }
    return y;
}

static enum pk_status rkmk_step(struct pk_integrator *it, pk_real limit)
{
    struct pk_integrator_private *const own = it->own;
    const struct pk_tableau *table = (const struct pk_tableau *)it->method->table;
    const size_t m = it->n_q + it->n, turned = rotations(it);
    pk_real *y = own->next, *low = pk_next(it, PK_LOW_Q);
    (void)limit;
    for (int i = 0; i < table->stages; i++) {
        const pk_real *at = argument(it, table, i, y);
        pk_real *k = own->work + (size_t)i * m;
        PK_TRY(generic_slope(it, it->t + table->c[i] * own->h, at, k));
        for (size_t r = 0; r < turned; r++) {
            const struct pk_turning to = turning(it, r);
            pk_real theta[3], omega[3], slope[4] = {0};
            rotation_vector(it, table->a + i * (i - 1) / 2, i, to, theta);
            pk_gather(omega, at + to.rate, 3, to.step);
            pk_dexp_inverse(theta, omega, slope);
            for (size_t j = 0; j < 4; j++)
                k[to.number + j * to.step] = slope[j];
        }
    }
    /* the low parts of q, and of v behind them */
    pk_copy(low, pk_state(it, PK_LOW_Q), m);
    for (size_t i = 0; i < m; i++)
        y[i] = pk_sum(own->state[i], own->h * pk_row_sum(table->b, table->stages, own->work, m, i),
                      &low[i]);
    for (size_t r = 0; r < turned; r++) {
        const struct pk_turning at = turning(it, r);
        pk_real added[4];
        added_by(it, table->b, table->stages, at, added);
        for (size_t k = 0, i = at.number; k < 4; k++, i += at.step) {
            low[i] = pk_state(it, PK_LOW_Q)[i];
            y[i] = pk_sum(own->state[i], added[k], &low[i]);
        }
    }
    return PK_DONE;
}

#define RKMK(of) \
    .needs = PK_NEEDS_RKMK, .table = &pk_##of##_table, .size = pk_erk_size, .step = rkmk_step
PK_METHODS_RKMK(PK_DEFINE_METHOD, RKMK)

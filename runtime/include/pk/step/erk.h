/* Explicit Runge-Kutta methods at a fixed step size, on y = (q, v), where q' is the first n_q
 * numbers of v, and v' = a(q, v, t):
 *
 *     k_i = f(t0 + c_i h, y0 + h sum_j<i a_ij k_j),   y1 = y0 + h sum b_i k_i
 *
 * with a compensated sum for y1. Reference: E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary
 * Differential Equations I, II.1. Uses the macros of pk/inlined.h. */
#include <pk/step/tables.h>

/* Computes stage i > 0: writes the state of the stage to it->own->next, and its derivative to k. */
static PK_INLINE enum pk_status PK_STEPPER(erk_stage)(struct pk_integrator *it,
                                                      const struct pk_tableau *table, int i)
{
    const size_t m = PK_STEPPER_COORDINATES(it) + PK_STEPPER_N(it);
    pk_real *k = it->own->work;
    pk_erk_combine(it->own->next, it->own->state, it->own->h, table->a + i * (i - 1) / 2, i, k, m);
    return PK_STEPPER(slope)(it, it->t + table->c[i] * it->own->h, it->own->next,
                             k + (size_t)i * m);
}

static PK_INLINE enum pk_status PK_STEPPER(erk)(struct pk_integrator *it,
                                                const struct pk_tableau *table)
{
    const size_t n_q = PK_STEPPER_COORDINATES(it), n = PK_STEPPER_N(it), m = n_q + n;
    const pk_real h = it->own->h, *y0 = it->own->state,
                  *low0 = pk_part(it->own->state, n_q, n, PK_LOW_Q);
    pk_real *k = it->own->work, *y = it->own->next, *low = pk_part(y, n_q, n, PK_LOW_Q);

#ifndef PK_WITHOUT_RUNTIME
    if (pk_is_ahead(it, h)) {
        pk_ahead_take(it, PK_Q, 2);
        pk_ahead_take(it, PK_LOW_Q, 2);
        it->count.evaluations += (unsigned long)table->stages;
        return PK_DONE;
    }
#endif
    PK_TRY(PK_STEPPER(slope)(it, it->t, y0, k));
#define PK_ERK_STAGE(i)                              \
    if ((i) < table->stages) {                       \
        PK_TRY(PK_STEPPER(erk_stage)(it, table, i)); \
    }
    PK_EACH_STAGE(PK_ERK_STAGE)
#undef PK_ERK_STAGE
    for (size_t i = 0; i < m; i++) { /* the low parts of q and of v are contiguous */
        low[i] = low0[i];
        y[i] = pk_sum(y0[i], h * pk_row_sum(table->b, table->stages, k, m, i), &low[i]);
    }
    return PK_DONE;
}

/* A step of W states in SIMD lanes, each with its own time and step size: the explicit Runge-Kutta
 * and splitting steps of pk/step/erk.h, pk/step/embedded.h and pk/step/splitting.h on a structure
 * of arrays. Terms are added in the same order as in the scalar step, so with -ffp-contract=off
 * results have the same bits. Uses the macros
 *
 *     PK_STEPPER(x)                   x with a name that is unique in this file
 *     PK_BLOCK_N(b), PK_BLOCK_LANES(b)    length of v, W
 *     PK_BLOCK_COORDINATES(b)         number of coordinates
 *     PK_BLOCK_MEMBERS(b, q, v, a)    accelerations at b->t; the bits of lanes that failed */
#include <pk/step/block.h>
#include <pk/step/tables.h>

/* Computes the acceleration in each lane, at the time from[l] + at * h[l] of lane l. */
static PK_INLINE void PK_STEPPER(block_slope)(struct pk_block *b, pk_real at, const pk_real *q,
                                              const pk_real *v, pk_real *a)
{
    for (size_t l = 0; l < PK_BLOCK_LANES(b); l++)
        b->t[l] = b->from[l] + at * b->h[l];
    const unsigned long long failed = PK_BLOCK_MEMBERS(b, q, v, a);
    if (failed)
        pk_block_failed(b, failed, q, v);
}

/* Computes the acceleration in each lane at the end of the step, at the exact time end[l]. */
static PK_INLINE void PK_STEPPER(block_slope_end)(struct pk_block *b, const pk_real *q,
                                                  const pk_real *v, pk_real *a)
{
    for (size_t l = 0; l < PK_BLOCK_LANES(b); l++)
        b->t[l] = b->end[l];
    const unsigned long long failed = PK_BLOCK_MEMBERS(b, q, v, a);
    if (failed)
        pk_block_failed(b, failed, q, v);
}

static PK_INLINE void PK_STEPPER(block_stages)(struct pk_block *b, const struct pk_tableau *table)
{
    const size_t n_q = PK_BLOCK_COORDINATES(b), n = PK_BLOCK_N(b), W = PK_BLOCK_LANES(b), m = n * W;
    const pk_real *q0 = b->state, *v0 = q0 + n_q * W;
    pk_real *k = b->work, *q = k + ((size_t)table->stages + 1) * 2 * m;

    if (!b->have_a) {
        for (size_t i = 0; i < n_q * W; i++)
            k[i] = v0[i];
        PK_STEPPER(block_slope)(b, 0, q0, v0, k + m);
    }
/* Makes stage i. The rates of a stage are the slopes of its coordinates, so they are computed
 * directly in the memory of the slopes. */
#define PK_BLOCK_STAGE(i)                                          \
    if ((i) < table->stages) {                                     \
        const pk_real *ai = table->a + (i) * ((i) - 1) / 2;        \
        pk_real *ki = k + (size_t)(i) * 2 * m;                     \
        pk_block_combine(n_q, W, q, q0, b->h, ai, i, k, 2 * m);    \
        pk_block_combine(n, W, ki, v0, b->h, ai, i, k + m, 2 * m); \
        PK_STEPPER(block_slope)(b, table->c[i], q, ki, ki + m);    \
    }
    PK_EACH_STAGE(PK_BLOCK_STAGE)
#undef PK_BLOCK_STAGE
}

static PK_INLINE unsigned long long PK_STEPPER(block_erk)(struct pk_block *b,
                                                          const struct pk_tableau *table)
{
    const size_t n_q = PK_BLOCK_COORDINATES(b), n = PK_BLOCK_N(b), W = PK_BLOCK_LANES(b);
    const size_t v = n_q * W, low_q = pk_state_offset(n_q, n, PK_LOW_Q) * W, low_v = low_q + v,
                 m = n * W;
    PK_STEPPER(block_stages)(b, table);
    pk_block_sum(n_q, W, b->next, b->state, b->next + low_q, b->state + low_q, b->h, table->b,
                 table->stages, b->work, 2 * m);
    pk_block_sum(n, W, b->next + v, b->state + v, b->next + low_v, b->state + low_v, b->h, table->b,
                 table->stages, b->work + m, 2 * m);
    return b->failed | pk_block_not_finite(b->next, n_q + n, W);
}

/* Makes a trial step of an adaptive method, and computes the derivative at its end. */
static PK_INLINE unsigned long long PK_STEPPER(block_attempt)(struct pk_block *b,
                                                              const struct pk_tableau *table)
{
    const size_t n_q = PK_BLOCK_COORDINATES(b), n = PK_BLOCK_N(b), W = PK_BLOCK_LANES(b), m = n * W;
    pk_real *last = b->work + (size_t)table->stages * 2 * m, *v = b->next + n_q * W;
    PK_STEPPER(block_stages)(b, table);
    pk_block_combine(n_q, W, b->next, b->state, b->h, table->b, table->stages, b->work, 2 * m);
    pk_block_combine(n, W, v, b->state + n_q * W, b->h, table->b, table->stages, b->work + m,
                     2 * m);
    for (size_t i = 0; i < n_q * W; i++)
        last[i] = v[i];
    PK_STEPPER(block_slope_end)(b, b->next, v, last + m);
    return b->failed | pk_block_not_finite(b->next, n_q + n, W) |
           pk_block_not_finite(last + m, n, W);
}

static PK_INLINE unsigned long long PK_STEPPER(block_splitting)(struct pk_block *b,
                                                                const struct pk_splitting *table)
{
    const size_t n_q = PK_BLOCK_COORDINATES(b), n = PK_BLOCK_N(b), W = PK_BLOCK_LANES(b);
    const size_t v = n_q * W, of_a = pk_state_offset(n_q, n, PK_A) * W;
    const pk_real *from = b->state, *a = from + of_a;
    pk_real *to = b->next, *a1 = to + of_a;
    const int s = table->stages, ends = table->kick[s] > 0 || table->kick[s] < 0;
    pk_real done = 0;

    for (int i = 0; i < s; i++) {
        if (i > 0 || !b->have_a) {
            PK_STEPPER(block_slope)(b, done, from, from + v, a1);
            a = a1;
        }
        pk_block_kick_drift(n_q, n, W, b->h, table->kick[i], a, table->drift[i], from, to);
        done += table->drift[i];
        from = to;
    }
    if (ends) {
        PK_STEPPER(block_slope_end)(b, to, to + v, a1);
        pk_block_kick(n_q, n, W, b->h, table->kick[s], a1, to);
    }
    b->have_a = ends;
    return b->failed | pk_block_not_finite(to, n_q + n, W);
}

/* A step of many members of an ensemble at once: the fixed explicit Runge-Kutta and splitting
 * steps of pk/step/erk.h and pk/step/splitting.h on a structure of arrays, W members side by
 * side. Every sum is made in the order of the scalar step, so with -ffp-contract=off a member
 * comes out as it does alone. Written over
 *
 *     PK_STEPPER(x)                   x with a name of its own in this file
 *     PK_BLOCK_N(b), PK_BLOCK_LANES(b)    degrees of freedom, W
 *     PK_BLOCK_MEMBERS(b, q, v, a)    accelerations at b->t; the bits of lanes that failed
 */
#ifndef PK_STEP_ENSEMBLE_H
#define PK_STEP_ENSEMBLE_H

#include <pk/step/tables.h>

#define PK_BLOCK_MOST 64

/* n W numbers a part, in the order of enum pk_part as in an integrator. */
struct pk_block {
    const struct pk_system *system;
    size_t n, lanes;
    const void *params[PK_BLOCK_MOST]; /* of each lane */
    pk_real *P, *u;                    /* number k of the params of lane l: P[k * W + l] */
    pk_real *t;                        /* W times */
    pk_real *state, *next, *spare, *work;
    pk_real *lane;       /* one state, of a system without lane kernels */
    pk_real now, end, h; /* of the step */
    int have_a;
    unsigned long long failed, not_finite; /* lanes, since the step began */
};

PK_BEGIN
/* Notes lanes whose acceleration failed, and whether it was for want of a finite state. */
void pk_block_failed(struct pk_block *b, unsigned long long failed, const pk_real *q,
                     const pk_real *v);
PK_END

/* The bits of lanes where any of `rows` rows is not finite. */
static PK_INLINE unsigned long long pk_block_not_finite(const pk_real *x, size_t rows, size_t W)
{
    pk_real sum[PK_BLOCK_MOST];
    unsigned long long bits = 0;
    int any = 0;
    for (size_t l = 0; l < W; l++)
        sum[l] = 0;
    for (size_t i = 0; i < rows; i++)
        for (size_t l = 0; l < W; l++)
            sum[l] += x[i * W + l] - x[i * W + l];
    for (size_t l = 0; l < W; l++)
        any |= !(sum[l] == PK_C(0.0));
    for (size_t l = 0; any && l < W; l++)
        if (!(sum[l] == PK_C(0.0)))
            bits |= 1ull << l;
    return bits;
}

/* y = y0 + h sum a_j k_j, m numbers, rows of k `stride` apart. */
static PK_INLINE void pk_block_combine(pk_real *PK_RESTRICT y, const pk_real *PK_RESTRICT y0,
                                       pk_real h, const pk_real *a, int count,
                                       const pk_real *PK_RESTRICT k, size_t stride, size_t m)
{
    PK_LANE_LOOP
    for (size_t i = 0; i < m; i++)
        y[i] = y0[i] + h * pk_row_sum(a, count, k, stride, i);
}

/* The same with a compensated sum. */
static PK_INLINE void pk_block_sum(pk_real *PK_RESTRICT y, const pk_real *PK_RESTRICT y0,
                                   pk_real *PK_RESTRICT low, const pk_real *PK_RESTRICT low0,
                                   pk_real h, const pk_real *b, int count,
                                   const pk_real *PK_RESTRICT k, size_t m)
{
    PK_LANE_LOOP
    for (size_t i = 0; i < m; i++) {
        pk_real part = low0[i];
        y[i] = pk_sum(y0[i], h * pk_row_sum(b, count, k, m, i), &part);
        low[i] = part;
    }
}

/* Numbers of work for a table of s stages. */
static inline size_t pk_block_reals(int stages, size_t n, size_t W)
{
    return ((size_t)stages * 2 + 1) * n * W;
}
#endif

static PK_INLINE void PK_STEPPER(block_slope)(struct pk_block *b, pk_real t, const pk_real *q,
                                              const pk_real *v, pk_real *a)
{
    for (size_t l = 0; l < PK_BLOCK_LANES(b); l++)
        b->t[l] = t;
    const unsigned long long failed = PK_BLOCK_MEMBERS(b, q, v, a);
    if (failed)
        pk_block_failed(b, failed, q, v);
}

static PK_INLINE unsigned long long PK_STEPPER(block_erk)(struct pk_block *b,
                                                          const struct pk_tableau *table)
{
    const size_t n = PK_BLOCK_N(b), W = PK_BLOCK_LANES(b), m = n * W;
    const pk_real *q0 = b->state, *v0 = q0 + m;
    pk_real *k = b->work, *q = k + (size_t)table->stages * 2 * m;

    for (size_t i = 0; i < m; i++)
        k[i] = v0[i];
    PK_STEPPER(block_slope)(b, b->now, q0, v0, k + m);
/* The argument's rates are the slope of its coordinates: they are made where that is kept. */
#define PK_BLOCK_STAGE(i)                                                       \
    if ((i) < table->stages) {                                                  \
        const pk_real *ai = table->a + (i) * ((i) - 1) / 2;                     \
        pk_real *ki = k + (size_t)(i) * 2 * m;                                  \
        pk_block_combine(q, q0, b->h, ai, i, k, 2 * m, m);                      \
        pk_block_combine(ki, v0, b->h, ai, i, k + m, 2 * m, m);                 \
        PK_STEPPER(block_slope)(b, b->now + table->c[i] * b->h, q, ki, ki + m); \
    }
    PK_EACH_STAGE(PK_BLOCK_STAGE)
#undef PK_BLOCK_STAGE
    pk_block_sum(b->next, q0, b->next + PK_LOW_Q * m, q0 + PK_LOW_Q * m, b->h, table->b,
                 table->stages, k, 2 * m);
    return b->failed | pk_block_not_finite(b->next, 2 * n, W);
}

static PK_INLINE unsigned long long PK_STEPPER(block_splitting)(struct pk_block *b,
                                                                const struct pk_splitting *table)
{
    const size_t n = PK_BLOCK_N(b), W = PK_BLOCK_LANES(b), m = n * W;
    const pk_real *from = b->state, *a = from + PK_A * m;
    pk_real *to = b->next, *a1 = to + PK_A * m;
    const int s = table->stages, ends = table->kick[s] > 0 || table->kick[s] < 0;
    pk_real done = 0;

    for (int i = 0; i < s; i++) {
        if (i > 0 || !b->have_a) {
            PK_STEPPER(block_slope)(b, b->now + done * b->h, from, from + m, a1);
            a = a1;
        }
        pk_kick_drift(m, table->kick[i] * b->h, a, table->drift[i] * b->h, from, to);
        done += table->drift[i];
        from = to;
    }
    if (ends) {
        PK_STEPPER(block_slope)(b, b->end, to, to + m, a1);
        pk_kick(m, table->kick[s] * b->h, a1, to);
    }
    b->have_a = ends;
    return b->failed | pk_block_not_finite(to, 2 * n, W);
}

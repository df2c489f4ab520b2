/* A block: W states in SIMD lanes, as a structure of arrays, and the sums that their steps need;
 * the steps are in pk/step/ensemble.h. */
#ifndef PK_STEP_BLOCK_H
#define PK_STEP_BLOCK_H

#include <pk/step/state.h>
#include <pk/step/tableau.h>

#define PK_BLOCK_MOST 64

/* A block of W states. `state` and `next` have W times as many numbers as the same arrays of an
 * integrator. */
struct pk_block {
    const struct pk_system *system;
    size_t n_q, n, lanes;
    const void *params[PK_BLOCK_MOST]; /* params of each lane */
    /* P: params of all lanes; number k of the params of lane l is P[k * W + l]. u: inputs */
    pk_real *P, *u;
    pk_real *t; /* the time of each lane */
    pk_real *state, *next, *spare, *work;
    pk_real *lane; /* memory for one state, if the system has no kernel for lanes */
    pk_real now;   /* time of all lanes in block.c, where they have the same time */
    /* start time, end time and size of the step of each lane */
    pk_real from[PK_BLOCK_MOST], end[PK_BLOCK_MOST], h[PK_BLOCK_MOST];
    int have_a; /* 1: the first acceleration or stage of the step is known */
    int order;  /* of Taylor coefficients, which `work` then has */
    unsigned long long failed, not_finite; /* bit masks of lanes in the current step */
};

PK_BEGIN
/* Adds the bits `failed` to b->failed, and sets the bits of b->not_finite for those lanes whose
 * states are not finite. */
void pk_block_failed(struct pk_block *b, unsigned long long failed, const pk_real *q,
                     const pk_real *v);
PK_END

/* Returns a bit mask of the lanes in which a number is not finite; each lane has `rows` numbers. */
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
        any |= !(sum[l] == 0);
    for (size_t l = 0; any && l < W; l++)
        if (!(sum[l] == 0))
            bits |= 1ull << l;
    return bits;
}

/* Computes y = y0 + h sum a_j k_j in each lane with its own h. k_j are `stride` apart. */
static PK_INLINE void pk_block_combine(size_t rows, size_t W, pk_real *PK_RESTRICT y,
                                       const pk_real *PK_RESTRICT y0, const pk_real *PK_RESTRICT h,
                                       const pk_real *a, int count, const pk_real *PK_RESTRICT k,
                                       size_t stride)
{
    for (size_t i = 0; i < rows; i++) {
        PK_LANE_LOOP
        for (size_t l = 0; l < W; l++)
            y[i * W + l] = y0[i * W + l] + h[l] * pk_row_sum(a, count, k, stride, i * W + l);
    }
}

/* Does the same as pk_block_combine() with compensated sums. */
static PK_INLINE void pk_block_sum(size_t rows, size_t W, pk_real *PK_RESTRICT y,
                                   const pk_real *PK_RESTRICT y0, pk_real *PK_RESTRICT low,
                                   const pk_real *PK_RESTRICT low0, const pk_real *PK_RESTRICT h,
                                   const pk_real *b, int count, const pk_real *PK_RESTRICT k,
                                   size_t stride)
{
    for (size_t i = 0; i < rows; i++) {
        PK_LANE_LOOP
        for (size_t l = 0; l < W; l++) {
            const size_t at = i * W + l;
            pk_real part = low0[at];
            y[at] = pk_sum(y0[at], h[l] * pk_row_sum(b, count, k, stride, at), &part);
            low[at] = part;
        }
    }
}

/* Like pk_kick_drift() with the step size of each lane. */
static PK_INLINE void pk_block_kick_drift(size_t n_q, size_t n, size_t W,
                                          const pk_real *PK_RESTRICT h, pk_real kick,
                                          const pk_real *a, pk_real drift, const pk_real *from,
                                          pk_real *to)
{
    const size_t of_v = pk_state_offset(n_q, n, PK_V) * W,
                 of_low_q = pk_state_offset(n_q, n, PK_LOW_Q) * W;
    const size_t of_low_v = pk_state_offset(n_q, n, PK_LOW_X) * W;
    for (size_t i = 0; i < n_q * W; i += W) {
        PK_LANE_LOOP
        for (size_t l = 0; l < W; l++) {
            const size_t k = i + l;
            pk_real low_v = from[of_low_v + k], low_q = from[of_low_q + k];
            const pk_real v = pk_sum(from[of_v + k], kick * h[l] * a[k], &low_v);
            to[k] = pk_sum(from[k], drift * h[l] * v, &low_q);
            to[of_v + k] = v;
            to[of_low_v + k] = low_v;
            to[of_low_q + k] = low_q;
        }
    }
    for (size_t i = n_q * W; i < n * W; i += W) {
        PK_LANE_LOOP
        for (size_t l = 0; l < W; l++) {
            pk_real low = from[of_low_v + i + l];
            to[of_v + i + l] = pk_sum(from[of_v + i + l], kick * h[l] * a[i + l], &low);
            to[of_low_v + i + l] = low;
        }
    }
}

static PK_INLINE void pk_block_kick(size_t n_q, size_t n, size_t W, const pk_real *PK_RESTRICT h,
                                    pk_real kick, const pk_real *a, pk_real *to)
{
    pk_real *v = to + pk_state_offset(n_q, n, PK_V) * W,
            *low = to + pk_state_offset(n_q, n, PK_LOW_X) * W;
    for (size_t i = 0; i < n * W; i += W) {
        PK_LANE_LOOP
        for (size_t l = 0; l < W; l++)
            v[i + l] = pk_sum(v[i + l], kick * h[l] * a[i + l], &low[i + l]);
    }
}

/* Returns the number of pk_real of work memory for s stages, the derivative at the end, and the
 * coordinates of a stage. For each of these, memory has 2 n W numbers: the n W rates and
 * first-order variables of the stage, the first n_q W slopes of coordinates, then n W
 * accelerations. */
static inline size_t pk_block_reals(int stages, size_t n_q, size_t n, size_t W)
{
    return (((size_t)stages + 1) * 2 * n + n_q) * W;
}
static inline pk_real *pk_block_slopes(const struct pk_block *b, int stage)
{
    return b->work + (size_t)stage * 2 * b->n * b->lanes;
}

#endif

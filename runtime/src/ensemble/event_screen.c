/* Finds steps in lanes that certainly cross no event and no switch; see event_screen.h. It uses the
 * first test of events_look.c: the polynomial through samples of the quintic interpolant. */

#include "../events/events.h"
#include "event_screen.h"

enum { N = 8, STRIDE = PK_MOST_SAMPLES / N, TAIL = 4, LANES = PK_LANES };
#define SAFE PK_C(1.001) /* margin, since sums are rounded in another order than in events_look.c */

/* Computes the differences of h^2 q'' between the motion and its cubic Hermite interpolant at both
 * ends of the step. Sets `bad` to nonzero in lanes where a difference is so large that the
 * interpolant is useless. Inner loops are over vectors of lanes. */
static void coordinates_bend(const struct pk_screen *s, const struct pk_block *b, pk_bits *bad)
{
    const size_t m = b->n_q * b->lanes;
    for (size_t k = 0; k < m; k += LANES) {
        const pk_real *q0 = b->state + k, *v0 = q0 + m, *q1 = b->next + k, *v1 = q1 + m;
        const pk_real *a0 = s->a0 + k, *a1 = s->a1 + k, *length = b->h + k % b->lanes;
        pk_real *PK_RESTRICT bend0 = s->bends + k, *PK_RESTRICT bend1 = s->bends + m + k;
        pk_bits *PK_RESTRICT worthless = bad + k % b->lanes;
        PK_LANE_LOOP
        for (size_t l = 0; l < LANES; l++) {
            const pk_real h = length[l], rise = q1[l] - q0[l], w0 = h * v0[l], w1 = h * v1[l];
            const pk_real size = pk_max(pk_abs(rise), pk_max(pk_abs(w0), pk_abs(w1)) / 4);
            const pk_real at0 = h * h * a0[l] - (6 * rise - 4 * w0 - 2 * w1);
            const pk_real at1 = h * h * a1[l] - (2 * w0 + 4 * w1 - 6 * rise);
            const pk_real most = SAFE * pk_max(pk_abs(at0), pk_abs(at1));
            bend0[l] = at0;
            bend1[l] = at1;
            worthless[l] |= most <= size ? 0 : ~(pk_bits)0;
        }
    }
}

/* Evaluates the quintic interpolant (for first-order variables a quartic) and its derivative at x,
 * a fraction 0 .. 1 of the step. */
static void between(const struct pk_screen *s, const struct pk_block *b, pk_real x)
{
    const size_t m = b->n_q * b->lanes, all = b->n * b->lanes;
    const pk_real y = 1 - x, h01 = x * x * (3 - 2 * x), h10 = x * y * y, h11 = -x * x * y;
    const pk_real slope = 6 * x * y, d10 = y * (1 - 3 * x), d11 = x * (3 * x - 2);
    const pk_real both = x * x * y * y / 2, turn = x * y * (y - x);
    for (size_t k = 0; k < m; k += LANES) {
        const pk_real *q0 = b->state + k, *v0 = q0 + m, *q1 = b->next + k, *v1 = q1 + m;
        const pk_real *bend0 = s->bends + k, *bend1 = bend0 + m, *length = b->h + k % b->lanes;
        pk_real *PK_RESTRICT q = s->trial + k, *PK_RESTRICT v = s->trial + m + k;
        PK_LANE_LOOP
        for (size_t l = 0; l < LANES; l++) {
            const pk_real h = length[l], rise = q1[l] - q0[l], bent = bend0[l] * y + bend1[l] * x;
            const pk_real risen = slope * rise + turn * bent + both * (bend1[l] - bend0[l]);
            q[l] = q0[l] + h01 * rise + h * (h10 * v0[l] + h11 * v1[l]) + both * bent;
            v[l] = risen / h + d10 * v0[l] + d11 * v1[l];
        }
    }
    for (size_t k = m; k < all; k += LANES) {
        const pk_real *v0 = b->state + m + k, *v1 = b->next + m + k, *a0 = s->a0 + k;
        const pk_real *a1 = s->a1 + k, *bend = s->bends + m + k, *length = b->h + k % b->lanes;
        pk_real *PK_RESTRICT v = s->trial + m + k;
        PK_LANE_LOOP
        for (size_t l = 0; l < LANES; l++)
            v[l] = v0[l] + h01 * (v1[l] - v0[l]) + length[l] * (h10 * a0[l] + h11 * a1[l]) +
                   2 * both * bend[l];
    }
}

/* Computes the quartic terms of first-order variables by rates at a quarter; see events_look.c. */
static void states_bend(const struct pk_screen *s, struct pk_block *b, pk_bits *bad)
{
    const size_t W = b->lanes, first = b->n_q * W, end = (b->n_q + b->n) * W;
    const pk_real x = PK_C(0.25), y = 1 - x, d01 = 6 * x * y, d10 = y * (1 - 3 * x);
    const pk_real d11 = x * (3 * x - 2), d22 = 2 * x * y * (y - x);
    if (b->n == b->n_q)
        return;
    pk_zero(s->bends + 2 * first, end - 2 * first);
    between(s, b, x);
    for (size_t l = 0; l < W; l++)
        b->t[l] = b->from[l] + x * b->h[l];
    const unsigned long long failed = s->members(b, s->trial, s->trial + first, s->a_between);
    for (size_t l = 0; l < W; l++)
        bad[l] |= failed >> l & 1 ? ~(pk_bits)0 : 0;
    for (size_t k = first; k < end - first; k += LANES) { /* only first-order variables, in v */
        const pk_real *v0 = b->state + first + k, *v1 = b->next + first + k;
        const pk_real *a0 = s->a0 + k, *a1 = s->a1 + k, *a = s->a_between + k;
        const pk_real *length = b->h + k % W;
        pk_real *PK_RESTRICT bend = s->bends + first + k;
        pk_bits *PK_RESTRICT worthless = bad + k % W;
        PK_LANE_LOOP
        for (size_t l = 0; l < LANES; l++) {
            const pk_real h = length[l], rise = v1[l] - v0[l], w0 = h * a0[l], w1 = h * a1[l];
            const pk_real size = pk_max(pk_abs(rise), pk_max(pk_abs(w0), pk_abs(w1)) / 4);
            bend[l] = (h * a[l] - (d01 * rise + d10 * w0 + d11 * w1)) / d22;
            worthless[l] |= SAFE * pk_abs(bend[l]) <= size / 2 ? 0 : ~(pk_bits)0;
        }
    }
}

static void bend(const struct pk_screen *s, struct pk_block *b, pk_bits *bad)
{
    coordinates_bend(s, b, bad);
    states_bend(s, b, bad);
}

/* Sets `bad` if the function with these samples, `stride` apart, may be zero: if |c_0| of the
 * polynomial sum c_i cos(i angle) does not exceed the other terms. Even and odd terms are apart. */
static void judge(const pk_real *g, size_t stride, pk_real far, pk_bits *PK_RESTRICT bad)
{
    enum { HALF = N / 2 };
    pk_real even[HALF + 1][LANES], odd[HALF + 1][LANES], sum[LANES] = {0}, last[LANES];
    for (int j = 0; j <= HALF; j++) {
        const pk_real *left = g + (size_t)j * stride, *right = g + (size_t)(N - j) * stride;
        const pk_real half = j == 0 || j == HALF ? PK_C(0.5) : 1;
        PK_LANE_LOOP
        for (size_t l = 0; l < LANES; l++) {
            even[j][l] = half * (left[l] + right[l]);
            odd[j][l] = half * (left[l] - right[l]);
        }
    }
    for (int i = N; i >= 0; i--) {
        const pk_real(*x)[LANES] = (const pk_real(*)[LANES])(i % 2 ? odd : even);
        const pk_real weight = i == N || i == 0 ? (i ? 1 : PK_C(0.5)) : i > N - TAIL ? 2 : 1;
        pk_real by[HALF + 1];
        for (int j = 0; j <= HALF; j++) {
            const int at = i * j * STRIDE % (2 * PK_MOST_SAMPLES);
            by[j] = pk_events_cosines[at <= PK_MOST_SAMPLES ? at : 2 * PK_MOST_SAMPLES - at];
        }
        PK_LANE_LOOP
        for (size_t l = 0; l < LANES; l++) {
            last[l] = weight * pk_abs(by[0] * x[0][l] + by[1] * x[1][l] + by[2] * x[2][l] +
                                      by[3] * x[3][l] + by[4] * x[4][l]);
            sum[l] += i ? last[l] : 0;
        }
    }
    PK_LANE_LOOP
    for (size_t l = 0; l < LANES; l++)
        bad[l] |= last[l] > far * SAFE * sum[l] ? 0 : ~(pk_bits)0;
}

size_t pk_screen_size(const struct pk_block *b)
{
    const size_t m = b->system->events.n + b->system->switches.n, n_q = b->n_q, n = b->n;
    const size_t W = b->lanes;
    return m ? (2 * n_q + 5 * n + (N + 1) * m) * W + n_q + n + m : 0;
}

void pk_screen_init(struct pk_screen *s, const struct pk_block *b,
                    const struct pk_block_stepper *stepper, pk_real *base)
{
    const struct pk_system *system = b->system;
    const size_t n_q = b->n_q, n = b->n, W = b->lanes;
    s->functions = system->events.n + system->switches.n;
    s->members = stepper->members;
    s->values = stepper->values;
    for (size_t k = 0; k < system->events.n; k++)
        /* pk_events_functions() shifts limits by rounding, s->values does not */
        if (system->events.table[k].stop > 1)
            s->values = NULL;
    if (PK_SYSTEM_HAS(system, counted) && system->counted)
        s->values = NULL;
    const struct pk_slot slots[] = {{&s->a0, n * W},
                                    {&s->a1, n * W},
                                    {&s->a_between, n * W},
                                    {&s->bends, (n_q + n) * W},
                                    {&s->trial, (n_q + n) * W},
                                    {&s->g, (N + 1) * s->functions * W},
                                    {&s->one, n_q + n + s->functions}};
    if (s->functions)
        PK_LAY_OUT(base, slots);
}

/* Evaluates all functions of a lane at a sample. */
static void sample(const struct pk_screen *s, const struct pk_block *b, const struct pk_lane *lane,
                   size_t l, int j, const pk_real *state)
{
    const size_t n_q = b->n_q, W = b->lanes;
    pk_real *q = s->one, *g = q + n_q + b->n;
    for (size_t i = 0; i < n_q + b->n; i++)
        q[i] = state[i * W + l];
    pk_events_functions(lane->events, lane->it, b->t[l], q, q + n_q, g);
    for (size_t k = 0; k < s->functions; k++)
        s->g[((size_t)j * s->functions + k) * W + l] = g[k];
}

unsigned long long pk_screen(struct pk_screen *s, struct pk_block *b, const struct pk_lane *lanes,
                             unsigned long long of, unsigned long long known, pk_real far)
{
    const size_t W = b->lanes;
    pk_bits bad[PK_BLOCK_MOST] = {0};
    unsigned long long clear = 0;
    bend(s, b, bad);
    for (int j = 0; j <= N; j++) {
        const pk_real x = (1 - pk_events_cosines[j * STRIDE]) / 2;
        if (j > 0 && j < N)
            between(s, b, x);
        /* values at the start are those at the end of the last step */
        if (j == 0 && !(of & ~known))
            continue;
        const pk_real *state = j == 0 ? b->state : j < N ? s->trial : b->next;
        for (size_t l = 0; l < W; l++)
            b->t[l] = j < N ? b->from[l] + x * b->h[l] : b->end[l];
        if (s->values)
            s->values(b, state, state + b->n_q * W, s->g + (size_t)j * s->functions * W);
        for (size_t l = 0; l < W && !s->values; l++)
            if (of >> l & 1 && !bad[l])
                sample(s, b, &lanes[l], l, j, state);
    }
    for (size_t k = 0; k < s->functions * W; k += PK_LANES)
        judge(s->g + k, s->functions * W, far, bad + k % W);
    for (size_t l = 0; l < W; l++)
        if (of >> l & 1 && !bad[l])
            clear |= 1ull << l;
    /* The last sample of these steps is the first sample of the next steps. */
    pk_copy(s->g, s->g + (size_t)N * s->functions * W, s->functions * W);
    return clear;
}

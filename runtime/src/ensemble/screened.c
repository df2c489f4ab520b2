/* Finds steps in lanes that certainly cross nothing; see screen.h. */
#include <string.h>

#include "../events/events.h"
#include "screen.h"

enum { N = PK_SCREENED, STRIDE = PK_MOST_SAMPLES / N };

size_t pk_screen_size(const struct pk_system *system, size_t n_q, size_t n, size_t W)
{
    const size_t m = system->events.n + system->switches.n;
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
        if (system->events.table[k].stop > 1) /* pk_events_functions() shifts limits by rounding */
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
    pk_screen_bend(s, b, bad);
    for (int j = 0; j <= N; j++) {
        const pk_real x = (1 - pk_events_cosines[j * STRIDE]) / 2;
        if (j > 0 && j < N)
            pk_screen_between(s, b, x);
        if (j == 0 && !(of & ~known)) /* kept from the end of the last step */
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
        pk_screen_judge(s->g + k, s->functions * W, far, bad + k % W);
    for (size_t l = 0; l < W; l++)
        if (of >> l & 1 && !bad[l])
            clear |= 1ull << l;
    /* The last sample is the first one of the next steps. */
    memcpy(s->g, s->g + (size_t)N * s->functions * W, s->functions * W * sizeof *s->g);
    return clear;
}

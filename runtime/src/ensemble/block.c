/* Integrates a block of members that make the same fixed steps, from one row to the next. */
#include <string.h>

#include "../core/attitude.h"
#include "ensemble.h"

/* Ends the members in lanes `bits` with `status`. These lanes then repeat another lane. */
static void retire(struct pk_block *b, const struct pk_ensemble *e, size_t first,
                   unsigned long long bits, enum pk_status status, unsigned long long *live)
{
    *live &= ~bits;
    for (size_t l = 0; l < b->lanes; l++)
        if (bits >> l & 1) {
            e->status[first + l] = status;
            e->last_t[first + l] = b->now;
            if (*live)
                pk_block_copy_lane(b, pk_lowest(*live), l);
        }
}

static void store_row(const struct pk_block *b, const struct pk_ensemble *e, size_t first,
                      size_t row, unsigned long long live, const pk_real *state)
{
    const size_t n_q = b->n_q, n = b->n, W = b->lanes;
    for (size_t l = 0; l < W; l++) {
        if (!(live >> l & 1))
            continue;
        const size_t at = (first + l) * e->rows + row;
        for (size_t i = 0; i < n_q; i++)
            e->q[at * n + i] = state[i * W + l];
        for (size_t i = 0; i < n; i++)
            e->v[at * n + i] = state[(n_q + i) * W + l];
        e->done[first + l] = row + 1;
        e->last_t[first + l] = b->now;
    }
}

/* Ends the members in lanes `bits` with `status`, or with the singularity that caused it. */
static void fail(struct pk_block *b, const struct pk_ensemble *e, struct pk_integrator *clock,
                 size_t first, char *memory, unsigned long long bits, enum pk_status status,
                 unsigned long long *live)
{
    *live &= ~bits;
    for (size_t l = 0; l < b->lanes; l++) {
        enum pk_status reason = status;
        if (!(bits >> l & 1))
            continue;
        if (e->system->singularities.n)
            reason =
                pk_member_step(pk_member_at(e, memory, l), clock, b->next + l, b->lanes, status);
        retire(b, e, first, 1ull << l, reason, live);
    }
}

/* Normalises quaternions as project.c does for one state. Returns the lanes where that fails. */
static unsigned long long normalise(struct pk_block *b)
{
    unsigned long long lost = 0;
    const size_t n_q = b->n_q, n = b->n, W = b->lanes, first = n_q + 3 * b->system->n_rotations;
    for (size_t r = 0; r < b->system->n_rotations; r++)
        for (size_t l = 0; l < W; l++) {
            const size_t at = (first + 4 * r) * W + l;
            pk_real *Q = b->next + n_q * W + at;
            pk_real *low = b->next + pk_state_offset(n_q, n, PK_LOW_X) * W + at;
            lost |= (unsigned long long)(pk_normalise(Q, low, W) < 0) << l;
        }
    return lost;
}

/* Sets the same step for all lanes. */
static void together(struct pk_block *b, pk_real from, pk_real end, pk_real h)
{
    for (size_t l = 0; l < b->lanes; l++)
        b->from[l] = from, b->end[l] = end, b->h[l] = h;
}

/* Repeats the last step, but only as far as time t, and stores the state there in b->spare, like
 * pk_integrator_aside(). Returns the lanes that failed. */
static unsigned long long aside(const struct pk_block *of, const struct pk_block_stepper *s,
                                const struct pk_integrator *clock, pk_real t)
{
    struct pk_block b = *of;
    b.state = of->next; /* state at the start of the step */
    b.next = of->spare;
    b.have_a = 0;
    together(&b, clock->last_t, t, t - clock->last_t);
    return s->step(&b) | normalise(&b);
}

/* Advances all live lanes to t, or to the end of the fixed step that contains t. */
static unsigned long long advance(struct pk_block *b, const struct pk_block_stepper *s,
                                  const struct pk_ensemble *e, struct pk_integrator *clock,
                                  size_t first, char *memory, pk_real t, unsigned long long live)
{
    const pk_real last = e->t[e->rows - 1], way = last < e->t0 ? -1 : 1;
    while (live && way * (t - clock->t) > 0 && !pk_integrator_is_at(clock, t)) {
        const enum pk_status status =
            pk_ensemble_stopped(e) ? PK_STOPPED_USER
                                   : pk_step_choose(clock, pk_integrator_limit(clock, t, last), 1);
        b->now = clock->t;
        if (status != PK_DONE) {
            retire(b, e, first, live, status, &live);
            break;
        }
        together(b, clock->t, clock->own->next_t, clock->own->h);
        b->failed = b->not_finite = 0;
        const unsigned long long bad = s->step(b) & live;
        if (bad) { /* at finite numbers, a kernel only fails if M is singular */
            const unsigned long long mass = bad & b->failed & ~b->not_finite;
            live &= ~bad;
            fail(b, e, clock, first, memory, mass, PK_SINGULAR_MASS, &live);
            fail(b, e, clock, first, memory, bad & ~mass, PK_NOT_FINITE, &live);
        }
        fail(b, e, clock, first, memory, normalise(b) & live, PK_NOT_FINITE, &live);
        for (size_t l = 0; e->system->singularities.n && l < b->lanes; l++) {
            if (!(live >> l & 1))
                continue;
            const enum pk_status seen =
                pk_member_step(pk_member_at(e, memory, l), clock, b->next + l, b->lanes, PK_DONE);
            if (seen < 0)
                retire(b, e, first, 1ull << l, seen, &live);
        }
        pk_real *left_behind = b->state;
        b->state = b->next;
        b->next = left_behind;
        pk_step_advance_time(clock, 1);
        b->now = clock->t;
    }
    return live;
}

size_t pk_block_size(const struct pk_ensemble *e)
{
    struct pk_block b;
    const struct pk_problem problem = pk_ensemble_problem(e, 0);
    return pk_ensemble_padded(pk_block_lay_out(&b, &problem, e->method, 1, NULL) * sizeof(pk_real));
}

void pk_block_run(const struct pk_ensemble *e, const struct pk_block_stepper *s, size_t first,
                  size_t count, char *memory)
{
    struct pk_block b = {.now = e->t0};
    struct pk_integrator clock = {0};
    const struct pk_problem problem = pk_ensemble_problem(e, 0);
    char *own = memory + pk_member_count(e, s->lanes) * pk_member_size(e);
    unsigned long long live = 0;
    memset(own, 0, pk_block_size(e));
    pk_block_lay_out(&b, &problem, e->method, 1, (pk_real *)(void *)own);
    for (size_t l = 0; l < count; l++) {
        struct pk_member *member = pk_member_at(e, memory, e->system->singularities.n ? l : 0);
        const enum pk_status status = pk_member_begin(e, first + l, member);
        e->status[first + l] = status;
        if (status < 0)
            continue;
        pk_block_load(&b, &member->it, member->it.problem.params, l);
        live |= 1ull << l;
        clock = member->it;
    }
    for (size_t l = 0; live && l < b.lanes; l++)
        if (!(live >> l & 1))
            pk_block_copy_lane(&b, pk_lowest(live), l);
    for (size_t row = 0; live && row < e->rows; row++) {
        live = advance(&b, s, e, &clock, first, memory, e->t[row], live);
        if (pk_integrator_is_at(&clock, e->t[row])) {
            store_row(&b, e, first, row, live, b.state);
            continue;
        }
        const unsigned long long bad = live ? aside(&b, s, &clock, e->t[row]) & live : 0;
        if (bad)
            retire(&b, e, first, bad, PK_NOT_FINITE, &live);
        store_row(&b, e, first, row, live, b.spare);
    }
}

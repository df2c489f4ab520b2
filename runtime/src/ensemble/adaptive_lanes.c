/* Makes steps of several integrators in advance, in SIMD lanes; see pk/adaptive_lanes.h. A lane
 * keeps its integrator's state as long as it uses the steps made for it; otherwise the state is
 * loaded again. */
#include <string.h>

#include "../core/generic.h"
#include "../core/tableau.h"

#include <pk/adaptive_lanes.h>
#include <pk/events.h>
#include <pk/step/embedded.h>
#include <pk/step/taylor.h>

#include "../events/events.h"
#include "event_screen.h"
#include "lanes.h"

enum {
    FEW = 8,  /* lanes are not used if at most 1/8 of them have a step to make */
    MANY = 32 /* limit of steps made in one call */
};

size_t pk_lanes_size(const struct pk_problem *problem, const struct pk_method *method)
{
    const struct pk_system *system = problem->system;
#ifdef PK_ONE_BY_ONE /* defined to measure the speed without lanes */
    const struct pk_block_stepper *s = NULL;
#else
    const struct pk_block_stepper *s = pk_block_stepper_of(system, method);
#endif
    struct pk_block b;
    if (!s || (method->traits & PK_ADAPTIVE && !s->attempt) ||
        system->constraints.n) /* projection cannot use lanes and takes most of a step's time */
        return 0;
    const size_t block = pk_block_lay_out(&b, problem, method, 0, NULL);
    return (block + pk_screen_size(&b)) * sizeof(pk_real);
}

size_t pk_lanes_count(const struct pk_problem *problem, const struct pk_method *method)
{
    return pk_lanes_size(problem, method) ? pk_block_stepper_of(problem->system, method)->lanes : 1;
}

void pk_lanes_leave(struct pk_integrator *it)
{
    if (it->own)
        it->own->ahead = NULL;
}

void pk_lanes_init(struct pk_lanes *a, const struct pk_problem *problem,
                   const struct pk_method *method, void *block, size_t size)
{
    const struct pk_system *system = problem->system;
    const struct pk_splitting *splitting = pk_splitting_table(method);
    const int stages = splitting ? splitting->stages : pk_block_stages(method);
    memset(a, 0, sizeof *a);
    memset(block, 0, size);
    a->method = method;
    a->stepper = pk_block_stepper_of(system, method);
    a->lanes = a->stepper->lanes;
    pk_real *const base = (pk_real *)block;
    pk_screen_init(&a->screen, &a->b, a->stepper,
                   base + pk_block_lay_out(&a->b, problem, method, 0, base));
    for (size_t l = 0; l < a->lanes; l++)
        a->ahead[l].lanes = a->lanes, a->ahead[l].cost = (unsigned long)stages;
}

/* Predicts the next step towards `limit`. Returns 0 if it cannot be predicted. */
static int plan(const struct pk_lanes *a, struct pk_integrator *it, pk_real limit,
                struct pk_planned *x)
{
    const struct pk_splitting *splitting = pk_splitting_table(a->method);
    const int direction = (limit > it->t) - (limit < it->t);
    if (!pk_ready(it) || !direction || direction != it->own->direction || it->own->passing.near)
        return 0;
    if (pk_is_fixed(a->method)) {
        *x = pk_step_planned(it, limit);
        return !splitting || !pk_splitting_ends(splitting) || it->own->flags & PK_HAVE_A;
    }
    if (!(it->own->flags & PK_HAVE_STEP || pk_waits(it)) || !(pk_abs(it->own->h) > 0))
        return 0;
    limit = pk_short_force_limit(it, limit);
    struct pk_trial trial = pk_trial(it, limit);
    if (!pk_trial_next(it, limit, &trial))
        return 0;
    x->h = trial.h;
    x->end = it->own->next_t;
    return 1;
}

static void load(struct pk_lanes *a, const struct pk_lane *lane, size_t l)
{
    struct pk_block *b = &a->b;
    struct pk_integrator *it = lane->it;
    const int switched = lane->events && lane->events->params;
    pk_block_load(b, it, switched ? lane->events->params : it->problem.params, l);
    if (a->method->traits & PK_ADAPTIVE) { /* loads the slope of the first stage */
        const struct pk_tableau *table = pk_explicit_table(a->method);
        const struct pk_embedded_work w = pk_embedded_parts(it, table, b->n_q, b->n);
        const pk_real *slope = it->own->flags & PK_HAVE_STEP ? w.last : w.k;
        for (size_t i = 0; i < b->n_q; i++)
            b->work[i * b->lanes + l] = slope[i];
        for (size_t i = 0; i < b->n; i++)
            b->work[(b->n + i) * b->lanes + l] = slope[b->n_q + i];
    }
    a->loaded |= 1ull << l;
}

/* Copies `from` to `to` in the lanes of `mask`. */
static void pick(const pk_bits *mask, size_t rows, size_t W, const pk_real *PK_RESTRICT from,
                 pk_real *PK_RESTRICT to)
{
    for (size_t i = 0; i < rows; i++) {
        PK_LANE_LOOP
        for (size_t l = 0; l < W; l++)
            to[i * W + l] = mask[l] ? from[i * W + l] : to[i * W + l];
    }
}

/* Advances the state of the given lanes to the end of their steps. */
static void advance(struct pk_lanes *a, unsigned long long lanes)
{
    struct pk_block *b = &a->b;
    const size_t n_q = b->n_q, n = b->n, W = b->lanes, low = pk_state_offset(n_q, n, PK_LOW_Q);
    pk_bits mask[PK_BLOCK_MOST];
    if (!lanes)
        return;
    for (size_t l = 0; l < W; l++)
        mask[l] = lanes >> l & 1 ? ~(pk_bits)0 : 0;
    pick(mask, n_q + n, W, b->next, b->state);
    if (a->method->traits & PK_ADAPTIVE)
        pick(mask, 2 * n, W, pk_block_slopes(b, pk_block_stages(a->method)), b->work);
    else
        pick(mask, pk_state_offset(n_q, n, PK_PARTS) - low, W, b->next + low * W,
             b->state + low * W);
}

/* Prepares the next step of each lane; loads its state if needed. Returns the lanes with a step. */
static unsigned long long enter(struct pk_lanes *a, const struct pk_lane *lanes)
{
    struct pk_block *b = &a->b;
    unsigned long long live = 0;
    for (size_t l = 0; l < a->lanes; l++) {
        struct pk_integrator *it = lanes[l].it;
        struct pk_ahead *ahead = &a->ahead[l];
        struct pk_planned x = {0};
        ahead->ready = ahead->clear = 0;
        ahead->many = 0;
        if (it && it->own->ahead != ahead)
            it->own->ahead = ahead, ahead->taken = ahead->waits = 0;
        if (it && plan(a, it, lanes[l].limit, &x)) {
            live |= 1ull << l;
            if (!(ahead->taken || ahead->waits) || it->own->project)
                load(a, &lanes[l], l);
        } else {
            ahead->taken = 0;
        }
        ahead->from = b->from[l] = it ? it->t : 0;
        ahead->end = b->end[l] = x.end;
        ahead->h = b->h[l] = x.h;
    }
    return live;
}

/* Gives each lane that has no step a step of length 0. */
static void rest(struct pk_lanes *a, unsigned long long live)
{
    struct pk_block *b = &a->b;
    const size_t first = pk_lowest(live);
    for (size_t l = 0; l < b->lanes; l++) {
        if (live >> l & 1)
            continue;
        if (!(a->loaded >> l & 1))
            pk_block_copy_lane(b, first, l);
        b->from[l] = b->end[l] = b->from[first];
        b->h[l] = 0;
    }
}

/* Makes a step in all lanes. Returns those that failed. */
static unsigned long long step(struct pk_lanes *a)
{
    struct pk_block *b = &a->b;
    b->failed = b->not_finite = 0;
    return (a->method->traits & PK_ADAPTIVE ? a->stepper->attempt : a->stepper->step)(b);
}

static unsigned long long accelerations(struct pk_lanes *a, const pk_real *t, const pk_real *state,
                                        pk_real *to)
{
    struct pk_block *b = &a->b;
    pk_copy(b->t, t, b->lanes);
    return a->stepper->members(b, state, state + b->n_q * b->lanes, to);
}

/* Returns those of the lanes `of` whose steps, already made, cross no event. `known`: lanes whose
 * previous step was also examined here. */
static unsigned long long clear(struct pk_lanes *a, const struct pk_lane *lanes,
                                unsigned long long of, unsigned long long known)
{
    struct pk_block *b = &a->b;
    const size_t m = b->n * b->lanes;
    if (!a->screen.functions)
        return of;
    if (a->method->traits & PK_ADAPTIVE) {
        pk_copy(a->screen.a0, b->work + m, m);
        pk_copy(a->screen.a1, pk_block_slopes(b, pk_block_stages(a->method)) + m, m);
        return pk_screen(&a->screen, b, lanes, of, known, PK_CLEAR_OF);
    }
    if (pk_splitting_table(a->method))
        of &= ~accelerations(a, b->from, b->state, a->screen.a0);
    else
        pk_copy(a->screen.a0, b->work + m, m);
    of &= ~accelerations(a, b->end, b->next, a->screen.a1);
    return pk_screen(&a->screen, b, lanes, of, known, 1);
}

/* Returns whether the next steps need no checks between them. */
static int is_free(const struct pk_lanes *a, const struct pk_lane *lane)
{
    const struct pk_integrator *it = lane->it;
    const struct pk_integrator_private *own = it->own;
    return pk_is_fixed(a->method) && !own->singularities && !own->marks && !own->project &&
           !own->crossing && (pk_real)own->direction * (lane->free - it->t) > 0 &&
           it->options.h > 10 * PK_EPS * pk_abs(lane->free);
}

static size_t bits(unsigned long long x)
{
    size_t count = 0;
    for (; x; x &= x - 1)
        count++;
    return count;
}

/* Returns how many steps of the lane may be made in one call. */
static unsigned long most_of(const struct pk_lanes *a, const struct pk_lane *lane)
{
    const struct pk_integrator *it = lane->it;
    const unsigned long asked = it->options.max_steps, made = it->count.steps;
    const unsigned long left = !asked ? MANY : asked > made ? asked - made : 0;
    if (!is_free(a, lane) || (a->screen.functions && !pk_events_goes_on(lane->events)))
        return 0;
    return pk_step_count(it, lane->free, left < MANY ? left : MANY);
}

/* Makes steps of the lanes `live` together while at least half of them continue. */
static void make_many(struct pk_lanes *a, const struct pk_lane *lanes, unsigned long long live,
                      const unsigned long *most)
{
    struct pk_block *b = &a->b;
    const size_t n_q = b->n_q, W = b->lanes, m = b->n * W, enough = (bits(live) + 1) / 2;
    const int splitting = pk_splitting_table(a->method) != NULL;
    unsigned long long going = live, known = 0;
    while (going && bits(going) >= enough) {
        for (size_t l = 0; l < W; l++) {
            const struct pk_ahead *ahead = &a->ahead[l];
            b->h[l] = 0;
            if (!(going >> l & 1))
                continue;
            const struct pk_integrator_private *own = lanes[l].it->own;
            b->h[l] = (pk_real)own->direction * lanes[l].it->options.h;
            b->end[l] = own->grid.anchor + (own->grid.count + (pk_real)ahead->many + 1) * b->h[l];
        }
        b->have_a = splitting ? pk_splitting_ends(pk_splitting_table(a->method))
                              : !(going & ~known);
        going &= ~step(a);
        going = clear(a, lanes, going, known);
        advance(a, going);
        known = a->screen.functions ? going : 0;
        for (size_t l = 0; l < W; l++) {
            struct pk_ahead *ahead = &a->ahead[l];
            if (!(going >> l & 1))
                continue;
            ahead->many++;
            ahead->h = b->h[l];
            ahead->end = b->from[l] = b->end[l];
            ahead->next = b->state + l;
            if (ahead->many == most[l])
                going &= ~(1ull << l);
        }
        if (known && !splitting) { /* copies the first stage of the next step */
            pk_copy(b->work, b->state + n_q * W, n_q * W);
            pk_copy(b->work + m, a->screen.a1, m);
        }
    }
}

/* Computes the Taylor coefficients for the next step of each lane; the step itself is short. */
static void make_jets(struct pk_lanes *a, const struct pk_lane *lanes)
{
    struct pk_block *b = &a->b;
    unsigned long long live = 0, loaded = a->loaded;
    for (size_t l = 0; l < a->lanes; l++) {
        struct pk_integrator *it = lanes[l].it;
        struct pk_ahead *ahead = &a->ahead[l];
        ahead->ready = 0;
        if (!it || !pk_ready(it) || !(it->t < lanes[l].limit || it->t > lanes[l].limit))
            continue;
        if (it->own->ahead != ahead || !(loaded >> l & 1)) {
            it->own->ahead = ahead;
            pk_block_load(b, it, it->problem.params, l);
            a->loaded |= 1ull << l;
        }
        for (size_t i = 0; i < b->n_q + b->n; i++)
            b->state[i * b->lanes + l] = it->own->state[i];
        b->t[l] = ahead->from = ahead->end = it->t;
        ahead->h = 0;
        b->order = pk_taylor_order(it);
        live |= 1ull << l;
    }
    if (bits(live) * FEW <= a->lanes)
        return;
    for (size_t l = 0; l < a->lanes; l++)
        if (!(a->loaded >> l & 1))
            pk_block_copy_lane(b, pk_lowest(live), l), b->t[l] = b->t[pk_lowest(live)];
    live &= ~a->stepper->attempt(b);
    for (size_t l = 0; l < a->lanes; l++) {
        a->ahead[l].slopes = b->work + l;
        a->ahead[l].ready = live >> l & 1;
    }
}

void pk_lanes_make(struct pk_lanes *a, const struct pk_lane *lanes)
{
    if (a->method->traits & PK_JETS) {
        make_jets(a, lanes);
        return;
    }
    struct pk_block *b = &a->b;
    const struct pk_splitting *splitting = pk_splitting_table(a->method);
    unsigned long most[PK_BLOCK_MOST];
    unsigned long long made = 0, free = 0;
    for (size_t l = 0; l < a->lanes; l++)
        made |= (unsigned long long)(a->ahead[l].taken && a->single >> l & 1) << l;
    advance(a, made);
    a->single = a->idle = 0;
    const unsigned long long live = enter(a, lanes);
    if (bits(live) * FEW <= a->lanes) /* for few steps it is faster not to use lanes */
        return;
    rest(a, live);
    for (size_t l = 0; l < a->lanes; l++)
        if (live >> l & 1) {
            most[l] = most_of(a, &lanes[l]);
            free |= (unsigned long long)(most[l] > 0) << l;
        }
    if (free) {
        a->idle = live & ~free;
        rest(a, free);
        make_many(a, lanes, free, most);
        return;
    }
    b->have_a = splitting ? pk_splitting_ends(splitting) : (a->method->traits & PK_ADAPTIVE) != 0;
    const unsigned long long good = live & ~step(a);
    unsigned long long looked = 0;
    for (size_t l = 0; l < a->lanes; l++)
        if (good >> l & 1) {
            a->ahead[l].next = b->next + l;
            a->ahead[l].slopes = b->work + l;
            a->ahead[l].ready = 1;
            if (lanes[l].events && !lanes[l].it->own->singularities &&
                pk_events_goes_on(lanes[l].events))
                looked |= 1ull << l;
        }
    a->single = good;
    if (!looked)
        return;
    looked = clear(a, lanes, looked, 0);
    for (size_t l = 0; l < a->lanes; l++)
        a->ahead[l].clear = looked >> l & 1;
}

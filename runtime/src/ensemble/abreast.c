/* Steps of several integrators made ahead, in lanes; see pk/abreast.h. What is in a lane is its
 * integrator's state as long as that takes the steps that are made for it; else it is loaded anew.
 */
#include <string.h>

#include "../core/generic.h"
#include "../core/tableau.h"
#include "ensemble.h"

#include <pk/abreast.h>
#include <pk/step/embedded.h>

enum { FEW = 8 }; /* no more than this part of the lanes: those are not worth while */

static int most_stages(const struct pk_method *method)
{
    const struct pk_tableau *table = pk_explicit_table(method);
    return table ? table->stages : 0;
}

static size_t lay_out(struct pk_block *b, const struct pk_system *system,
                      const struct pk_method *method, size_t n, size_t W, pk_real *base)
{
    const struct pk_slot slots[] = {{&b->state, PK_PARTS * n * W},
                                    {&b->next, PK_PARTS * n * W},
                                    {&b->P, pk_params_reals(system) * W},
                                    {&b->u, system->n_inputs * W},
                                    {&b->t, W},
                                    {&b->work, pk_block_reals(most_stages(method), n, W)},
                                    {&b->lane, 3 * n + system->n_inputs}};
    return PK_LAY_OUT(base, slots);
}

size_t pk_abreast_size(const struct pk_problem *problem, const struct pk_method *method)
{
    const struct pk_system *system = problem->system;
    const struct pk_block_stepper *s = pk_block_stepper_of(system, method);
    struct pk_block b;
    if (!s || (method->traits & PK_ADAPTIVE && !s->attempt))
        return 0;
    return lay_out(&b, system, method, pk_system_count(system, problem->params), s->lanes, NULL) *
           sizeof(pk_real);
}

size_t pk_abreast_lanes(const struct pk_problem *problem, const struct pk_method *method)
{
    return pk_abreast_size(problem, method) ? pk_block_stepper_of(problem->system, method)->lanes
                                            : 1;
}

void pk_abreast_leave(struct pk_integrator *it)
{
    if (it->own)
        it->own->ahead = NULL;
}

void pk_abreast_init(struct pk_abreast *a, const struct pk_problem *problem,
                     const struct pk_method *method, void *block, size_t size)
{
    const struct pk_system *system = problem->system;
    memset(a, 0, sizeof *a);
    memset(block, 0, size);
    a->method = method;
    a->stepper = pk_block_stepper_of(system, method);
    a->lanes = a->stepper->lanes;
    a->b.system = system;
    a->b.lanes = a->lanes;
    a->b.n = pk_system_count(system, problem->params);
    lay_out(&a->b, system, method, a->b.n, a->lanes, (pk_real *)block);
}

/* What the next step towards `limit` will be; 0: that is not to be said. */
static int plan(const struct pk_abreast *a, struct pk_integrator *it, pk_real limit,
                struct pk_planned *x)
{
    const struct pk_splitting *splitting = pk_splitting_table(a->method);
    const int direction = (limit > it->t) - (limit < it->t);
    if (!pk_ready(it) || !direction || direction != it->own->direction || it->own->near)
        return 0;
    if (!(a->method->traits & PK_ADAPTIVE)) {
        *x = pk_step_planned(it, limit);
        return !splitting || !pk_splitting_ends(splitting) || it->own->flags & PK_HAVE_A;
    }
    if (!(it->own->flags & PK_HAVE_STEP || pk_waits(it)) || !(pk_abs(it->own->h) > 0))
        return 0;
    limit = pk_marks_limit(it, limit);
    struct pk_trial trial = pk_trial(it, limit);
    if (!pk_trial_next(it, limit, &trial))
        return 0;
    x->h = trial.h;
    x->end = it->own->next_t;
    return 1;
}

static void put(const pk_real *from, size_t count, pk_real *to, size_t W)
{
    for (size_t i = 0; i < count; i++)
        to[i * W] = from[i];
}

static void load(struct pk_abreast *a, const struct pk_abreast_lane *lane, size_t l)
{
    struct pk_block *b = &a->b;
    struct pk_integrator *it = lane->it;
    const size_t n = b->n, W = b->lanes, reals = pk_params_reals(b->system);
    const pk_real *params = (const pk_real *)lane->params;
    b->params[l] = params;
    put(it->own->state, PK_PARTS * n, b->state + l, W);
    if (a->method->traits & PK_ADAPTIVE) {
        const struct pk_tableau *table = pk_explicit_table(a->method);
        const struct pk_embedded_work w = pk_embedded_parts(it, table, n, 0);
        put(it->own->flags & PK_HAVE_STEP ? w.last : w.k, 2 * n, b->work + l, W);
    }
    put(params, reals, b->P + l, W);
    put(pk_eval_input(it, it->t), b->system->n_inputs, b->u + l, W);
    a->loaded |= 1ull << l;
}

/* Numbers that are finite, for a lane with nobody in it. */
static void copy_lane(struct pk_block *b, const struct pk_abreast *a, size_t from, size_t to)
{
    const size_t W = b->lanes;
    const struct {
        pk_real *x;
        size_t count;
    } all[] = {{b->state, PK_PARTS * b->n},
               {b->P, pk_params_reals(b->system)},
               {b->u, b->system->n_inputs},
               {b->work, a->method->traits & PK_ADAPTIVE ? 2 * b->n : 0}};
    for (size_t k = 0; k < sizeof all / sizeof *all; k++)
        for (size_t i = 0; i < all[k].count; i++)
            all[k].x[i * W + to] = all[k].x[i * W + from];
    b->params[to] = b->params[from];
}

/* Of lanes with `mask` what they have come to, in place of where they were. */
static void pick(const pk_bits *mask, size_t rows, size_t W, const pk_real *PK_RESTRICT from,
                 pk_real *PK_RESTRICT to)
{
    for (size_t i = 0; i < rows; i++) {
        PK_LANE_LOOP
        for (size_t l = 0; l < W; l++)
            to[i * W + l] = mask[l] ? from[i * W + l] : to[i * W + l];
    }
}

/* What was taken is where the next steps begin. */
static void turn(struct pk_abreast *a)
{
    struct pk_block *b = &a->b;
    const size_t n = b->n, W = b->lanes, part = n * W;
    pk_bits mask[PK_BLOCK_MOST];
    int all = 1;
    for (size_t l = 0; l < W; l++) {
        mask[l] = a->ahead[l].taken ? ~(pk_bits)0 : 0;
        all &= a->ahead[l].taken;
    }
    if (all) {
        pk_real *const left_behind = b->state;
        b->state = b->next;
        b->next = left_behind;
    } else {
        pick(mask, 2 * n, W, b->next, b->state);
    }
    if (a->method->traits & PK_ADAPTIVE)
        pick(mask, 2 * n, W, pk_block_slopes(b, most_stages(a->method)), b->work);
    else if (!all)
        pick(mask, (PK_PARTS - PK_LOW_Q) * n, W, b->next + PK_LOW_Q * part,
             b->state + PK_LOW_Q * part);
}

void pk_abreast_make(struct pk_abreast *a, const struct pk_abreast_lane *lanes)
{
    struct pk_block *b = &a->b;
    const size_t W = a->lanes;
    const struct pk_splitting *splitting = pk_splitting_table(a->method);
    unsigned long long live = 0;
    size_t count = 0;
    turn(a);
    for (size_t l = 0; l < W; l++) {
        struct pk_integrator *it = lanes[l].it;
        struct pk_ahead *ahead = &a->ahead[l];
        struct pk_planned x = {0};
        ahead->ready = 0;
        if (it && it->own->ahead != ahead)
            it->own->ahead = ahead, ahead->taken = ahead->waits = 0;
        if (it && plan(a, it, lanes[l].limit, &x)) {
            live |= 1ull << l;
            count++;
            if (!(ahead->taken || ahead->waits) || it->own->project)
                load(a, &lanes[l], l);
            ahead->from = it->t;
        } else {
            ahead->taken = 0;
        }
        b->from[l] = it ? it->t : 0;
        b->end[l] = ahead->end = x.end;
        b->h[l] = ahead->h = x.h;
    }
    if (count * FEW <= W) /* each by itself is faster */
        return;
    size_t first = 0;
    while (!(live >> first & 1))
        first++;
    for (size_t l = 0; l < W; l++) {
        if (live >> l & 1)
            continue;
        if (!(a->loaded >> l & 1))
            copy_lane(b, a, first, l);
        b->from[l] = b->end[l] = b->from[first];
    }
    b->have_a = splitting ? pk_splitting_ends(splitting) : (a->method->traits & PK_ADAPTIVE) != 0;
    b->failed = b->not_finite = 0;
    const unsigned long long bad =
        (a->method->traits & PK_ADAPTIVE ? a->stepper->attempt : a->stepper->step)(b);
    for (size_t l = 0; l < W; l++)
        if ((live & ~bad) >> l & 1) {
            a->ahead[l].next = b->next + l;
            a->ahead[l].slopes = b->work + l;
            a->ahead[l].lanes = W;
            a->ahead[l].ready = 1;
        }
}

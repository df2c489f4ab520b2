/* Members of an ensemble side by side: a block of them from row to row. The steps of
 * pk/step/ensemble.h are instantiated here for systems with lane kernels as function pointers, or
 * with a kernel for one state.
 */
#include <string.h>

#include "../core/attitude.h"
#include "ensemble.h"
#include "../core/generic.h"

#define PK_BLOCK_N(b) ((b)->n)
#define PK_BLOCK_COORDINATES(b) ((b)->n_q)
#define PK_BLOCK_LANES(b) ((size_t)PK_LANES)
#define PK_BLOCK_MEMBERS(b, q, v, a) members(b, q, v, a)

static unsigned long long members(struct pk_block *b, const pk_real *q, const pk_real *v,
                                  pk_real *a);

#include <pk/step/ensemble.h>

static unsigned long long members(struct pk_block *b, const pk_real *q, const pk_real *v,
                                  pk_real *a)
{
    const size_t n_q = b->n_q, n = b->n, W = b->lanes, m = b->system->n_inputs;
    pk_real *q1 = b->lane, *v1 = q1 + n_q, *a1 = v1 + n, *u1 = a1 + n;
    unsigned long long failed = 0;
    if (b->system->members)
        return b->system->members(b->P, b->t, q, v, b->u, a);
    for (size_t l = 0; l < W; l++) {
        for (size_t i = 0; i < n_q; i++)
            q1[i] = q[i * W + l];
        for (size_t i = 0; i < n; i++)
            v1[i] = v[i * W + l];
        for (size_t i = 0; i < m; i++)
            u1[i] = b->u[i * W + l];
        if (b->system->acceleration(b->params[l], b->t[l], q1, v1, u1, a1))
            failed |= 1ull << l;
        else
            for (size_t i = 0; i < n; i++)
                a[i * W + l] = a1[i];
    }
    return failed;
}

void pk_block_failed(struct pk_block *b, unsigned long long failed, const pk_real *q,
                     const pk_real *v)
{
    const unsigned long long lost = pk_block_not_finite(q, b->n_q, b->lanes) |
                                    pk_block_not_finite(v, b->n, b->lanes);
    b->not_finite |= lost & failed & ~b->failed;
    b->failed |= failed;
}

#define RUNGE_KUTTA(method)                                     \
    static unsigned long long step_##method(struct pk_block *b) \
    {                                                           \
        return generic_block_erk(b, &pk_##method##_table);      \
    }
#define SPLITTING(method)                                        \
    static unsigned long long step_##method(struct pk_block *b)  \
    {                                                            \
        return generic_block_splitting(b, &pk_##method##_table); \
    }
#define EMBEDDED(method)                                           \
    RUNGE_KUTTA(method)                                            \
    static unsigned long long attempt_##method(struct pk_block *b) \
    {                                                              \
        return generic_block_attempt(b, &pk_##method##_table);     \
    }
PK_ERK_METHODS(RUNGE_KUTTA)
PK_EMBEDDED_METHODS(EMBEDDED)
PK_SPLITTING_METHODS(SPLITTING)

#define ENTRY(method) {#method, PK_LANES, step_##method, NULL, members, NULL},
#define ENTRY_EMBEDDED(method) {#method, PK_LANES, step_##method, attempt_##method, members, NULL},
static const struct pk_block_stepper generic[] = {PK_ERK_METHODS(ENTRY) PK_EMBEDDED_METHODS(
    ENTRY_EMBEDDED) PK_SPLITTING_METHODS(ENTRY){NULL, 0, NULL, NULL, NULL, NULL}};

static const struct pk_block_stepper *find(const struct pk_block_stepper *list, const char *method)
{
    for (; list && list->method; list++)
        if (strcmp(list->method, method) == 0)
            return list;
    return NULL;
}

/* Families have no blocks: their loops are over members of families, not over lanes. */
const struct pk_block_stepper *pk_block_stepper_of(const struct pk_system *system,
                                                   const struct pk_method *method)
{
    const struct pk_block_stepper *own = find(system->block_steppers, method->name);
    if (system->families.count ||
        (method->needs & PK_LINEAR_DRAG && !(system->facts & PK_SEPARABLE)))
        return NULL;
    return own ? own : find(generic, method->name);
}

static size_t block_reals(const struct pk_ensemble *e, size_t n_q, size_t n, size_t W)
{
    return (3 * pk_state_offset(n_q, n, PK_PARTS) + pk_params_reals(e->system) +
            e->system->n_inputs + 1) *
               W +
           pk_block_reals(PK_MOST_STAGES, n_q, n, W) + n_q + 2 * n + e->system->n_inputs;
}

size_t pk_block_size(const struct pk_ensemble *e, size_t n_q, size_t n, size_t W)
{
    return pk_ensemble_padded(block_reals(e, n_q, n, W) * sizeof(pk_real));
}

/* Fills a lane with the numbers of another: its own member has ended, and would only fail again. */
static void copy_lane(struct pk_block *b, const struct pk_ensemble *e, size_t from, size_t to)
{
    const size_t W = b->lanes;
    for (size_t i = 0; i < pk_state_offset(b->n_q, b->n, PK_PARTS); i++) {
        b->state[i * W + to] = b->state[i * W + from];
        b->next[i * W + to] = b->next[i * W + from];
    }
    for (size_t i = 0; i < pk_params_reals(e->system); i++)
        b->P[i * W + to] = b->P[i * W + from];
    for (size_t i = 0; i < e->system->n_inputs; i++)
        b->u[i * W + to] = b->u[i * W + from];
    b->params[to] = b->params[from];
}

static void load_lane(struct pk_block *b, const struct pk_ensemble *e,
                      const struct pk_integrator *it, size_t member, size_t l)
{
    const size_t n_q = b->n_q, n = b->n, W = b->lanes, m = e->system->n_inputs;
    b->params[l] = it->problem.params;
    for (size_t i = 0; i < n_q; i++)
        b->state[i * W + l] = it->q[i];
    for (size_t i = 0; i < n; i++)
        b->state[(n_q + i) * W + l] = it->v[i];
    for (size_t i = 0; i < pk_params_reals(e->system); i++)
        memcpy(&b->P[i * W + l], (const char *)it->problem.params + i * sizeof(pk_real),
               sizeof(pk_real));
    for (size_t i = 0; i < m; i++)
        b->u[i * W + l] = e->u ? e->u[member * m + i] : 0;
}

static size_t lowest(unsigned long long bits)
{
    size_t l = 0;
    while (!(bits >> l & 1))
        l++;
    return l;
}

/* Ends the members in the lanes `bits` with `status`; their lanes follow another lane from now
 * on. */
static void retire(struct pk_block *b, const struct pk_ensemble *e, size_t first,
                   unsigned long long bits, enum pk_status status, unsigned long long *live)
{
    *live &= ~bits;
    for (size_t l = 0; l < b->lanes; l++)
        if (bits >> l & 1) {
            e->status[first + l] = status;
            e->last_t[first + l] = b->now;
            if (*live)
                copy_lane(b, e, lowest(*live), l);
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

static struct pk_member *member_at(const struct pk_ensemble *e, char *memory, size_t k)
{
    return (struct pk_member *)(void *)(memory + k * pk_member_size(e));
}

/* Ends the members of `bits` with `status`, or with the singularity that caused it. */
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
            reason = pk_member_step(member_at(e, memory, l), clock, b->next + l, b->lanes, status);
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

/* Sets the same step in all lanes. */
static void together(struct pk_block *b, pk_real from, pk_real end, pk_real h)
{
    for (size_t l = 0; l < b->lanes; l++)
        b->from[l] = from, b->end[l] = end, b->h[l] = h;
}

/* Makes the last step again to t, as pk_integrator_aside(), into b->spare. Returns the lanes that
 * failed. */
static unsigned long long aside(const struct pk_block *of, const struct pk_block_stepper *s,
                                const struct pk_integrator *clock, pk_real t)
{
    struct pk_block b = *of;
    b.state = of->next; /* where the step began */
    b.next = of->spare;
    b.have_a = 0;
    together(&b, clock->last_t, t, t - clock->last_t);
    return s->step(&b) | normalise(&b);
}

/* Advances all live lanes to t, or past it by the fixed step that contains t. */
static unsigned long long advance(struct pk_block *b, const struct pk_block_stepper *s,
                                  const struct pk_ensemble *e, struct pk_integrator *clock,
                                  size_t first, char *memory, pk_real t, unsigned long long live)
{
    const pk_real last = e->t[e->rows - 1], way = last < e->t0 ? PK_C(-1.0) : PK_C(1.0);
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
        if (bad) { /* a kernel that fails at finite numbers fails on M; all else is not finite */
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
                pk_member_step(member_at(e, memory, l), clock, b->next + l, b->lanes, PK_DONE);
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

void pk_block_run(const struct pk_ensemble *e, const struct pk_block_stepper *s, size_t first,
                  size_t count, char *memory)
{
    struct pk_block b = {.system = e->system, .lanes = s->lanes};
    struct pk_integrator clock = {0};
    const struct pk_problem problem = pk_ensemble_problem(e, 0);
    const size_t W = s->lanes, n = pk_system_count(e->system, problem.params);
    const size_t n_q = pk_system_coordinates(e->system, problem.params);
    const size_t parts = pk_state_offset(n_q, n, PK_PARTS);
    char *own = memory + pk_member_count(e, W) * pk_member_size(e);
    unsigned long long live = 0;
    memset(own, 0, block_reals(e, n_q, n, W) * sizeof(pk_real));
    b.n_q = n_q;
    b.n = n;
    b.state = (pk_real *)(void *)own;
    b.next = b.state + parts * W;
    b.spare = b.next + parts * W;
    b.P = b.spare + parts * W;
    b.u = b.P + pk_params_reals(e->system) * W;
    b.t = b.u + e->system->n_inputs * W;
    b.work = b.t + W;
    b.lane = b.work + pk_block_reals(PK_MOST_STAGES, n_q, n, W);

    for (size_t l = 0; l < count; l++) {
        struct pk_member *member = member_at(e, memory, e->system->singularities.n ? l : 0);
        const enum pk_status status = pk_member_begin(e, first + l, member);
        e->status[first + l] = status;
        if (status < 0)
            continue;
        load_lane(&b, e, &member->it, first + l, l);
        live |= 1ull << l;
        clock = member->it;
    }
    for (size_t l = 0; live && l < W; l++)
        if (!(live >> l & 1))
            copy_lane(&b, e, lowest(live), l);
    b.now = e->t0;
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

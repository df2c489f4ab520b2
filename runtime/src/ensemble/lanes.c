/* Members in SIMD lanes, see lanes.h. The steps of pk/step/ensemble.h are instantiated here for two
 * cases: systems with lane kernels, by pointers, and with kernels for one state. */
#include <string.h>

#include "lanes.h"
#include "../core/generic.h"
#include "../core/tableau.h"

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

/* Systems with families have no blocks: their kernels loop over members, not over lanes. */
const struct pk_block_stepper *pk_block_stepper_of(const struct pk_system *system,
                                                   const struct pk_method *method)
{
    const struct pk_block_stepper *own = find(system->block_steppers, method->name);
    if (system->families.count ||
        (method->needs & PK_LINEAR_DRAG && !(system->facts & PK_SEPARABLE)))
        return NULL;
    return own ? own : find(generic, method->name);
}

int pk_block_stages(const struct pk_method *method)
{
    const struct pk_tableau *table = pk_explicit_table(method);
    return table ? table->stages : 0;
}

size_t pk_block_lay_out(struct pk_block *b, const struct pk_problem *problem,
                        const struct pk_method *method, int spares, pk_real *base)
{
    const struct pk_system *system = problem->system;
    const size_t n_q = pk_coordinates_of(problem), n = pk_count_of(problem);
    const size_t W = pk_block_stepper_of(system, method)->lanes, u = system->n_inputs;
    const size_t parts = pk_state_offset(n_q, n, PK_PARTS) * W;
    b->system = system;
    b->n_q = n_q;
    b->n = n;
    b->lanes = W;
    const struct pk_slot slots[] = {
        {&b->state, parts},
        {&b->next, parts},
        {&b->spare, spares ? parts : 0},
        {&b->P, pk_params_reals(system) * W},
        {&b->u, u * W},
        {&b->t, W},
        {&b->work, method->traits & PK_JETS ? (PK_JET_ORDER + 1) * (n_q + n) * W
                                            : pk_block_reals(pk_block_stages(method), n_q, n, W)},
        {&b->lane, n_q + 2 * n + u}};
    return PK_LAY_OUT(base, slots);
}

/* Arrays of a block: each has `rows` rows with one number per lane. */
struct rows {
    pk_real *x;
    size_t rows;
};

static void put(struct pk_block *b, struct rows to, const pk_real *from, size_t l)
{
    for (size_t i = 0; i < to.rows; i++)
        to.x[i * b->lanes + l] = from[i];
}

void pk_block_load(struct pk_block *b, const struct pk_integrator *it, const void *params, size_t l)
{
    b->params[l] = params;
    put(b, (struct rows){b->state, pk_state_offset(b->n_q, b->n, PK_PARTS)}, it->own->state, l);
    put(b, (struct rows){b->P, pk_params_reals(b->system)}, (const pk_real *)params, l);
    pk_input(&it->problem, it->t, b->lane);
    put(b, (struct rows){b->u, b->system->n_inputs}, b->lane, l);
}

void pk_block_copy_lane(struct pk_block *b, size_t from, size_t to)
{
    const size_t W = b->lanes, parts = pk_state_offset(b->n_q, b->n, PK_PARTS);
    const struct rows all[] = {{b->state, parts},
                               {b->next, parts},
                               {b->P, pk_params_reals(b->system)},
                               {b->u, b->system->n_inputs},
                               {b->work, 2 * b->n}}; /* work: slopes of the first stage */
    for (size_t k = 0; k < sizeof all / sizeof *all; k++)
        for (size_t i = 0; i < all[k].rows; i++)
            all[k].x[i * W + to] = all[k].x[i * W + from];
    b->params[to] = b->params[from];
}

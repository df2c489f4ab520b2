/* Swarms of live pages: ensembles of many states, each member with its own params. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <pk/ensemble.h>

#include "pk_host.h"

/* Fixed steps end at multiples of the step h, whatever times the page shows. `state` has the states
 * of all members at the last such multiple. `shown` has the states at the time shown, after one
 * shorter step from `state`. */
struct swarm {
    struct pk_ensemble e;
    void *block;
    size_t block_size, n;
    pk_real at, target; /* time of `state`; time at which the current integration ends */
    pk_real *state, *shown, *ends, *u;
    size_t *done;
    pk_real *last;
    /* minimum and maximum of x over all members, then of y; then x and y of each member */
    float *points;
    enum pk_status *status;
    unsigned char *ended; /* flags of members that failed: they keep their last state */
};

void EXPORT(pk_swarm_free)(struct swarm *s)
{
    if (!s)
        return;
    free(s->block);
    free(s->state);
    free(s->done);
    free(s->last);
    free(s->points);
    free(s->status);
    free(s->ended);
    free(s);
}

/* Makes a swarm. `params` has the model's params of each member, one after another, each of
 * params_size bytes. The inputs u are the same for all members. The caller writes the initial
 * states to pk_swarm_start(): first q of all members, then v of all members. */
struct swarm *EXPORT(pk_swarm_new)(const void *params, const char *method, double h, double rtol,
                                   const double *u, size_t count)
{
    struct swarm *s = (struct swarm *)calloc(1, sizeof *s);
    const struct pk_method *const found = pk_host_method(method);
    const size_t n_inputs = pk_host_model.system->n_inputs;
    if (!s || !found) {
        free(s);
        pk_host_refuse(found ? "there is no memory" : "there is no such method");
        return NULL;
    }
    if (pk_host_model.system->switches.impulses || pk_host_model.system->resets.n ||
        pk_host_model.system->contacts.n) {
        free(s);
        pk_host_refuse("a swarm is not made of a model with impacts");
        return NULL;
    }
    s->n = pk_system_count(pk_host_model.system, params);
    const size_t half = 2 * s->n * count;
    s->state = (pk_real *)calloc(3 * half + n_inputs * count + 1, sizeof *s->state);
    s->done = (size_t *)calloc(count, sizeof *s->done);
    s->last = (pk_real *)calloc(count, sizeof *s->last);
    s->points = (float *)calloc(4 + 2 * count, sizeof *s->points);
    s->status = (enum pk_status *)calloc(count, sizeof *s->status);
    s->ended = (unsigned char *)calloc(count, 1);
    if (!s->state || !s->done || !s->last || !s->points || !s->status || !s->ended) {
        pk_swarm_free(s);
        pk_host_refuse("there is no memory");
        return NULL;
    }
    s->shown = s->state + half;
    s->ends = s->shown + half;
    s->u = s->ends + half;
    for (size_t i = 0; i < count && n_inputs; i++)
        memcpy(s->u + i * n_inputs, u, n_inputs * sizeof *u);
    s->e.system = pk_host_model.system;
    s->e.method = found;
    s->e.options = pk_options_default();
    s->e.options.h = h;
    if (rtol > 0)
        s->e.options.rtol = rtol;
    s->e.members = count;
    s->e.params = params;
    s->e.q0 = s->state;
    s->e.v0 = s->state + s->n * count;
    s->e.u = n_inputs ? s->u : NULL;
    s->e.q = s->ends;
    s->e.v = s->ends + s->n * count;
    s->e.rows = 1;
    s->e.t = &s->target;
    s->e.done = s->done;
    s->e.last_t = s->last;
    s->e.status = s->status;
    s->block_size = pk_ensemble_size(&s->e);
    s->block = malloc(s->block_size);
    if (!s->block) {
        pk_swarm_free(s);
        pk_host_refuse("there is no memory");
        return NULL;
    }
    return s;
}

pk_real *EXPORT(pk_swarm_start)(struct swarm *s) { return s->state; }

/* The states at the time of the last pk_swarm_to(): q of all, then v of all. */
const pk_real *EXPORT(pk_swarm_states)(const struct swarm *s) { return s->shown; }

/* Returns columns i and j of the states (q, v) as floats for WebGL, in the layout of `points`. */
const float *EXPORT(pk_swarm_points)(struct swarm *s, size_t i, size_t j)
{
    const size_t n = s->n, members = s->e.members;
    const pk_real *const x = s->shown + (i < n ? i : n * members + i - n);
    const pk_real *const y = s->shown + (j < n ? j : n * members + j - n);
    float *const lo = s->points, *const all = lo + 4;
    lo[0] = lo[2] = INFINITY;
    lo[1] = lo[3] = -INFINITY;
    for (size_t k = 0; k < members; k++) {
        const float at[2] = {(float)x[k * n], (float)y[k * n]};
        for (size_t d = 0; d < 2; d++) {
            all[2 * k + d] = at[d];
            lo[2 * d] = fminf(lo[2 * d], at[d]);
            lo[2 * d + 1] = fmaxf(lo[2 * d + 1], at[d]);
        }
    }
    return s->points;
}

/* Copies q and v of member i between arrays of states. */
static void take(const struct swarm *s, pk_real *to, const pk_real *from, size_t i)
{
    const size_t v = s->n * s->e.members, size = s->n * sizeof *to;
    memcpy(to + i * s->n, from + i * s->n, size);
    memcpy(to + v + i * s->n, from + v + i * s->n, size);
}

/* Integrates all members from `state` to t and stores the results in `to`. */
static void run(struct swarm *s, pk_real t, pk_real *to)
{
    s->target = t;
    s->e.t0 = s->at;
    const enum pk_status status = pk_ensemble_run(&s->e, 0, s->e.members, s->block, s->block_size);
    const int none = status == PK_BAD_ARGUMENT || status == PK_BLOCK_TOO_SMALL;
    for (size_t i = 0; i < s->e.members; i++) {
        if (none || !s->done[i])
            s->ended[i] = 1;
        else if (!s->ended[i])
            take(s, to, s->ends, i);
    }
}

/* Integrates all members to t and returns how many have not failed. A failed member keeps its last
 * state. If all have failed, pk_host_why() returns the first member's reason. */
size_t EXPORT(pk_swarm_to)(struct swarm *s, double t)
{
    const pk_real h = s->e.options.h;
    const pk_real grid = pk_ensemble_fixed(&s->e) ? h * floor(t / h * (1 + 4 * PK_EPSILON)) : t;
    size_t going = 0;
    if (grid > s->at) {
        run(s, grid, s->state);
        s->at = grid;
    }
    for (size_t i = 0; i < s->e.members; i++)
        if (!s->ended[i])
            take(s, s->shown, s->state, i);
    if (t - s->at > 1e-9 * h)
        run(s, t, s->shown);
    for (size_t i = 0; i < s->e.members; i++)
        going += !s->ended[i];
    if (!going)
        pk_ensemble_reason(&s->e, 0, s->block, s->block_size, pk_host_text, PK_HOST_TEXT);
    return going;
}

/* The largest Lyapunov exponent of a motion that events change at once, as impacts do: linearised
 * equations do not tell what happens to a displacement there. A second motion beside it does, at a
 * distance that is made NEAR again wherever it has left CLOSEST .. FARTHEST; these are relative to
 * the coordinates and rates of the motion. Between the impact of one and that of the other the
 * distance tells nothing, so it is measured where both have changed equally often.
 * Reference: G. Benettin, L. Galgani, J.-M. Strelcyn, Phys. Rev. A 14 (1976) 2338. */

#include "../../src/core/internal.h"
#include "parts.h"

#define NEAR PK_C(1e-7)
#define CLOSEST PK_C(1e-9)
#define FARTHEST PK_C(1e-4)

struct neighbour {
    struct motion motion;
    struct pk_problem problem;
    struct pk_events events;
    struct pk_actor actor;
    unsigned long changes, all; /* since the distance was NEAR; since the start */
    pk_real *state;             /* work memory: a state, and twice the functions of events */
    char why[512];              /* why there is no exponent, or "" */
};

static void inputs(void *context, pk_real t, pk_real *u)
{
    const struct neighbour *x = context;
    (void)t;
    memcpy(u, x->actor.u, x->problem.system->n_inputs * sizeof *u);
}

static int found(void *context, const struct pk_events *events)
{
    struct neighbour *x = context;
    return pk_actor_note(&x->actor, events);
}

static enum pk_status refuse(struct neighbour *x, const char *why)
{
    snprintf(x->why, sizeof x->why, "%s", why);
    return PK_REFUSED;
}

static enum pk_status refuse_closed(struct neighbour *x)
{
    const struct pk_part_contacts *all = &x->problem.system->contacts;
    for (size_t k = 0; k < all->n; k++)
        if (x->actor.u[all->table[k].mode] > 0) {
            snprintf(x->why, sizeof x->why,
                     "contact %s stays closed from t = %.9g on: exponents are of motions whose "
                     "impacts end at once",
                     all->table[k].name, (double)x->motion.it.t);
            return PK_REFUSED;
        }
    return PK_DONE;
}

static enum pk_status start(struct neighbour *x, struct pk_run *run, struct memory *memory)
{
    const struct pk_system *system = &run->bare;
    const size_t m = system->n_inputs;
    x->problem = (struct pk_problem){system, run->settings.params, inputs, x, NULL};
    x->motion = motion_of(run);
    x->motion.problem = &x->problem;
    x->motion.memory = memory;
    x->state = memory_take(memory, 2 * run->settings.n + 2 * system->events.n, sizeof *x->state);
    x->actor = (struct pk_actor){.system = system, .params = run->settings.params};
    x->actor.u =
        memcpy(memory_take(memory, m + 1, sizeof *x->state), run->settings.u, m * sizeof *x->state);
    for (size_t k = 0; k < system->contacts.n; k++) /* the run may have ended with closed ones */
        memset(x->actor.u + system->contacts.table[k].mode, 0, 3 * sizeof *x->state);
    PK_TRY(motion_begin(&x->motion));
    const size_t reals = pk_actor_reals(&x->problem),
                 size = pk_events_size(&x->problem, x->motion.method);
    PK_TRY(pk_events_init(&x->events, &x->motion.it, memory_take(memory, size, 1), size));
    x->events.found = found;
    x->events.context = x;
    x->actor.events = &x->events;
    PK_TRY(pk_actor_start(&x->actor, &x->motion.it, memory_take(memory, reals, sizeof *x->state)));
    return refuse_closed(x);
}

static int is_before(const struct neighbour *x, pk_real end)
{
    return x->motion.it.t < end && !pk_integrator_is_at(&x->motion.it, end);
}

/* Makes steps up to the time `end`, or one step towards it. */
static enum pk_status go(struct neighbour *x, pk_real end, int one)
{
    enum pk_status status = PK_DONE;
    while (status == PK_DONE && is_before(x, end)) {
        status = pk_events_step(&x->events, &x->motion.it, end);
        if (status == PK_STOPPED_EVENT && x->actor.acting) {
            x->changes++, x->all++;
            PK_TRY(status = pk_actor_run(&x->actor, &x->motion.it));
            PK_TRY(refuse_closed(x));
        }
        if (one)
            break;
    }
    return status;
}

static enum pk_status both(struct neighbour *a, struct neighbour *b, pk_real end, int one)
{
    enum pk_status status;
    PK_TRY(status = go(a, end, one));
    PK_TRY(go(b, a->motion.it.t, 0));
    return status;
}

/* Sets b to a, plus `part` of what is between them, plus `more`. Returns 0, and changes nothing, if
 * an event that changes the motion would be there or in between. */
static int put(struct neighbour *b, struct neighbour *a, pk_real part, const pk_real *more)
{
    const struct pk_system *system = a->problem.system;
    const struct pk_integrator *from = &a->motion.it;
    struct pk_integrator *it = &b->motion.it;
    pk_real *q = b->state, *v = q + it->n_q, *g = v + it->n, *h = g + system->events.n;
    int clear = 1;
    for (size_t i = 0; i < it->n_q; i++)
        q[i] = from->q[i] + part * (it->q[i] - from->q[i]) + more[i];
    for (size_t i = 0; i < it->n; i++)
        v[i] = from->v[i] + part * (it->v[i] - from->v[i]) + more[it->n + i];
    system->events.values(a->actor.params, from->t, from->q, from->v, a->actor.u, g);
    system->events.values(a->actor.params, from->t, q, v, a->actor.u, h);
    for (size_t k = 0; k < system->contacts.n; k++)
        clear &= g[system->contacts.table[k].event] * h[system->contacts.table[k].event] > 0;
    for (size_t k = 0; k < system->resets.n; k++)
        clear &= g[system->resets.table[k].event] * h[system->resets.table[k].event] > 0;
    if (!clear)
        return 0;
    a->changes = b->changes = 0;
    pk_integrator_reset(it, from->t, q, v);
    return 1;
}

static pk_real distance(const struct neighbour *a, const struct neighbour *b, const pk_real *sizes)
{
    const struct pk_integrator *x = &a->motion.it, *y = &b->motion.it;
    pk_real sum = 0;
    for (size_t i = 0; i < x->n_q; i++)
        sum += PK_F(pow)((y->q[i] - x->q[i]) / sizes[i], 2);
    for (size_t i = 0; i < x->n; i++)
        sum += PK_F(pow)((y->v[i] - x->v[i]) / sizes[x->n + i], 2);
    return PK_F(sqrt)(sum);
}

/* Measures the distance, and makes it NEAR if it is too small or too large. Where that cannot be
 * done yet, both go on for a part of the time between changes. Near a graze only one may ever
 * strike; then the next distance counts. */
static enum pk_status renew(struct lyapunov *l, struct neighbour *a, struct neighbour *b,
                            const pk_real *sizes, const pk_real *none, pk_real *size)
{
    const pk_real flight = a->motion.it.t / (pk_real)(a->all + 1);
    for (pk_real dt = flight / PK_C(1e9); dt < flight / 8; dt *= 2) {
        if (a->changes == b->changes) {
            *size = distance(a, b, sizes);
            if (*size > CLOSEST && *size < FARTHEST)
                return PK_DONE;
            if (!(*size > 0 && *size < 1))
                return refuse(a, *size > 0 ? "neighbours part too far from one step to the next"
                                           : "the motion and its neighbour become one");
            if (put(b, a, NEAR / *size, none)) {
                l->grown += PK_F(log)(*size / NEAR);
                *size = NEAR;
                return PK_DONE;
            }
        }
        PK_TRY(both(a, b, a->motion.it.t + dt, 0));
    }
    a->changes = b->changes = 0;
    return PK_DONE;
}

/* Writes the scale of each coordinate and rate: the larger of its values at the start and the end
 * of the run, or if that is 0 the largest of its kind. */
static void measure(const struct pk_run *run, pk_real *sizes)
{
    const struct settings *s = &run->settings;
    for (size_t rates = 0; rates < 2; rates++) {
        const size_t n = s->n, m = rates ? n : run->it.n_q;
        const pk_real *x = rates ? s->v : s->q, *y = rates ? run->it.v : run->it.q;
        const pk_real most = pk_max(pk_largest(x, m), pk_largest(y, m));
        for (size_t i = 0; i < m; i++) {
            const pk_real size = pk_max(pk_abs(x[i]), pk_abs(y[i]));
            sizes[rates * n + i] = size > 0 ? size : most > 0 ? most : 1;
        }
    }
}

static enum pk_status follow(struct lyapunov *l, struct neighbour *a, struct neighbour *b,
                             struct pk_run *run, pk_real *most)
{
    const struct settings *s = &run->settings;
    const size_t n = s->n;
    const struct pk_integrator *it = &a->motion.it;
    pk_real *sizes = memory_take(a->motion.memory, 6 * n, sizeof *sizes), *none = sizes + 2 * n;
    pk_real *more = none + 2 * n, size = NEAR;
    enum pk_status status = PK_DONE;
    measure(run, sizes);
    for (size_t i = 0; i < 2 * n; i++) { /* fractional parts of multiples of the golden section */
        const pk_real part = PK_C(0.61803398874989484820458683436563812) * (pk_real)(i + 1);
        more[i] = NEAR * (part - PK_F(floor)(part) + PK_C(0.1)) * sizes[i];
    }
    for (pk_real dt = l->block / 1024; !put(b, a, 0, more); dt *= 2) { /* it starts at an event */
        if (!(dt < run->it.t))
            return refuse(a, "the function of an event that changes the motion stays 0");
        PK_TRY(both(a, b, it->t + dt, 0));
    }
    while (l->blocks < LYAPUNOV_BLOCKS && status == PK_DONE) {
        const pk_real until = (pk_real)(l->blocks + 1) * l->block;
        while (is_before(a, until) && status == PK_DONE) {
            PK_TRY(status = both(a, b, until, 1));
            PK_TRY(renew(l, a, b, sizes, none, &size));
        }
        l->G[l->blocks++] = l->grown + PK_F(log)(size / NEAR);
        motion_note(most + (2 * l->blocks > LYAPUNOV_BLOCKS ? 2 * n : 0), s, it);
    }
    return PK_DONE;
}

enum pk_status lyapunov_beside(struct lyapunov *l, struct pk_run *run, struct memory *memory,
                               pk_real *most, const char **why)
{
    const struct pk_system *system = &run->bare;
    struct neighbour *x = memory_take(memory, 2, sizeof *x);
    *why = system->constraints.n > system->contacts.n ? diagnose_not_free(system) : NULL;
    if (*why)
        return PK_REFUSED;
    l->block = run->it.t / LYAPUNOV_BLOCKS;
    l->G = memory_take(memory, LYAPUNOV_BLOCKS, sizeof *l->G);
    enum pk_status status = start(&x[0], run, memory);
    if (status >= 0)
        status = start(&x[1], run, memory);
    if (status >= 0)
        status = follow(l, &x[0], &x[1], run, most);
    struct neighbour *failed = &x[!*x->why && x->motion.it.status >= 0];
    if (status < 0 && !*failed->why)
        pk_integrator_reason(&failed->motion.it, failed->why, sizeof failed->why);
    *why = failed->why;
    for (int k = 0; k < 2; k++) {
        pk_events_free(&x[k].events);
        pk_integrator_free(&x[k].motion.it);
    }
    return status;
}

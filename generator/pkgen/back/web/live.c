/* A model as a live page calls it: motions by any method, values at any state, swarms. Compiled with
 * one model and the runtime's core to WebAssembly; engine.js is its one caller. Parameters are a
 * flat array in the order of the description, not a number where the default is meant. q has
 * the coordinates, v the rates and behind them the first-order variables. All in SI.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <pk/ensemble.h>
#include <pk/events.h>
#include <pk/integrator.h>

#define EXPORT(name) __attribute__((export_name(#name))) name

extern const struct pk_system *const live_system;

enum { LONGEST_TEXT = 600, MOST_CROSSINGS = 256 };

static char why[LONGEST_TEXT];

static int refuse(const char *text)
{
    snprintf(why, sizeof why, "%s", text);
    return 0;
}

const char *EXPORT(live_why)(void)
{
    return why;
}

/* Parameters. */

static size_t members(const void *params, size_t k, pk_real **first)
{
    const struct pk_system *s = live_system;
    struct pk_range range = {0, 1, 0};
    if (s->families.range)
        s->families.range(params, 1, k, &range);
    char *place = (char *)params + s->parameters[k].offset;
    if (range.is_family)
        memcpy(first, place, sizeof *first);
    else
        *first = (pk_real *)(void *)place;
    return range.count;
}

size_t EXPORT(live_parameters)(void *params)
{
    size_t count = 0;
    pk_real *first;
    for (size_t k = 0; k < live_system->n_parameters; k++)
        count += members(params, k, &first);
    return count;
}

/* With room for families; NULL without memory. */
void *EXPORT(live_params)(void)
{
    const struct pk_system *s = live_system;
    void *params = calloc(1, s->params_size + sizeof(pk_real));
    if (!params)
        return NULL;
    if (s->families.set_sizes)
        s->families.set_sizes(params);
    const size_t size = s->families.block_size ? s->families.block_size(params) : 0;
    if (size) {
        void *block = calloc(1, size);
        if (!block)
            return NULL;
        s->families.attach(params, block);
    }
    s->defaults(params);
    return params;
}

/* Values in, all of them out. 1, or 0 with why: a parameter is out of bounds. */
int EXPORT(live_set)(void *params, double *values)
{
    const struct pk_system *s = live_system;
    unsigned char *given = (unsigned char *)calloc(s->n_parameters + 1, 1);
    size_t flat = 0;
    pk_real *first;
    if (!given)
        return refuse("there is no memory");
    s->defaults(params);
    for (size_t k = 0; k < s->n_parameters; k++) {
        const size_t count = members(params, k, &first);
        for (size_t i = 0; i < count; i++, flat++)
            if (!isnan(values[flat])) {
                first[i] = values[flat];
                given[k] = 1;
            }
    }
    if (s->derive)
        s->derive(params, given);
    free(given);
    flat = 0;
    for (size_t k = 0; k < s->n_parameters; k++) {
        const size_t count = members(params, k, &first);
        for (size_t i = 0; i < count; i++)
            values[flat++] = first[i];
    }
    const int failure = s->prepare(params);
    if (!failure)
        return 1;
    if (PK_FAILURE(failure) == PK_FAILURE_PARAMETER) {
        const size_t k = (size_t)PK_FAILURE_AT(failure);
        snprintf(why, sizeof why, "%s is outside its bounds", s->parameters[k].what.name);
        return 0;
    }
    return refuse("what is computed from the parameters is not finite");
}

size_t EXPORT(live_n)(const void *params)
{
    return pk_system_count(live_system, params);
}

size_t EXPORT(live_n_q)(const void *params)
{
    return pk_system_coordinates(live_system, params);
}

void EXPORT(live_start)(const void *params, double *q, double *v)
{
    live_system->start(params, q, v);
}

/* Values at a state: u are the inputs. 0: there is none. */

int EXPORT(live_outputs)(const void *params, double t, const double *q, const double *v,
                         const double *u, double *out)
{
    if (!live_system->observe)
        return 0;
    live_system->observe(params, t, q, v, u, out);
    return 1;
}

int EXPORT(live_claims)(const void *params, double t, const double *q, const double *v,
                        const double *u, double *out)
{
    if (!live_system->conserve)
        return 0;
    live_system->conserve(params, t, q, v, u, out);
    return 1;
}

double EXPORT(live_energy)(const void *params, double t, const double *q, const double *v,
                           const double *u)
{
    return live_system->energy ? live_system->energy(params, t, q, v, u) : NAN;
}

int EXPORT(live_acceleration)(const void *params, double t, const double *q, const double *v,
                              const double *u, double *out)
{
    return !live_system->acceleration(params, t, q, v, u, out);
}

/* `rest` has room for n numbers. */
int EXPORT(live_momenta)(const void *params, double t, const double *q, const double *v,
                         const double *u, double *out, double *rest)
{
    pk_kernel_2 *const kernel =
        live_system->unconstrained ? live_system->unconstrained : live_system->canonical;
    if (!kernel)
        return 0;
    kernel(params, t, q, v, u, out, rest);
    return 1;
}

/* Motions. */

struct crossing {
    double event, t;
};

struct live {
    struct pk_integrator it, aside;
    struct pk_events events;
    void *block, *events_block, *aside_block;
    size_t size, n;
    double *q, *v, *u; /* at t */
    double t;
    struct crossing crossings[MOST_CROSSINGS];
    size_t n_crossings;
    size_t n_inputs;
};

static void give_inputs(void *context, pk_real t, pk_real *u)
{
    const struct live *m = (const struct live *)context;
    (void)t;
    memcpy(u, m->u, m->n_inputs * sizeof *u);
}

static int cross(void *context, const struct pk_events *events)
{
    struct live *m = (struct live *)context;
    if (m->n_crossings < MOST_CROSSINGS) {
        m->crossings[m->n_crossings].event = (double)events->which;
        m->crossings[m->n_crossings++].t = events->t;
    }
    return 0;
}

void EXPORT(live_free)(struct live *m)
{
    if (!m)
        return;
    free(m->block);
    free(m->events_block);
    free(m->aside_block);
    free(m->q);
    free(m);
}

static int fixed(const struct live *m)
{
    return !(m->it.method->traits & (PK_ADAPTIVE | PK_DENSE));
}

static void keep(struct live *m, double t, const double *q, const double *v)
{
    m->t = t;
    memcpy(m->q, q, m->n * sizeof *q);
    memcpy(m->v, v, m->n * sizeof *v);
}

/* NULL with why where the method, its settings or the start are refused. params stay the caller's
 * as long as the motion is used. */
struct live *EXPORT(live_new)(const void *params, const char *method, double h, double rtol,
                              double t, const double *q, const double *v, const double *u)
{
    struct live *m = (struct live *)calloc(1, sizeof *m);
    struct pk_options options = pk_options_default();
    const struct pk_problem problem = {live_system, params, give_inputs, m};
    const struct pk_method *const found = pk_method_find(method);
    if (!m || !found) {
        free(m);
        refuse(found ? "there is no memory" : "there is no such method");
        return NULL;
    }
    options.h = h;
    options.max_steps = 0;
    if (rtol > 0)
        options.rtol = rtol;
    m->n = pk_system_count(live_system, params);
    m->n_inputs = live_system->n_inputs;
    m->size = pk_integrator_size(&problem, found);
    m->q = (double *)calloc(2 * m->n + m->n_inputs + 1, sizeof *m->q);
    m->block = calloc(1, m->size + 1);
    const size_t events_size = pk_events_size(&problem, found);
    m->events_block = calloc(1, events_size + 1);
    if (!m->q || !m->block || !m->events_block) {
        live_free(m);
        refuse("there is no memory");
        return NULL;
    }
    m->v = m->q + m->n;
    m->u = m->v + m->n;
    if (m->n_inputs)
        memcpy(m->u, u, m->n_inputs * sizeof *u);
    if (pk_integrator_init(&m->it, &problem, found, &options, t, q, v, m->block, m->size) < 0) {
        pk_integrator_reason(&m->it, why, sizeof why);
        live_free(m);
        return NULL;
    }
    if (pk_events_init(&m->events, &m->it, m->events_block, events_size) < 0) {
        refuse("the events of the model cannot be looked for");
        live_free(m);
        return NULL;
    }
    m->events.found = cross;
    m->events.context = m;
    keep(m, t, m->it.q, m->it.v);
    return m;
}

/* The state at t in the last step. */
static enum pk_status within(struct live *m, double t)
{
    if (pk_integrator_is_at(&m->it, t)) {
        keep(m, t, m->it.q, m->it.v);
        return PK_DONE;
    }
    if (!fixed(m))
        return pk_integrator_dense(&m->it, m->t = t, m->q, m->v);
    if (!m->aside_block) {
        struct pk_problem problem = m->it.problem;
        if (m->events.params) /* with the sides of switches */
            problem.params = m->events.params;
        m->aside_block = calloc(1, m->size);
        if (!m->aside_block)
            return PK_NO_MEMORY;
        const enum pk_status begun =
            pk_integrator_init(&m->aside, &problem, m->it.method, &m->it.options, m->it.t, m->it.q,
                               m->it.v, m->aside_block, m->size);
        if (begun < 0)
            return begun;
    }
    m->aside.options.h = m->it.options.h;
    const enum pk_status found = pk_integrator_aside(&m->it, &m->aside, t);
    if (found >= 0)
        keep(m, t, m->aside.q, m->aside.v);
    return found;
}

/* To t, by at most `budget` steps: 1 if there are more to make, 0 at t, negative or above 1 the
 * status. A method of fixed steps, or of its own dense output, is not disturbed by t; others land
 * there. */
int EXPORT(live_to)(struct live *m, double t, double budget)
{
    struct pk_integrator *it = &m->it;
    const double far = t + 1e9 * (fabs(t) + 1);
    const int lands = !fixed(m) && !(it->method->traits & PK_DENSE);
    while (it->t < t && !pk_integrator_is_at(it, t)) {
        if (budget-- <= 0)
            return 1;
        const double limit = lands ? t : fixed(m) ? pk_integrator_limit(it, t, far) : far;
        const enum pk_status status = pk_events_step(&m->events, it, limit);
        if (status != PK_DONE) {
            if (status == PK_STOPPED_EVENT || it->t < t)
                keep(m, it->t, it->q, it->v);
            return status == PK_STOPPED_EVENT ? 2 : status;
        }
    }
    const enum pk_status status = within(m, t);
    if (status == PK_BAD_ARGUMENT) { /* the step has ended at a switch: its end is what there is */
        keep(m, it->t, it->q, it->v);
        return 0;
    }
    return status < 0 ? status : 0;
}

const char *EXPORT(live_reason)(struct live *m)
{
    pk_integrator_reason(&m->it, why, sizeof why);
    return why;
}

double EXPORT(live_t)(const struct live *m)
{
    return m->t;
}

const double *EXPORT(live_q)(const struct live *m)
{
    return m->q;
}

const double *EXPORT(live_v)(const struct live *m)
{
    return m->v;
}

double EXPORT(live_steps)(const struct live *m)
{
    return (double)m->it.count.steps;
}

double EXPORT(live_evaluations)(const struct live *m)
{
    return (double)m->it.count.evaluations;
}

/* Crossings since the last call: pairs of event and time. */
const struct crossing *EXPORT(live_crossings)(const struct live *m)
{
    return m->crossings;
}

size_t EXPORT(live_take_crossings)(struct live *m)
{
    const size_t count = m->n_crossings;
    m->n_crossings = 0;
    return count;
}

/* Swarms: members of one set of parameters, or each of its own. */

struct swarm {
    struct pk_ensemble e;
    void *block;
    size_t block_size, n;
    double t;
    pk_real target;
    double *state; /* q0, v0, q, v of all members */
    size_t *done;
    pk_real *last;
    enum pk_status *status;
};

void EXPORT(live_swarm_free)(struct swarm *s)
{
    if (!s)
        return;
    free(s->block);
    free(s->state);
    free(s->done);
    free(s->last);
    free(s->status);
    free(s);
}

/* `params`: of each member, params_size bytes one after the other. States are to be put where
 * live_swarm_states() is. */
struct swarm *EXPORT(live_swarm_new)(const void *params, const char *method, double h,
                                     double rtol, size_t count)
{
    struct swarm *s = (struct swarm *)calloc(1, sizeof *s);
    const struct pk_method *const found = pk_method_find(method);
    if (!s || !found) {
        free(s);
        refuse("there is no such method");
        return NULL;
    }
    s->n = pk_system_count(live_system, params);
    s->state = (double *)calloc(4 * s->n * count + 1, sizeof *s->state);
    s->done = (size_t *)calloc(count, sizeof *s->done);
    s->last = (pk_real *)calloc(count, sizeof *s->last);
    s->status = (enum pk_status *)calloc(count, sizeof *s->status);
    s->e.system = live_system;
    s->e.method = found;
    s->e.options = pk_options_default();
    s->e.options.h = h;
    if (rtol > 0)
        s->e.options.rtol = rtol;
    s->e.members = count;
    s->e.params = params;
    s->e.q0 = s->state;
    s->e.v0 = s->state + s->n * count;
    s->e.q = s->state + 2 * s->n * count;
    s->e.v = s->state + 3 * s->n * count;
    s->e.rows = 1;
    s->e.t = &s->target;
    s->e.done = s->done;
    s->e.last_t = s->last;
    s->e.status = s->status;
    s->block_size = pk_ensemble_size(&s->e);
    s->block = malloc(s->block_size);
    if (!s->state || !s->done || !s->last || !s->status || !s->block) {
        live_swarm_free(s);
        refuse("there is no memory");
        return NULL;
    }
    return s;
}

double *EXPORT(live_swarm_states)(struct swarm *s)
{
    return s->state;
}

size_t EXPORT(live_params_size)(void)
{
    return live_system->params_size;
}

/* All to t. Members that fail stay where they are; how many do not. */
size_t EXPORT(live_swarm_to)(struct swarm *s, double t)
{
    const size_t half = 2 * s->n * s->e.members;
    size_t going = 0;
    s->target = t;
    s->e.t0 = s->t;
    if (pk_ensemble_run(&s->e, 0, s->e.members, s->block, s->block_size) == PK_BAD_ARGUMENT)
        return 0;
    for (size_t i = 0; i < s->e.members; i++) {
        if (!s->done[i])
            continue;
        going++;
        for (size_t k = 0; k < s->n; k++) {
            s->state[i * s->n + k] = s->state[half + i * s->n + k];
            s->state[half / 2 + i * s->n + k] = s->state[half + half / 2 + i * s->n + k];
        }
    }
    s->t = t;
    return going;
}

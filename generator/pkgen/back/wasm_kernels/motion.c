/* Motions: one state, integrated by any method to any time. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <pk/events.h>
#include <pk/integrator.h>

#include "live.h"

enum { MOST_CROSSINGS = 1 << 16 }; /* most that are kept between calls of live_take_crossings() */

struct live {
    struct pk_integrator it, aside;
    struct pk_events events;
    void *block, *events_block, *aside_block;
    size_t size, n;
    double *q, *v, *u; /* at t */
    double t;
    double *q0, *v0, t0; /* the initial state */
    double *crossings;   /* event, t, q, v of each */
    size_t n_crossings, room;
    size_t n_inputs;
    int stopped;    /* `it` stands at an event that ends the motion */
    double from;    /* t at which the last step began */
    double refused; /* the time that the last live_to() refused */
    int is_refused;
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
    const size_t width = 2 + 2 * m->n;
    if (m->n_crossings == m->room && m->room < MOST_CROSSINGS) {
        const size_t room = m->room ? 2 * m->room : 16;
        double *const grown = (double *)realloc(m->crossings, room * width * sizeof *grown);
        if (grown) {
            m->crossings = grown;
            m->room = room;
        }
    }
    if (m->n_crossings == m->room)
        return 0;
    double *const at = m->crossings + width * m->n_crossings++;
    at[0] = (double)events->which;
    at[1] = events->t;
    memcpy(at + 2, events->q, m->n * sizeof *at);
    memcpy(at + 2 + m->n, events->v, m->n * sizeof *at);
    return 0;
}

void EXPORT(live_free)(struct live *m)
{
    if (!m)
        return;
    free(m->block);
    free(m->events_block);
    free(m->aside_block);
    free(m->crossings);
    free(m->q);
    free(m);
}

static int has(const struct live *m, unsigned trait) { return (m->it.method->traits & trait) != 0; }

static void keep(struct live *m, double t, const double *q, const double *v)
{
    m->t = t;
    memcpy(m->q, q, m->it.n_q * sizeof *q);
    memcpy(m->v, v, m->n * sizeof *v);
}

const struct pk_method *live_method(const char *name)
{
    for (size_t i = 0; i < live_own_count; i++)
        if (!strcmp(live_own[i]->name, name))
            return live_own[i];
    return pk_method_find(name);
}

/* Returns a motion, or NULL with a reason if an argument is refused. The method chooses the first
 * step size if h is 0. The caller keeps params alive while it uses the motion. */
struct live *EXPORT(live_new)(const void *params, const char *method, double h, double rtol,
                              double t, const double *q, const double *v, const double *u)
{
    struct live *m = (struct live *)calloc(1, sizeof *m);
    struct pk_options options = pk_options_default();
    const struct pk_problem problem = {
        .system = live_system, .params = params, .input = give_inputs, .context = m};
    const struct pk_method *const found = live_method(method);
    const char *const why = !m                         ? "there is no memory"
                            : !found                   ? "there is no such method"
                            : !(isfinite(h) && h >= 0) ? "the step must be positive and finite"
                            : !(isfinite(rtol) && rtol > 0)
                                ? "the tolerance rtol must be positive and finite"
                                : NULL;
    if (why) {
        free(m);
        refuse(why);
        return NULL;
    }
    options.h = h;
    options.max_steps = 0;
    options.rtol = rtol;
    m->n = pk_system_count(live_system, params);
    m->n_inputs = live_system->n_inputs;
    m->size = pk_integrator_size(&problem, found);
    m->q = (double *)calloc(4 * m->n + m->n_inputs + 1, sizeof *m->q);
    m->block = calloc(1, m->size + 1);
    const size_t events_size = pk_events_size(&problem, found);
    m->events_block = calloc(1, events_size + 1);
    if (!m->q || !m->block || !m->events_block) {
        live_free(m);
        refuse("there is no memory");
        return NULL;
    }
    m->v = m->q + m->n;
    m->q0 = m->v + m->n;
    m->v0 = m->q0 + m->n;
    m->u = m->v0 + m->n;
    m->t0 = t;
    memcpy(m->q0, q, m->n * sizeof *q);
    memcpy(m->v0, v, m->n * sizeof *v);
    if (m->n_inputs)
        memcpy(m->u, u, m->n_inputs * sizeof *u);
    if (pk_integrator_init(&m->it, &problem, found, &options, t, q, v, m->block, m->size) < 0) {
        pk_integrator_reason(&m->it, live_reason_text, LONGEST_TEXT);
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
    m->from = t;
    keep(m, t, m->it.q, m->it.v);
    return m;
}

/* Makes the second integrator `aside`, which computes states within a step. It starts at the
 * initial state, since another state might be refused as a start. Returns 0 if that fails. */
static int make_aside(struct live *m)
{
    struct pk_problem problem = m->it.problem;
    if (m->events.sides) /* these params hold the sides of the switches */
        problem.params = m->events.params;
    m->aside_block = calloc(1, m->size + 1);
    return m->aside_block && pk_integrator_init(&m->aside, &problem, m->it.method, &m->it.options,
                                                m->t0, m->q0, m->v0, m->aside_block, m->size) >= 0;
}

/* Computes the state at t within the last step, by dense output or by a shorter step aside. */
static enum pk_status within(struct live *m, double t)
{
    if (pk_integrator_is_at(&m->it, t)) {
        keep(m, t, m->it.q, m->it.v);
        return PK_DONE;
    }
    if (has(m, PK_DENSE))
        return pk_integrator_dense(&m->it, m->t = t, m->q, m->v);
    if (!m->aside_block && !make_aside(m))
        return m->it.status = m->aside.own || m->aside.status ? m->aside.status : PK_NO_MEMORY;
    m->aside.options.h = m->it.options.h;
    const enum pk_status found = pk_integrator_aside(&m->it, &m->aside, t);
    if (found >= 0)
        keep(m, t, m->aside.q, m->aside.v);
    return found;
}

/* The last step ended at the event that stops the motion, perhaps beyond t. Returns 0 with the
 * state at t if that is before the event, else 2 with the event's state, or a failure's status. */
static int at_stop(struct live *m, double t)
{
    if (!(t < m->it.t) || pk_integrator_is_at(&m->it, t)) {
        keep(m, m->it.t, m->it.q, m->it.v);
        return 2;
    }
    if (!m->aside_block && !make_aside(m))
        return m->it.status = m->aside.own || m->aside.status ? m->aside.status : PK_NO_MEMORY;
    m->aside.options.h = m->it.options.h;
    if (pk_integrator_reset(&m->aside, m->events.from, m->events.q0, m->events.v0) < 0 ||
        pk_integrator_to(&m->aside, t) < 0)
        return m->it.status = m->aside.status;
    keep(m, t, m->aside.q, m->aside.v);
    return 0;
}

/* Integrates to t by at most `budget` steps. Returns 0 at t, 1 if more steps are needed, otherwise
 * a status (negative or above 1). t does not affect the steps: the state at t comes from dense
 * output or a shorter step aside. A time before the last step is refused, since no state is kept
 * there. */
int EXPORT(live_to)(struct live *m, double t, double budget)
{
    struct pk_integrator *it = &m->it;
    const double far = t + 1e9 * (fabs(t) + 1);
    const int fixed = !has(m, PK_ADAPTIVE | PK_DENSE);
    m->is_refused = !isfinite(t) || t < m->from;
    if (m->is_refused) {
        m->refused = t;
        return PK_BAD_ARGUMENT;
    }
    if (m->stopped)
        return at_stop(m, t);
    while (it->t < t && !pk_integrator_is_at(it, t)) {
        if (budget-- <= 0)
            return 1;
        const double limit = fixed ? pk_integrator_limit(it, t, far) : far;
        m->from = it->t;
        const enum pk_status status = pk_events_step(&m->events, it, limit);
        if (status == PK_STOPPED_EVENT) {
            m->stopped = 1;
            return at_stop(m, t);
        }
        if (status != PK_DONE) {
            if (it->t < t)
                keep(m, it->t, it->q, it->v);
            return status;
        }
    }
    const enum pk_status status = within(m, t);
    if (status == PK_BAD_ARGUMENT) { /* the step ended at a switch: the state at its end serves */
        keep(m, it->t, it->q, it->v);
        return 0;
    }
    return status < 0 ? status : 0;
}

const char *EXPORT(live_reason)(struct live *m)
{
    if (!m->is_refused)
        pk_integrator_reason(&m->it, live_reason_text, LONGEST_TEXT);
    else if (!isfinite(m->refused))
        refuse("the time to go to is not finite");
    else
        snprintf(
            live_reason_text, LONGEST_TEXT,
            "a motion goes forward: t = %.17g is before its last step, which began at t = %.17g",
            m->refused, m->from);
    return live_reason_text;
}

double EXPORT(live_t)(const struct live *m) { return m->t; }

const double *EXPORT(live_q)(const struct live *m) { return m->q; }

const double *EXPORT(live_v)(const struct live *m) { return m->v; }

double EXPORT(live_steps)(const struct live *m) { return (double)m->it.count.steps; }

double EXPORT(live_evaluations)(const struct live *m) { return (double)m->it.count.evaluations; }

/* Crossings since the last call: event, t, q, v of each. */
const double *EXPORT(live_crossings)(const struct live *m) { return m->crossings; }

size_t EXPORT(live_take_crossings)(struct live *m)
{
    const size_t count = m->n_crossings;
    m->n_crossings = 0;
    return count;
}

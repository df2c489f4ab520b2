/* Integration of motions: see pk_host.h. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <pk/act.h>
#include <pk/events.h>
#include <pk/integrator.h>

#include "pk_host.h"

enum { MOST_CROSSINGS = 1 << 16 }; /* maximum number of recorded crossings */

struct pk_host_motion {
    struct pk_integrator it, aside;
    struct pk_events events;
    struct pk_actor actor;
    void *block, *events_block, *aside_block;
    size_t size, n_q, n, n_inputs;
    double t, *y;      /* the current state of the motion */
    double t0, *y0;    /* the initial state */
    double *u;         /* inputs, the modes of contacts among them */
    double *acts;      /* memory of the actor, or NULL */
    double *crossings; /* rows of event index, t, y */
    size_t n_crossings, room;
    int stopped; /* nonzero after an event that ends the motion */
    double from; /* time at which the last step began */
};

static void give_inputs(void *context, pk_real t, pk_real *u)
{
    const struct pk_host_motion *m = (const struct pk_host_motion *)context;
    (void)t;
    memcpy(u, m->u, m->n_inputs * sizeof *u);
}

static void state(const struct pk_host_motion *m, double *y, const double *q, const double *v)
{
    memcpy(y, q, m->n_q * sizeof *y);
    memcpy(y + m->n_q, v, m->n * sizeof *y);
}

static void keep(struct pk_host_motion *m, double t, const struct pk_integrator *it)
{
    m->t = t;
    state(m, m->y, it->q, it->v);
}

static int cross(void *context, const struct pk_events *events)
{
    struct pk_host_motion *m = (struct pk_host_motion *)context;
    const size_t width = 2 + m->n_q + m->n;
    const int acts = m->acts ? pk_actor_note(&m->actor, events) : 0;
    if (m->n_crossings == m->room && m->room < MOST_CROSSINGS) {
        const size_t room = m->room ? 2 * m->room : 16;
        double *const grown = (double *)realloc(m->crossings, room * width * sizeof *grown);
        if (grown) {
            m->crossings = grown;
            m->room = room;
        }
    }
    if (m->n_crossings == m->room)
        return acts;
    double *const at = m->crossings + width * m->n_crossings++;
    at[0] = (double)events->which;
    at[1] = events->t;
    state(m, at + 2, events->q, events->v);
    return acts;
}

void pk_host_free(struct pk_host_motion *m)
{
    if (!m)
        return;
    free(m->block);
    free(m->events_block);
    free(m->aside_block);
    free(m->crossings);
    free(m->acts);
    free(m->y);
    free(m);
}

static int has(const struct pk_host_motion *m, unsigned trait)
{
    return (m->it.method->traits & trait) != 0;
}

const struct pk_method *pk_host_method(const char *name)
{
    for (size_t i = 0; i < pk_host_model.n_own; i++)
        if (!strcmp(pk_host_model.own[i]->name, name))
            return pk_host_model.own[i];
    return pk_method_find(name);
}

/* Frees the motion; sets the reason to `why` unless this is NULL. Returns NULL. */
static struct pk_host_motion *refused(struct pk_host_motion *m, const char *why)
{
    if (why)
        pk_host_refuse(why);
    pk_host_free(m);
    return NULL;
}

/* Makes the second integrator `aside`, which computes states within a step of the first. It starts
 * at the initial state of the motion, since the integrator might refuse to start at another state.
 * Returns PK_DONE or an error. */
static enum pk_status make_aside(struct pk_host_motion *m)
{
    struct pk_problem problem = m->it.problem;
    if (!m->aside_block) {
        if (m->events.sides) /* parameters in which the side of each switch is fixed */
            problem.params = m->events.params;
        m->aside_block = calloc(1, m->size + 1);
        if (!m->aside_block)
            return PK_NO_MEMORY;
        if (pk_integrator_init(&m->aside, &problem, m->it.method, &m->it.options, m->t0, m->y0,
                               m->y0 + m->n_q, m->aside_block, m->size) < 0)
            return m->aside.status;
    }
    m->aside.options.h = m->it.options.h;
    return PK_DONE;
}

/* Starts what changes the motion at once: contacts, and values after events. Returns 0 on a
 * failure. */
static int begin_contacts(struct pk_host_motion *m)
{
    const struct pk_problem *problem = &m->it.problem;
    const size_t reals = pk_actor_reals(problem);
    m->actor = (struct pk_actor){.system = problem->system, .params = problem->params};
    m->actor.u = m->u;
    m->actor.events = &m->events;
    if (!reals)
        return 1;
    m->acts = (double *)calloc(reals, sizeof *m->acts);
    if (!m->acts) {
        m->it.status = PK_NO_MEMORY;
        return 0;
    }
    return pk_actor_start(&m->actor, &m->it, m->acts) >= 0;
}

struct pk_host_motion *pk_host_motion_new(const void *params, const char *method, double h,
                                          double rtol, double t, const double *y, const double *u)
{
    struct pk_host_motion *m = (struct pk_host_motion *)calloc(1, sizeof *m);
    struct pk_options options = pk_options_default();
    const struct pk_problem problem = {
        .system = pk_host_model.system, .params = params, .input = give_inputs, .context = m};
    const struct pk_method *const found = pk_host_method(method);
    if (!m)
        return refused(m, "there is no memory");
    if (!found)
        return refused(m, "there is no such method");
    if (!(isfinite(h) && h >= 0))
        return refused(m, "the step must be positive and finite");
    if (!(isfinite(rtol) && rtol > 0))
        return refused(m, "the tolerance rtol must be positive and finite");
    options.h = h;
    options.max_steps = 0;
    options.rtol = rtol;
    m->n = pk_host_n(params);
    m->n_q = pk_host_coordinates(params);
    m->n_inputs = problem.system->n_inputs;
    m->size = pk_integrator_size(&problem, found);
    const size_t width = m->n_q + m->n, events_size = pk_events_size(&problem, found);
    m->y = (double *)calloc(2 * width + m->n_inputs + 1, sizeof *m->y);
    m->block = calloc(1, m->size + 1);
    m->events_block = calloc(1, events_size + 1);
    if (!m->y || !m->block || !m->events_block)
        return refused(m, "there is no memory");
    m->y0 = m->y + width;
    m->u = m->y0 + width;
    m->t0 = m->from = t;
    memcpy(m->y0, y, width * sizeof *y);
    if (m->n_inputs)
        memcpy(m->u, u, m->n_inputs * sizeof *u);
    if (pk_integrator_init(&m->it, &problem, found, &options, t, y, y + m->n_q, m->block, m->size) <
        0) {
        pk_integrator_reason(&m->it, pk_host_text, PK_HOST_TEXT);
        return refused(m, NULL);
    }
    if (pk_events_init(&m->events, &m->it, m->events_block, events_size) < 0)
        return refused(m, "the events of the model cannot be looked for");
    m->events.found = cross;
    m->events.context = m;
    if (!begin_contacts(m)) {
        pk_integrator_reason(&m->it, pk_host_text, PK_HOST_TEXT);
        return refused(m, NULL);
    }
    keep(m, t, &m->it);
    state(m, m->y0, m->it.q, m->it.v);
    if (m->acts && make_aside(m) < 0) /* later, other contacts hold */
        return refused(m, "the motion cannot be started twice");
    return m;
}

/* Computes the state at t within the last step, by dense output or by a shorter step of `aside`. */
static enum pk_status within(struct pk_host_motion *m, double t)
{
    if (pk_integrator_is_at(&m->it, t)) {
        keep(m, t, &m->it);
        return PK_DONE;
    }
    if (has(m, PK_DENSE))
        return pk_integrator_dense(&m->it, m->t = t, m->y, m->y + m->n_q);
    enum pk_status found = make_aside(m);
    if (found < 0)
        return m->it.status = found;
    found = pk_integrator_aside(&m->it, &m->aside, t);
    if (found >= 0)
        keep(m, t, &m->aside);
    return found;
}

/* Computes the state at t by steps of `aside` from the start of the last step. That step ended
 * at an event or a switch and has no dense output. In the steps of `aside` the sides of switches
 * are not fixed. */
static enum pk_status before_end(struct pk_host_motion *m, double t)
{
    const enum pk_status found = make_aside(m);
    if (found < 0)
        return m->it.status = found;
    const void *const held = m->aside.problem.params;
    m->aside.problem.params = m->it.problem.params;
    enum pk_status status =
        pk_integrator_reset(&m->aside, m->events.from, m->events.q0, m->events.v0);
    if (status >= 0)
        status = pk_integrator_to(&m->aside, t);
    m->aside.problem.params = held;
    if (status < 0)
        return m->it.status = status;
    keep(m, t, &m->aside);
    return PK_DONE;
}

/* Computes the state at t of a motion that an event has ended. Returns 0 if t is before the event;
 * 2 otherwise, with the state at the event; or a negative status. */
static int at_stop(struct pk_host_motion *m, double t)
{
    if (t < m->it.t && !pk_integrator_is_at(&m->it, t))
        return before_end(m, t);
    keep(m, m->it.t, &m->it);
    return 2;
}

/* Steps until the last step covers t. Returns PK_DONE, 1 after `budget` steps, or a failure. */
static int cover(struct pk_host_motion *m, double t, double budget)
{
    struct pk_integrator *const it = &m->it;
    const double far = t + 1e9 * (fabs(t) + 1);
    const int fixed = !has(m, PK_ADAPTIVE | PK_DENSE);
    /* A step that ends at a switch has no dense output: if there are switches, a step ends at t. */
    const double end = m->events.sides && has(m, PK_ADAPTIVE) ? t : far;
    while (m->actor.acting || (it->t < t && !pk_integrator_is_at(it, t))) {
        if (budget-- <= 0)
            return 1;
        enum pk_status status;
        if (m->actor.acting) {
            if (it->t > t) /* the change is after t: the motion before it is asked for first */
                break;
            status = pk_actor_run(&m->actor, it);
            m->from = it->t;
        } else {
            m->from = it->t;
            status = pk_events_step(&m->events, it, fixed ? pk_integrator_limit(it, t, far) : end);
            if (status == PK_STOPPED_EVENT && m->actor.acting)
                continue;
            status = pk_actor_act(&m->actor, it, status);
        }
        m->stopped = status == PK_STOPPED_EVENT;
        if (m->stopped)
            break;
        if (status != PK_DONE) {
            if (it->t < t)
                keep(m, it->t, it);
            return status;
        }
    }
    return PK_DONE;
}

int pk_host_to(struct pk_host_motion *m, double t, double budget)
{
    if (!isfinite(t))
        return pk_host_refuse("the time to go to is not finite"), PK_BAD_ARGUMENT;
    if (t < m->from) {
        snprintf(
            pk_host_text, PK_HOST_TEXT,
            "a motion goes forward: t = %.17g is before its last step, which began at t = %.17g", t,
            m->from);
        return PK_BAD_ARGUMENT;
    }
    int status = m->stopped ? PK_DONE : cover(m, t, budget);
    if (status == PK_DONE && m->stopped)
        status = at_stop(m, t);
    else if (status == PK_DONE) {
        enum pk_status found = m->actor.acting ? PK_BAD_ARGUMENT : within(m, t);
        if (found == PK_BAD_ARGUMENT) /* no dense output: the step ended at a switch */
            found = before_end(m, t);
        status = found < 0 ? found : 0;
    }
    if (status < 0 || status > 1)
        pk_integrator_reason(&m->it, pk_host_text, PK_HOST_TEXT);
    return status;
}

size_t pk_host_rows(struct pk_host_motion *m, size_t count, const double *times, double budget,
                    double *rows, int *status)
{
    const size_t width = m->n_q + m->n;
    for (size_t k = 0; k < count; k++) {
        *status = pk_host_to(m, times[k], budget);
        if (*status)
            return k;
        memcpy(rows + k * width, m->y, width * sizeof *rows);
    }
    return count;
}

const double *pk_host_u(const struct pk_host_motion *m) { return m->u; }

double pk_host_t(const struct pk_host_motion *m) { return m->t; }

const double *pk_host_y(const struct pk_host_motion *m) { return m->y; }

double pk_host_steps(const struct pk_host_motion *m) { return (double)m->it.count.steps; }

double pk_host_evaluations(const struct pk_host_motion *m)
{
    return (double)m->it.count.evaluations;
}

size_t pk_host_crossed(struct pk_host_motion *m)
{
    const size_t count = m->n_crossings;
    m->n_crossings = 0;
    return count;
}

const double *pk_host_crossings(const struct pk_host_motion *m) { return m->crossings; }

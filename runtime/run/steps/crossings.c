/* Makes steps that detect crossings of events and switches. At a crossing, they first write the
 * rows that are due earlier, then the row at the event; they may stop there. */

#include "steps.h"

static struct moment moment_of(const struct pk_events *e)
{
    return (struct moment){e->t, e->q, e->v};
}

/* Writes the rows that are due up to the switch. The step ends there, without dense output. */
static void switched(void *context, const struct pk_events *events)
{
    struct pk_run *run = context;
    const struct moment now = moment_of(events);
    const struct pk_system *system = run->problem.system;
    const size_t which = pk_system_switch(system, run->problem.params, events->which).which;
    observe_crossing(run, system->events.n + which, &now);
    run_due(run, events->t);
}

static int found(void *context, const struct pk_events *events)
{
    struct pk_run *run = context;
    const struct moment now = moment_of(events);
    observe_crossing(run, events->which, &now);
    if (run->acts)
        pk_actor_note(&run->actor, events);
    if (!run_due(run, events->t))
        return 1;
    if (run->settings.asked.at == events->which + 1) {
        run->at_event = 1;
        observe_row(run, &now);
        run->at_event = 0;
    }
    return run->write_failed || run->actor.acting;
}

static void doubtful(void *context, const struct pk_events *events)
{
    struct pk_run *run = context;
    const struct pk_system *system = run->problem.system;
    const size_t n = system->events.n, k = events->which;
    const size_t which = k < n ? k : n + pk_system_switch(system, run->problem.params, k - n).which;
    struct crossed *crossed = &run->crossed[which];
    if (crossed->doubts++ == 0)
        crossed->doubtful_t = events->t;
}

enum pk_run_code crossings_begin(struct pk_run *run)
{
    const struct pk_system *system = run->problem.system;
    const size_t m = system->events.n, all = m + system->switches.n;
    const size_t size = pk_events_size(&run->problem, run->settings.method);
    if (all == 0)
        return PK_RUN_DONE;
    struct memory *memory = &run->memory;
    run->crossed = memory_take(memory, all, sizeof *run->crossed);
    run->event_values =
        memory_take(memory, 2 * m + run->it.n_q + run->it.n, sizeof *run->event_values);
    for (size_t k = 0; k < all; k++)
        run->crossed[k].t = memory_take(memory, WATCH_TIMES, sizeof(pk_real));
    const enum pk_status status =
        pk_events_init(&run->events, &run->it, memory_take(memory, size, 1), size);
    if (status < 0) {
        run_say(run, "events: %s", pk_status_text(status));
        return PK_RUN_FAILED;
    }
    run->events.found = found;
    run->events.switched = switched;
    run->events.doubtful = doubtful;
    run->events.context = run;
    run->actor.events = &run->events;
    pk_real *const work = memory_take(memory, run->acts, sizeof *work);
    const int starts = !run->acts || pk_actor_start(&run->actor, &run->it, work) >= 0;
    return starts ? PK_RUN_DONE : PK_RUN_FAILED;
}

/* Notes for each event function g whether it has become clearly nonzero. If g is always zero up to
 * errors, as a constant of the motion may be, only these errors make it cross zero. The scale of g
 * is the largest |dg/dx_i| |x_i| over coordinates and rates x_i. */
static void note_leaving(struct pk_run *run)
{
    const struct pk_system *system = run->problem.system;
    const size_t n_q = run->it.n_q, n = run->it.n, m = system->events.n;
    const pk_real t = run->it.t, *u = run->settings.u;
    pk_real *g = run->event_values, *moved = g + m, *x = moved + m;
    int all = 1;
    for (size_t k = 0; k < m; k++)
        all &= run->crossed[k].leaves;
    if (all) /* also true if the system has no events, only switches */
        return;
    memcpy(x, run->it.q, n_q * sizeof *x);
    memcpy(x + n_q, run->it.v, n * sizeof *x);
    system->events.values(run->settings.params, t, x, x + n_q, u, g);
    for (size_t i = 0; i < n_q + n; i++) {
        const pk_real was = x[i], part = PK_C(1e-4);
        x[i] += part * was;
        system->events.values(run->settings.params, t, x, x + n_q, u, moved);
        x[i] = was;
        for (size_t k = 0; k < m; k++)
            run->crossed[k].parts =
                PK_F(fmax)(run->crossed[k].parts, PK_F(fabs)(moved[k] - g[k]) / part);
    }
    for (size_t k = 0; k < m; k++) {
        run->crossed[k].states++;
        run->crossed[k].leaves |= PK_F(fabs)(g[k]) > WATCH_NOISE * run->crossed[k].parts;
    }
}

enum pk_status crossings_step(struct pk_run *run, pk_real limit)
{
    if (!run->crossed)
        return pk_integrator_step(&run->it, limit);
    const enum pk_status status =
        pk_actor_act(&run->actor, &run->it, pk_events_step(&run->events, &run->it, limit));
    if (status >= 0)
        note_leaving(run);
    return status;
}

enum pk_status crossings_sample(struct pk_run *run)
{
    const struct pk_part_events *events = &run->problem.system->events;
    const struct settings *s = &run->settings;
    struct pk_integrator *it = &run->it;
    const size_t m = it->t > 0 && run->crossed ? events->n : 0;
    const int due = pk_sampler_is_due(&run->sampler, it);
    pk_real *before = run->event_values, *after = before + m;
    if (m)
        events->values(s->params, it->t, it->q, it->v, s->u, before);
    enum pk_status status = pk_sampler_run(&run->sampler, it);
    if (m && status >= 0)
        events->values(s->params, it->t, it->q, it->v, s->u, after);
    for (size_t k = 0; k < m && status >= 0; k++) {
        const int rises = !(before[k] > 0) && after[k] > 0,
                  falls = !(before[k] < 0) && after[k] < 0;
        if (!(rises && events->table[k].direction >= 0) &&
            !(falls && events->table[k].direction <= 0))
            continue;
        observe_crossing(run, k, run_moment(run));
        run->events.which = k;
        if (run->acts)
            pk_actor_note(&run->actor, &run->events);
        run->at_event = s->asked.at == k + 1;
        if (run->at_event)
            observe_row(run, run_moment(run));
        run->at_event = 0;
        if (events->table[k].stop == 1) {
            it->event = k + 1;
            status = it->status = PK_STOPPED_EVENT;
        }
    }
    /* other forces may let go what holds */
    const int acts = due && status >= 0 && (run->actor.acting || run->bare.contacts.n);
    return acts ? pk_actor_run(&run->actor, it) : status;
}

enum pk_status crossings_to(struct pk_run *run, pk_real t, int one_step, int seen)
{
    struct pk_integrator *it = &run->it;
    enum pk_status status = PK_DONE;
    seen |= run->acts > 0;
    if (run->bare.samples.n && t < it->t) {
        run_say(run, "a model with sample blocks goes forward in time");
        return PK_BAD_ARGUMENT;
    }
    do {
        if (run->bare.samples.n)
            status = seen ? crossings_sample(run) : pk_sampler_run(&run->sampler, it);
        const pk_real end = run->bare.samples.n ? pk_sampler_limit(&run->sampler, t) : t;
        if (status == PK_DONE && one_step)
            status = run->crossed
                         ? pk_actor_act(&run->actor, it, pk_events_step(&run->events, it, end))
                         : pk_integrator_step(it, end);
        else if (status == PK_DONE)
            status = run->crossed
                         ? pk_actor_act(&run->actor, it, pk_events_to(&run->events, it, end))
                         : pk_integrator_to(it, end);
    } while (status == PK_DONE && it->t < t && !one_step);
    if (run->bare.samples.n && status == PK_DONE)
        status = seen ? crossings_sample(run) : pk_sampler_run(&run->sampler, it);
    return status;
}

/* Makes one trajectory from the initial state to the end, row by row. */
#include <pk/adaptive_lanes.h>

#include "../settings/settings.h"
#include "checkpoint.h"

/* Steps per call of a system with singularities, which long steps may jump over. */
enum { CLOSE = 8 };

static int singular(const struct pk_run *run)
{
    return run->problem.system->singularities.values != NULL;
}

/* Makes many steps of a large system in one call, which takes about 0.1 s. The drifts of such a
 * system are measured at rows only. */
static enum pk_status many(struct pk_run *run, pk_real end)
{
    struct pk_integrator *it = &run->it;
    const unsigned long most = singular(run) ? CLOSE : (unsigned long)(50000000 / it->n) + 2;
    const pk_real next = run_wanted(run, it->t, run->settings.until);
    const pk_real whole = PK_F(floor)((next - it->t) / it->options.h);
    if (end > next && !(whole >= 2)) /* the next row is less than two steps away */
        return pk_integrator_step(it, end);
    return pk_integrator_steps(it, end,
                               end > next && whole < (pk_real)most ? (unsigned long)whole : most);
}

/* At one of settings.stops, recomputes inputs and restarts the method, since forces may jump. */
static void stop(struct pk_run *run)
{
    const struct pk_run_settings *x = &run->settings.asked;
    struct pk_integrator *it = &run->it;
    const size_t before = run->stops;
    while (run->stops < x->n_stops && (it->t >= (pk_real)x->stops[run->stops] ||
                                       pk_integrator_is_at(it, (pk_real)x->stops[run->stops])))
        run->stops++;
    if (run->stops == before)
        return;
    compute_inputs(&run->settings, it->t, it->q, it->v, 1);
    if (it->count.steps)
        pk_integrator_reset(it, it->t, it->q, it->v);
}

/* Runs the sample blocks that are due at the end of a step. Rows before it show the inputs of that
 * step. Returns 0 if the run must end. */
static int sample(struct pk_run *run)
{
    const struct pk_integrator *it = &run->it;
    if (!run->bare.samples.n || !pk_sampler_is_due(&run->sampler, it))
        return 1;
    return !(it->t > 0 && !run_due(run, it->t * (1 - 8 * PK_EPSILON))) &&
           crossings_sample(run) == PK_DONE;
}

static int fused(const struct pk_run *run)
{
    if (run->settings.asked.compute || run->settings.asked.tape)
        return 0;
    const struct pk_system *system = run->problem.system;
    return system->families.advance && run_fixed(run) && !system->events.n && !system->switches.n;
}

static int by_time(const struct pk_run *run)
{
    const struct settings *s = &run->settings;
    return s->has_every || (!s->asked.bare && !s->asked.at);
}

/* Returns how many fixed steps to make before the observers are called again. This is 1 if the
 * observers need every step, or a row is due soon; else up to the next multiple of LOOK. */
static unsigned long unseen(const struct pk_run *run)
{
    enum { ALL = 1024, LOOK = 16 };
    const struct pk_integrator *it = &run->it;
    const struct settings *s = &run->settings;
    const unsigned long steps = it->count.steps;
    if (steps < ALL || !run_fixed(run) || s->asked.compute || run->bare.samples.n || run->crossed ||
        s->asked.tape || s->asked.diagnose || s->asked.n_drifts || s->asked.n_expected || s->n_parts ||
        (by_time(run) && !(s->every > 0)))
        return 1;
    const pk_real left = run_wanted(run, it->t, s->until) - it->t;
    const unsigned long most = LOOK - steps % LOOK;
    return left > (pk_real)(most + 2) * it->options.h ? most : 1;
}

static enum pk_status steps(struct pk_run *run, pk_real end)
{
    const unsigned long count = unseen(run);
    return count > 1 ? pk_integrator_steps(&run->it, end, count) : crossings_step(run, end);
}

static int step(struct pk_run *run)
{
    struct pk_integrator *it = &run->it;
    stop(run);
    const pk_real end = run_limit(run), before = it->t - it->last_t;
    const enum pk_status status = fused(run) ? many(run, end) : steps(run, end);
    if (status < 0)
        return 0;
    if (pk_waits(it))
        return 1;
    const pk_real h = it->t - it->last_t; /* h is 0 after a stop at an event */
    /* If the next step is at least twice as long, the previous step was not limited by its error
     * but by the start, an event or a row; h_min ignores it. */
    if (before > 0 && h < 2 * before && (!(run->h_min > 0) || before < run->h_min))
        run->h_min = before;
    if (h > run->h_max)
        run->h_max = h;
    const int goes = sample(run);
    if (!run->lean && (!fused(run) || singular(run) || !(it->t < end)))
        observe_step(run, run_moment(run));
    return status == PK_DONE && goes && !run->write_failed;
}

/* Saves or restores all state on which the next step depends. */
static enum pk_status keep(struct pk_run *run, void *context, struct pk_keep *k)
{
    int aside = run->aside_block != NULL;
    (void)context;
    PK_KEEP(k, run->next);
    PK_KEEP(k, run->expecting);
    PK_KEEP(k, run->h_min);
    PK_KEEP(k, run->h_max);
    PK_KEEP(k, aside);
    if (run->bare.samples.n)
        pk_sampler_keep(&run->sampler, k);
    if (run->acts)
        pk_actor_keep(&run->actor, k);
    k->wrong |= !(run->next >= 0 && run->next <= run->count + 1) ||
                run->next > PK_F(floor)(run->next);
    enum pk_status status = pk_integrator_keep(&run->it, k);
    if (status >= 0 && run->crossed)
        status = pk_events_keep(&run->events, k);
    if (status >= 0 && aside && !run->aside_block)
        status = run_aside(run);
    return status >= 0 && aside ? pk_integrator_keep(&run->aside, k) : status;
}

/* Called between steps: polls, and writes checkpoints. Returns whether the run continues. */
static int goes_on(struct pk_run *run)
{
    const struct pk_integrator *it = &run->it;
    const struct control *control = run->settings.control;
    if (fused(run) || control->often < 2 || it->count.steps % control->often == 0 || control->stop)
        run->interrupted = run_stopped(run, (double)(it->t / run->settings.until));
    if (!run->settings.asked.members)
        checkpoint_look(run, keep, NULL);
    return !run->interrupted;
}

int run_starts(struct pk_run *run)
{
    const struct settings *s = &run->settings;
    if (!s->asked.members && !checkpoint_begin(run, keep, NULL))
        return 0;
    if (!run->checkpoint.resumed) {
        stop(run);
        if (!sample(run))
            return 0;
        /* in other cases, only the final row is written */
        if (by_time(run) && (s->has_every || !s->asked.members))
            observe_row(run, run_moment(run));
        observe_step(run, run_moment(run));
    }
    return run->it.t < s->until;
}

int run_goes(struct pk_run *run)
{
    const struct settings *s = &run->settings;
    if (!step(run))
        return 0;
    if (pk_waits(&run->it))
        return 1;
    if (!run_due(run, run->it.t))
        return 0;
    if (by_time(run) && !(s->every > 0))
        observe_row(run, run_moment(run));
    /* a run that has reached `until` cannot be interrupted any more */
    return run->it.t < s->until && goes_on(run);
}

void run_ends(struct pk_run *run)
{
    const struct pk_integrator *it = &run->it;
    if (run->checkpoint.refused)
        return;
    if (by_time(run) && it->status == PK_STOPPED_EVENT && (!run->rows || run->last_row < it->t))
        observe_row(run, run_moment(run));
    if (run->lean)
        observe_step(run, run_moment(run));
    observe_end(run);
}

void run_integrate(struct pk_run *run)
{
    for (int goes = run_starts(run); goes; goes = run_goes(run))
        ;
    run_ends(run);
}

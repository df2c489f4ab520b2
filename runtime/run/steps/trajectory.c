/* One trajectory: completes its settings, starts it, makes its steps, and frees its memory. */
#include "../observers/observers.h"
#include "../settings/settings.h"
#include "steps.h"

/* Completes the interval of rows, the fixed step, and whether steps end at rows. */
static enum pk_run_code settle(struct pk_run *run)
{
    struct settings *s = &run->settings;
    const int fixed = s->asked.members ? run->model->ensemble->fixed(s) : pk_is_fixed(s->method);
    settle_every(s);
    if ((!fixed || s->asked.members) && !(s->every > 0))
        return run_refuse(run, "every 0 (each step) is for one run of a method of a fixed step");
    if (!s->has_every && (s->asked.bare || s->asked.at))
        s->every = 0;
    const pk_real interval = s->every > 0 ? s->every : s->until, least = 10 * PK_EPSILON * s->until;
    if (!(interval > least) || (fixed && s->options.h > 0 && !(s->options.h > least)))
        return run_refuse(run, "every and step must be above the round-off of until, %.3g",
                          (double)least);
    run->next = 1;
    run->count = s->every > 0 ? run_intervals(s->until, s->every) : 0;
    s->has_step = s->options.h > 0;
    if (!s->has_step && (s->method->traits & PK_EXACT))
        s->options.h = interval;
    if (fixed && !(s->options.h > 0))
        return run_refuse(run, "method %s has a fixed step: give it by --step", s->method->name);
    if (fixed)
        s->options.h = s->asked.bare ? s->until / run_intervals(s->until, s->options.h)
                                     : run_step(interval, s->options.h);
    if (s->asked.land < 0)
        s->asked.land = s->method->dense_order < s->method->order;
    if (!(s->method->traits & PK_DENSE))
        s->asked.land = 1;
    return PK_RUN_DONE;
}

static enum pk_run_code start(struct pk_run *run)
{
    struct settings *s = &run->settings;
    run->problem = run_problem(run);
    const size_t size = pk_integrator_size(&run->problem, s->method);
    run->block = memory_take(&run->memory, size, 1);
    drift_begin(run, &run->problem);
    if (pk_integrator_init(&run->it, &run->problem, s->method, &s->options, 0, s->q, s->v,
                           run->block, size) < 0)
        return PK_RUN_FAILED;
    if (PK_SYSTEM_HAS(s->system, consistent)) {
        memcpy(s->q, run->it.q, run->it.n_q * sizeof *s->q);
        memcpy(s->v, run->it.v, run->it.n * sizeof *s->v);
    }
    run->sampler = (struct pk_sampler){.system = &run->bare,
                                       .params = s->params,
                                       .u = s->u,
                                       .replace = s->asked.sample ? run_sampled : NULL,
                                       .context = s};
    if (run->bare.samples.n &&
        pk_sampler_start(&run->sampler, &run->it, s->until,
                         memory_take(&run->memory, pk_sampler_reals(&run->bare), sizeof(pk_real))) <
            0)
        return PK_RUN_FAILED;
    run->acts = pk_actor_reals(&run->problem);
    run->actor = (struct pk_actor){.system = &run->bare, .params = s->params, .u = s->u};
    /* Without a given step size, steps are as long as the interval between rows, which may be too
     * long to detect events. method->resolved() returns an upper limit; for steps of half this
     * length the interpolant is good without extra steps. */
    if (run->problem.system->events.n && s->method->resolved && !s->has_step) {
        const pk_real most = s->method->resolved(&run->it) / 2, h = s->options.h;
        s->options.h = h > most ? h / run_intervals(h, most) : h;
        pk_integrator_set_step(&run->it, s->options.h);
    }
    return PK_RUN_DONE;
}

enum pk_run_code run_settle(struct pk_run *run)
{
    return run->settings.n_parts ? subsystems_choose(run) : settle(run);
}

enum pk_run_code run_begin(struct pk_run *run)
{
    observe_begin(run);
    if (run->settings.n_parts)
        return subsystems_begin(run);
    const enum pk_run_code code = start(run);
    return code ? code : crossings_begin(run);
}

void run_steps(struct pk_run *run)
{
    (run->settings.n_parts ? subsystems_integrate : run_integrate)(run);
}

void run_end(struct pk_run *run)
{
    pk_subsystems_free(&run->subsystems);
    pk_events_free(&run->events);
    pk_integrator_free(&run->it);
    pk_integrator_free(&run->aside);
    if (run->model->diagnose)
        run->model->diagnose->free(run);
    free(run->besides);
    run->besides = NULL;
}

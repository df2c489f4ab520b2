/* Blocks of coordinates, called parts, each with an integrator of its own. Adaptive steps end at
 * rows; fixed steps reach rows by a second integrator. run->it makes no steps: it holds the time,
 * the state and the summed counts. */
#include "checkpoint.h"

#include "../settings/settings.h"

/* Returns the method and options of part k; by default they are the run's. */
static struct pk_choice choice_of(const struct settings *s, size_t k)
{
    const struct pk_run_part none = {0}, *given = s->asked.parts ? &s->asked.parts[k] : &none;
    struct pk_choice c = {s->method, s->options};
    if (given->method)
        c.method = run_method_find(s->run->model, given->method);
    if (given->step > 0)
        c.options.h = (pk_real)given->step;
    if (given->rtol > 0)
        c.options.rtol = (pk_real)given->rtol;
    if (given->h_max > 0)
        c.options.h_max = (pk_real)given->h_max;
    return c;
}

enum pk_run_code subsystems_choose(struct pk_run *run)
{
    struct settings *s = &run->settings;
    const char *none = s->asked.members      ? "ensembles"
                       : s->system->events.n ? "events"
                       : s->asked.diagnose   ? "diagnostics"
                       : s->asked.land == 0  ? "dense rows"
                                             : NULL;
    settle_every(s);
    if (!none && !(s->every > 10 * PK_EPSILON * s->until))
        none = "rows at each step";
    if (none)
        return run_refuse(run, "blocks integrated apart have no %s", none);
    s->asked.land = 1;
    run->count = run_intervals(s->until, s->every);
    run->choices = memory_take(&run->memory, s->n_parts, sizeof *run->choices);
    for (size_t k = 0; k < s->n_parts; k++) {
        struct pk_choice *c = &run->choices[k];
        *c = choice_of(s, k);
        if (c->method->traits & PK_ADAPTIVE)
            continue;
        if (!(c->options.h > 0) && (c->method->traits & PK_EXACT))
            c->options.h = s->every;
        if (!(c->options.h > 10 * PK_EPSILON * s->until))
            return run_refuse(run, "part %zu: method %s has a fixed step: give it by --step", k + 1,
                              c->method->name);
        c->options.h = run_step(s->every, c->options.h);
    }
    return PK_RUN_DONE;
}

/* Copies time, state, status and summed counts to run->it, for rows, drifts and the report. */
static void look(struct pk_run *run)
{
    const struct pk_subsystems *a = &run->subsystems;
    struct pk_integrator *it = &run->it;
    it->problem = run->problem;
    it->method = run->settings.method;
    it->n_q = pk_coordinates_of(&run->problem);
    it->n = run->settings.n;
    it->t = a->t;
    it->q = a->q;
    it->v = a->v;
    it->status = a->status;
    memset(&it->count, 0, sizeof it->count);
    for (size_t k = 0; a->parts && k < a->count; k++) {
        const struct pk_counters *c = &a->parts[k].it.count;
        it->count.steps += c->steps;
        it->count.rejections += c->rejections;
        it->count.evaluations += c->evaluations;
        it->count.jacobians += c->jacobians;
        it->count.factorisations += c->factorisations;
        it->count.iterations += c->iterations;
        it->count.held += c->held;
    }
}

enum pk_run_code subsystems_begin(struct pk_run *run)
{
    struct settings *s = &run->settings;
    run->problem = run_problem(run);
    const size_t size = pk_subsystems_size(&run->problem, s->parts, run->choices, s->n_parts);
    run->block = memory_take(&run->memory, size, 1);
    drift_begin(run, &run->problem);
    const enum pk_status status = pk_subsystems_init(&run->subsystems, &run->problem, s->parts,
                                                     run->choices, s->n_parts, 0, s->q, s->v,
                                                     run->block, size);
    look(run);
    return status < 0 ? PK_RUN_FAILED : PK_RUN_DONE;
}

/* Updates the energy scale of part k at each of its steps. Rows may be too few: if a motion is
 * recorded at its turning points only, it seems to be at rest. */
static void stepped(void *context, size_t k)
{
    struct pk_run *run = context;
    const struct pk_integrator *it = &run->subsystems.parts[k].it;
    pk_monitor_update(&run->part_monitors[k], it->t, it->q, it->v);
}

static void scale(struct pk_run *run)
{
    pk_real sum = 0;
    for (size_t k = 0; k < run->settings.n_parts; k++)
        sum += run->part_monitors[k].energy.scale;
    if (run->monitor.has_energy && run->monitor.energy.scale < sum)
        run->monitor.energy.scale = sum;
}

static void watch_parts(struct pk_run *run)
{
    struct pk_subsystems *a = &run->subsystems;
    size_t size = 0;
    for (size_t k = 0; k < a->count; k++)
        size += pk_monitor_size(&a->parts[k].it.problem);
    run->part_monitors = memory_take(&run->memory, a->count, sizeof *run->part_monitors);
    char *block = memory_take(&run->memory, size, 1);
    for (size_t k = 0; k < a->count; k++) {
        const struct pk_problem *problem = &a->parts[k].it.problem;
        size = pk_monitor_size(problem);
        pk_monitor_init(&run->part_monitors[k], problem, block, size);
        block += size;
        stepped(run, k);
    }
    a->stepped = stepped;
    a->context = run;
}

static enum pk_status keep(struct pk_run *run, void *context, struct pk_keep *k)
{
    (void)context;
    PK_KEEP(k, run->next);
    const enum pk_status status = pk_subsystems_keep(&run->subsystems, k);
    for (size_t i = 0; i < run->subsystems.count; i++)
        pk_monitor_keep(&run->part_monitors[i], k);
    return status;
}

void subsystems_integrate(struct pk_run *run)
{
    const struct settings *s = &run->settings;
    struct pk_subsystems *a = &run->subsystems;
    watch_parts(run);
    run->next = 1;
    if (!checkpoint_begin(run, keep, NULL))
        return;
    look(run);
    if (!run->checkpoint.resumed) {
        observe_row(run, run_moment(run));
        observe_step(run, run_moment(run));
    }
    while (run->next <= run->count && !run->interrupted && !run->write_failed) {
        const pk_real t = run_row_time(run, run->next, run->count);
        while (a->t < t) {
            pk_subsystems_to(a, expect_limit(run, a->t, t), s->until);
            look(run);
            if (a->status != PK_DONE)
                return;
            scale(run);
            observe_step(run, run_moment(run));
        }
        struct moment now = *run_moment(run);
        now.t = t;
        observe_row(run, &now);
        run->next += 1;
        run->interrupted = run->next <= run->count && run_stopped(run, (double)(t / s->until));
        checkpoint_look(run, keep, NULL);
    }
    observe_end(run);
}

void subsystems_report(const struct pk_run *run, struct json *j)
{
    const struct pk_subsystems *a = &run->subsystems;
    if (!run->settings.parts)
        return;
    json_open(j, "parts", '[');
    for (size_t k = 0; a->parts && k < a->count; k++) {
        const struct pk_subsystem *part = &a->parts[k];
        const struct pk_choice *c = &run->choices[k];
        json_open(j, NULL, '{');
        json_open(j, "coordinates", '[');
        for (size_t i = 0; i < part->of.system->n; i++)
            json_text(j, NULL, part->of.system->coordinates[i].name);
        json_close(j, ']');
        const int adaptive = (c->method->traits & PK_ADAPTIVE) != 0;
        json_texts(j, {"method", c->method->name}, {"status", pk_status_name(part->it.status)});
        json_reals(j, {"t", part->it.t},
                   {adaptive ? "rtol" : "step", adaptive ? c->options.rtol : c->options.h});
        json_counts(j, {"steps", part->it.count.steps}, {"rejections", part->it.count.rejections},
                    {"evaluations", part->it.count.evaluations});
        json_close(j, '}');
    }
    json_close(j, ']');
}

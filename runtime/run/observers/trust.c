/* Determines up to which time a run can be trusted; an observer. See observers.h. */
#include <pk/methods.h>

#include "../settings/settings.h"
#include "observers.h"

#define OFF "the energy, which the motion keeps, is off by more than %g of its scale after t = %.9g"
#define LOOSE PK_C(1e-8)
#define JUDGE "dop853"
#define JUDGE_TOL PK_C(1e-9)

/* limit of the number of accelerations that judge() computes, about 1 s */
enum { MOST_VALUES = 5000000 };

static void step(struct pk_run *run, const struct moment *at)
{
    if (!run->looked || !run->monitor.has_energy || run->distrusted)
        return;
    /* A drift that is NaN counts as a wrong energy, too. */
    run->distrusted = !(pk_drift_max(&run->monitor.energy) <= TRUST_WRONG);
    if (!run->distrusted)
        run->trusted = at->t;
}

static void keep(struct pk_run *run, struct pk_keep *k)
{
    PK_KEEP(k, run->trusted);
    PK_KEEP(k, run->distrusted);
}

const struct observer trust_observer = {.step = step, .keep = keep};

/* Returns whether the failure may be due to the steps rather than the motion. */
static int doubtful(const struct pk_run *run)
{
    static const enum pk_status statuses[] = {PK_SINGULAR_MASS,        PK_SINGULAR_TIME,
                                              PK_SINGULAR_COORDINATES, PK_NOT_FINITE,
                                              PK_STEP_TOO_LONG,        PK_NO_PROJECTION};
    int found = 0;
    for (size_t i = 0; i < sizeof statuses / sizeof *statuses; i++)
        found |= run->it.status == statuses[i];
    return found && run->it.t > 0;
}

/* Integrates the same motion to t by the method JUDGE, and writes its end, or that there is
 * none. */
static void judge(struct pk_run *run, pk_real t, FILE *file)
{
    const struct settings *s = &run->settings;
    const struct pk_method *method = &pk_method_dop853;
    const size_t size = pk_integrator_size(&run->problem, method);
    struct pk_options options = pk_options_default();
    struct pk_integrator it;
    void *block = memory_take(&run->memory, size, 1);
    options.words = &run_options;
    options.rtol = JUDGE_TOL;
    options.max_steps = MOST_VALUES / (12 * s->n) + 1;
    enum pk_status status =
        pk_integrator_init(&it, &run->problem, method, &options, 0, s->q, s->v, block, size);
    if (status >= 0)
        status = pk_integrator_to(&it, t);
    if (status == PK_DONE && run->it.status < 0) {
        run->goes_on = 1;
        fprintf(file,
                "; by %s at %.0e the motion goes on to t = %.9g at least: only these steps end",
                JUDGE, (double)JUDGE_TOL, (double)t);
        /* the reason PK_STEP_TOO_LONG already contains this advice */
        if (run->it.status != PK_STEP_TOO_LONG)
            fprintf(file, ": make the step%s",
                    run_fixed(run) ? " shorter (--step)" : "s shorter (--step, --rtol)");
    }
    if (status <= PK_SINGULAR_MASS && status != PK_TOO_MANY_STEPS && status != PK_NO_MEMORY) {
        const int singular = status == PK_SINGULAR_TIME || status == PK_SINGULAR_COORDINATES;
        run->ends = singular ? it.reason.time : it.t;
        run->beyond = run->ends < run->it.t;
        fprintf(file, "; by %s at %.0e it ends at t = %.9g%s", JUDGE, (double)JUDGE_TOL,
                (double)run->ends, run->beyond ? ", so what follows is of the steps alone" : "");
    }
    pk_integrator_free(&it);
    memory_drop(&run->memory, block);
}

void trust_judge(struct pk_run *run)
{
    const int fixed = run_fixed(run), arrived = run->it.status >= 0;
    /* Fixed steps that arrive with a wrong energy may have passed the end of the motion. */
    if (run->settings.n_parts || run->bare.samples.n || run->bare.noise.n ||
        !(arrived ? fixed && run->distrusted && !run->interrupted : doubtful(run)))
        return;
    FILE *file = run_text(run, &run->besides);
    if (run->distrusted)
        fprintf(file, "; " OFF, (double)TRUST_WRONG, (double)run->trusted);
    if (fixed || run->settings.options.rtol > LOOSE)
        judge(run, run->it.t + (arrived ? 0 : 2 * (fixed ? run->settings.options.h : run->h_max)),
              file);
    run_text_end(run);
    run->beyond = run->beyond && arrived;
    if (arrived)
        run->besides[0] = '\0';
}

int trust_warning(const struct pk_run *run, char *text, size_t size)
{
    text[0] = '\0';
    if (!run->distrusted || run->it.status < 0 || run->beyond)
        return 0;
    return snprintf(text, size, OFF ": make the steps shorter (--step, --rtol)",
                    (double)TRUST_WRONG, (double)run->trusted) > 0;
}

pk_real trust_last_valid(const struct pk_run *run)
{
    return !run->beyond ? run->it.t : run->trusted < run->ends ? run->trusted : run->ends;
}

void trust_reason(const struct pk_run *run, char *text, size_t size)
{
    const struct pk_integrator *it = &run->it;
    char arrived[256], name[128];
    if (run->settings.n_parts) {
        pk_subsystems_reason(&run->subsystems, text, size);
        return;
    }
    pk_integrator_reason(it, text, size);
    /* If the motion goes on according to dop853, the singularity only ends these steps. */
    if (run->goes_on && (it->status == PK_SINGULAR_TIME || it->status == PK_SINGULAR_COORDINATES)) {
        pk_system_singularity_name(it->problem.system, it->problem.params, it->reason.index, name,
                                   sizeof name);
        snprintf(text, size, "the steps come to %s = 0 at t = %.17g; last valid time %.17g", name,
                 (double)it->reason.time, (double)it->t);
    }
    if (!run->beyond)
        return;
    if (it->status == PK_DONE)
        snprintf(arrived, sizeof arrived, "arrived at t = %.17g", (double)it->t);
    else
        pk_integrator_reason(it, arrived, sizeof arrived);
    snprintf(text, size,
             "%s, but the motion ends at t = %.9g (by %s at %.0e): rows after that are of the "
             "steps alone: make the step shorter (--step); last valid time %.17g",
             arrived, (double)run->ends, JUDGE, (double)JUDGE_TOL, (double)trust_last_valid(run));
}

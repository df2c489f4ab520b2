/* Advances a run step by step; see pk/run.h. */
#include <pk/run.h>

#include "settings/settings.h"
#include "steps/steps.h"

static void tell(struct pk_run *run)
{
    char reason[640];
    pk_integrator_reason(&run->it, reason, sizeof reason);
    run_say(run, "%s: %s", run->settings.method->name, reason);
}

static void begin(void *context)
{
    struct pk_run *run = context;
    struct settings *s = &run->settings;
    const int fixed = !(s->method->traits & (PK_ADAPTIVE | PK_EXACT));
    if (s->n_parts)
        run->code = run_refuse(run, "a model in parts is not integrated step by step");
    else if (fixed && !(s->options.h > 0))
        run->code = run_refuse(run, "a method of a fixed step: give it by --step");
    else
        run->code = run_begin(run);
    run->next = run->count + 1; /* the caller asks for states: no row is due */
    run->begun = run->code == PK_RUN_DONE;
    if (run->it.status < 0)
        tell(run);
}

enum pk_run_code pk_run_begin(struct pk_run *run)
{
    if (!run->code && !run->begun && !memory_try(&run->memory, begin, run))
        run->code = PK_RUN_FAILED;
    return run->code;
}

int pk_run_advance(struct pk_run *run, double t, int one_step, double *u, double *state)
{
    struct pk_integrator *it = &run->it;
    struct settings *s = &run->settings;
    enum pk_status status = run->begun ? PK_DONE : PK_BAD_ARGUMENT;
    int anew = 0;
    for (size_t i = 0; run->begun && i < s->system->n_inputs; i++) {
        if (s->system->samples.held && s->system->samples.held[i])
            continue;
        anew |= (double)s->u[i] < u[i] || (double)s->u[i] > u[i];
        s->u[i] = (pk_real)u[i];
    }
    if (anew && it->count.steps)
        status = pk_integrator_reset(it, it->t, it->q, it->v);
    if (status == PK_DONE)
        status = crossings_to(run, (pk_real)t, one_step, 1);
    if (!run->begun)
        return status;
    for (size_t i = 0; i < s->system->n_inputs; i++)
        u[i] = (double)s->u[i];
    if (status < 0)
        tell(run);
    *state++ = (double)it->t;
    for (size_t i = 0; i < it->n_q; i++)
        *state++ = (double)it->q[i];
    for (size_t i = 0; i < it->n; i++)
        *state++ = (double)it->v[i];
    return status;
}

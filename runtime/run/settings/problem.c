/* What follows from settings: the problem to be integrated, its quadratures, kinds of members. */
#include "settings.h"

const struct pk_words run_options = {
    .step = " (--step)",
    .rtol = " (--rtol)",
    .step_or_rtol = " (--step, --rtol)",
    .max_step = " (--max-step)",
    .max_steps = " (--max-steps)",
    .newton = " (--iteration newton)",
};

static void constant_input(void *context, pk_real t, pk_real *u)
{
    const struct settings *s = context;
    (void)t;
    memcpy(u, s->u, s->system->n_inputs * sizeof *u);
}

static int shows_quadratures(const struct settings *s)
{
    for (size_t i = 0; i < s->n_show; i++)
        if (s->show[i].kind == 'z')
            return 1;
    for (size_t i = 0; i < s->n_expected; i++)
        if (s->expected[i].of.a.kind == 'z' || s->expected[i].of.b.kind == 'z' ||
            s->expected[i].of.within.kind == 'z')
            return 1;
    return 0;
}

struct pk_problem run_problem(struct pk_run *run)
{
    struct settings *s = &run->settings;
    run->bare = *s->system;
    if (s->bare || !shows_quadratures(s))
        run->bare.quadratures.n = 0;
    if (s->bare)
        run->bare.events.n = 0;
    return (struct pk_problem){&run->bare, s->params, constant_input, s};
}

void settings_z(const struct settings *s, const void *params, pk_real *z)
{
    memset(z, 0, s->system->quadratures.n * sizeof *z);
    if (s->system->quadratures.start)
        s->system->quadratures.start(params, z);
    for (size_t i = 0; i < s->system->quadratures.n; i++)
        if (s->start_given[2 * s->n + i])
            z[i] = s->z[i];
}

enum pk_status run_quadratures(struct pk_run *run, struct pk_integrator *it)
{
    const struct settings *s = &run->settings;
    if (!it->z)
        return PK_DONE;
    pk_real *z = memory_take(s->memory, s->system->quadratures.n, sizeof *z);
    settings_z(s, it->problem.params, z);
    const enum pk_status status = pk_integrator_set_quadratures(it, z);
    memory_drop(s->memory, z);
    return status;
}

long member_number(const struct settings *s, size_t member)
{
    return s->first_member + (long)member;
}

int member_by_one(const struct settings *s) { return s->watch || s->system->switches.n > 0; }

int member_fixed(const struct settings *s)
{
    if (member_by_one(s))
        return !(s->method->traits & PK_ADAPTIVE);
    const struct pk_ensemble e = {.system = s->system, .method = s->method, .options = s->options};
    return pk_ensemble_fixed(&e);
}

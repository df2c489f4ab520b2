/* What follows from settings: the problem to be integrated, kinds of members. */
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

struct pk_problem run_problem(struct pk_run *run)
{
    struct settings *s = &run->settings;
    run->bare = *s->system;
    if (s->asked.bare)
        run->bare.events.n = 0;
    return (struct pk_problem){&run->bare, s->params, constant_input, s};
}

void settle_every(struct settings *s)
{
    s->has_every = s->every >= 0;
    if (!s->has_every)
        s->every = s->asked.members ? s->until : s->until / 1000;
    if (s->every > s->until)
        s->every = s->until;
}

long member_number(const struct settings *s, size_t member)
{
    return s->asked.first_member + (long)member;
}

int member_by_one(const struct settings *s)
{
    return s->asked.watch > 0 || s->system->switches.n > 0;
}

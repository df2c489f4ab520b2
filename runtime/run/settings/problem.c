/* Values derived from the settings: the struct pk_problem, computed inputs, and the numbers by
 * which rows and messages name members. */
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

static void see(const struct settings *s, const pk_real *q, const pk_real *v)
{
    const size_t n_q = settings_coordinates(s);
    for (size_t i = 0; q && i < n_q; i++)
        s->asked.seen[i] = (double)q[i];
    for (size_t i = 0; v && i < s->n; i++)
        s->asked.seen[n_q + i] = (double)v[i];
}

int run_sampled(void *context, size_t block, pk_real t, const pk_real *q, const pk_real *v,
                pk_real *next)
{
    const struct settings *s = context;
    double *u = s->asked.computed;
    see(s, q, v);
    for (size_t i = 0; i < s->system->n_inputs; i++)
        u[i] = (double)next[i];
    const int done = s->asked.sample(s->asked.context, (double)t, block);
    s->control->stop |= done < 0;
    for (size_t i = 0; i < s->system->n_inputs && done > 0; i++)
        next[i] = (pk_real)u[i];
    return done;
}

void compute_inputs(const struct settings *s, pk_real t, const pk_real *q, const pk_real *v,
                    int stop)
{
    const struct pk_run_settings *x = &s->asked;
    see(s, q, v);
    if (x->compute(x->context, (double)t, stop))
        s->control->stop = 1;
    for (size_t i = 0; i < s->system->n_inputs; i++)
        s->u[i] = (pk_real)x->computed[i];
}

void refresh_inputs(const struct settings *s, pk_real t, const pk_real *q, const pk_real *v)
{
    if (s->asked.compute && !s->asked.only_stops)
        compute_inputs(s, t, q, v, 0);
}

static void computed_at(void *context, pk_real t, const pk_real *q, const pk_real *v, pk_real *u)
{
    compute_inputs(context, t, q, v, 0);
    constant_input(context, t, u);
}

static void computed(void *context, pk_real t, pk_real *u)
{
    computed_at(context, t, NULL, NULL, u);
}

struct pk_problem run_problem(struct pk_run *run)
{
    struct settings *s = &run->settings;
    run->bare = *s->system;
    if (s->asked.bare && !s->system->resets.n && !s->system->contacts.n)
        run->bare.events.n = 0;
    if (s->asked.compute && !s->asked.only_stops)
        return (struct pk_problem){&run->bare, s->params, computed, s, computed_at};
    return (struct pk_problem){&run->bare, s->params, constant_input, s, NULL};
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
    return s->asked.watch > 0 || s->system->switches.n > 0 || s->system->samples.n > 0 ||
           s->system->resets.n > 0 || s->system->contacts.n > 0;
}

const struct pk_jacobian *run_jacobian_named(const struct pk_system *system, const char *name)
{
    const struct pk_part_sensitivity *all = &system->sensitivity;
    for (size_t k = 0; k < all->n; k++)
        if (strcmp(all->table[k].name, name) == 0)
            return &all->table[k];
    return NULL;
}

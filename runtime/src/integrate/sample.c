/* Runs sample blocks between steps; see pk/sample.h. */
#include <pk/sample.h>

#include "../core/internal.h"

size_t pk_sampler_reals(const struct pk_system *system)
{
    return system->n_inputs + 3 * system->samples.n;
}

enum pk_status pk_sampler_start(struct pk_sampler *s, struct pk_integrator *it, pk_real end,
                                pk_real *work)
{
    const struct pk_system *system = s->system;
    const size_t n = system->samples.n;
    s->next = work;
    s->times = s->next + system->n_inputs;
    s->done = s->times + 2 * n;
    if (!n)
        return PK_DONE;
    pk_zero(s->done, n);
    system->samples.start(s->params, 0, NULL, NULL, s->u, s->times, s->next);
    pk_copy(s->u, s->next, system->n_inputs);
    for (size_t k = 0; k < n; k++) {
        const pk_real period = s->times[2 * k], first = s->times[2 * k + 1];
        if (!(period > 10 * PK_EPS * end) || !(period <= PK_INFINITY) || !(first >= 0)) {
            it->reason = PK_WHY(.kind = BAD_PERIOD, .index = k, .value = period);
            return it->status = PK_BAD_ARGUMENT;
        }
    }
    return pk_integrator_reset(it, it->t, it->q, it->v);
}

static pk_real due(const struct pk_sampler *s, size_t k)
{
    return s->times[2 * k + 1] + s->done[k] * s->times[2 * k];
}

static int is_due(const struct pk_sampler *s, size_t k, const struct pk_integrator *it)
{
    return it->t >= due(s, k) || pk_integrator_is_at(it, due(s, k));
}

pk_real pk_sampler_limit(const struct pk_sampler *s, pk_real limit)
{
    for (size_t k = 0; k < s->system->samples.n; k++)
        limit = pk_min(limit, due(s, k));
    return limit;
}

int pk_sampler_is_due(const struct pk_sampler *s, const struct pk_integrator *it)
{
    int found = 0;
    for (size_t k = 0; k < s->system->samples.n; k++)
        found |= is_due(s, k, it);
    return found;
}

enum pk_status pk_sampler_run(struct pk_sampler *s, struct pk_integrator *it)
{
    const size_t m = s->system->n_inputs;
    int changed = 0;
    for (size_t k = 0; k < s->system->samples.n; k++) {
        if (!is_due(s, k, it))
            continue;
        pk_copy(s->next, s->u, m);
        if (!s->replace || !s->replace(s->context, k, it->t, it->q, it->v, s->next))
            s->system->samples.table[k].next(s->params, it->t, it->q, it->v, s->u, s->next);
        changed |= memcmp(s->u, s->next, m * sizeof *s->u) != 0;
        pk_copy(s->u, s->next, m);
        s->done[k] += 1;
    }
    if (!changed)
        return PK_DONE;
    /* the next step is as long as it would have been, since a first step is chosen too short */
    const pk_real h = pk_abs(it->own->h);
    const int adapts = it->method->traits & PK_ADAPTIVE && it->own->direction;
    const enum pk_status status = pk_integrator_reset(it, it->t, it->q, it->v);
    return status >= 0 && adapts && h > 0 ? pk_integrator_set_step(it, h) : status;
}

void pk_sampler_keep(struct pk_sampler *s, struct pk_keep *k)
{
    pk_keep(k, s->u, s->system->n_inputs * sizeof *s->u);
    pk_keep(k, s->done, s->system->samples.n * sizeof *s->done);
}

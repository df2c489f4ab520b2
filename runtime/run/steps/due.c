/* Rows and expectations that are due at given times, at ends of steps or within steps.
 *
 * Rows are at 0, DT, 2 DT, ..., and exactly at `until`. They do not change fixed steps: only the
 * last step before `until` or a switch is shorter, and a row within a step is computed by an extra,
 * shorter step from the same state. The steps of an adaptive method end at rows, unless its dense
 * output is as accurate as its steps: this is so for gauss, but dense output of dopri5 and dop853
 * loses digits at tight tolerances (measured in tests/runtime). */
#include "steps.h"

/* A quotient that exceeds an integer by less than the fraction 1e-12 counts as this integer. For
 * more than 1e9 intervals the fraction is that of round-off, as 1e-12 of it may be an interval. */
pk_real run_intervals(pk_real whole, pk_real part)
{
    const pk_real ratio = whole / part, round = 4 * PK_EPSILON;
    const pk_real slack = ratio < PK_C(1e9) && round < PK_C(1e-12) ? PK_C(1e-12) : round;
    const pk_real count = PK_F(ceil)(ratio * (1 - slack));
    return count < 1 ? 1 : count;
}

pk_real run_step(pk_real interval, pk_real h)
{
    const pk_real count = run_intervals(interval, h);
    return PK_F(fabs)(interval / count - h) <= PK_C(1e-12) * h ? interval / count : h;
}

const struct moment *run_moment(struct pk_run *run)
{
    run->now = (struct moment){run->it.t, run->it.q, run->it.v};
    return &run->now;
}

enum pk_status run_aside(struct pk_run *run)
{
    const struct pk_integrator *it = &run->it;
    const size_t size = pk_integrator_size(&it->problem, it->method);
    struct pk_problem problem = run->problem;
    if (run->events.params) /* run->events.params contain the current sides of the switches */
        problem.params = run->events.params;
    run->aside_block = memory_take(&run->memory, size, 1);
    return pk_integrator_init(&run->aside, &problem, it->method, &it->options, it->t, it->q, it->v,
                              run->aside_block, size);
}

/* Returns the state at t within the last step; q is NULL if it cannot be computed. */
static struct moment at(struct pk_run *run, pk_real t)
{
    struct pk_integrator *it = &run->it;
    const struct moment none = {t, NULL, NULL}, now = {t, it->q, it->v};
    pk_real *q = run->row, *v = q + it->n;
    if (pk_integrator_is_at(it, t))
        return now;
    if (!run_fixed(run)) {
        const struct moment dense = {t, q, v};
        return pk_integrator_dense(it, t, q, v) < 0 ? none : dense;
    }
    const enum pk_status begun = run->aside_block ? PK_DONE : run_aside(run);
    if (begun < 0) {
        it->status = begun;
        return none;
    }
    run->aside.options.h = it->options.h;
    const enum pk_status status = it->status;
    if (pk_integrator_aside(it, &run->aside, t) < 0)
        return none;
    it->status = status;
    return (struct moment){t, run->aside.q, run->aside.v};
}

pk_real run_row_time(const struct pk_run *run, pk_real k, pk_real count)
{
    return k < count ? (pk_real)(double)(k * run->settings.every) : run->settings.until;
}

pk_real run_wanted(const struct pk_run *run, pk_real from, pk_real limit)
{
    const int rows = run->next <= run->count && run->settings.every > 0;
    const pk_real row = rows ? run_row_time(run, run->next, run->count) : limit;
    return expect_limit(run, from, row < limit ? row : limit);
}

/* Returns the next sample, or stop, where inputs are computed, or an earlier `limit`. */
static pk_real stop(const struct pk_run *run, pk_real limit)
{
    const struct pk_run_settings *x = &run->settings.asked;
    if (run->bare.samples.n)
        return pk_sampler_limit(&run->sampler, limit);
    const size_t k = run->stops;
    return k < x->n_stops && (pk_real)x->stops[k] < limit ? (pk_real)x->stops[k] : limit;
}

/* An adaptive step ends at the next expectation at the latest; with asked.land, at rows too. */
pk_real run_limit(const struct pk_run *run)
{
    const struct settings *s = &run->settings;
    if (!run_fixed(run))
        return stop(run, s->asked.land ? run_wanted(run, run->it.t, s->until)
                                       : expect_limit(run, run->it.t, s->until));
    const pk_real wanted = stop(run, run_wanted(run, run->it.t, s->until));
    return pk_integrator_limit(&run->it, wanted,
                               run->bare.samples.n ? stop(run, s->until) : s->until);
}

int run_due(struct pk_run *run, pk_real end)
{
    const struct settings *s = &run->settings;
    pk_real from = run->it.last_t, t = 0;
    const int now = !(end < run->it.t);
    for (; run->next <= run->count && s->every > 0; run->next += 1) {
        t = run_row_time(run, run->next, run->count);
        if (!(t <= end) && !(now && pk_integrator_is_at(&run->it, t)))
            break;
        const struct moment state = at(run, t);
        if (!state.q)
            return 0;
        observe_row(run, &state);
    }
    if (run->expecting < from)
        run->expecting = from;
    while (run_fixed(run) && (t = expect_limit(run, run->expecting, end)) < end &&
           !pk_integrator_is_at(&run->it, t)) {
        const struct moment state = at(run, t);
        if (!state.q)
            return 0;
        expect_landed(run, &state);
        run->expecting = t;
    }
    return 1;
}

/* Checks the expectations of a scene along its run; an observer. */
#include "observers.h"

#include "../settings/settings.h"

/* Returns whether `now` is worse than `before`; NaN is worse than any number. */
static int is_worst(int first, pk_real now, pk_real before)
{
    return first || (before - before == PK_C(0.0) && !(now <= before));
}

/* Checks the relation between a and b, and keeps the worst case. A NaN counts as a failure. */
static void compare(struct pk_run *run, struct expected *x, pk_real t, pk_real a, pk_real b,
                    pk_real within)
{
    const pk_real d = x->of.relation == '>' ? b - a : a - b;
    const pk_real off = x->of.relation == '=' ? PK_F(fabs)(d) - within : d;
    const int met = x->of.relation == '=' ? off <= 0 : off < 0;
    const int worst = is_worst(x->count == 0, off, x->off);
    x->count++;
    x->missed += !met;
    if (!worst)
        return;
    x->off = off;
    x->value = a;
    x->bound = b;
    x->allowed = within;
    x->t = t;
    x->member = run->member;
}

static const pk_real *outputs(struct pk_run *run, const struct moment *at)
{
    const struct settings *s = &run->settings;
    refresh_inputs(s, at->t, at->q, at->v);
    if (s->system->n_observed)
        s->system->observe(s->params, at->t, at->q, at->v, s->u, run->expected);
    return run->expected;
}

/* Returns whether t equals `at` up to the round-off of a step that ends there. */
static int is_at(const struct pk_run *run, pk_real t, pk_real at)
{
    return PK_F(fabs)(t - at) <= 8 * PK_EPSILON * run->settings.until;
}

pk_real expect_limit(const struct pk_run *run, pk_real t, pk_real limit)
{
    pk_real next = limit;
    for (size_t i = 0; i < run->settings.asked.n_expected; i++) {
        const struct expected *x = &run->settings.expected[i];
        if (x->of.when == 't' && (pk_real)x->of.at < next && (pk_real)x->of.at > t &&
            !is_at(run, t, (pk_real)x->of.at) && !is_at(run, limit, (pk_real)x->of.at))
            next = (pk_real)x->of.at;
    }
    return next;
}

/* Checks all relations of one kind: `when` is t (time), e (event `event`) or r (rows). */
static void compare_all(struct pk_run *run, char when, size_t event, const struct moment *at)
{
    const pk_real *out = NULL;
    for (size_t i = 0; i < run->settings.asked.n_expected; i++) {
        struct expected *x = &run->settings.expected[i];
        if (x->of.when != when || (when == 'e' && x->of.event != event) ||
            (when == 't' && !is_at(run, at->t, (pk_real)x->of.at)))
            continue;
        if (!out)
            out = outputs(run, at);
        compare(run, x, at->t, rows_value(run, &x->of.a, at, out),
                rows_value(run, &x->of.b, at, out),
                x->of.within.kind ? rows_value(run, &x->of.within, at, out) : 0);
    }
}

void expect_landed(struct pk_run *run, const struct moment *at) { compare_all(run, 't', 0, at); }

static void row(struct pk_run *run, const struct moment *at) { compare_all(run, 'r', 0, at); }

static void event(struct pk_run *run, size_t which, const struct moment *at)
{
    compare_all(run, 'e', which, at);
}

static void step(struct pk_run *run, const struct moment *at)
{
    const pk_real *out = NULL;
    for (size_t i = 0; i < run->settings.asked.n_drifts; i++) {
        struct drifting *d = &run->settings.drifting[i];
        if (d->energy)
            continue;
        if (!out)
            out = outputs(run, at);
        pk_drift_update(&d->drift, at->t, out[d->output]);
    }
    expect_landed(run, at);
}

int expect_uses_h(const struct pk_run *run)
{
    for (size_t i = 0; i < run->settings.asked.n_drifts; i++)
        if (run->settings.drifting[i].energy)
            return run->settings.system->energy && run->settings.system->canonical;
    return 0;
}

int expect_lean(const struct pk_run *run)
{
    for (size_t i = 0; i < run->settings.asked.n_expected; i++)
        if (run->settings.expected[i].of.when == 't')
            return 0;
    return run->settings.asked.n_drifts == 0;
}

/* Records the drifts of the member that has ended, and resets them for the next one. */
static void end(struct pk_run *run)
{
    for (size_t i = 0; i < run->settings.asked.n_drifts; i++) {
        struct drifting *d = &run->settings.drifting[i];
        const struct pk_drift *drift = d->energy ? &run->monitor.energy : &d->drift;
        const pk_real max = drift->samples ? pk_drift_max(drift) : (pk_real)NAN;
        d->last = max;
        if (is_worst(!d->members, max, d->max)) {
            d->max = max;
            d->member = run->member;
        }
        d->members++;
        pk_drift_init(&d->drift);
    }
}

void expect_own(struct settings *s)
{
    const struct expected *expected = s->expected;
    const struct drifting *drifting = s->drifting;
    s->expected = memory_take(s->memory, s->asked.n_expected, sizeof *s->expected);
    s->drifting = memory_take(s->memory, s->asked.n_drifts, sizeof *s->drifting);
    for (size_t i = 0; i < s->asked.n_expected; i++)
        s->expected[i].of = expected[i].of;
    for (size_t i = 0; i < s->asked.n_drifts; i++) {
        s->drifting[i].energy = drifting[i].energy;
        s->drifting[i].output = drifting[i].output;
    }
}

void expect_merge(struct settings *all, const struct settings *one)
{
    for (size_t i = 0; i < all->asked.n_expected; i++) {
        struct expected *to = &all->expected[i];
        const struct expected *from = &one->expected[i];
        const unsigned long count = to->count + from->count, missed = to->missed + from->missed;
        if (from->count && is_worst(to->count == 0, from->off, to->off))
            *to = *from;
        to->count = count;
        to->missed = missed;
    }
    for (size_t i = 0; i < all->asked.n_drifts; i++) {
        struct drifting *to = &all->drifting[i];
        const struct drifting *from = &one->drifting[i];
        const size_t members = to->members + from->members;
        if (from->members && is_worst(to->members == 0, from->max, to->max))
            *to = *from;
        to->members = members;
    }
}

static void begin(struct pk_run *run)
{
    if (run->settings.asked.n_expected || run->settings.asked.n_drifts)
        run->expected = memory_take(
            &run->memory, pk_system_outputs(run->settings.system, run->settings.params) + 1,
            sizeof *run->expected);
}

void expect_report(const struct pk_run *run, struct json *j)
{
    const struct settings *s = &run->settings;
    json_open(j, "expects", '[');
    for (size_t i = 0; i < s->asked.n_expected; i++) {
        const struct expected *x = &s->expected[i];
        json_open(j, NULL, '{');
        json_counts(j, {"count", x->count}, {"missed", x->missed});
        json_reals(j, {"member", (pk_real)member_number(s, x->member)}, {"value", x->value},
                   {"bound", x->bound}, {"within", x->allowed}, {"t", x->t});
        json_close(j, '}');
    }
    json_close(j, ']');
    json_open(j, "expect_drifts", '[');
    for (size_t i = 0; i < s->asked.n_drifts; i++) {
        json_object(j, NULL, {"member", (pk_real)member_number(s, s->drifting[i].member)},
                    {"max", s->drifting[i].max});
    }
    json_close(j, ']');
}

/* Saves or restores the results; the relations come from the settings. */
static void keep(struct pk_run *run, struct pk_keep *k)
{
    for (size_t i = 0; i < run->settings.asked.n_expected; i++) {
        struct expected *x = &run->settings.expected[i];
        const struct pk_run_expected of = x->of;
        PK_KEEP(k, *x);
        x->of = of;
    }
    for (size_t i = 0; i < run->settings.asked.n_drifts; i++) {
        struct drifting *d = &run->settings.drifting[i];
        PK_KEEP(k, d->member);
        PK_KEEP(k, d->members);
        pk_drift_keep(&d->drift, k);
        PK_KEEP(k, d->max);
        PK_KEEP(k, d->last);
    }
}

const struct observer expect_observer = {.begin = begin,
                                         .step = step,
                                         .event = event,
                                         .row = row,
                                         .end = end,
                                         .report = expect_report,
                                         .keep = keep};

/* One trajectory from the start to the end, row by row.
 *
 * Rows are at 0, DT, 2 DT, ..., and exactly at `until`. A fixed step is shortened so that a whole
 * number of steps makes an interval, the last and shorter interval likewise. An adaptive method
 * lands on rows, or answers by its dense output where that is as accurate as its steps: that of
 * gauss is; dopri5's and dop853's lose digits at tight tolerances (measured in tests/runtime), so
 * they land.
 */
#include "ensemble.h"
#include "expect.h"
#include "trust.h"
#include "watch.h"

static void progress(const struct run *run, int force)
{
    run_progress(run, (double)(run->it.t / run->settings.until), force);
}

/* How many intervals of `every` cover `until`; a quotient that is whole up to round-off counts
 * as whole. Up to 1e-12 of it, yet never up to a whole interval of many. */
pk_real run_intervals(pk_real whole, pk_real part)
{
    const pk_real ratio = whole / part, round = 4 * PK_EPSILON;
    const pk_real slack = ratio < PK_C(1e9) && round < PK_C(1e-12) ? PK_C(1e-12) : round;
    const pk_real count = PK_F(ceil)(ratio * (1 - slack));
    return count < 1 ? 1 : count;
}

void run_sample(struct run *run)
{
    const struct pk_integrator *it = &run->it;
    pk_monitor_update(&run->monitor, it->t, it->q, it->v);
    expect_sample(run, it->t, it->q, it->v);
    expect_landed(run, it->t, it->q, it->v, it->z);
}

static int step(struct run *run, pk_real limit)
{
    struct pk_integrator *it = &run->it;
    const enum pk_status status = watch_step(run, expect_limit(run, limit));
    if (status < 0)
        return 0;
    const pk_real h = it->t - it->last_t; /* 0 at an event that stopped */
    if (h > 0 && (!(run->h_max > 0) || h < run->h_min))
        run->h_min = h;
    if (h > run->h_max)
        run->h_max = h;
    run_sample(run);
    trust_step(run);
    if (it->count.steps % 64 == 0)
        progress(run, 0);
    run->interrupted = run_interrupted();
    return status == PK_DONE && !run->interrupted && !run->write_failed;
}

/* Many steps of a large system at once: some 0.1 s of them. Drifts are measured where they end. */
static int steps(struct run *run, pk_real limit)
{
    struct pk_integrator *it = &run->it;
    const unsigned long many = (unsigned long)(50000000 / it->n) + 2;
    const pk_real end = expect_limit(run, limit);
    if (pk_integrator_steps(it, end, many) < 0)
        return 0;
    const pk_real h = it->t - it->last_t;
    if (run->h_max <= 0 || h < run->h_min)
        run->h_min = h;
    if (h > run->h_max)
        run->h_max = h;
    if (!(it->t < end))
        run_sample(run), trust_step(run);
    progress(run, 0);
    run->interrupted = run_interrupted();
    return !run->interrupted && !run->write_failed;
}

pk_real run_row_time(const struct run *run, pk_real k, pk_real count)
{
    return k < count ? (pk_real)(double)(k * run->settings.every) : run->settings.until;
}

static void integrate_landing(struct run *run)
{
    struct pk_integrator *it = &run->it;
    const pk_real count = run->count;
    const int fixed = !(run->settings.method->traits & PK_ADAPTIVE);
    for (pk_real k = 1; k <= count; k += 1) {
        const pk_real t = run_row_time(run, k, count);
        if (fixed && k >= count && count > 1) {
            /* A tail that is a whole interval but for the round-off of t keeps its step. */
            const pk_real tail = t - it->t, rounding = 4 * PK_EPSILON * t;
            if (tail < run->settings.every - rounding)
                pk_integrator_set_step(it, tail / run_intervals(tail, run->settings.options.h));
        }
        while (it->t < t)
            if (!(run->problem.system->advance ? steps(run, t) : step(run, t)))
                return;
        output_row(run, run->out, t, it->q, it->v, it->z);
    }
}

int run_dense_rows(struct run *run, pk_real end)
{
    const struct pk_integrator *it = &run->it;
    pk_real *q = run->row, *v = q + it->n;
    pk_real *z = v + it->n + run->problem.system->n_observed;
    for (; run->next <= run->count && run_row_time(run, run->next, run->count) <= end;
         run->next += 1) {
        const pk_real t = run_row_time(run, run->next, run->count);
        if (!(t < it->t))
            output_row(run, run->out, t, it->q, it->v, it->z);
        else if (pk_integrator_dense(&run->it, t, q, v) < 0 ||
                 (it->z && pk_integrator_dense_quadratures(&run->it, t, z) < 0))
            return 0;
        else
            output_row(run, run->out, t, q, v, z);
    }
    return 1;
}

static void integrate_dense(struct run *run)
{
    while (run->it.t < run->settings.until)
        if (!step(run, run->settings.until) || !run_dense_rows(run, run->it.t))
            return;
}

/* A row at each step, or with rows at events alone at none. */
static void integrate_steps(struct run *run)
{
    const int rows = run->settings.has_every || !run->settings.at;
    while (run->it.t < run->settings.until && step(run, run->settings.until))
        if (rows)
            output_row(run, run->out, run->it.t, run->it.q, run->it.v, run->it.z);
}

void run_integrate(struct run *run)
{
    const struct settings *s = &run->settings;
    const struct pk_integrator *it = &run->it;
    const int by_time = s->has_every || !s->at;
    if (by_time && (s->has_every || !s->ensemble)) /* of a member the final state alone */
        output_row(run, run->out, 0, it->q, it->v, it->z);
    run_sample(run);
    if (!by_time || !(s->every > 0))
        integrate_steps(run);
    else if (s->land)
        integrate_landing(run);
    else
        integrate_dense(run);
    if (by_time && it->status == PK_STOPPED_EVENT && run->last_row < it->t)
        output_row(run, run->out, it->t, it->q, it->v, it->z);
    expect_member(run, &run->monitor.energy);
}


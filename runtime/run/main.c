/* The program that `pkgen run` builds for a model: settings in, CSV out, a report beside it.
 * Linked with the generated C and with a definition of run_system, the model it is to run.
 *
 * Rows are at 0, DT, 2 DT, ..., and exactly at `until`. A fixed step is shortened so that a whole
 * number of steps makes an interval, the last and shorter interval likewise. An adaptive method
 * lands on rows, or answers by its dense output where that is as accurate as its steps: that of
 * gauss is; dopri5's and dop853's lose digits at tight tolerances (measured in tests/runtime), so
 * they land.
 *
 * Exit: 0 done; 2 wrong settings or output that cannot be written; 4 the numerics failed, or an
 * energy or observed value was no finite number in some row; 130 interrupted. Rows up to the last
 * valid time are always written first.
 */
#define _POSIX_C_SOURCE 200809L

#include <errno.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "chart.h"
#include "diagnose.h"
#include "ensemble.h"
#include "stability.h"
#include "watch.h"

static volatile sig_atomic_t interrupted;

static void on_interrupt(int number)
{
    (void)number;
    interrupted = 1;
}

int run_interrupted(void) { return interrupted; }

double run_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

void run_progress(const struct run *run, double part, int force)
{
    static double last;
    const double t = run_now();
    if (!run->settings.progress || (!force && t - last < 0.1))
        return;
    last = t;
    fprintf(stderr, "progress %.4g\n", part);
    fflush(stderr);
}

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

static int step(struct run *run, pk_real limit)
{
    struct pk_integrator *it = &run->it;
    const enum pk_status status = watch_step(run, limit);
    if (status < 0)
        return 0;
    const pk_real h = it->t - it->last_t; /* 0 at an event that stopped */
    if (h > 0 && (!(run->h_max > 0) || h < run->h_min))
        run->h_min = h;
    if (h > run->h_max)
        run->h_max = h;
    pk_monitor_update(&run->monitor, it->t, it->q, it->v);
    if (it->count.steps % 64 == 0)
        progress(run, 0);
    run->interrupted = interrupted;
    return status == PK_DONE && !interrupted && !run->write_failed;
}

/* Many steps of a large system at once: some 0.1 s of them. Drifts are measured where they end. */
static int steps(struct run *run, pk_real limit)
{
    struct pk_integrator *it = &run->it;
    const unsigned long many = (unsigned long)(50000000 / it->n) + 2;
    if (pk_integrator_steps(it, limit, many) < 0)
        return 0;
    const pk_real h = it->t - it->last_t;
    if (run->h_max <= 0 || h < run->h_min)
        run->h_min = h;
    if (h > run->h_max)
        run->h_max = h;
    if (!(it->t < limit))
        pk_monitor_update(&run->monitor, it->t, it->q, it->v);
    progress(run, 0);
    run->interrupted = interrupted;
    return !interrupted && !run->write_failed;
}

static pk_real row_time(const struct run *run, pk_real k, pk_real count)
{
    return k < count ? k * run->settings.every : run->settings.until;
}

static void integrate_landing(struct run *run)
{
    struct pk_integrator *it = &run->it;
    const pk_real count = run->count;
    const int fixed = !(run->settings.method->traits & PK_ADAPTIVE);
    for (pk_real k = 1; k <= count; k += 1) {
        const pk_real t = row_time(run, k, count);
        if (fixed && k >= count && count > 1) {
            /* A tail that is a whole interval but for the round-off of t keeps its step. */
            const pk_real tail = t - it->t, rounding = 4 * PK_EPSILON * t;
            if (tail < run->settings.every - rounding)
                pk_integrator_set_step(it, tail / run_intervals(tail, run->settings.options.h));
        }
        while (it->t < t)
            if (!(run->problem.system->advance ? steps(run, t) : step(run, t)))
                return;
        output_row(run, stdout, t, it->q, it->v);
    }
}

int run_dense_rows(struct run *run, pk_real end)
{
    const struct pk_integrator *it = &run->it;
    pk_real *q = run->row, *v = run->row + it->n;
    for (; run->next <= run->count && row_time(run, run->next, run->count) <= end;
         run->next += 1) {
        const pk_real t = row_time(run, run->next, run->count);
        if (!(t < it->t))
            output_row(run, stdout, t, it->q, it->v);
        else if (pk_integrator_dense(&run->it, t, q, v) < 0)
            return 0;
        else
            output_row(run, stdout, t, q, v);
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
            output_row(run, stdout, run->it.t, run->it.q, run->it.v);
}

/* Rows from the start to the end, which may be at an event. */
static void integrate(struct run *run)
{
    const struct settings *s = &run->settings;
    const struct pk_integrator *it = &run->it;
    const int by_time = s->has_every || !s->at;
    if (by_time)
        output_row(run, stdout, 0, it->q, it->v);
    pk_monitor_update(&run->monitor, 0, it->q, it->v);
    if (!by_time || !(s->every > 0))
        integrate_steps(run);
    else if (s->land)
        integrate_landing(run);
    else
        integrate_dense(run);
    if (by_time && it->status == PK_STOPPED_EVENT && run->last_row < it->t)
        output_row(run, stdout, it->t, it->q, it->v);
}

/* Settings that depend on one another: the recording interval, the fixed step, landing. */
static int choose(struct run *run)
{
    struct settings *s = &run->settings;
    const int fixed = s->ensemble ? ensemble_fixed(s) : !(s->method->traits & PK_ADAPTIVE);
    s->has_every = s->every >= 0;
    if (!s->has_every)
        s->every = s->ensemble ? s->until : s->until / 1000;
    if (s->every > s->until)
        s->every = s->until;
    if ((!fixed || s->ensemble) && !(s->every > 0)) {
        fprintf(stderr, "run: every 0 (each step) is for one run of a method of a fixed step\n");
        return 2;
    }
    if (s->at && !s->has_every)
        s->every = 0;
    const pk_real interval = s->every > 0 ? s->every : s->until;
    if (!(interval > 10 * PK_EPSILON * s->until) ||
        (fixed && s->options.h > 0 && !(s->options.h > 10 * PK_EPSILON * s->until))) {
        fprintf(stderr, "run: every and step must be above the round-off of until, %.3g\n",
                (double)(10 * PK_EPSILON * s->until));
        return 2;
    }
    run->next = 1;
    run->count = s->every > 0 ? run_intervals(s->until, s->every) : 0;
    if (fixed && !(s->options.h > 0)) {
        fprintf(stderr, "run: method %s has a fixed step: give it by --step\n", s->method->name);
        return 2;
    }
    if (fixed)
        s->options.h = interval / run_intervals(interval, s->options.h);
    if (s->land < 0)
        s->land = s->method->dense_order < s->method->order;
    if (!(s->method->traits & PK_DENSE))
        s->land = 1;
    return 0;
}

static int start(struct run *run)
{
    struct settings *s = &run->settings;
    const struct pk_system *system = run_system;
    run->problem = settings_problem(s);
    const size_t size = pk_integrator_size(&run->problem, s->method);
    const size_t monitor_size = pk_monitor_size(&run->problem);
    run->block = malloc(size ? size : 1);
    run->monitor_block = malloc(monitor_size ? monitor_size : 1);
    run->row = (pk_real *)calloc(2 * s->n + system->n_observed + 1, sizeof *run->row);
    if (!run->block || !run->monitor_block || !run->row) {
        fprintf(stderr, "run: out of memory\n");
        return 4;
    }
    pk_monitor_init(&run->monitor, &run->problem, run->monitor_block, monitor_size);
    if (pk_integrator_init(&run->it, &run->problem, s->method, &s->options, 0, s->q, s->v,
                           run->block, size) < 0)
        return 4;
    return 0;
}

static int finish(struct run *run, int code)
{
    char reason[512];
    errno = 0;
    if (!run->write_failed && (fflush(stdout) || ferror(stdout)))
        run->write_failed = errno ? errno : EIO;
    if (run->it.status < 0) {
        pk_integrator_reason(&run->it, reason, sizeof reason);
        fprintf(stderr, "run: %s: %s\n", run->settings.method->name, reason);
        code = run->it.status == PK_BAD_ARGUMENT ? 2 : 4;
    }
    if (run->it.status == PK_STOPPED_EVENT) {
        pk_integrator_reason(&run->it, reason, sizeof reason);
        fprintf(stderr, "run: %s\n", reason);
    }
    if (run->not_finite) {
        fprintf(stderr, "run: %s is not finite in %lu of %lu rows, first at t = %.17g\n",
                run->not_finite, run->bad_rows, run->rows, run->bad_t);
        code = code ? code : 4;
    }
    if (run->write_failed) {
        fprintf(stderr, "run: cannot write rows: %s\n", strerror(run->write_failed));
        code = 2;
    }
    if (run->interrupted) {
        fprintf(stderr, "run: interrupted at t = %.17g\n", (double)run->it.t);
        code = 130;
    }
    if (run->settings.report && output_report(run, run->settings.report) && code == 0)
        code = 2;
    return code;
}

int main(int argc, char **argv)
{
    static struct run run;
    static char buffer[1 << 16];
    if (argc == 2 && strcmp(argv[1], "--methods") == 0)
        return output_methods(stdout) ? 2 : 0;
    if (argc == 3 && strcmp(argv[1], "--chart") == 0)
        return chart_run(argv[2]);
    if (argc == 3 && strcmp(argv[1], "--stability") == 0)
        return stability_run(argv[2]);
    if (argc > 1) {
        fprintf(stderr, "run: settings come on standard input; the options are --methods, "
                        "--chart FILE and --stability FILE\n");
        return 2;
    }
    int code = settings_read(&run.settings, run_system, stdin);
    if (code == 0)
        code = choose(&run);
    if (code) {
        settings_free(&run.settings);
        return code;
    }
    setvbuf(stdout, buffer, _IOFBF, sizeof buffer);
    signal(SIGPIPE, SIG_IGN); /* a closed pipe is a write that fails, and is reported */
    signal(SIGINT, on_interrupt);
    const double began = run_now();
    if (run.settings.ensemble) {
        code = ensemble_run(&run, run.count);
        settings_free(&run.settings);
        return code;
    }
    code = start(&run);
    if (run.it.state) {
        output_header(&run, stdout);
        if (code == 0)
            code = watch_start(&run);
        if (code == 0)
            integrate(&run);
    }
    run.seconds = run_now() - began;
    code = diagnose_run(&run, code);
    progress(&run, 1);
    code = finish(&run, code);
    watch_free(&run);
    pk_integrator_free(&run.it);
    diagnose_free(&run);
    settings_free(&run.settings);
    free(run.block);
    free(run.monitor_block);
    free(run.row);
    return code;
}

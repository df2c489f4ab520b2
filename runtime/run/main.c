/* The program that `pkgen run` builds for a model: settings in, CSV out, a report beside it.
 * Linked with the generated C and with a definition of run_model, the model it is to run.
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

#include "apart.h"
#include "chart.h"
#include "choose.h"
#include "diagnose.h"
#include "ensemble.h"
#include "expect.h"
#include "stability.h"
#include "trust.h"
#include "watch.h"

static volatile sig_atomic_t interrupted;

static void on_interrupt(int number)
{
    (void)number;
    interrupted = 1;
}

int run_interrupted(void) { return interrupted; }
void run_interrupt(int whether) { interrupted = whether; }

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

/* Settings that depend on one another: the recording interval, the fixed step, landing. */
static int settle(struct run *run)
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
    s->has_step = s->options.h > 0;
    if (!s->has_step && (s->method->traits & PK_EXACT))
        s->options.h = interval;
    if (fixed && !(s->options.h > 0)) {
        fprintf(stderr, "run: method %s has a fixed step: give it by --step\n", s->method->name);
        return 2;
    }
    if (fixed)
        s->options.h = run_step(interval, s->options.h);
    if (s->land < 0)
        s->land = s->method->dense_order < s->method->order;
    if (!(s->method->traits & PK_DENSE))
        s->land = 1;
    return 0;
}

static int start(struct run *run)
{
    struct settings *s = &run->settings;
    const struct pk_system *system = run_model;
    if (!run->problem.system) /* that of a member is known */
        run->problem = settings_shows_z(s) ? settings_problem(s) : settings_motion(s);
    const size_t size = pk_integrator_size(&run->problem, s->method);
    const size_t monitor_size = pk_monitor_size(&run->problem);
    run->block = malloc(size ? size : 1);
    run->monitor_block = malloc(monitor_size ? monitor_size : 1);
    run->row = (pk_real *)calloc(
        2 * s->n + system->n_observed + system->n_quadratures + 1, sizeof *run->row);
    if (!run->block || !run->monitor_block || !run->row) {
        fprintf(stderr, "run: out of memory\n");
        return 4;
    }
    pk_monitor_init(&run->monitor, &run->problem, run->monitor_block, monitor_size);
    run->monitor.has_energy |= expect_uses_h(run);
    if (pk_integrator_init(&run->it, &run->problem, s->method, &s->options, 0, s->q, s->v,
                           run->block, size) < 0 ||
        settings_quadratures(s, &run->it) < 0)
        return 4;
    /* Steps as long as rows are apart may be too long to see events in. */
    if (system->n_events && s->method->resolved && !s->has_step) {
        const pk_real most = s->method->resolved(&run->it), h = s->options.h;
        s->options.h = h > most ? h / run_intervals(h, most) : h;
        pk_integrator_set_step(&run->it, s->options.h);
    }
    return 0;
}

int run_settle(struct run *run) { return run_parts ? apart_choose(run) : settle(run); }

int run_begin(struct run *run)
{
    const int code = run_parts ? apart_begin(run) : start(run);
    return code || run_parts ? code : watch_begin(run);
}

void run_rows(struct run *run) { (run_parts ? apart_integrate : run_integrate)(run); }

void run_free(struct run *run)
{
    apart_free(run);
    watch_free(run);
    pk_integrator_free(&run->it);
    diagnose_free(run);
    free(run->block);
    free(run->monitor_block);
    free(run->row);
    pk_integrator_free(&run->aside);
    free(run->aside_block);
    free(run->expected);
    free(run->besides);
}

static int finish(struct run *run, int code)
{
    char reason[640];
    code = output_rows_end(run, code);
    if (run->write_failed == EPIPE)
        return 0;
    trust_judge(run);
    watch_warn(run);
    if (run->it.status < 0 || run->beyond) {
        trust_reason(run, reason, sizeof reason);
        const char *name = run->settings.method->name;
        const int named = run_parts || strncmp(reason, name, strlen(name)) == 0; /* in the reason itself */
        fprintf(stderr, "run: %s%s%s%s\n", named ? "" : name, named ? "" : ": ", reason,
                run->besides ? run->besides : "");
        code = run->it.status == PK_BAD_ARGUMENT ? 2 : 4;
    }
    if (run->it.status == PK_STOPPED_EVENT && !run->beyond) {
        trust_reason(run, reason, sizeof reason);
        fprintf(stderr, "run: %s\n", reason);
    }
    if (trust_warning(run, reason, sizeof reason))
        fprintf(stderr, "run: warning: %s\n", reason);
    if (run->not_finite) {
        fprintf(stderr, "run: %s is not finite in %lu of %lu rows, first at t = %.17g\n",
                run->not_finite, run->bad_rows, run->rows, run->bad_t);
        code = code ? code : 4;
    }
    code = run->write_failed ? 2 : code;
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
    if (argc == 3 && strcmp(argv[1], "--choose") == 0)
        return choose_run(argv[2]);
    if (argc > 1) {
        fprintf(stderr, "run: settings come on standard input; the options are --methods, "
                        "--chart FILE, --stability FILE and --choose FILE\n");
        return 2;
    }
    int code = settings_read(&run.settings, run_model, stdin);
    if (code == 0)
        code = run_settle(&run);
    if (code) {
        settings_free(&run.settings);
        return code;
    }
    setvbuf(stdout, buffer, _IOFBF, sizeof buffer);
    signal(SIGPIPE, SIG_IGN); /* a closed pipe is a write that fails, and is reported, */
    signal(SIGXFSZ, SIG_IGN); /* so is a file that is as large as may be; */
    signal(SIGTTOU, SIG_IGN); /* a terminal is written to from the background */
    signal(SIGINT, on_interrupt);
    const double began = run_now();
    run.out = stdout;
    expect_begin(&run);
    if (run.settings.ensemble) {
        code = ensemble_run(&run, run.count);
        settings_free(&run.settings);
        return code;
    }
    code = run_begin(&run);
    if (code == 0 || run.it.state)
        output_header(&run, stdout);
    if (code == 0)
        run_rows(&run);
    run.seconds = run_now() - began;
    code = diagnose_run(&run, code);
    run_progress(&run, (double)(run.it.t / run.settings.until), 1);
    code = finish(&run, code);
    run_free(&run);
    settings_free(&run.settings);
    return code;
}

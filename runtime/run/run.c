/* One run from its settings to its report; see pk/run.h. */
#define _POSIX_C_SOURCE 200809L

#include <pk/stability.h>

#include "state.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "apart.h"
#include "diagnose.h"
#include "ensemble.h"
#include "observe.h"
#include "trust.h"
#include "watch.h"

#define SELDOM 16u       /* steps from one look at the clock to the next, where steps are short: */
#define SHORT 1e-3       /* seconds for all of them */
#define BETWEEN 0.1      /* seconds from one question to the next */
#define LAP_SECONDS 1e-3 /* so many runs that the clock's own cost is nothing */

static double seconds_of(clockid_t clock)
{
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

double run_now(void) { return seconds_of(CLOCK_MONOTONIC); }
double run_processor(void) { return seconds_of(CLOCK_THREAD_CPUTIME_ID); }

static volatile sig_atomic_t stops; /* all runs */

void pk_run_stop(int whether) { stops = whether; }

int run_ending(void *context)
{
    (void)context;
    return stops;
}

int run_stopped(struct run *run, double part)
{
    struct control *c = run->settings.control;
    c->stop |= stops;
    if (c->stop || !run->settings.polls)
        return c->stop;
    if (c->cap > 0 && run_processor() - c->began > c->cap)
        return c->slow = c->stop = 1;
    if (!c->poll)
        return 0;
    const double t = run_now();
    c->often = t - c->looked < SHORT ? SELDOM : 1;
    c->looked = t;
    if (t - c->last < BETWEEN)
        return 0;
    c->last = t;
    return c->stop = c->poll(c->context, part) != 0;
}

/* The recording interval, the fixed step, landing. */
static enum pk_run_code settle(struct run *run)
{
    struct settings *s = &run->settings;
    const int fixed = s->members ? ensemble_fixed(s) : !(s->method->traits & PK_ADAPTIVE);
    s->has_every = s->every >= 0;
    if (!s->has_every)
        s->every = s->members ? s->until : s->until / 1000;
    if (s->every > s->until)
        s->every = s->until;
    if ((!fixed || s->members) && !(s->every > 0)) {
        run_say(run, "every 0 (each step) is for one run of a method of a fixed step");
        return PK_RUN_USAGE;
    }
    if (!s->has_every && (s->bare || s->at))
        s->every = 0;
    const pk_real interval = s->every > 0 ? s->every : s->until;
    if (!(interval > 10 * PK_EPSILON * s->until) ||
        (fixed && s->options.h > 0 && !(s->options.h > 10 * PK_EPSILON * s->until))) {
        run_say(run, "every and step must be above the round-off of until, %.3g",
                (double)(10 * PK_EPSILON * s->until));
        return PK_RUN_USAGE;
    }
    run->next = 1;
    run->count = s->every > 0 ? run_intervals(s->until, s->every) : 0;
    s->has_step = s->options.h > 0;
    if (!s->has_step && (s->method->traits & PK_EXACT))
        s->options.h = interval;
    if (fixed && !(s->options.h > 0)) {
        run_say(run, "method %s has a fixed step: give it by --step", s->method->name);
        return PK_RUN_USAGE;
    }
    if (fixed)
        s->options.h = s->bare ? s->until / run_intervals(s->until, s->options.h)
                               : run_step(interval, s->options.h);
    if (s->land < 0)
        s->land = s->method->dense_order < s->method->order;
    if (!(s->method->traits & PK_DENSE))
        s->land = 1;
    return PK_RUN_DONE;
}

static enum pk_run_code start(struct run *run)
{
    struct settings *s = &run->settings;
    if (!run->problem.system) /* that of a member is known */
        run->problem = run_problem(run);
    const size_t size = pk_integrator_size(&run->problem, s->method);
    run->block = memory_take(&run->memory, size, 1);
    drift_begin(run, &run->problem);
    if (pk_integrator_init(&run->it, &run->problem, s->method, &s->options, 0, s->q, s->v,
                           run->block, size) < 0 ||
        run_quadratures(run, &run->it) < 0)
        return PK_RUN_FAILED;
    /* Steps as long as rows are apart may be too long to see events in. */
    if (run->problem.system->events.n && s->method->resolved && !s->has_step) {
        const pk_real most = s->method->resolved(&run->it), h = s->options.h;
        s->options.h = h > most ? h / run_intervals(h, most) : h;
        pk_integrator_set_step(&run->it, s->options.h);
    }
    return PK_RUN_DONE;
}

enum pk_run_code run_settle(struct run *run)
{
    return run->settings.n_parts ? apart_choose(run) : settle(run);
}

enum pk_run_code run_begin(struct run *run)
{
    observe_begin(run);
    if (run->settings.n_parts)
        return apart_begin(run);
    const enum pk_run_code code = start(run);
    return code ? code : watch_begin(run);
}

void run_steps(struct run *run) { (run->settings.n_parts ? apart_integrate : run_integrate)(run); }

void run_end(struct run *run)
{
    pk_apart_free(&run->apart);
    pk_events_free(&run->events);
    pk_integrator_free(&run->it);
    pk_integrator_free(&run->aside);
    diagnose_free(run);
    free(run->besides);
    run->besides = NULL;
}

static void tell_failure(struct run *run)
{
    char reason[640];
    const char *name = run->settings.method->name;
    trust_reason(run, reason, sizeof reason);
    const int named = run->settings.n_parts || strncmp(reason, name, strlen(name)) == 0;
    run_say(run, "%s%s%s%s", named ? "" : name, named ? "" : ": ", reason,
            run->besides ? run->besides : "");
}

/* What there is to say of one trajectory, and the code. */
static enum pk_run_code finish(struct run *run, enum pk_run_code code)
{
    char reason[640];
    code = rows_end(run, code);
    if (run->write_failed == EPIPE)
        return PK_RUN_DONE; /* who read them has read enough */
    if (!run->settings.bare && !run->settings.compared) {
        trust_judge(run);
        watch_warn(run);
    }
    if (run->it.status < 0 || run->beyond) {
        tell_failure(run);
        code = run->it.status == PK_BAD_ARGUMENT ? PK_RUN_USAGE : PK_RUN_FAILED;
    }
    if (run->it.status == PK_STOPPED_EVENT && !run->beyond) {
        trust_reason(run, reason, sizeof reason);
        run_say(run, "%s", reason);
    }
    if (trust_warning(run, reason, sizeof reason))
        run_say(run, "warning: %s", reason);
    if (run->not_finite) {
        run_say(run, "%s is not finite in %lu of %lu rows, first at t = %.17g", run->not_finite,
                run->bad_rows, run->rows, run->bad_t);
        code = code ? code : PK_RUN_FAILED;
    }
    code = run->write_failed ? PK_RUN_USAGE : code;
    if (run->interrupted && !run->control.slow) {
        run_say(run, "interrupted at t = %.17g", (double)run->it.t);
        code = PK_RUN_INTERRUPTED;
    }
    return code;
}

/* What stands for rows that are wanted and that there are none of. */
static void ends(struct run *run)
{
    const struct settings *s = &run->settings;
    const struct pk_integrator *it = &run->it;
    pk_real *z = run->row + 2 * s->n + s->system->n_observed;
    const struct moment start = {0, s->q, s->v, z}, now = run_moment(run);
    if (s->compared && s->at && run->begun && it->status >= 0 && !run->n_kept) {
        settings_z(s, s->params, z);
        observe_row(run, &start);
        observe_row(run, &now);
        run->rows = 0;
    }
    if (s->bare && !s->has_every && run->begun)
        observe_row(run, &now);
}

static enum pk_run_code one(struct run *run)
{
    const double began = run_now(), processor = run->control.began = run_processor();
    enum pk_run_code code = run_begin(run);
    if (code == PK_RUN_DONE || run->it.q)
        rows_header(run);
    run->begun = code == PK_RUN_DONE;
    if (run->begun)
        run_steps(run);
    run->processor = run_processor() - processor;
    run->seconds = run_now() - began;
    ends(run);
    code = diagnose_run(run, code);
    return finish(run, code);
}

/* Settings and where rows go; 0: there is no memory. */
static int take(struct run *run, const struct pk_run_model *model,
                const struct pk_run_settings *given)
{
    if (setjmp(run->memory.none))
        return 0;
    run->code = settings_take(run, model, given);
    if (run->code != PK_RUN_DONE || given->csv < 0)
        return 1;
    const int fd = dup(given->csv);
    run->out = fd < 0 ? NULL : fdopen(fd, "w");
    if (run->out)
        return 1;
    run_say(run, "cannot write rows: %s", strerror(errno == EINVAL ? EBADF : errno));
    run->code = PK_RUN_USAGE;
    return 1;
}

struct pk_run *pk_run_new(const struct pk_run_model *model, const struct pk_run_settings *settings)
{
    struct run *run = (struct run *)calloc(1, sizeof *run);
    if (run && take(run, model, settings))
        return (struct pk_run *)run;
    pk_run_free((struct pk_run *)run);
    return NULL;
}

enum pk_run_code pk_run_go(struct pk_run *of)
{
    struct run *run = (struct run *)of;
    if (run->code || run->control.began > 0)
        return run->code;
    if (setjmp(run->memory.none)) {
        static const char text[] = "out of memory\n";
        memory_end(&run->memory);
        run->said = NULL;
        run->kept = run->kept_low = NULL;
        run->n_kept = 0;
        run->report = strdup("{}");
        run->besides = strdup(text);
        return run->code = PK_RUN_FAILED;
    }
    run->code = run_settle(run);
    if (run->code)
        return run->code;
    run->code = run->settings.members ? ensemble_run(run) : one(run);
    return run->code;
}

size_t pk_run_rows(const struct pk_run *of, const double **rows, const double **low,
                   size_t *columns)
{
    const struct run *run = (const struct run *)of;
    *rows = run->kept;
    *low = run->kept_low;
    *columns = 1 + run->settings.n_show + (run->settings.members > 0);
    return run->n_kept;
}

const char *pk_run_report(struct pk_run *of)
{
    struct run *run = (struct run *)of;
    size_t size;
    const int known = run->report || !run->it.method; /* an ensemble has its own */
    FILE *file = known ? NULL : open_memstream(&run->report, &size);
    if (file) {
        report_run(run, file);
        fclose(file);
    }
    return run->report ? run->report : "{}";
}

const char *pk_run_given(struct pk_run *of)
{
    struct run *run = (struct run *)of;
    size_t size;
    FILE *file = run->told ? NULL : open_memstream(&run->told, &size);
    if (file) {
        settings_tell(&run->settings, file);
        fclose(file);
    }
    return run->told ? run->told : "{}";
}

const char *pk_run_messages(const struct pk_run *of)
{
    const struct run *run = (const struct run *)of;
    return run->said ? run->said : "";
}

int pk_run_refused(const struct pk_run *of) { return ((const struct run *)of)->refused; }

size_t pk_run_size(int which)
{
    static const size_t sizes[] = {sizeof(struct pk_run_settings), sizeof(struct pk_run_expected),
                                   sizeof(struct pk_run_part),
                                   sizeof(struct pk_stability_question)};
    return which >= 0 && which < 4 ? sizes[which] : 0;
}

/* Laps are longer until the clock shows them: under a limit of CPU time it goes by ticks of
 * milliseconds. */
double pk_run_laps(struct pk_run *of, double seconds)
{
    struct run *run = (struct run *)of;
    const struct settings *s = &run->settings;
    unsigned long block = 1;
    double best = 0, total = 0;
    do {
        const double began = run_processor();
        for (unsigned long k = 0; k < block; k++)
            if (stops || pk_integrator_reset(&run->it, 0, s->q, s->v) < 0 ||
                (run->crossed ? pk_events_to(&run->events, &run->it, s->until)
                              : pk_integrator_to(&run->it, s->until)) < 0)
                return 0;
        const double took = run_processor() - began;
        total += took;
        if (took < LAP_SECONDS)
            block *= 2;
        else if (!(best > 0) || took < best * (double)block)
            best = took / (double)block;
    } while (!(best > 0) || total < seconds);
    return best;
}

void pk_run_free(struct pk_run *of)
{
    struct run *run = (struct run *)of;
    if (!run)
        return;
    run_end(run);
    if (run->out)
        fclose(run->out);
    memory_end(&run->memory);
    free(run->report);
    free(run->told);
    free(run);
}

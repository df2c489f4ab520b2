/* One run from its settings to its report; see pk/run.h. */
#define _POSIX_C_SOURCE 200809L

#include "observers/condition.h"
#include "settings/settings.h"
#include "steps/steps.h"

/* The timed repetitions of a run take at least so long that reading the clock costs little. */
#define LAP_SECONDS 1e-3

static void tell_failure(struct pk_run *run)
{
    char reason[640];
    const char *name = run->settings.method->name;
    trust_reason(run, reason, sizeof reason);
    const int named = run->settings.n_parts || strncmp(reason, name, strlen(name)) == 0;
    run_say(run, "%s%s%s%s", named ? "" : name, named ? "" : ": ", reason,
            run->besides ? run->besides : "");
}

/* Writes the final messages of one trajectory. Returns the exit code. */
static enum pk_run_code finish(struct pk_run *run, enum pk_run_code code)
{
    char reason[640];
    code = rows_end(run, code);
    if (run->write_failed == EPIPE)
        return PK_RUN_DONE; /* the program to which the rows are piped has ended */
    if (!run->settings.asked.bare && !run->settings.asked.compared) {
        trust_judge(run);
        watch_warn(run);
        if (condition_warning(run->looking, reason, sizeof reason))
            run_say(run, "warning: %s", reason);
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
    if (run->acts && isfinite((double)run->actor.order_t)) {
        const struct pk_contact *table = run->bare.contacts.table;
        run_say(run,
                "warning: %s and %s strike at once at t = %.9g: what follows would differ if one "
                "struck first",
                table[(size_t)run->actor.order_of[0]].name,
                table[(size_t)run->actor.order_of[1]].name, (double)run->actor.order_t);
    }
    code = rows_told(run, code);
    if (run->interrupted && !run->control.slow) {
        run_say(run, "interrupted at t = %.17g", (double)run->it.t);
        code = PK_RUN_INTERRUPTED;
    }
    return code;
}

/* Writes the rows of runs that write none during their steps: of a bare run, the final state; of a
 * compared run whose event never occurred, the initial and final states. */
static void ends(struct pk_run *run)
{
    const struct settings *s = &run->settings;
    const struct pk_integrator *it = &run->it;
    const struct moment start = {0, s->q, s->v};
    if (s->asked.compared && s->asked.at && run->begun && it->status >= 0 && !run->n_kept) {
        observe_row(run, &start);
        observe_row(run, run_moment(run));
        run->rows = 0;
    }
    if (s->asked.bare && !s->has_every && run->begun)
        observe_row(run, run_moment(run));
}

/* Ends a run that has written a checkpoint; the resumed run writes the other messages. */
static enum pk_run_code leave(struct pk_run *run)
{
    const enum pk_run_code code = rows_end(run, PK_RUN_LEFT);
    if (code == PK_RUN_LEFT)
        run_say(run, "left at t = %.17g with the checkpoint %s", (double)run->it.t,
                run->settings.asked.checkpoint);
    return code;
}

static enum pk_run_code one(struct pk_run *run)
{
    const double began = run_now(), processor = run->control.began = run_processor();
    enum pk_run_code code = run_begin(run);
    run->checkpoint.began = began;
    if ((code == PK_RUN_DONE || run->it.q) && !run->settings.asked.resume)
        rows_header(run);
    run->begun = code == PK_RUN_DONE;
    if (run->begun)
        run_steps(run);
    run->processor += run_processor() - processor;
    run->seconds += run_now() - began;
    if (run->checkpoint.refused)
        return PK_RUN_USAGE;
    if (run->checkpoint.left)
        return leave(run);
    ends(run);
    if (run->model->diagnose)
        code = run->model->diagnose->run(run, code);
    return finish(run, code);
}

/* Converts the settings and opens the file of the rows. */
static void take(void *context)
{
    struct pk_run *run = context;
    const int fd = run->settings.asked.csv;
    run->code = settings_take(run);
    if (run->code || fd < 0 || run_open(run, fd))
        return;
    run->code = run_refuse(run, "cannot write rows: %s", strerror(errno == EINVAL ? EBADF : errno));
}

struct pk_run *pk_run_new(const struct pk_run_model *model, const struct pk_run_settings *settings)
{
    struct pk_run *run = calloc(1, sizeof *run);
    if (!run)
        return NULL;
    run->model = model;
    run->settings.asked = *settings;
    if (memory_try(&run->memory, take, run))
        return run;
    pk_run_free(run);
    return NULL;
}

static void go(void *context)
{
    struct pk_run *run = context;
    run->code = run_settle(run);
    if (!run->code)
        run->code = run->settings.asked.members ? run->model->ensemble->run(run) : one(run);
}

enum pk_run_code pk_run_go(struct pk_run *run)
{
    if (run->code || run->control.began > 0 || memory_try(&run->memory, go, run))
        return run->code;
    memory_end(&run->memory);
    run->kept = run->kept_low = run->members = NULL;
    run->tape = NULL;
    run->diagnostics = NULL;
    run->n_kept = 0;
    run->report = strdup("{}");
    run->told = run->told ? run->told : strdup("{}"); /* the settings were in this memory */
    run->said = NULL;
    return run->code = PK_RUN_FAILED;
}

size_t pk_run_rows(const struct pk_run *run, const double **rows, const double **low,
                   size_t *columns)
{
    *rows = run->kept;
    *low = run->kept_low;
    *columns = run_width(run);
    return run->n_kept;
}

size_t pk_run_members(const struct pk_run *run, const double **numbers, size_t *columns)
{
    *numbers = run->members;
    *columns = 2 + run->settings.asked.n_reduced;
    return run->members ? run->settings.asked.members : 0;
}

/* Returns *text, which the first call writes. */
static const char *once(struct pk_run *run, char **text,
                        void (*write)(struct pk_run *run, FILE *file))
{
    size_t size;
    FILE *file = *text ? NULL : open_memstream(text, &size);
    if (file) {
        write(run, file);
        fclose(file);
    }
    return *text ? *text : "{}";
}

/* the report of an ensemble is already in run->report */
const char *pk_run_report(struct pk_run *run)
{
    const int known = (run->report || run->it.method) && !run->checkpoint.refused;
    /* {}: a run that could not start has no report */
    return known ? once(run, &run->report, report_run) : "{}";
}

const char *pk_run_given(struct pk_run *run) { return once(run, &run->told, settings_tell); }

const char *pk_run_messages(const struct pk_run *run)
{
    /* failures with any other code have left a message */
    const int none = run->code == PK_RUN_FAILED;
    return run->said ? run->said : none ? "out of memory\n" : "";
}

int pk_run_refused(const struct pk_run *of) { return of->refused; }

size_t pk_run_size(int which)
{
    static const size_t sizes[] = {sizeof(struct pk_run_settings), sizeof(struct pk_run_expected),
                                   sizeof(struct pk_run_part), sizeof(struct pk_run_reduced)};
    return which >= 0 && which < 4 ? sizes[which] : 0;
}

/* Repeats the run several times between two readings of the clock, and doubles the number of
 * repetitions until they take LAP_SECONDS, since the clock of CPU time may tick in milliseconds. */
double pk_run_laps(struct pk_run *run, double seconds)
{
    const struct settings *s = &run->settings;
    unsigned long block = 1;
    double best = 0, total = 0;
    do {
        const double began = run_processor();
        for (unsigned long k = 0; k < block; k++)
            if (run_ending(NULL) || pk_integrator_reset(&run->it, 0, s->q, s->v) < 0 ||
                (run->bare.samples.n &&
                 pk_sampler_start(&run->sampler, &run->it, s->until, run->sampler.next) < 0) ||
                (run->acts && pk_actor_start(&run->actor, &run->it, run->actor.work) < 0) ||
                crossings_to(run, s->until, 0, 0) < 0)
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

void pk_run_free(struct pk_run *run)
{
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

/* Runs an ensemble (`pkgen run --ensemble`). One batch of members is in memory at a time, and rows
 * are written in the order of members, independent of the threads. The parameters of all members
 * are checked before the first one runs. */

#include "../settings/settings.h"
#include "ensemble.h"

static int stop(void *context)
{
    struct pk_run *run = context;
    return pk_thread() ? run->control.stop : run_stopped(run, run->part);
}

/* Passes a state of a member to the observers and, if has_row, writes it as a row. */
static void show(struct pk_run *run, int has_row, const struct moment *at)
{
    if (has_row)
        observe_row(run, at);
    observe_step(run, at);
}

/* Writes all rows of member i of the batch. The drifts of this member are measured at rows only. */
static void show_all(const struct batch *b, struct pk_run *run, size_t i)
{
    const struct pk_ensemble *e = &b->e;
    const struct settings *s = &run->settings;
    const struct pk_problem problem = {.system = b->system, .params = s->params};
    struct moment at = {0, b->q0 + i * b->n, b->v0 + i * b->n};
    if (run->monitor_block)
        drift_begin(run, &problem);
    show(run, s->has_every, &at);
    if (run->loop)
        run->model->diagnose->area_note(run, at.t, at.q, at.v);
    for (size_t row = 0; row < e->done[i]; row++) {
        const size_t k = (i * e->rows + row) * b->n;
        at = (struct moment){b->t[row], e->q + k, e->v + k};
        show(run, 1, &at);
    }
    observe_end(run);
    if (e->status[i] < 0)
        at.t = e->last_t[i];
    reduce_end(run, run, run->member, e->status[i], &at);
}

/* Writes the rows and results of a member. Meanwhile the settings contain this member's parameters
 * and inputs, since observers read them there. */
static void write_member(struct batch *b, struct pk_run *run, size_t i, size_t member)
{
    const struct pk_ensemble *e = &b->e;
    struct settings *s = &run->settings;
    void *const params = s->params;
    pk_real *const u = s->u;
    const enum pk_status status = e->status[i];
    const struct moment none = {0, NULL, NULL};
    if (status == PK_BAD_ARGUMENT || status == PK_REFUSED || status == PK_OUT_OF_BOUNDS) {
        reduce_end(run, run, member, status, &none);
        return;
    }
    s->params = b->params + i * b->system->params_size;
    s->u = b->u + i * b->system->n_inputs;
    run->member = member;
    show_all(b, run, i);
    s->params = params;
    s->u = u;
}

/* Returns whether fixed steps ended with a wrong energy in member i of the batch. */
static int is_astray(const struct batch *b, const struct pk_run *run, size_t i)
{
    if (!run->monitor_block || !member_fixed(&run->settings) || b->e.done[i] == 0)
        return 0;
    const pk_real final = pk_drift_final(&run->monitor.energy);
    return !(PK_F(fabs)(final) <= TRUST_WRONG); /* NaN counts as a wrong energy */
}

static void write_batch(struct batch *b, struct pk_run *run, size_t first, size_t count,
                        struct tally *tally)
{
    const struct pk_ensemble *e = &b->e;
    for (size_t i = 0; i < count; i++) {
        write_member(b, run, i, first + i);
        char *reason =
            tally_note(tally, first + i, e->status[i], e->last_t[i], is_astray(b, run, i));
        if (reason)
            pk_ensemble_reason(e, i, b->block, b->block_size, reason, TALLY_REASON);
    }
}

/* Reports how many members failed with one status, and the first of them. */
static void report_failed(const struct settings *s, struct json *j, const char *key,
                          const struct failed *of)
{
    json_open(j, key, '{');
    json_integer(j, "count", of->count);
    json_real(j, "member", (pk_real)member_number(s, of->member));
    json_texts(j, {"status", pk_status_name(of->status)}, {"text", pk_status_text(of->status)});
    json_real(j, "t", of->t);
    json_text(j, "reason", of->reason);
    json_close(j, '}');
}

static void report(const struct pk_run *run, const struct batch *b, const struct tally *tally,
                   FILE *file)
{
    const struct settings *s = &run->settings;
    struct json json = {.file = file}, *j = &json;
    json_open(j, NULL, '{');
    json_texts(j, {"model", b->system->name}, {"source_hash", b->system->source_hash},
               {"method", s->method->name});
    json_reals(j, {"order", s->method->order},
               {"step", member_fixed(s) ? s->options.h : PK_INFINITY});
    if (b->system->noise.n)
        json_integer(j, "seed", s->asked.seed);
    json_counts(j, {"members", s->asked.members}, {"done", tally->done}, {"failed", tally->failed});
    if (tally->failed)
        report_failed(s, j, "first_failed", tally->first_failed);
    else
        json_text(j, "first_failed", NULL);
    json_open(j, "failures", '[');
    for (size_t k = 0; k < sizeof tally->failures / sizeof *tally->failures; k++)
        if (tally->failures[k].count)
            report_failed(s, j, NULL, &tally->failures[k]);
    json_close(j, ']');
    json_integer(j, "astray", tally->astray);
    json_real(j, "first_astray",
              tally->astray ? (pk_real)member_number(s, tally->first_astray) : PK_INFINITY);
    watched_report(tally, s, j);
    expect_report(run, j);
    json_flag(j, "interrupted", run->interrupted);
    json_flag(j, "whole", rows_complete(run));
    json_counts(j, {"rows", run->rows}, {"threads", b->threads});
    json_reals(j, {"seconds", (pk_real)run->seconds}, {"processor", (pk_real)run->processor});
    if (run->model->diagnose)
        run->model->diagnose->report(run, j);
    json_close(j, '}');
}

/* Returns why members may have ended before `until`, for messages. */
static const char *ended(const struct settings *s, const struct tally *tally)
{
    int stops = 0;
    for (size_t k = 0; s->asked.watch > 0 && k < s->system->events.n; k++)
        stops |= s->system->events.table[k].stop;
    return !stops          ? "they failed"
           : tally->failed ? "they failed or an event stopped them"
                           : "an event stopped them";
}

/* Writes the final messages and the report. Returns the exit code. */
static enum pk_run_code finish(struct pk_run *run, const struct batch *b, const struct tally *tally)
{
    enum pk_run_code code = rows_end(run, PK_RUN_DONE);
    if (run->write_failed == EPIPE)
        return code;
    if (tally->failed) {
        run_say(run, "%s: %zu of %zu members failed, first member %ld: %s",
                run->settings.method->name, tally->failed, run->settings.asked.members,
                member_number(&run->settings, tally->first_failed->member),
                tally->first_failed->reason);
        code = PK_RUN_FAILED;
    }
    watched_warn(run, tally);
    if (tally->astray)
        run_say(run,
                "warning: energy off by more than %g of its scale at the end in %zu of %zu "
                "members, first member %ld: make the step shorter (--step)",
                (double)TRUST_WRONG, tally->astray, run->settings.asked.members,
                member_number(&run->settings, tally->first_astray));
    code = rows_told(run, code);
    if (run->loop && !run->control.stop)
        code = run->model->diagnose->area_find(run, code, ended(&run->settings, tally));
    run->interrupted = run->control.stop;
    if (run->checkpoint.left) {
        run_say(run, "left after %zu of %zu members with the checkpoint %s", tally->done,
                run->settings.asked.members, run->settings.asked.checkpoint);
        code = PK_RUN_LEFT;
    } else if (run->interrupted) {
        run_say(run, "interrupted after %zu of %zu members", tally->done,
                run->settings.asked.members);
        code = PK_RUN_INTERRUPTED;
    }
    FILE *file = run_text(run, &run->report);
    report(run, b, tally, file);
    run_text_end(run);
    return code;
}

struct ensemble {
    struct batch b;
    struct tally tally;
    size_t first; /* index of the next member to run */
};

/* Saves or restores the results so far, for a checkpoint. */
static enum pk_status keep(struct pk_run *run, void *context, struct pk_keep *k)
{
    struct ensemble *of = context;
    struct tally *tally = &of->tally;
    const size_t ways = sizeof tally->failures / sizeof *tally->failures;
    size_t first = tally->first_failed ? 1 + (size_t)(tally->first_failed - tally->failures) : 0;
    PK_KEEP(k, of->first);
    PK_KEEP(k, tally->done);
    PK_KEEP(k, tally->failed);
    PK_KEEP(k, tally->astray);
    PK_KEEP(k, tally->first_astray);
    PK_KEEP(k, tally->failures);
    PK_KEEP(k, first);
    for (size_t i = 0; i < ways; i++)
        tally->failures[i].reason[TALLY_REASON - 1] = '\0';
    k->wrong |= first > ways || of->first > run->settings.asked.members;
    tally->first_failed = first && !k->wrong ? &tally->failures[first - 1] : NULL;
    watched_keep(tally, &run->settings, k);
    return PK_DONE;
}

/* Runs `count` members. Returns 0 if the run must end; a resumed run repeats these members. */
static int make_batch(struct pk_run *run, struct ensemble *of, size_t count)
{
    struct batch *b = &of->b;
    const struct settings *s = &run->settings;
    b->e.members = count;
    run->part = (double)of->first / (double)s->asked.members;
    members_set(b, of->first, count, run);
    b->e.options.member = (unsigned long long)member_number(s, of->first);
    if (member_by_one(s))
        return watched_batch(b, run, of->first, count, &of->tally);
    pk_ensemble_run_threads(&b->e, b->threads, b->block, b->block_size);
    if (run->control.stop && s->asked.checkpoint)
        return 0;
    write_batch(b, run, of->first, count, &of->tally);
    return 1;
}

/* With checkpoints, batches are small at first. Their size doubles if one takes less than a quarter
 * of the time between two checkpoints. */
static void make_all(struct pk_run *run, struct ensemble *of)
{
    const struct pk_run_settings *asked = &run->settings.asked;
    const size_t all = asked->members, least = of->b.threads * WHOLE_BLOCKS;
    size_t take = asked->checkpoint && least < of->b.size ? least : of->b.size;
    while (of->first < all && !run->control.stop && !run->write_failed) {
        const double began = run_now();
        const size_t left = all - of->first, count = left < take ? left : take;
        of->first += make_batch(run, of, count) ? count : 0;
        run_stopped(run, (double)of->first / (double)all);
        checkpoint_look(run, keep, of);
        if (take <= of->b.size / 2 && run_now() - began < asked->checkpoint_every / 4)
            take *= 2;
    }
}

/* Runs all members, with rows at equal intervals up to `until`. Returns the exit code. */
static enum pk_run_code ensemble_run(struct pk_run *run)
{
    struct ensemble of = {0};
    struct batch *b = &of.b;
    struct settings *s = &run->settings;
    const struct pk_system *system = s->system;
    const size_t rows = run->count > 1 ? (size_t)run->count : 1;
    const int watched = member_by_one(s);
    const double began = run_now(), processor = run->control.began = run_processor();
    run->problem.system = system;
    s->options.stop = stop;
    s->options.context = run;
    members_allocate(b, run, rows);
    if (watched && b->size > WATCHED_AT_ONCE)
        b->size = WATCHED_AT_ONCE;
    if ((member_fixed(s) && (system->facts & PK_CONSERVATIVE)) || expect_uses_h(run)) {
        const struct pk_problem problem = {.system = system, .params = b->params};
        run->monitor_block = memory_take(&run->memory, pk_monitor_size(&problem), 1);
    }
    for (size_t k = 0; k < rows; k++)
        b->t[k] = k + 1 < rows ? (pk_real)(k + 1) * s->every : s->until;
    enum pk_run_code code = s->asked.lenient ? PK_RUN_DONE : members_check(b, run);
    if (s->asked.n_reduced || s->asked.no_rows)
        run->members = memory_take(&run->memory, s->asked.members * (2 + s->asked.n_reduced),
                                   sizeof *run->members);
    if (watched)
        watched_begin(&of.tally, run);
    observe_begin(run);
    if (!code && s->asked.diagnose)
        code = run->model->diagnose->area_begin(run, b->t, rows);
    if (code)
        return code;
    run->checkpoint.began = began;
    if (!checkpoint_begin(run, keep, &of))
        return PK_RUN_USAGE;
    if (!s->asked.resume)
        rows_header(run);
    make_all(run, &of);
    run->seconds += run_now() - began;
    run->processor += run_processor() - processor;
    return finish(run, b, &of.tally);
}

const struct pk_run_ensemble pk_run_ensemble = {.run = ensemble_run, .fixed = member_fixed};

/* Members of an ensemble whose events are watched, or whose equations have switches: each is a run
 * of its own, with the rows and the verdicts of one, several at a time; what they wrote comes out in
 * their order.
 */
#define _POSIX_C_SOURCE 200809L

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "diagnose_area.h"
#include "ensemble.h"
#include "expect.h"
#include "members.h"
#include "watch.h"
#include "words.h"

/* A member's run when it is over, its rows and how often each event and switch was crossed. */
struct done {
    struct run *run;
    char *text;
    size_t size;
    unsigned long *count; /* and behind, of doubts */
    pk_real *first;
    enum pk_status status;
    char reason[512];
};

struct work {
    const struct batch *b;
    const struct run *run; /* of all, whose settings they share */
    struct pk_problem problem;
    size_t first;
    struct done *done;
};

int watched_by_one(const struct settings *s) { return s->watch || run_model->n_switches > 0; }

static size_t kinds(void) { return run_model->n_events + run_model->n_switches; }

/* With a state, parameters, inputs and verdicts of its own. */
static struct run *prepared(const struct work *w, size_t i)
{
    const struct batch *b = w->b;
    struct run *run = (struct run *)words_allocate(1, sizeof *run);
    struct settings *s = &run->settings;
    *s = w->run->settings;
    s->params = b->params + i * b->system->params_size;
    s->q = b->q0 + i * b->n;
    s->v = b->v0 + i * b->n;
    s->u = b->u + i * b->system->n_inputs;
    s->progress = 0;
    s->expected = (struct expected *)words_allocate(s->n_expected, sizeof *s->expected);
    s->drifting = (struct drifting *)words_allocate(s->n_drifting, sizeof *s->drifting);
    if (s->n_expected)
        memcpy(s->expected, w->run->settings.expected, s->n_expected * sizeof *s->expected);
    if (s->n_drifting)
        memcpy(s->drifting, w->run->settings.drifting, s->n_drifting * sizeof *s->drifting);
    expect_clear(s);
    run->member = w->first + i;
    run->next = 1;
    run->count = w->run->count;
    run->loop = w->run->loop;
    area_note(run, 0, s->q, s->v);
    run->problem = w->problem;
    run->problem.params = s->params;
    run->problem.context = s;
    expect_begin(run);
    return run;
}

static void integrate(struct run *run, const pk_real *z0)
{
    if (run_begin(run) != 0) {
        if (run->it.status >= 0)
            run->it.status = PK_NO_MEMORY;
        return;
    }
    if (z0 && run->it.z && pk_integrator_set_quadratures(&run->it, z0) < 0)
        return;
    run_integrate(run);
    if (run->interrupted)
        run->it.status = PK_STOPPED_USER;
    if (run->write_failed)
        run->it.status = PK_NO_MEMORY;
}

static void member(void *context, size_t i)
{
    const struct work *w = (const struct work *)context;
    struct done *done = &w->done[i];
    struct run *run = done->run = prepared(w, i);
    const size_t m = w->b->system->n_quadratures;
    run->out = open_memstream(&done->text, &done->size);
    if (!run->out)
        run->it.status = PK_NO_MEMORY;
    else if (run_interrupted())
        run->it.status = PK_STOPPED_USER;
    else
        integrate(run, m ? w->b->z0 + i * m : NULL);
    done->status = run->it.status;
    if (run->it.method)
        pk_integrator_reason(&run->it, done->reason, sizeof done->reason);
    else
        strcpy(done->reason, pk_status_text(run->it.status));
    done->count = (unsigned long *)words_allocate(2 * kinds(), sizeof *done->count);
    done->first = (pk_real *)words_allocate(kinds(), sizeof *done->first);
    for (size_t k = 0; k < kinds(); k++) {
        done->count[k] = run->crossed ? run->crossed[k].count : 0;
        done->first[k] = done->count[k] ? run->crossed[k].t[0] : PK_INFINITY;
        done->count[kinds() + k] = run->crossed ? run->crossed[k].doubts : 0;
    }
    if (run->out)
        fclose(run->out);
    run_free(run);
}

/* What a member adds to what is known of all. */
static void merge(struct run *run, struct done *done, struct tally *tally)
{
    struct run *of = done->run;
    const size_t i = of->member;
    if (done->size && fwrite(done->text, 1, done->size, run->out) != done->size)
        run->write_failed = errno ? errno : EIO;
    run->rows += of->rows;
    if (of->bad_rows && run->bad_rows == 0) {
        run->not_finite = of->not_finite;
        run->bad_t = of->bad_t;
    }
    run->bad_rows += of->bad_rows;
    expect_merge(&run->settings, &of->settings);
    tally->done += done->status == PK_DONE || done->status == PK_STOPPED_EVENT;
    tally->stopped += done->status == PK_STOPPED_USER;
    if (done->status < 0 && tally->failed++ == 0) {
        tally->first_failed = i;
        tally->status = done->status;
        tally->t = of->it.t;
        memcpy(tally->reason, done->reason, sizeof tally->reason);
    }
    if (done->status >= 0 && of->distrusted && !(of->settings.method->traits & PK_ADAPTIVE) &&
        tally->astray++ == 0)
        tally->first_astray = i;
    for (size_t k = 0; k < kinds(); k++) {
        tally->crossings[k] += done->count[k];
        tally->never[k] += done->count[k] == 0;
        tally->doubts[k] += done->count[kinds() + k] > 0;
        if (tally->first && k < run_model->n_events)
            tally->first[k * run->settings.members + i] = done->first[k];
    }
}

void watched_begin(struct tally *tally, const struct settings *s)
{
    tally->crossings = (unsigned long *)words_allocate(3 * kinds(), sizeof *tally->crossings);
    tally->never = tally->crossings + kinds();
    tally->doubts = tally->never + kinds();
    if (s->watch > 1)
        tally->first = (pk_real *)words_allocate(run_model->n_events * s->members,
                                                 sizeof *tally->first);
}

void watched_batch(const struct batch *b, struct run *run, size_t first, size_t count,
                   struct tally *tally)
{
    struct work w = {.b = b, .run = run, .first = first};
    w.problem = settings_shows_z(&run->settings) ? settings_problem(&run->settings)
                                                 : settings_motion(&run->settings);
    w.done = (struct done *)words_allocate(count, sizeof *w.done);
    pk_parallel(b->threads, count, member, &w);
    for (size_t i = 0; i < count; i++) {
        struct done *done = &w.done[i];
        merge(run, done, tally);
        free(done->run->settings.expected);
        free(done->run->settings.drifting);
        free(done->run);
        free(done->text);
        free(done->count);
        free(done->first);
    }
    free(w.done);
}

static void report_kind(FILE *file, const struct tally *tally, size_t k, const char *name)
{
    fputs("\n    {\"name\": ", file);
    output_text(file, name);
    fprintf(file, ", \"count\": %lu, \"never\": %lu, \"doubts\": %lu", tally->crossings[k],
            tally->never[k], tally->doubts[k]);
}

void watched_warn(const struct tally *tally)
{
    for (size_t k = 0; tally->crossings && k < kinds(); k++)
        if (tally->doubts[k])
            fprintf(stderr, "run: warning: %s: in %lu members %s\n", watch_name(k), tally->doubts[k],
                    WATCH_TOO_OFTEN);
}

void watched_report(const struct tally *tally, const struct settings *s, FILE *file)
{
    const size_t m = run_model->n_events;
    if (!tally->crossings)
        return;
    fprintf(file, "  \"first_member\": %ld,\n  \"events\": [", ensemble_number(s, 0));
    for (size_t k = 0; k < m; k++) {
        fputs(k ? "," : "", file);
        report_kind(file, tally, k, run_model->events[k].what.name);
        fprintf(file, ", \"stop\": %s", run_model->events[k].stop ? "true" : "false");
        if (tally->first) {
            fputs(", ", file);
            output_numbers(file, "first", tally->first + k * s->members, s->members);
        }
        fputs("}", file);
    }
    fputs("],\n  \"switches\": [", file);
    for (size_t k = m; k < kinds(); k++) {
        fputs(k > m ? "," : "", file);
        report_kind(file, tally, k, run_model->switches[k - m].name);
        fputs("}", file);
    }
    fputs("],\n", file);
}

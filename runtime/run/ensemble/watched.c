/* Members of an ensemble whose events are watched, or whose equations have switches: each is a run
 * of its own, with the rows and the verdicts of one, several at a time; what they wrote comes out
 * in their order.
 */

#include "../diagnose/area.h"
#include "../settings/settings.h"
#include "ensemble.h"

/* A member's run when it is over, its rows and how often each event and switch was crossed. */
struct done {
    struct pk_run *run;
    char *text;
    size_t size;
    unsigned long *count; /* and behind, of doubts */
    pk_real *first;
    enum pk_status status;
    char reason[512];
};

struct work {
    const struct batch *b;
    const struct pk_run *run; /* of all, whose settings they share */
    struct pk_problem problem;
    size_t first;
    struct done *done;
};

static size_t kinds(const struct settings *s)
{
    return s->system->events.n + s->system->switches.n;
}

/* With a state, parameters, inputs, verdicts and memory of its own. */
static void prepare(struct pk_run *run, const struct work *w, size_t i)
{
    const struct batch *b = w->b;
    struct settings *s = &run->settings;
    *s = w->run->settings;
    s->memory = &run->memory;
    s->params = b->params + i * b->system->params_size;
    s->q = b->q0 + i * b->n;
    s->v = b->v0 + i * b->n;
    s->u = b->u + i * b->system->n_inputs;
    s->polls = pk_thread() == 0;
    s->expected = memory_take(s->memory, s->n_expected, sizeof *s->expected);
    s->drifting = memory_take(s->memory, s->n_drifting, sizeof *s->drifting);
    memcpy(s->expected, w->run->settings.expected, s->n_expected * sizeof *s->expected);
    memcpy(s->drifting, w->run->settings.drifting, s->n_drifting * sizeof *s->drifting);
    expect_clear(s);
    run->next = 1;
    run->count = w->run->count;
    run->loop = w->run->loop;
    area_note(run, 0, s->q, s->v);
    run->bare = *w->problem.system;
    run->problem = w->problem;
    run->problem.system = &run->bare;
    run->problem.params = s->params;
    run->problem.context = s;
}

static void integrate(struct pk_run *run, const pk_real *z0)
{
    if (run_begin(run) != PK_RUN_DONE) {
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

static void tell(struct done *done, struct pk_run *run)
{
    const size_t m = kinds(&run->settings);
    done->status = run->it.status;
    if (run->it.method)
        pk_integrator_reason(&run->it, done->reason, sizeof done->reason);
    else
        strcpy(done->reason, pk_status_text(run->it.status));
    for (size_t k = 0; k < m; k++) {
        done->count[k] = run->crossed ? run->crossed[k].count : 0;
        done->first[k] = done->count[k] ? run->crossed[k].t[0] : PK_INFINITY;
        done->count[m + k] = run->crossed ? run->crossed[k].doubts : 0;
    }
}

struct one {
    const struct work *w;
    size_t i;
};

static void follow(void *context)
{
    const struct one *one = context;
    const struct batch *b = one->w->b;
    struct done *done = &one->w->done[one->i];
    const size_t m = b->system->quadratures.n;
    prepare(done->run, one->w, one->i);
    if (one->w->run->out)
        done->run->out = run_text(done->run, &done->text);
    if (done->run->settings.control->stop)
        done->run->it.status = PK_STOPPED_USER;
    else
        integrate(done->run, m ? b->z0 + one->i * m : NULL);
}

static void member(void *context, size_t i)
{
    struct one one = {(const struct work *)context, i};
    struct done *done = &one.w->done[i];
    struct pk_run *run = done->run;
    run->member = one.w->first + i;
    if (!memory_try(&run->memory, follow, &one)) {
        run->it.status = PK_NO_MEMORY;
        run->crossed = NULL;
    }
    tell(done, run);
    run_text_end(run);
    done->size = run->memory.text_size;
    run->out = NULL;
    run_end(run);
}

/* What a member adds to what is known of all. */
static void merge(struct pk_run *run, struct done *done, struct tally *tally)
{
    struct pk_run *of = done->run;
    const size_t i = of->member;
    if (done->size && fwrite(done->text, 1, done->size, run->out) != done->size)
        run->write_failed = errno ? errno : EIO;
    rows_take(run, of);
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
    for (size_t k = 0; k < kinds(&run->settings); k++) {
        tally->crossings[k] += done->count[k];
        tally->never[k] += done->count[k] == 0;
        tally->doubts[k] += done->count[kinds(&run->settings) + k] > 0;
        if (tally->first && k < run->settings.system->events.n)
            tally->first[k * run->settings.members + i] = done->first[k];
    }
}

void watched_begin(struct tally *tally, struct pk_run *run)
{
    struct memory *memory = &run->memory;
    const struct settings *s = &run->settings;
    const size_t m = kinds(s);
    tally->crossings = memory_take(memory, 3 * m, sizeof *tally->crossings);
    tally->never = tally->crossings + m;
    tally->doubts = tally->never + m;
    if (s->watch > 1)
        tally->first = memory_take(memory, s->system->events.n * s->members, sizeof *tally->first);
}

void watched_batch(const struct batch *b, struct pk_run *run, size_t first, size_t count,
                   struct tally *tally)
{
    struct memory *memory = &run->memory;
    const size_t m = kinds(&run->settings);
    struct work w = {.b = b, .run = run, .first = first, .problem = run_problem(run)};
    struct pk_run *runs = memory_take(memory, count, sizeof *runs);
    unsigned long *counts = memory_take(memory, 2 * m * count, sizeof *counts);
    pk_real *firsts = memory_take(memory, m * count, sizeof *firsts);
    w.done = memory_take(memory, count, sizeof *w.done);
    for (size_t i = 0; i < count; i++)
        w.done[i] =
            (struct done){.run = &runs[i], .count = counts + 2 * m * i, .first = firsts + m * i};
    pk_parallel(b->threads, count, member, &w);
    for (size_t i = 0; i < count; i++) {
        merge(run, &w.done[i], tally);
        memory_end(&runs[i].memory);
        free(w.done[i].text);
    }
    memory_drop(memory, w.done);
    memory_drop(memory, firsts);
    memory_drop(memory, counts);
    memory_drop(memory, runs);
}

void watched_warn(struct pk_run *run, const struct tally *tally)
{
    const struct settings *s = &run->settings;
    for (size_t k = 0; tally->crossings && k < kinds(s); k++)
        if (tally->doubts[k])
            run_say(run, "warning: %s: in %lu members %s", watch_name(s->system, k),
                    tally->doubts[k], WATCH_TOO_OFTEN);
}

/* `from` events or switches on. */
static void report_kind(const struct tally *tally, const struct settings *s, struct json *j,
                        const char *key, size_t from, size_t count)
{
    json_open(j, key, '[');
    for (size_t k = from; k < from + count; k++) {
        json_open(j, NULL, '{');
        json_text(j, "name", watch_name(s->system, k));
        json_count(j, "count", tally->crossings[k]);
        json_count(j, "never", tally->never[k]);
        json_count(j, "doubts", tally->doubts[k]);
        if (k < s->system->events.n)
            json_flag(j, "stop", s->system->events.table[k].stop);
        if (k < s->system->events.n && tally->first)
            json_numbers(j, "first", tally->first + k * s->members, s->members);
        json_close(j, '}');
    }
    json_close(j, ']');
}

void watched_report(const struct tally *tally, const struct settings *s, struct json *j)
{
    if (!tally->crossings)
        return;
    json_real(j, "first_member", (pk_real)member_number(s, 0));
    report_kind(tally, s, j, "events", 0, s->system->events.n);
    report_kind(tally, s, j, "switches", s->system->events.n, s->system->switches.n);
}

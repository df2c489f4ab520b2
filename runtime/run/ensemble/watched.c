/* Ensembles whose events are watched, or whose equations have switches: each member is a struct
 * pk_run with its own rows and results. Threads run in parallel, and output is merged in the order
 * of members. */
#include "../diagnose/area.h"
#include "../settings/settings.h"
#include "ensemble.h"

#include <pk/adaptive_lanes.h>

enum { PARTS = 4 }; /* a batch is divided into so many groups of members for each thread */

/* A batch of members. Each thread advances `lanes` members at once, one in each SIMD lane; if
 * `lanes` is 1, it advances them one by one. */
struct work {
    const struct batch *b;
    const struct pk_run *run; /* the run of the whole ensemble, whose settings the members share */
    /* `group`: number of members that one call of make() runs */
    size_t first, count, group, lanes, bytes;
    /* a struct pk_run for each member; freed when its results have been merged */
    struct pk_run *runs;
    char *block; /* memory for the lanes: `bytes` for each thread */
};

struct member {
    const struct work *w;
    struct pk_run *run;
    size_t i; /* index of the member in the batch */
    int goes; /* whether the member must make another step */
};

static size_t kinds(const struct settings *s)
{
    return s->system->events.n + s->system->switches.n;
}

/* Initialises a member's run: parameters, initial state, inputs, expectations and memory. */
static void prepare(struct pk_run *run, const struct work *w, size_t i)
{
    const struct batch *b = w->b;
    struct settings *s = &run->settings;
    run->model = w->run->model;
    *s = w->run->settings;
    s->run = run;
    s->memory = &run->memory;
    s->params = b->params + i * b->system->params_size;
    s->q = b->q0 + i * b->n;
    s->v = b->v0 + i * b->n;
    s->u = b->u + i * b->system->n_inputs;
    s->options.member = (unsigned long long)member_number(s, w->first + i);
    s->polls = pk_thread() == 0;
    expect_own(s);
    run->lean = expect_lean(run);
    run->next = 1;
    run->count = w->run->count;
    run->loop = w->run->loop;
    if (run->loop)
        run->model->diagnose->area_note(run, 0, s->q, s->v);
}

static void start(void *context)
{
    struct member *m = context;
    struct pk_run *run = m->run;
    prepare(run, m->w, m->i);
    if (m->w->run->out)
        run->out = run_text(run, &run->csv);
    if (run->settings.control->stop)
        run->it.status = PK_STOPPED_USER;
    else if (run_begin(run) == PK_RUN_DONE)
        m->goes = run_starts(run);
    else if (run->it.status >= 0)
        run->it.status = PK_NO_MEMORY;
}

static void go_on(void *context)
{
    struct member *m = context;
    m->goes = run_goes(m->run);
}

static void go_through(void *context)
{
    struct member *m = context;
    while (m->goes)
        m->goes = run_goes(m->run);
}

static void end(void *context)
{
    struct member *m = context;
    if (m->run->begun)
        run_ends(m->run);
}

/* Calls the function `part` for a member. Returns 1, or 0 if an allocation in it failed; the
 * member's status is then PK_NO_MEMORY. */
static int try_to(void (*part)(void *context), struct member *m)
{
    if (memory_try(&m->run->memory, part, m))
        return 1;
    m->goes = 0;
    m->run->crossed = NULL;
    m->run->it.status = PK_NO_MEMORY;
    return 0;
}

static void finish(struct member *m)
{
    struct pk_run *run = m->run;
    if (run->begun && try_to(end, m) && run->interrupted)
        run->it.status = PK_STOPPED_USER;
    if (run->write_failed)
        run->it.status = PK_NO_MEMORY;
    run_text_end(run);
    run->out = NULL;
}

/* Starts member i of the batch. Returns 1 if it has a step to make; otherwise finishes it. */
static int begin(struct member *m, const struct work *w, size_t i)
{
    *m = (struct member){w, &w->runs[i], i, 0};
    m->run->member = w->first + i;
    m->run->begun = try_to(start, m) && m->run->it.own && m->run->it.status >= 0;
    if (m->goes)
        return 1;
    finish(m);
    return 0;
}

/* Advances members in lanes; when a member has ended, its lane takes the next one. */
static void go_in_lanes(const struct work *w, size_t next, size_t behind)
{
    struct member members[PK_BLOCK_MOST];
    struct pk_lane lanes[PK_BLOCK_MOST] = {{0}};
    struct pk_lanes a;
    size_t live = 0;
    pk_lanes_init(&a, &(struct pk_problem){.system = w->b->system, .params = w->b->params},
                  w->run->settings.method, w->block + pk_thread() * w->bytes, w->bytes);
    do {
        for (size_t l = 0; l < w->lanes; l++) {
            struct member *m = &members[l];
            struct pk_lane *lane = &lanes[l];
            while (!lane->it && next < behind)
                if (begin(m, w, next++))
                    lane->it = &m->run->it, live++;
            if (!lane->it)
                continue;
            lane->events = m->run->crossed ? &m->run->events : NULL;
            lane->limit = run_limit(m->run);
            /* Until `free` nobody looks at a step: up to the next row, if no sample comes before. */
            lane->free = m->run->lean && !m->run->bare.samples.n
                             ? run_wanted(m->run, lane->it->t, m->run->settings.until)
                             : lane->it->t;
        }
        pk_lanes_make(&a, lanes);
        for (size_t l = 0; l < w->lanes; l++)
            if (lanes[l].it && !(a.idle >> l & 1) &&
                !(try_to(go_on, &members[l]) && members[l].goes)) {
                finish(&members[l]);
                pk_lanes_leave(lanes[l].it);
                lanes[l].it = NULL;
                live--;
            }
    } while (live || next < behind);
}

static void make(void *context, size_t number)
{
    const struct work *w = context;
    const size_t first = number * w->group, left = w->count - first;
    const size_t behind = first + (left < w->group ? left : w->group);
    if (w->lanes > 1) {
        go_in_lanes(w, first, behind);
        return;
    }
    for (size_t i = first; i < behind; i++) {
        struct member m;
        if (begin(&m, w, i)) {
            try_to(go_through, &m);
            finish(&m);
        }
    }
}

/* Adds the rows and results of member `of` to the ensemble's. */
static void merge(struct pk_run *run, struct pk_run *of, struct tally *tally)
{
    const size_t i = of->member, size = of->csv ? of->memory.text_size : 0;
    const enum pk_status status = of->it.status;
    if (size && fwrite(of->csv, 1, size, run->out) != size)
        run->write_failed = errno ? errno : EIO;
    rows_take(run, of);
    run->rows += of->rows;
    if (of->bad_rows && run->bad_rows == 0) {
        run->not_finite = of->not_finite;
        run->bad_t = of->bad_t;
    }
    run->bad_rows += of->bad_rows;
    expect_merge(&run->settings, &of->settings);
    const int astray = status >= 0 && of->distrusted && run_fixed(of);
    char *reason = tally_note(tally, i, status, of->it.t, astray);
    if (reason && of->it.method)
        pk_integrator_reason(&of->it, reason, TALLY_REASON);
    else if (reason)
        strcpy(reason, pk_status_text(status));
    reduce_end(run, of, i, status, run_moment(of));
    for (size_t k = 0; k < kinds(&run->settings); k++) {
        static const struct crossed none = {0};
        const struct crossed *crossed = of->crossed ? &of->crossed[k] : &none;
        tally->crossings[k] += crossed->count;
        tally->never[k] += crossed->count == 0;
        tally->doubts[k] += crossed->doubts > 0;
        if (tally->first && k < run->settings.system->events.n)
            tally->first[k * run->settings.asked.members + i] = crossed->count ? crossed->t[0]
                                                                               : PK_INFINITY;
    }
}

void watched_begin(struct tally *tally, struct pk_run *run)
{
    struct memory *memory = &run->memory;
    const struct settings *s = &run->settings;
    const size_t m = kinds(s), all = s->system->events.n * s->asked.members;
    tally->crossings = memory_take(memory, 3 * m, sizeof *tally->crossings);
    tally->never = tally->crossings + m;
    tally->doubts = tally->never + m;
    if (s->asked.watch > 1)
        tally->first = memory_take(memory, all, sizeof *tally->first);
}

int watched_batch(const struct batch *b, struct pk_run *run, size_t first, size_t count,
                  struct tally *tally)
{
    const struct pk_problem problem = {.system = b->system, .params = b->params};
    struct memory *memory = &run->memory;
    struct work w = {.b = b, .run = run, .first = first, .count = count, .group = 1, .lanes = 1};
    w.runs = memory_take(memory, count, sizeof *w.runs);
    w.bytes = pk_lanes_size(&problem, run->settings.method);
    if (w.bytes) {
        const size_t parts = PARTS * b->threads;
        w.lanes = pk_lanes_count(&problem, run->settings.method);
        w.group = (count + parts - 1) / parts;
        w.group = w.group < w.lanes ? w.lanes : w.group;
        w.block = memory_take(memory, b->threads, w.bytes);
    }
    pk_parallel(b->threads, (count + w.group - 1) / w.group, make, &w, &run->settings.options);
    const int kept = !(run->control.stop && run->settings.asked.checkpoint);
    if (!kept && run->loop)
        memset(run->loop->came + first, 0, count * sizeof *run->loop->came);
    for (size_t i = 0; i < count; i++) {
        struct pk_run *of = &w.runs[i];
        if (kept)
            merge(run, of, tally);
        run_end(of);
        memory_end(&of->memory);
        free(of->csv);
    }
    memory_drop(memory, w.runs);
    memory_drop(memory, w.block);
    return kept;
}

void watched_warn(struct pk_run *run, const struct tally *tally)
{
    const struct settings *s = &run->settings;
    for (size_t k = 0; tally->crossings && k < kinds(s); k++)
        if (tally->doubts[k])
            run_say(run, "warning: %s: in %lu members %s", watch_name(s->system, k),
                    tally->doubts[k], WATCH_TOO_OFTEN);
}

void watched_keep(struct tally *tally, const struct settings *s, struct pk_keep *k)
{
    const size_t m = kinds(s), all = s->system->events.n * s->asked.members;
    if (tally->crossings)
        pk_keep(k, tally->crossings, 3 * m * sizeof *tally->crossings);
    if (tally->first)
        pk_keep(k, tally->first, all * sizeof *tally->first);
}

/* Writes `count` events or switches, the first with index `from`. */
static void report_kind(const struct tally *tally, const struct settings *s, struct json *j,
                        const char *key, size_t from, size_t count)
{
    json_open(j, key, '[');
    for (size_t k = from; k < from + count; k++) {
        json_open(j, NULL, '{');
        json_text(j, "name", watch_name(s->system, k));
        json_counts(j, {"count", tally->crossings[k]}, {"never", tally->never[k]},
                    {"doubts", tally->doubts[k]});
        if (k < s->system->events.n)
            json_flag(j, "stop", s->system->events.table[k].stop);
        if (k < s->system->events.n && tally->first)
            json_numbers(j, "first", tally->first + k * s->asked.members, s->asked.members);
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

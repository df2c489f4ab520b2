/* An ensemble as `pkgen run --ensemble` asks for it: members by the thousand, a batch in memory at a
 * time, rows in the order of members whatever thread made them. Every member's parameters are
 * checked before the first one runs.
 */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "ensemble.h"

/* A batch is as many members as keep their rows within this. */
enum { BATCH_BYTES = 1 << 26, CHUNK = 64 };

int ensemble_setting(struct settings *s, const struct pk_system *system, size_t line,
                     char *const word[], int *code)
{
    const struct {
        const char *name;
        size_t count;
    } kinds[] = {{"param", system->n_parameters},
                 {"input", system->n_inputs},
                 {"q", pk_system_count(system, s->params)},
                 {"v", pk_system_count(system, s->params)}};
    const int members = strcmp(word[0], "members") == 0;
    size_t index;
    *code = 0;
    if (members || strcmp(word[0], "threads") == 0) {
        if (!settings_index(word[1], (size_t)-1, members ? &s->members : &s->threads))
            *code = settings_usage(line, "not a count", word[1]);
        return 1;
    }
    if (strcmp(word[0], "column") != 0)
        return 0;
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        if (strcmp(word[1], kinds[i].name) != 0)
            continue;
        struct column *columns =
            (struct column *)realloc(s->columns, (s->n_columns + 1) * sizeof *columns);
        if (!columns || !settings_index(word[2], kinds[i].count, &index)) {
            *code = settings_usage(line, "no such quantity", word[2]);
            return 1;
        }
        s->columns = columns;
        columns[s->n_columns++] = (struct column){kinds[i].name[0], index};
        return 1;
    }
    *code = settings_usage(line, "a column is of param, input, q or v", word[1]);
    return 1;
}

int ensemble_fixed(const struct settings *s)
{
    const struct pk_ensemble e = {
        .system = run_system, .method = s->method, .options = s->options};
    return pk_ensemble_fixed(&e);
}

struct batch {
    struct pk_ensemble e;
    const struct settings *s;
    const struct pk_system *system;
    size_t n, size; /* members that it has room for */
    char *params;
    pk_real *numbers, *q0, *v0, *u, *t;
    double *values; /* of the file */
    unsigned char *given;
    void *block;
    size_t block_size, threads;
    FILE *file;
};

struct tally {
    size_t done, failed, stopped, first_failed;
    enum pk_status status;
    pk_real t;
};

static void *memory(size_t count, size_t size)
{
    void *found = calloc(count ? count : 1, size ? size : 1);
    if (!found) {
        fprintf(stderr, "run: out of memory\n");
        exit(4);
    }
    return found;
}

/* Parameters, start and inputs of member i of the batch from a row of the file. */
static int set_member(struct batch *b, size_t i, size_t member, const double *row)
{
    const struct settings *s = b->s;
    char *params = b->params + i * b->system->params_size;
    pk_real *q = b->q0 + i * b->n, *v = b->v0 + i * b->n, *u = b->u + i * b->system->n_inputs;
    memcpy(params, s->params, b->system->params_size);
    memcpy(u, s->u, b->system->n_inputs * sizeof *u);
    memcpy(b->given, s->given, b->system->n_parameters);
    for (size_t k = 0; k < s->n_columns; k++)
        if (s->columns[k].kind == 'p') {
            const pk_real x = (pk_real)row[k];
            memcpy(params + b->system->parameters[s->columns[k].index].offset, &x, sizeof x);
            b->given[s->columns[k].index] = 1;
        }
    b->system->derive(params, b->given);
    const int outside = b->system->prepare(params);
    if (outside) {
        const int one = (size_t)outside <= b->system->n_parameters;
        fprintf(stderr, "run: member %zu: %s%s\n", member + 1,
                one ? b->system->parameters[outside - 1].what.name
                    : "what is computed from its parameters is not finite",
                one ? " is outside its bounds" : "");
        return 2;
    }
    b->system->start(params, q, v);
    for (size_t k = 0; k < b->n; k++) {
        if (s->start_given[k])
            q[k] = s->q[k];
        if (s->start_given[b->n + k])
            v[k] = s->v[k];
    }
    for (size_t k = 0; k < s->n_columns; k++) {
        const struct column c = s->columns[k];
        if (c.kind != 'p')
            (c.kind == 'i' ? u : c.kind == 'q' ? q : v)[c.index] = (pk_real)row[k];
    }
    return 0;
}

/* The next `count` members of the file, from `first` on. */
static int read_members(struct batch *b, size_t first, size_t count)
{
    const size_t columns = b->s->n_columns;
    if (columns && fread(b->values, columns * sizeof(double), count, b->file) != count) {
        fprintf(stderr, "run: %s ends early\n", b->s->ensemble);
        return 2;
    }
    for (size_t i = 0; i < count; i++) {
        const int code = set_member(b, i, first + i, b->values + i * columns);
        if (code)
            return code;
    }
    return 0;
}

static int stop(void *context)
{
    (void)context;
    return run_interrupted();
}

static void allocate(struct batch *b, struct run *run, size_t rows)
{
    const struct settings *s = &run->settings;
    struct pk_ensemble *e = &b->e;
    b->s = s;
    b->system = run_system;
    b->n = pk_system_count(b->system, s->params);
    const size_t fit = BATCH_BYTES / (2 * b->n * rows * sizeof(pk_real)) + 1;
    b->size = fit < s->members ? fit : s->members;
    if (b->size > CHUNK && b->size < s->members)
        b->size -= b->size % CHUNK; /* whole blocks */
    b->params = (char *)memory(b->size, b->system->params_size);
    b->q0 = (pk_real *)memory(b->size * b->n, sizeof *b->q0);
    b->v0 = (pk_real *)memory(b->size * b->n, sizeof *b->v0);
    b->u = (pk_real *)memory(b->size * b->system->n_inputs, sizeof *b->u);
    b->t = (pk_real *)memory(rows, sizeof *b->t);
    b->values = (double *)memory(b->size * s->n_columns, sizeof *b->values);
    b->given = (unsigned char *)memory(b->system->n_parameters, 1);
    memcpy(b->params, s->params, b->system->params_size);
    *e = (struct pk_ensemble){.system = b->system,
                              .method = s->method,
                              .options = s->options,
                              .members = b->size,
                              .params = b->params,
                              .q0 = b->q0,
                              .v0 = b->v0,
                              .u = b->u,
                              .rows = rows,
                              .t = b->t,
                              .stop = stop};
    e->q = (pk_real *)memory(b->size * rows * b->n, sizeof *e->q);
    e->v = (pk_real *)memory(b->size * rows * b->n, sizeof *e->v);
    e->done = (size_t *)memory(b->size, sizeof *e->done);
    e->last_t = (pk_real *)memory(b->size, sizeof *e->last_t);
    e->status = (enum pk_status *)memory(b->size, sizeof *e->status);
    b->threads = pk_ensemble_threads();
    if (s->threads && b->threads > 1)
        b->threads = s->threads;
    b->block_size = b->threads * pk_ensemble_size(e);
    b->block = memory(b->block_size, 1);
    run->row = (pk_real *)memory(2 * b->n + b->system->n_observed + 1, sizeof *run->row);
}

static void release(struct batch *b, struct run *run)
{
    void *const all[] = {b->params,   b->q0,        b->v0, b->u,    b->t,       b->values, b->given,
                         b->e.q,      b->e.v,       b->e.done, b->e.last_t, b->e.status, b->block,
                         run->row};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++)
        free(all[i]);
    if (b->file)
        fclose(b->file);
}

/* A member's row; the driver's own columns take its parameters and inputs. */
static void write_row(struct batch *b, struct run *run, size_t i, size_t member, pk_real t,
                      const pk_real *q, const pk_real *v)
{
    void *const params = run->settings.params;
    pk_real *const u = run->settings.u;
    run->settings.params = b->params + i * b->system->params_size;
    run->settings.u = b->u + i * b->system->n_inputs;
    fprintf(stdout, "%zu,", member + 1);
    output_row(run, stdout, t, q, v);
    run->settings.params = params;
    run->settings.u = u;
}

static void write_batch(struct batch *b, struct run *run, size_t first, size_t count,
                        struct tally *tally)
{
    const struct pk_ensemble *e = &b->e;
    for (size_t i = 0; i < count; i++) {
        if (run->settings.has_every && e->status[i] != PK_BAD_ARGUMENT && e->status[i] != PK_REFUSED)
            write_row(b, run, i, first + i, 0, b->q0 + i * b->n, b->v0 + i * b->n);
        for (size_t row = 0; row < e->done[i]; row++) {
            const size_t at = (i * e->rows + row) * b->n;
            write_row(b, run, i, first + i, b->t[row], e->q + at, e->v + at);
        }
        tally->done += e->status[i] == PK_DONE;
        tally->stopped += e->status[i] > 0;
        if (e->status[i] < 0 && tally->failed++ == 0) {
            tally->first_failed = first + i;
            tally->status = e->status[i];
            tally->t = e->last_t[i];
        }
    }
}

static int report(const struct run *run, const struct batch *b, const struct tally *tally)
{
    const struct settings *s = &run->settings;
    FILE *file = fopen(s->report, "w");
    if (!file) {
        fprintf(stderr, "run: cannot write %s: %s\n", s->report, strerror(errno));
        return 1;
    }
    fputs("{\n  \"model\": ", file);
    output_text(file, b->system->name);
    fputs(",\n  \"source_hash\": ", file);
    output_text(file, b->system->source_hash);
    fprintf(file, ",\n  \"method\": \"%s\",\n  \"order\": %d,\n  \"step\": ", s->method->name,
            s->method->order);
    if (ensemble_fixed(s))
        output_real(file, s->options.h);
    else
        fputs("null", file);
    fprintf(file,
            ",\n  \"members\": %zu,\n  \"done\": %zu,\n  \"failed\": %zu,\n  \"first_failed\": ",
            s->members, tally->done, tally->failed);
    if (tally->failed) {
        fprintf(file, "{\"member\": %zu, \"status\": \"%s\", \"text\": \"%s\", \"t\": ",
                tally->first_failed + 1, pk_status_name(tally->status),
                pk_status_text(tally->status));
        output_real(file, tally->t);
        fputs("}", file);
    } else {
        fputs("null", file);
    }
    fprintf(file,
            ",\n  \"interrupted\": %s,\n  \"rows\": %lu,\n  \"threads\": %zu,\n"
            "  \"seconds\": %.6g\n}\n",
            run->interrupted ? "true" : "false", run->rows, b->threads, run->seconds);
    const int failed = ferror(file);
    return fclose(file) || failed;
}

/* What is said at the end, and the exit code. */
static int finish(struct run *run, const struct batch *b, const struct tally *tally)
{
    int code = 0;
    errno = 0;
    if (!run->write_failed && (fflush(stdout) || ferror(stdout)))
        run->write_failed = errno ? errno : EIO;
    if (tally->failed) {
        fprintf(stderr, "run: %s: %zu of %zu members failed, first member %zu: %s; "
                        "last valid time %.17g\n",
                run->settings.method->name, tally->failed, run->settings.members,
                tally->first_failed + 1, pk_status_text(tally->status), (double)tally->t);
        code = 4;
    }
    if (run->not_finite) {
        fprintf(stderr, "run: %s is not finite in %lu of %lu rows, first at t = %.17g\n",
                run->not_finite, run->bad_rows, run->rows, run->bad_t);
        code = 4;
    }
    if (run->write_failed) {
        fprintf(stderr, "run: cannot write rows: %s\n", strerror(run->write_failed));
        code = 2;
    }
    run->interrupted = run_interrupted();
    if (run->interrupted) {
        fprintf(stderr, "run: interrupted after %zu of %zu members\n", tally->done,
                run->settings.members);
        code = 130;
    }
    if (run->settings.report && report(run, b, tally) && code == 0)
        code = 2;
    return code;
}

/* Every member once, without running: a parameter out of bounds shows before the first row. */
static int check_members(struct batch *b)
{
    int code = 0;
    for (size_t first = 0; code == 0 && first < b->s->members; first += b->size) {
        const size_t left = b->s->members - first;
        code = read_members(b, first, left < b->size ? left : b->size);
    }
    rewind(b->file);
    return code;
}

int ensemble_run(struct run *run, pk_real count)
{
    struct batch b = {0};
    struct tally tally = {0};
    struct settings *s = &run->settings;
    const size_t rows = (size_t)count;
    const double began = run_now();
    int code = 0;

    run->problem.system = run_system;
    b.file = fopen(s->ensemble, "rb");
    if (!b.file || s->members == 0) {
        fprintf(stderr, "run: cannot read %s\n", s->ensemble);
        return 2;
    }
    allocate(&b, run, rows);
    for (size_t k = 0; k < rows; k++)
        b.t[k] = k + 1 < rows ? (pk_real)(k + 1) * s->every : s->until;
    if (rows > 1 && ensemble_fixed(s)) {
        const pk_real tail = s->until - b.t[rows - 2];
        if (tail < s->every - 4 * PK_EPSILON * s->until)
            b.e.last_h = tail / run_intervals(tail, s->options.h);
    }
    code = check_members(&b);
    if (code == 0) {
        fputs("member,", stdout);
        output_header(run, stdout);
    }
    for (size_t first = 0; code == 0 && first < s->members && !run_interrupted();
         first += b.size) {
        const size_t left = s->members - first;
        b.e.members = left < b.size ? left : b.size;
        code = read_members(&b, first, b.e.members);
        if (code)
            break;
        pk_ensemble_run_threads(&b.e, b.threads, b.block, b.block_size);
        write_batch(&b, run, first, b.e.members, &tally);
        run_progress(run, (double)(first + b.e.members) / (double)s->members, 0);
        if (run->write_failed)
            break;
    }
    run->seconds = run_now() - began;
    if (code == 0)
        code = finish(run, &b, &tally);
    release(&b, run);
    return code;
}

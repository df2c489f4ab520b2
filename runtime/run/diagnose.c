/* Diagnostics of a run; see diagnose.h. Each writes one member of an object in JSON as it is found:
 * {"status": ..., "reason": ...} says how it went, and numbers follow where it went well.
 */
#define _POSIX_C_SOURCE 200809L

#include <stdlib.h>
#include <string.h>

#include "diagnose_parts.h"
#include "observe.h"

/* Diagnostics that are made of rows. */
#define FLAG_OF_MOTION(name)
#define FLAG_OF_OF_ROWS(name) | 1u << DIAGNOSE_PLACE_##name
#define FLAG_OF_REDUCED(name) | 1u << DIAGNOSE_PLACE_##name
#define FLAG(name, of, kernels) FLAG_OF_##of(name)
static const unsigned OF_ROWS = 0 DIAGNOSTICS(FLAG);

/* Spectra are of rows, and steps, actions and modes are looked at there. */
static void keep_row(struct run *run, const struct moment *at)
{
    const size_t n = run->settings.n, width = 1 + 2 * n;
    if (!(run->settings.diagnose & OF_ROWS))
        return;
    if (run->at_event && run->settings.has_every) /* spectra are of rows at equal times */
        return;
    if (!run->diagnostics)
        run->diagnostics =
            (struct diagnostics *)memory_take(&run->memory, 1, sizeof *run->diagnostics);
    struct diagnostics *d = run->diagnostics;
    if (d->n_rows == d->capacity) {
        d->capacity = d->capacity ? 2 * d->capacity : 1024;
        d->rows =
            (pk_real *)memory_grow(&run->memory, d->rows, d->capacity * width, sizeof *d->rows);
    }
    pk_real *row = d->rows + d->n_rows++ * width;
    row[0] = at->t;
    memcpy(row + 1, at->q, n * sizeof *row);
    memcpy(row + 1 + n, at->v, n * sizeof *row);
}

void diagnose_real(struct diagnostics *d, const char *key, pk_real x)
{
    fprintf(d->file, ", \"%s\": ", key);
    report_real(d->file, x);
}

struct diagnostics *diagnose_open(struct run *run)
{
    if (!run->diagnostics)
        run->diagnostics =
            (struct diagnostics *)memory_take(&run->memory, 1, sizeof *run->diagnostics);
    struct diagnostics *d = run->diagnostics;
    d->file = run_text(run, &d->json);
    d->run = run;
    d->first = 1;
    d->all = run->settings.diagnose == DIAGNOSE_ALL;
    return d;
}

int diagnose_member(struct diagnostics *d, const char *name, enum pk_status status,
                    const char *reason)
{
    fprintf(d->file, "%s\n    \"%s\": {\"status\": \"%s\", \"reason\": ", d->first ? "" : ",", name,
            pk_status_name(status));
    d->first = 0;
    report_text(d->file, reason);
    if (status >= 0)
        return 1;
    fputs("}", d->file);
    if (d->run->control.stop) /* told once, by diagnose() */
        return 0;
    run_say(d->run, "diagnose %s: %s", name, reason);
    if (d->code == 0 && status == PK_REFUSED)
        d->code = d->all ? PK_RUN_DONE : PK_RUN_USAGE; /* of all, those that apply */
    else if (d->code == 0)
        d->code = PK_RUN_FAILED;
    return 0;
}

#define ROW(name, of, kernels) {#name, 1u << DIAGNOSE_PLACE_##name, diagnose_##name},
static const struct {
    const char *name;
    unsigned flag;
    void (*make)(struct run *run, struct diagnostics *d); /* in this order */
} names[] = {DIAGNOSTICS(ROW){"all", DIAGNOSE_ALL, NULL},
             {"area", DIAGNOSE_AREA, NULL}}; /* see diagnose_area.h */

unsigned pk_run_diagnostic(const char *name)
{
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (strcmp(names[i].name, name) == 0)
            return names[i].flag;
    return 0;
}

static int stop(void *context)
{
    struct run *run = (struct run *)context;
    return run_stopped(run, 1);
}

enum pk_run_code diagnose_run(struct run *run, enum pk_run_code code)
{
    const unsigned wanted = run->settings.diagnose;
    if (!wanted || code || run->interrupted || run->write_failed || run->it.status < 0 ||
        !(run->it.t > 0))
        return code;
    struct diagnostics *d = diagnose_open(run);
    if (run->out)
        fflush(run->out); /* rows are whole, whatever comes of this */
    run->settings.options.stop = stop;
    run->settings.options.context = run;
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (names[i].make && (wanted & names[i].flag) && !run->control.stop)
            names[i].make(run, d);
    run_text_end(run);
    if (!run->control.stop)
        return d->code;
    run_say(run, "interrupted in --diagnose");
    free(d->json);
    d->json = NULL;
    return PK_RUN_INTERRUPTED;
}

void diagnose_report(const struct run *run, FILE *file)
{
    if (run->diagnostics && run->diagnostics->json)
        fprintf(file, ",\n  \"diagnostics\": {%s\n  }", run->diagnostics->json);
}

const struct observer diagnose_observer = {.row = keep_row, .report = diagnose_report};

void diagnose_free(struct run *run)
{
    if (run->diagnostics)
        free(run->diagnostics->json);
}

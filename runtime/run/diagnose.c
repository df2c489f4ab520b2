/* Diagnostics of a run; see diagnose.h. Each writes one member of an object in JSON as it is found:
 * {"status": ..., "reason": ...} says how it went, and numbers follow where it went well.
 */
#define _POSIX_C_SOURCE 200809L

#include <signal.h>
#include <stdlib.h>
#include <string.h>

#include "diagnose_parts.h"
#include "ensemble.h"
#include "words.h"

enum { STATES = 16 };
/* What is made of rows. */
static const unsigned OF_ROWS =
    DIAGNOSE_SPECTRUM | DIAGNOSE_SYMPLECTIC | DIAGNOSE_ACTION | DIAGNOSE_MODES;
static const double THRESHOLD = 1e-3; /* of reversal: what has come so far from its start is lost */

void diagnose_row(struct run *run, pk_real t, const pk_real *q, const pk_real *v)
{
    const size_t n = run->settings.n, width = 1 + 2 * n;
    if (!(run->settings.diagnose & OF_ROWS))
        return;
    if (run->at_event && run->settings.has_every) /* spectra are of rows at equal times */
        return;
    if (!run->diagnostics)
        run->diagnostics = (struct diagnostics *)words_allocate(1, sizeof *run->diagnostics);
    struct diagnostics *d = run->diagnostics;
    if (d->n_rows == d->capacity) {
        d->capacity = d->capacity ? 2 * d->capacity : 1024;
        d->rows = (pk_real *)realloc(d->rows, d->capacity * width * sizeof *d->rows);
        if (!d->rows) {
            fprintf(stderr, "run: out of memory for the rows that --diagnose wants\n");
            exit(4);
        }
    }
    pk_real *row = d->rows + d->n_rows++ * width;
    row[0] = t;
    memcpy(row + 1, q, n * sizeof *q);
    memcpy(row + 1 + n, v, n * sizeof *v);
}

void diagnose_real(struct diagnostics *d, const char *key, pk_real x)
{
    fprintf(d->file, ", \"%s\": ", key);
    output_real(d->file, x);
}

struct diagnostics *diagnose_open(struct run *run)
{
    if (!run->diagnostics)
        run->diagnostics = (struct diagnostics *)words_allocate(1, sizeof *run->diagnostics);
    struct diagnostics *d = run->diagnostics;
    d->file = open_memstream(&d->json, &d->json_size);
    if (!d->file) {
        fprintf(stderr, "run: out of memory for --diagnose\n");
        exit(4);
    }
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
    output_text(d->file, reason);
    if (status >= 0)
        return 1;
    fputs("}", d->file);
    fprintf(stderr, "run: diagnose %s: %s\n", name, reason);
    if (d->code == 0 && status == PK_REFUSED)
        d->code = d->all ? 0 : EXIT_USAGE; /* of all, those that apply */
    else if (d->code == 0)
        d->code = 4;
    return 0;
}

static void reversal(struct run *run, struct diagnostics *d)
{
    const struct settings *s = &run->settings;
    const size_t size = pk_reversal_size(&run->problem, s->method);
    void *block = words_allocate(size, 1);
    struct pk_integrator it = {0};
    struct pk_reversal r = {0};
    char reason[512];
    const enum pk_status status =
        pk_reversal_find(&r, &it, &run->problem, s->method, &s->options, 0, s->q, s->v, run->it.t,
                         (pk_real)THRESHOLD, block, size);
    if (status == PK_REFUSED && run_model->n_switches && !run_model->impulses &&
        !(run_model->facts & PK_SMOOTH))
        strcpy(reason, "the way back is not followed through switches: give a method that needs no "
                       "smooth equations, as dop853");
    else if (status < 0 && it.method)
        pk_integrator_reason(&it, reason, sizeof reason);
    else
        strcpy(reason, pk_status_text(status));
    if (diagnose_member(d, "reversal", status, reason)) {
        diagnose_real(d, "threshold", r.threshold);
        fprintf(d->file, ", \"symmetric\": %s, \"lost\": %s",
                s->method->traits & PK_SYMMETRIC ? "true" : "false", r.passed ? "true" : "false");
        diagnose_real(d, "horizon_lo", r.horizon_lo);
        diagnose_real(d, "horizon_hi", r.passed ? r.horizon_hi : PK_INFINITY);
        diagnose_real(d, "predicted", d->exponent > 0
                                 ? PK_F(log)(r.threshold / PK_EPSILON) / (pk_real)d->exponent
                                 : PK_INFINITY);
        fputs(", \"times\": [", d->file);
        for (size_t i = 0; i < r.count; i++) {
            fputs(i ? ", [" : "[", d->file);
            output_real(d->file, r.at[i].t);
            fputs(", ", d->file);
            output_real(d->file, r.at[i].error);
            fputs("]", d->file);
        }
        fputs("]}", d->file);
    }
    pk_integrator_free(&it);
    free(block);
}

/* The largest defect over states spread over the rows; a step that cannot be made at one of them is
 * counted, and is a failure if none could be. */
static void symplectic(struct run *run, struct diagnostics *d)
{
    const struct settings *s = &run->settings;
    const struct pk_system *system = run->problem.system;
    const size_t size = pk_stepmap_size(&run->problem, s->method), width = 1 + 2 * s->n;
    const size_t states = d->n_rows < 1 ? 1 : d->n_rows < STATES ? d->n_rows : STATES;
    const int fixed = !(s->method->traits & PK_ADAPTIVE);
    const pk_real h = fixed ? s->options.h : run->it.t / (pk_real)run->it.count.steps;
    void *block = words_allocate(size, 1);
    struct pk_stepmap most = {.defect = -1}, map;
    pk_real t = 0;
    enum pk_status status = PK_DONE, last = PK_DONE;
    size_t made = 0;
    for (size_t k = 0; k < states && status != PK_REFUSED; k++) {
        const size_t at = states > 1 ? k * (d->n_rows - 1) / (states - 1) * width : 0;
        const pk_real *row = d->rows ? d->rows + at : NULL; /* no row: the start */
        status = pk_stepmap_find(&map, &run->problem, s->method, &s->options, h, row ? row[0] : 0,
                                 row ? row + 1 : s->q, row ? row + 1 + s->n : s->v, NULL, block,
                                 size);
        if (status < 0) {
            last = status;
            continue;
        }
        made++;
        if (map.defect - map.rounding > most.defect - most.rounding || most.defect < 0) {
            most = map;
            t = row ? row[0] : 0;
        }
    }
    const char *reason = pk_status_text(made ? PK_DONE : last);
    if (!made && last == PK_REFUSED)
        reason = diagnose_not_free(system) ? diagnose_not_free(system)
                 : system->n_states
                     ? "states have no momenta, so there is no symplectic form to be kept"
                 : diagnose_no_variation(system)
                     ? diagnose_no_variation(system)
                     : "steps of this method have no length of their own: take one of fixed steps";
    if (diagnose_member(d, "symplectic", made ? PK_DONE : last, reason)) {
        diagnose_real(d, "defect", most.defect);
        diagnose_real(d, "volume", most.volume);
        diagnose_real(d, "rounding", most.rounding);
        diagnose_real(d, "step", most.h);
        diagnose_real(d, "t", t);
        fprintf(d->file, ", \"states\": %zu, \"failed\": %zu, \"symplectic\": %s, "
                         "\"variational\": %s}",
                made, states - made, most.defect <= most.rounding ? "true" : "false",
                system->facts & PK_VARIATIONAL ? "true" : "false");
    }
    free(block);
}

static const struct {
    const char *name;
    unsigned flag;
    void (*make)(struct run *run, struct diagnostics *d); /* in this order */
} names[] = {{"lyapunov", DIAGNOSE_LYAPUNOV, diagnose_lyapunov},
             {"reversal", DIAGNOSE_REVERSAL, reversal},
             {"spectrum", DIAGNOSE_SPECTRUM, diagnose_spectrum},
             {"symplectic", DIAGNOSE_SYMPLECTIC, symplectic},
             {"least_action", DIAGNOSE_LEAST_ACTION, diagnose_least_action},
             {"action", DIAGNOSE_ACTION, diagnose_action},
             {"angular_momentum", DIAGNOSE_ANGULAR_MOMENTUM, diagnose_angular_momentum},
             {"lrl", DIAGNOSE_LRL, diagnose_lrl},
             {"modes", DIAGNOSE_MODES, diagnose_modes},
             {"all", DIAGNOSE_ALL, NULL},
             {"area", DIAGNOSE_AREA, NULL}}; /* see diagnose_area.h */

unsigned diagnose_flag(const char *name)
{
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (strcmp(names[i].name, name) == 0)
            return names[i].flag;
    return 0;
}

int diagnose_run(struct run *run, int code)
{
    const unsigned wanted = run->settings.diagnose;
    if (!wanted || code || run->interrupted || run->write_failed || run->it.status < 0 ||
        !(run->it.t > 0))
        return code;
    struct diagnostics *d = diagnose_open(run);
    fflush(stdout);
    signal(SIGINT, SIG_DFL); /* rows are written; there is nothing else to save */
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (names[i].make && (wanted & names[i].flag))
            names[i].make(run, d);
    fclose(d->file);
    return d->code;
}

void diagnose_report(const struct run *run, FILE *file)
{
    if (run->diagnostics && run->diagnostics->json)
        fprintf(file, ",\n  \"diagnostics\": {%s\n  }", run->diagnostics->json);
}

void diagnose_free(struct run *run)
{
    if (!run->diagnostics)
        return;
    free(run->diagnostics->rows);
    free(run->diagnostics->json);
    free(run->diagnostics);
}

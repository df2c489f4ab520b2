/* Functions shared by the diagnostics. Each diagnostic writes one member of a JSON object, which
 * begins with {"status": ..., "reason": ...}; numbers follow if it succeeded. */
#include "parts.h"

#include "../observers/observers.h"
#include "tape.h"

/* OF_ROWS: the flags of all diagnostics that read rows, combined. */
#define FLAG_OF_MOTION(name)
#define FLAG_OF_OF_ROWS(name) | 1u << DIAGNOSE_PLACE_##name
#define FLAG_OF_REDUCED(name) | 1u << DIAGNOSE_PLACE_##name
#define FLAG(name, of, kernels) FLAG_OF_##of(name)
static const unsigned OF_ROWS = 0 DIAGNOSTICS(FLAG);

static struct diagnostics *diagnostics(struct pk_run *run)
{
    if (!run->diagnostics)
        run->diagnostics = memory_take(&run->memory, 1, sizeof *run->diagnostics);
    return run->diagnostics;
}

/* Keeps a row for diagnostics that read rows. */
static void keep_row(struct pk_run *run, const struct moment *at)
{
    const size_t n = run->settings.n, width = 1 + 2 * n;
    /* Rows at events are left out, since spectra need equal intervals. */
    if (!(run->settings.asked.diagnose & OF_ROWS) || (run->at_event && run->settings.has_every))
        return;
    struct diagnostics *d = diagnostics(run);
    d->rows = memory_room(&run->memory, d->rows, d->n_rows + 1, &d->room, width * sizeof *d->rows);
    pk_real *row = d->rows + d->n_rows++ * width;
    row[0] = at->t;
    memcpy(row + 1, at->q, n * sizeof *row);
    memcpy(row + 1 + n, at->v, n * sizeof *row);
}

struct diagnostics *diagnose_open(struct pk_run *run)
{
    struct diagnostics *d = diagnostics(run);
    d->json = (struct json){.file = run_text(run, &d->text)};
    d->run = run;
    d->all = run->settings.asked.diagnose == DIAGNOSE_ALL;
    json_open(&d->json, NULL, '{');
    return d;
}

void diagnose_close(struct diagnostics *d)
{
    json_close(&d->json, '}');
    run_text_end(d->run);
}

void diagnose_one(struct diagnostics *d, const char *name, void (*make)(struct diagnostics *d))
{
    d->name = name;
    json_open(&d->json, name, '{');
    make(d);
    json_close(&d->json, '}');
}

const pk_real *diagnose_row(const struct diagnostics *d, size_t k, size_t count)
{
    const size_t row = count > 1 ? k * (d->n_rows - 1) / (count - 1) : 0;
    return d->rows + row * (1 + 2 * d->run->settings.n);
}

int diagnose_told(struct diagnostics *d, enum pk_status status, const char *reason,
                  const struct pk_integrator *it)
{
    char text[512];
    if (!reason && status < 0 && it && it->method) {
        pk_integrator_reason(it, text, sizeof text);
        reason = text;
    }
    reason = reason ? reason : pk_status_text(status);
    json_text(&d->json, "status", pk_status_name(status));
    json_text(&d->json, "reason", reason);
    /* diagnose_run() reports a user's interruption, once for all diagnostics. */
    if (status >= 0 || d->run->control.stop)
        return status >= 0;
    run_say(d->run, "diagnose %s: %s", d->name, reason);
    if (d->code == 0 && status == PK_REFUSED)
        /* If all diagnostics were requested, inapplicable ones are no errors. */
        d->code = d->all ? PK_RUN_DONE : PK_RUN_USAGE;
    else if (d->code == 0)
        d->code = PK_RUN_FAILED;
    return 0;
}

struct motion motion_of(struct pk_run *run)
{
    const struct settings *s = &run->settings;
    return (struct motion){.problem = &run->problem,
                           .method = s->method,
                           .options = s->options,
                           .end = run->it.t,
                           .q = s->q,
                           .v = s->v,
                           .memory = &run->memory};
}

const char *diagnose_not_free(const struct pk_system *system)
{
    if (system->constraints.n)
        return "the model has constraints, on which q and p are not free";
    return system->n_rotations
               ? "the model has rotations, whose body rates are the rates of no coordinates"
               : NULL;
}

const char *diagnose_no_variation(const struct pk_run *run)
{
    const struct pk_system *system = run->problem.system;
    if (run->settings.method->needs & PK_FAST)
        return "the fast forces by which this method goes have no derivatives here: take another";
    if (run->settings.method->traits & PK_JETS)
        return "there are no Taylor coefficients of the linearised equations: take dop853 or gauss";
    if (!system->linear)
        return "the system has no kernel linear: it was left out, or its families are kept as "
               "loops";
    return system->facts & PK_SMOOTH
               ? NULL
               : "the equations have kinks (abs, min, max, step), across which displacements jump: "
                 "linearised equations do not tell";
}

int diagnose_kink(struct pk_run *run, const pk_real *from, const pk_real *to)
{
    enum { PLACES = 64 };
    const struct pk_system *system = run->problem.system;
    const struct settings *s = &run->settings;
    const size_t n = s->n, m = pk_system_switch_count(system, s->params);
    if (system->facts & PK_SMOOTH || m == 0)
        return !(system->facts & PK_SMOOTH);
    pk_real *q = memory_take(&run->memory, 2 * n + 2 * m, sizeof *q), *v = q + n;
    pk_real *side = v + n, *first = side + m;
    int kink = 0;
    for (size_t k = 0; k <= PLACES && !kink; k++) {
        for (size_t i = 0; i < n; i++)
            q[i] = from[i] + (to[i] - from[i]) * (pk_real)k / PLACES;
        system->switches.values(s->params, 0, q, v, s->u, k ? side : first);
        for (size_t i = 0; i < m; i++)
            kink |= !((k ? side[i] : first[i]) * first[i] > 0);
    }
    return kink;
}

void diagnose_report(const struct pk_run *run, struct json *j)
{
    if (run->diagnostics && run->diagnostics->text)
        json_raw(j, "diagnostics", run->diagnostics->text);
}

/* Saves or restores the rows kept. */
static void keep(struct pk_run *run, struct pk_keep *k)
{
    struct diagnostics *d = run->diagnostics;
    const size_t size = (1 + 2 * run->settings.n) * sizeof *d->rows;
    size_t count = d ? d->n_rows : 0;
    PK_KEEP(k, count);
    if (!count || k->wrong)
        return;
    if (k->from && count > (k->size - k->used) / size) {
        k->wrong = 1;
        return;
    }
    d = diagnostics(run);
    d->rows = memory_room(&run->memory, d->rows, count, &d->room, size);
    d->n_rows = count;
    pk_keep(k, d->rows, count * size);
}

const struct observer diagnose_observer = {
    .row = keep_row, .report = diagnose_report, .keep = keep};

void diagnose_free(struct pk_run *run)
{
    if (run->diagnostics)
        free(run->diagnostics->text);
    if (run->tape)
        pk_integrator_free(&run->tape->differences.it);
}

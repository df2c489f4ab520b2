/* Makes the diagnostics of a run in the order of their list; see parts.h. */

#include "parts.h"

#define ROW(name, of, kernels) {#name, 1u << DIAGNOSE_PLACE_##name, diagnose_##name},
static const struct {
    const char *name;
    unsigned flag;
    void (*make)(struct diagnostics *d); /* called in this order */
} names[] = {DIAGNOSTICS(ROW){"all", DIAGNOSE_ALL, NULL}, {"area", DIAGNOSE_AREA, NULL}};

unsigned pk_run_diagnostic(const char *name)
{
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (strcmp(names[i].name, name) == 0)
            return names[i].flag;
    return 0;
}

static int stop(void *context)
{
    struct pk_run *run = context;
    return run_stopped(run, 1);
}

static enum pk_run_code diagnose_run(struct pk_run *run, enum pk_run_code code)
{
    const unsigned wanted = run->settings.asked.diagnose;
    if (!wanted || code || run->interrupted || run->write_failed || run->it.status < 0 ||
        !(run->it.t > 0))
        return code;
    if (run->bare.samples.n && wanted & ~(DIAGNOSE_AREA | 1u << DIAGNOSE_PLACE_spectrum))
        return run_refuse(run, "diagnose: a model with sample blocks has spectrum and area alone");
    struct diagnostics *d = diagnose_open(run);
    if (run->out)
        /* writes all rows to the file now, since a diagnostic may end the process */
        fflush(run->out);
    run->settings.options.stop = stop;
    run->settings.options.context = run;
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (names[i].make && (wanted & names[i].flag) && !run->control.stop)
            diagnose_one(d, names[i].name, names[i].make);
    diagnose_close(d);
    if (!run->control.stop)
        return d->code;
    run_say(run, "interrupted in --diagnose");
    free(d->text);
    d->text = NULL;
    return PK_RUN_INTERRUPTED;
}

const struct pk_run_diagnose pk_run_diagnose = {
    .observers = {&diagnose_observer, &area_observer, &tape_observer},
    .run = diagnose_run,
    .report = diagnose_report,
    .free = diagnose_free,
    .lyapunov = diagnose_exponent,
    .area_begin = area_begin,
    .area_note = area_note,
    .area_find = area_find,
};

/* Calls the observers of a run in the order of the report: events first, condition numbers and
 * diagnostics last. Drifts come before trust.c, and rows before reductions, which read them. */
#include "steps.h"

static const struct observer *const observers[] = {
    &watch_observer, &rows_observer,   &expect_observer,    &drift_observer,
    &trust_observer, &reduce_observer, &condition_observer,
};

#define EACH(call)                                     \
    for (size_t i = 0; run->observers[i] != NULL; i++) \
        if (run->observers[i]->call)                   \
    run->observers[i]->call

void observe_begin(struct pk_run *run)
{
    enum { OWN = sizeof observers / sizeof *observers };
    const struct pk_run_diagnose *more = run->model->diagnose;
    memcpy(run->observers, observers, sizeof observers);
    if (more)
        memcpy(run->observers + OWN, more->observers, sizeof more->observers);
    EACH(begin)(run);
}

void observe_step(struct pk_run *run, const struct moment *at) { EACH(step)(run, at); }

void observe_crossing(struct pk_run *run, size_t event, const struct moment *at)
{
    EACH(event)(run, event, at);
}

void observe_row(struct pk_run *run, const struct moment *at) { EACH(row)(run, at); }

void observe_end(struct pk_run *run) { EACH(end)(run); }

void observe_keep(struct pk_run *run, struct pk_keep *k) { EACH(keep)(run, k); }

void observe_report(const struct pk_run *run, struct json *j) { EACH(report)(run, j); }

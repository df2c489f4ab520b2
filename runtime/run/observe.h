/* One pass over a run. Whatever looks at it (rows, expectations, events, drifts, diagnostics) is an
 * observer: a row of the table in observe.c, called in the order of that table.
 */
#ifndef RUN_OBSERVE_H
#define RUN_OBSERVE_H

#include "state.h"

/* The functions that an observer has no use for are NULL. */
struct observer {
    void (*begin)(struct run *run); /* takes memory; longjmps where there is none */
    /* At the start, and where each step ends. */
    void (*step)(struct run *run, const struct moment *at);
    void (*event)(struct run *run, size_t event, const struct moment *at);
    void (*row)(struct run *run, const struct moment *at);
    void (*end)(struct run *run);                      /* of one trajectory */
    void (*report)(const struct run *run, FILE *file); /* members of the report, in JSON */
};

extern const struct observer watch_observer, rows_observer, expect_observer, drift_observer,
    trust_observer, diagnose_observer, area_observer;

void observe_begin(struct run *run);
void observe_step(struct run *run, const struct moment *at);
void observe_crossing(struct run *run, size_t event, const struct moment *at);
void observe_row(struct run *run, const struct moment *at);
void observe_end(struct run *run);
void observe_report(const struct run *run, FILE *file);

#endif

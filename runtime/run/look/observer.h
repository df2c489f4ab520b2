/* What looks at a run: rows, expectations, events, drifts, diagnostics. Each is a row of the table
 * in steps/observe.c, and knows nothing of who calls it.
 */
#ifndef RUN_OBSERVER_H
#define RUN_OBSERVER_H

#include "../base/json.h"
#include "../base/state.h"

/* The functions that an observer has no use for are NULL. */
struct observer {
    void (*begin)(struct run *run); /* takes memory */
    /* At the start, and where each step ends. */
    void (*step)(struct run *run, const struct moment *at);
    /* Of an event, or behind these of a switch. */
    void (*event)(struct run *run, size_t event, const struct moment *at);
    void (*row)(struct run *run, const struct moment *at);
    void (*end)(struct run *run);                          /* of one trajectory */
    void (*report)(const struct run *run, struct json *j); /* members of the report, in JSON */
};

extern const struct observer watch_observer, rows_observer, expect_observer, drift_observer,
    trust_observer, diagnose_observer, area_observer;

#endif

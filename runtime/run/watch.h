/* Events of a run: rows at them, their times for the report, where they stop. */
#ifndef RUN_WATCH_H
#define RUN_WATCH_H

#include "state.h"

/* Behind pk_integrator_init(). */
enum pk_run_code watch_begin(struct run *run);
/* One step, with all that is crossed in it. */
enum pk_status watch_step(struct run *run, pk_real limit);
/* Of an event, or behind these of a switch; why crossings of it may be missed. */
const char *watch_name(const struct pk_system *system, size_t k);
#define WATCH_TOO_OFTEN                                                                           \
    "its function turns too often within a step for all its crossings to be found: take shorter " \
    "steps (--step, --max-step)"
/* Says which events are crossings of errors alone, and which may be missing. */
void watch_warn(struct run *run);

#endif

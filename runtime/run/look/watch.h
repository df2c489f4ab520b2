/* Events of a run: their times for the report, and what is doubtful of them. */
#ifndef RUN_WATCH_H
#define RUN_WATCH_H

#include "../base/state.h"

enum { WATCH_TIMES = 1000 };   /* of an event, in the report */
#define WATCH_NOISE PK_C(1e-8) /* of the size of what is subtracted: no more than errors */

/* Of an event, or behind these of a switch; why crossings of it may be missed. */
const char *watch_name(const struct pk_system *system, size_t k);
#define WATCH_TOO_OFTEN                                                                           \
    "its function turns too often within a step for all its crossings to be found: take shorter " \
    "steps (--step, --max-step)"
/* Says which events are crossings of errors alone, and which may be missing. */
void watch_warn(struct run *run);

#endif

/* One pass over a run: each observer is told, in the order of the table in observe.c. */
#ifndef RUN_OBSERVE_H
#define RUN_OBSERVE_H

#include "../look/observer.h"

void observe_begin(struct run *run);
void observe_step(struct run *run, const struct moment *at);
void observe_crossing(struct run *run, size_t event, const struct moment *at);
void observe_row(struct run *run, const struct moment *at);
void observe_end(struct run *run);
void observe_report(const struct run *run, struct json *j);

#endif

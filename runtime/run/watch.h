/* Events of a run: rows at them, their times for the report, where they stop. */
#ifndef RUN_WATCH_H
#define RUN_WATCH_H

#include "output.h"

/* Behind pk_integrator_init(); 0, or the process's exit code with a message. */
int watch_begin(struct run *run);
/* One step, with all that is crossed in it. */
enum pk_status watch_step(struct run *run, pk_real limit);
/* Of an event, or behind these of a switch; why crossings of it may be missed. */
const char *watch_name(size_t k);
#define WATCH_TOO_OFTEN                                                                            \
    "its function turns too often within a step for all its crossings to be found: take shorter "  \
    "steps (--step, --max-step)"
/* Says on standard error which events are crossings of errors alone, and which may be missing. */
void watch_warn(const struct run *run);
/* The member "events" of the report. */
void watch_report(struct run *run, FILE *file);
void watch_free(struct run *run);

/* Of integrate.c: rows from the start to the end, which may be at an event; rows by time, and what is
 * expected at times, up to t in the last step, 0 where the motion there cannot be had. */
void run_integrate(struct run *run);
/* A state that a step has made, or the start: for drifts and for what is expected. */
void run_sample(struct run *run);
int run_due(struct run *run, pk_real t);

#endif

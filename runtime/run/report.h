/* The report of one trajectory, in JSON. */
#ifndef RUN_REPORT_H
#define RUN_REPORT_H

#include "base/state.h"

void report_run(struct run *run, FILE *file);

#endif

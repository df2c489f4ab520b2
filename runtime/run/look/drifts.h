/* Drifts of what is constant along a run. */
#ifndef RUN_DRIFTS_H
#define RUN_DRIFTS_H

#include "../base/json.h"
#include "../base/state.h"

/* Memory and reference values of the drifts; those of a member of an ensemble each time anew. */
void drift_begin(struct run *run, const struct pk_problem *problem);
/* {"name": ..., "max": ...} of it; as a member where it has a key. */
void report_drift(struct json *j, const char *key, const char *name, const struct pk_drift *drift);

#endif

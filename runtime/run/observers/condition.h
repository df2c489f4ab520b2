/* Condition numbers along a run or a motion. Functions do nothing if `l` is NULL. */
#ifndef RUN_CONDITION_H
#define RUN_CONDITION_H

#include <pk/condition.h>

#include "observers.h"

struct looking;

/* Returns NULL without a matrix to examine. memory_drop() frees it; `problem` must outlive it. */
struct looking *condition_begin(struct memory *memory, const struct pk_problem *problem,
                                const struct pk_method *method);
/* Called at the start and after each step; with `it` NULL, matrices of steps are not examined. */
void condition_step(struct looking *l, struct pk_integrator *it, pk_real until,
                    const struct moment *at);
/* Returns the condition number of the equations that the last step solved; 0 if it solved none. */
pk_real condition_of_step(struct memory *memory, const struct pk_problem *problem,
                          struct pk_integrator *it);
/* Writes the member "condition" of the report. */
void condition_report(const struct looking *l, struct json *j);
/* Writes a warning that equations are nearly singular, with the number of digits lost. Returns 0
 * without a warning if few digits are lost. */
int condition_warning(const struct looking *l, char *text, size_t size);

#endif

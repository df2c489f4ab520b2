/* Condition numbers along a run or a motion. `l` may be NULL: then nothing is done. */
#ifndef RUN_CONDITION_H
#define RUN_CONDITION_H

#include <pk/condition.h>

#include "observers.h"

struct looking;

/* Returns NULL without matrices to examine. memory_drop() frees it; `problem` must outlive it. */
struct looking *condition_begin(struct memory *memory, const struct pk_problem *problem,
                                const struct pk_method *method);
/* Called at the start and at the end of each step of `it`; `it` NULL: no step's own equations. */
void condition_step(struct looking *l, struct pk_integrator *it, pk_real until,
                    const struct moment *at);
/* Returns the condition number of the equations of the last step; 0: there are none. */
pk_real condition_of_step(struct memory *memory, const struct pk_problem *problem,
                          struct pk_integrator *it);
/* Writes the member "condition" of the report. */
void condition_report(const struct looking *l, struct json *j);
/* Writes a warning where the equations are nearly singular, with the digits lost; 0: too few. */
int condition_warning(const struct looking *l, char *text, size_t size);

#endif

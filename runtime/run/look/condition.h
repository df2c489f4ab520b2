/* Condition numbers along a motion, of a run or of the motion itself; `l` NULL: of none. */
#ifndef RUN_CONDITION_H
#define RUN_CONDITION_H

#include <pk/condition.h>

#include "look.h"

struct looking;

/* NULL where there is nothing to look at; for memory_drop(). `problem` stays where it is. */
struct looking *condition_begin(struct memory *memory, const struct pk_problem *problem,
                                const struct pk_method *method);
/* At the start, and where each step of `it` ends; NULL: of no integrator alone. */
void condition_step(struct looking *l, struct pk_integrator *it, pk_real until,
                    const struct moment *at);
/* Of the equations of its last step; 0: there are none. */
pk_real condition_of_step(struct memory *memory, const struct pk_problem *problem,
                          struct pk_integrator *it);
/* A member "condition". */
void condition_report(const struct looking *l, struct json *j);
/* Where the equations are nearly singular, and how many digits that costs; 0: not so many. */
int condition_warning(const struct looking *l, char *text, size_t size);

#endif

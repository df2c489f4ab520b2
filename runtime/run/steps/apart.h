/* A run of a model whose blocks of coordinates are integrated apart; see pk/apart.h. */
#ifndef RUN_APART_H
#define RUN_APART_H

#include "../base/json.h"
#include "../base/state.h"

/* What no parts can do, and the choices that they are integrated by. */
enum pk_run_code apart_choose(struct run *run);
enum pk_run_code apart_begin(struct run *run);
void apart_integrate(struct run *run);
/* A member of the report. */
void apart_report(const struct run *run, struct json *j);

#endif

/* What a scene expects of its run: columns compared at times, at events or in all rows, and drifts
 * of outputs. The driver measures; what is said of it is pkgen's.
 */
#ifndef RUN_EXPECT_H
#define RUN_EXPECT_H

#include "../base/json.h"
#include "../base/state.h"

/* The next time behind `from`, up to `limit`, at which something is expected. */
pk_real expect_limit(const struct run *run, pk_real from, pk_real limit);
/* At such a time within a step. */
void expect_landed(struct run *run, const struct moment *at);
/* Whether the drift of the energy is asked for. It is then watched where the equations do not show
 * it to be constant as well: a parameter that makes it so may be left to the run (--no-reduce). */
int expect_uses_h(const struct run *run);
/* Nothing is known yet; and what is known of one member goes to that of all, in their order. */
void expect_clear(struct settings *s);
void expect_merge(struct settings *all, const struct settings *one);
/* The members "expects" and "expect_drifts" of the report. */
void expect_report(const struct run *run, struct json *j);

#endif

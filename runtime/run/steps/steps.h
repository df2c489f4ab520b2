/* One trajectory: settled, begun, made step by step. */
#ifndef RUN_STEPS_H
#define RUN_STEPS_H

#include "../base/state.h"

/* Settings that depend on one another; memory, integrators and events; all rows; and all is given
 * back but the settings. */
enum pk_run_code run_settle(struct run *run);
enum pk_run_code run_begin(struct run *run);
void run_steps(struct run *run);
void run_end(struct run *run);

/* Of integrate.c: rows from the start to the end, which may be at an event. */
void run_integrate(struct run *run);

/* Of crossings.c, behind pk_integrator_init(); and one step, with all that is crossed in it. */
enum pk_run_code crossings_begin(struct run *run);
enum pk_status crossings_step(struct run *run, pk_real limit);

/* Of due.c. Rows by time, and what is expected at times, up to t in the last step: 0 where the
 * motion there cannot be had. */
int run_due(struct run *run, pk_real t);
/* The next time up to `limit` for which a row or what is expected asks. */
pk_real run_wanted(const struct run *run, pk_real from, pk_real limit);
/* Where a step is to end at the latest. */
pk_real run_limit(const struct run *run);
/* Where it has come to. */
struct moment run_moment(const struct run *run);
/* How many intervals of `part` cover the whole; a quotient that is whole up to round-off counts as
 * whole. Up to 1e-12 of it, yet never up to a whole interval of many. */
pk_real run_intervals(pk_real whole, pk_real part);
/* A step that was asked for, made a whole part of the interval where it is one but for rounding. */
pk_real run_step(pk_real interval, pk_real h);
/* Of row k of `count`: a double in every precision, as it is written. */
pk_real run_row_time(const struct run *run, pk_real k, pk_real count);

#endif

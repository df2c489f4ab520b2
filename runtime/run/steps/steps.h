/* One trajectory: settled, begun, made step by step. */
#ifndef RUN_STEPS_H
#define RUN_STEPS_H

#include "../look/look.h"

/* Settings that depend on one another; memory, integrators and events; all rows; and all is given
 * back but the settings. */
enum pk_run_code run_settle(struct pk_run *run);
enum pk_run_code run_begin(struct pk_run *run);
void run_steps(struct pk_run *run);
void run_end(struct pk_run *run);

/* Of integrate.c: rows from the start to the end, which may be at an event. The same a step at a
 * time: whether there is one to be made; that step, and whether there is a next one; the end. */
void run_integrate(struct pk_run *run);
int run_starts(struct pk_run *run);
int run_goes(struct pk_run *run);
void run_ends(struct pk_run *run);

/* Of crossings.c, behind pk_integrator_init(); and one step, with all that is crossed in it. */
enum pk_run_code crossings_begin(struct pk_run *run);
enum pk_status crossings_step(struct pk_run *run, pk_real limit);

/* Of due.c. Rows by time, and what is expected at times, up to t in the last step: 0 where the
 * motion there cannot be had. */
int run_due(struct pk_run *run, pk_real t);
/* The integrator for states within fixed steps, begun where the run is. */
enum pk_status run_aside(struct pk_run *run);
/* The next time up to `limit` for which a row or what is expected asks. */
pk_real run_wanted(const struct pk_run *run, pk_real from, pk_real limit);
/* Where a step is to end at the latest. */
pk_real run_limit(const struct pk_run *run);
/* Where it has come to. */
const struct moment *run_moment(struct pk_run *run);
/* How many intervals of `part` cover the whole; a quotient that is whole up to round-off counts as
 * whole. Up to 1e-12 of it, yet never up to a whole interval of many. */
pk_real run_intervals(pk_real whole, pk_real part);
/* A step that was asked for, made a whole part of the interval where it is one but for rounding. */
pk_real run_step(pk_real interval, pk_real h);
/* Of row k of `count`: a double in every precision, as it is written. */
pk_real run_row_time(const struct pk_run *run, pk_real k, pk_real count);

/* Of observe.c: each observer is told, in the order of the table there. */
void observe_begin(struct pk_run *run);
void observe_step(struct pk_run *run, const struct moment *at);
void observe_crossing(struct pk_run *run, size_t event, const struct moment *at);
void observe_row(struct pk_run *run, const struct moment *at);
void observe_end(struct pk_run *run);
void observe_keep(struct pk_run *run, struct pk_keep *k);
void observe_report(const struct pk_run *run, struct json *j);

/* Of apart.c: blocks of coordinates integrated apart; see pk/apart.h. */
/* What no parts can do, and the choices that they are integrated by. */
enum pk_run_code apart_choose(struct pk_run *run);
enum pk_run_code apart_begin(struct pk_run *run);
void apart_integrate(struct pk_run *run);
/* A member of the report. */
void apart_report(const struct pk_run *run, struct json *j);

/* The report of one trajectory, in JSON. */
void report_run(struct pk_run *run, FILE *file);

#endif

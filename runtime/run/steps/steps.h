/* One trajectory: its settings, initial state, steps and end. */
#ifndef RUN_STEPS_H
#define RUN_STEPS_H

#include "../observers/observers.h"

/* run_settle() completes settings that depend on each other; run_begin() allocates memory, starts
 * integrators and events; run_steps() makes steps and rows; run_end() frees all but the
 * settings. */
enum pk_run_code run_settle(struct pk_run *run);
enum pk_run_code run_begin(struct pk_run *run);
void run_steps(struct pk_run *run);
void run_end(struct pk_run *run);

/* In integrate.c: run_integrate() makes the whole trajectory. To make it step by step, run_starts()
 * returns whether a step is needed at all, run_goes() makes one step and returns whether another
 * one follows, and run_ends() ends the trajectory. */
void run_integrate(struct pk_run *run);
int run_starts(struct pk_run *run);
int run_goes(struct pk_run *run);
void run_ends(struct pk_run *run);

/* In crossings.c: starts after pk_integrator_init(); makes one step and handles its crossings. */
enum pk_run_code crossings_begin(struct pk_run *run);
enum pk_status crossings_step(struct pk_run *run, pk_real limit);
/* Runs the sample blocks that are due. An event whose function jumps across zero there occurs. */
enum pk_status crossings_sample(struct pk_run *run);
/* Integrates to t, or one step towards it, with the samples on the way. Observers see the events of
 * samples alone, and without `seen` none. */
enum pk_status crossings_to(struct pk_run *run, pk_real t, int one_step, int seen);

/* In due.c: writes rows and checks expectations that are due up to t in the last step. Returns 0 if
 * the state at such a time cannot be computed. */
int run_due(struct pk_run *run, pk_real t);
/* Initialises run->aside, which computes states within fixed steps, at the current state. */
enum pk_status run_aside(struct pk_run *run);
/* Returns the time of the first row or expectation after `from`, or `limit` if that is earlier. */
pk_real run_wanted(const struct pk_run *run, pk_real from, pk_real limit);
/* Returns the time that the next step must not pass. */
pk_real run_limit(const struct pk_run *run);
/* Returns the current time and state. */
const struct moment *run_moment(struct pk_run *run);
/* Returns the least number of intervals of length `part` that cover `whole`, at least 1. Ignores
 * the round-off of a quotient whole / part that should be an integer. */
pk_real run_intervals(pk_real whole, pk_real part);
/* Returns h, or interval / k for an integer k if h equals it up to round-off. */
pk_real run_step(pk_real interval, pk_real h);
/* Returns the time of row k; row `count` is the last one. The time is rounded to double
 * even if pk_real is more precise, since rows are written in doubles. */
pk_real run_row_time(const struct pk_run *run, pk_real k, pk_real count);

/* In observe.c: call the function of each observer, in the order of the table there. */
void observe_begin(struct pk_run *run);
void observe_step(struct pk_run *run, const struct moment *at);
void observe_crossing(struct pk_run *run, size_t event, const struct moment *at);
void observe_row(struct pk_run *run, const struct moment *at);
void observe_end(struct pk_run *run);
void observe_keep(struct pk_run *run, struct pk_keep *k);
void observe_report(const struct pk_run *run, struct json *j);

/* In subsystems.c: blocks of coordinates with integrators of their own; see pk/subsystems.h. */
/* Refuses settings that need all coordinates together; chooses methods and options of blocks. */
enum pk_run_code subsystems_choose(struct pk_run *run);
enum pk_run_code subsystems_begin(struct pk_run *run);
void subsystems_integrate(struct pk_run *run);
/* Writes the member "parts" of the report. */
void subsystems_report(const struct pk_run *run, struct json *j);

/* The report of one trajectory, in JSON. */
void report_run(struct pk_run *run, FILE *file);

#endif

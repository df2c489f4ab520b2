/* Observers of a run: rows, expectations, drifts, events, trust, reductions, condition numbers. The
 * table in steps/observe.c lists them and calls them.
 */
#ifndef RUN_LOOK_H
#define RUN_LOOK_H

#include <pk/keep.h>

#include "../base/json.h"
#include "../base/state.h"

/* An observer; unused functions are NULL. */
struct observer {
    void (*begin)(struct pk_run *run); /* allocates memory */
    /* Called at the start and at the end of each step. */
    void (*step)(struct pk_run *run, const struct moment *at);
    /* Called at a crossing; numbers of switches follow those of events. */
    void (*event)(struct pk_run *run, size_t event, const struct moment *at);
    void (*row)(struct pk_run *run, const struct moment *at);
    void (*end)(struct pk_run *run);                          /* end of one trajectory */
    void (*report)(const struct pk_run *run, struct json *j); /* members of the report, in JSON */
    void (*keep)(struct pk_run *run, struct pk_keep *k);      /* its state, for a checkpoint */
};

extern const struct observer watch_observer, rows_observer, expect_observer, drift_observer,
    trust_observer, condition_observer, reduce_observer;

/* Functions of run/diagnose; a program may be linked without them. */
struct pk_run_diagnose {
    const struct observer *observers[2];
    /* Makes the requested diagnostics, their JSON for the report, and messages. Returns `code`,
     * unless a diagnostic failed. */
    enum pk_run_code (*run)(struct pk_run *run, enum pk_run_code code);
    void (*report)(const struct pk_run *run, struct json *j); /* the member "diagnostics" */
    void (*free)(struct pk_run *run);
    /* Returns the largest Lyapunov exponent of a member with a run of its own; NaN on failure. */
    pk_real (*lyapunov)(struct pk_run *of);
    /* Area enclosed by an ensemble whose starts are a closed loop. Allocates room for the members
     * at the start and at `count` times. Returns the exit code. */
    enum pk_run_code (*area_begin)(struct pk_run *run, const pk_real *t, size_t count);
    /* Stores a member's state if t is its next row; the settings hold its parameters. */
    void (*area_note)(struct pk_run *run, pk_real t, const pk_real *q, const pk_real *v);
    /* Computes it for the report; `gone`: why members may have ended. Returns `code` on success. */
    enum pk_run_code (*area_find)(struct pk_run *run, enum pk_run_code code, const char *gone);
};

/* Functions of run/ensemble; a program may be linked without them. */
struct pk_run_ensemble {
    enum pk_run_code (*run)(struct pk_run *run);
    int (*fixed)(const struct settings *s); /* whether the members take fixed steps */
};

/* Rows. */
void rows_header(struct pk_run *run);
/* Appends the rows that a member kept in memory to those of the run. */
void rows_take(struct pk_run *run, const struct pk_run *from);
/* Returns a column's value; `out` are the outputs at that state, if the system has any. */
pk_real rows_value(const struct pk_run *run, const struct pk_run_column *column,
                   const struct moment *at, const pk_real *out);
/* Flushes the rows. Returns `code`, or PK_RUN_USAGE with a message if they could not be written. */
enum pk_run_code rows_end(struct pk_run *run, enum pk_run_code code);
/* Reports values that were not finite. Returns `code`, changed to a failure by them. */
enum pk_run_code rows_told(struct pk_run *run, enum pk_run_code code);
/* Returns whether all rows were made and written. */
int rows_complete(const struct pk_run *run);
/* Returns the name of the first output, or "energy", that was not finite; NULL if all were. */
const char *rows_not_finite(const struct pk_run *run, char *name, size_t size);

/* Computes run->cells. Returns the first column that is not finite, or NULL. */
const struct pk_run_column *rows_fill(struct pk_run *run, const struct moment *at);

/* Reductions of ensemble members. */
/* Stores the numbers of a member that ended at `at`, and resets for the next one. `of` is the
 * member's own run, or the ensemble's. */
void reduce_end(struct pk_run *run, struct pk_run *of, size_t member, enum pk_status status,
                const struct moment *at);

/* Expectations of a scene: columns compared at times, at events or in all rows, and drifts of
 * outputs. The runtime measures them; pkgen writes the messages. */
/* Returns the next time after `from`, at most `limit`, at which a relation is to be checked. */
pk_real expect_limit(const struct pk_run *run, pk_real from, pk_real limit);
/* Checks the relations of such a time. */
void expect_landed(struct pk_run *run, const struct moment *at);
/* Returns whether the drift of the energy is requested. It is then measured even if the equations
 * do not show that the energy is constant: that may depend on a parameter (--no-reduce). */
int expect_uses_h(const struct pk_run *run);
/* Returns whether the ends of steps need no checks: no drifts, no relations at times. */
int expect_lean(const struct pk_run *run);
/* expect_own() gives a member empty results of its own; expect_merge() adds them to the ensemble's,
 * in the order of members. */
void expect_own(struct settings *s);
void expect_merge(struct settings *all, const struct settings *one);
/* Writes the members "expects" and "expect_drifts" of the report. */
void expect_report(const struct pk_run *run, struct json *j);

/* Drifts of constants of the motion. */
/* Allocates the monitor and sets its reference values; called anew for each ensemble member. */
void drift_begin(struct pk_run *run, const struct pk_problem *problem);
/* Writes {"name": ..., "max": ...} of a drift, under `key` if that is not NULL. */
void report_drift(struct json *j, const char *key, const char *name, const struct pk_drift *drift);

/* Events: their times for the report, and warnings. */
enum { WATCH_TIMES = 1000 };   /* most times of an event in the report */
#define WATCH_NOISE PK_C(1e-8) /* |g| / max |dg/dx_i| |x_i| at most this: g is zero up to errors */

/* Returns the name of event k; numbers of switches follow those of events. */
const char *watch_name(const struct pk_system *system, size_t k);
#define WATCH_TOO_OFTEN                                                                           \
    "its function turns too often within a step for all its crossings to be found: take shorter " \
    "steps (--step, --max-step)"
/* Warns of events whose crossings may be rounding errors, and of crossings that may be missed. */
void watch_warn(struct pk_run *run);

/* How far a run can be trusted. A status describes the computed path, which may have left the true
 * motion long before: then the status says nothing about the motion. */
#define TRUST_WRONG PK_C(1e-2) /* energy drift relative to the energy's scale */
/* Status in the report for steps that went on past the end of the motion. Only this layer knows it,
 * so it is no enum pk_status. */
#define TRUST_BEYOND_NAME "RUN_BEYOND_END"
#define TRUST_BEYOND_TEXT "the motion ends before these steps do"
enum { TRUST_BEYOND_CODE = -100 };

/* Sets run->besides to the text that follows the reason of a failure: since when the energy of a
 * conservative system is wrong, and where dop853 at 1e-9 sees the same motion end. dop853 is used
 * if the method has fixed steps or a loose tolerance. It also checks fixed steps that arrive, or
 * stop at an event, with a wrong energy, and sets run->beyond if the motion ends earlier, at
 * run->ends. */
void trust_judge(struct pk_run *run);
/* After trust_judge(): the last time at which the run is known to be right. */
pk_real trust_last_valid(const struct pk_run *run);
/* Writes a warning for a run that arrived with a wrong energy; returns 0 if there is none. */
int trust_warning(const struct pk_run *run, char *text, size_t size);
/* Writes the reason why the run ended. */
void trust_reason(const struct pk_run *run, char *text, size_t size);

#endif

/* Observers of a run: rows, expectations, drifts, events, trust, reductions, condition numbers.
 * steps/observe.c lists and calls them. */
#ifndef RUN_LOOK_H
#define RUN_LOOK_H

#include <pk/keep.h>

#include "../base/json.h"
#include "../base/state.h"

/* An observer; functions that it does not need are NULL. */
struct observer {
    void (*begin)(struct pk_run *run); /* allocates memory */
    /* Called at the start and after each step. */
    void (*step)(struct pk_run *run, const struct moment *at);
    /* Called at a crossing. Events are numbered first, then switches. */
    void (*event)(struct pk_run *run, size_t event, const struct moment *at);
    void (*row)(struct pk_run *run, const struct moment *at);
    void (*end)(struct pk_run *run); /* called at the end of a trajectory */
    void (*report)(const struct pk_run *run, struct json *j); /* writes members of the report */
    void (*keep)(struct pk_run *run, struct pk_keep *k);      /* saves or restores its state */
};

extern const struct observer watch_observer, rows_observer, expect_observer, drift_observer,
    trust_observer, condition_observer, reduce_observer;

/* Functions of run/diagnose; a program may be linked without them. */
struct pk_run_diagnose {
    const struct observer *observers[3];
    /* Makes the requested diagnostics and their messages. Returns `code` unless one failed. */
    enum pk_run_code (*run)(struct pk_run *run, enum pk_run_code code);
    void (*report)(const struct pk_run *run, struct json *j); /* writes the member "diagnostics" */
    void (*free)(struct pk_run *run);
    /* Returns the largest Lyapunov exponent of a member that has its own pk_run, or NaN. */
    pk_real (*lyapunov)(struct pk_run *of);
    /* Prepares the area that an ensemble encloses whose initial states form a closed loop:
     * allocates memory for the members at the start and at `count` times. Returns the exit code. */
    enum pk_run_code (*area_begin)(struct pk_run *run, const pk_real *t, size_t count);
    /* Stores a member's state at the time of its next row; the settings hold its parameters. */
    void (*area_note)(struct pk_run *run, pk_real t, const pk_real *q, const pk_real *v);
    /* Computes the area for the report. `gone` says why members may have ended early, for messages.
     * Returns `code` unless that fails. */
    enum pk_run_code (*area_find)(struct pk_run *run, enum pk_run_code code, const char *gone);
};

/* Functions of run/ensemble; a program may be linked without them. */
struct pk_run_ensemble {
    enum pk_run_code (*run)(struct pk_run *run);
    int (*fixed)(const struct settings *s); /* returns whether the members take fixed steps */
};

/* Rows. */
void rows_header(struct pk_run *run);
/* Appends the rows that member `from` kept in memory to those of the run. */
void rows_take(struct pk_run *run, const struct pk_run *from);
/* Returns the value of a column; `out` holds the outputs at this state, if the system has any. */
pk_real rows_value(const struct pk_run *run, const struct pk_run_column *column,
                   const struct moment *at, const pk_real *out);
/* Flushes the rows. Returns `code`, or PK_RUN_USAGE with a message if they could not be written. */
enum pk_run_code rows_end(struct pk_run *run, enum pk_run_code code);
/* Reports values that were not finite; these change `code` to a failure. Returns the exit code. */
enum pk_run_code rows_told(struct pk_run *run, enum pk_run_code code);
/* Returns whether all rows were made and written. */
int rows_complete(const struct pk_run *run);
/* Returns the name of the first output (or "energy") that was not finite, or NULL. */
const char *rows_not_finite(const struct pk_run *run, char *name, size_t size);

/* Computes run->cells. Returns the first column that is not finite, or NULL. */
const struct pk_run_column *rows_fill(struct pk_run *run, const struct moment *at);

/* Stores the reductions of a member that ended at `at`, and resets them. `of` is the member's own
 * struct pk_run; if it has none, `of` is that of the ensemble. */
void reduce_end(struct pk_run *run, struct pk_run *of, size_t member, enum pk_status status,
                const struct moment *at);

/* Expectations of a scene: comparisons of columns at times, at events or at all rows, and limits of
 * drifts of outputs. The runtime evaluates them; pkgen writes the messages. */
/* Returns the next time in (from, limit] at which a relation must be checked, or `limit`. */
pk_real expect_limit(const struct pk_run *run, pk_real from, pk_real limit);
/* Checks the relations at a time that expect_limit() returned. */
void expect_landed(struct pk_run *run, const struct moment *at);
/* Returns whether the drift of the energy is requested. The drift is then measured even if the
 * facts of the system do not say that the energy is constant, as with --no-reduce. */
int expect_uses_h(const struct pk_run *run);
/* Returns whether nothing is checked at ends of steps: no drifts, no relations at times. */
int expect_lean(const struct pk_run *run);
/* expect_own() gives a member empty results of its own; expect_merge() adds these to the results of
 * the ensemble, in the order of members. */
void expect_own(struct settings *s);
void expect_merge(struct settings *all, const struct settings *one);
/* Writes the members "expects" and "expect_drifts" of the report. */
void expect_report(const struct pk_run *run, struct json *j);

/* Allocates the monitor and sets its initial values; called for each ensemble member. */
void drift_begin(struct pk_run *run, const struct pk_problem *problem);
/* Writes the statistics of a drift as an object, with the key `key` unless that is NULL. */
void report_drift(struct json *j, const char *key, const char *name, const struct pk_drift *drift);

/* Events: times of crossings for the report, and warnings. */
enum { WATCH_TIMES = 1000 }; /* limit of crossing times of an event in the report */
/* an event function g below this fraction of its scale (`parts` in struct crossed) is rounding */
#define WATCH_NOISE PK_C(1e-8)

/* Returns the name of event k. Events are numbered first, then switches. */
const char *watch_name(const struct pk_system *system, size_t k);
#define WATCH_TOO_OFTEN                                                                           \
    "its function turns too often within a step for all its crossings to be found: take shorter " \
    "steps (--step, --max-step)"
/* Warns of events whose crossings may be only rounding, and of crossings that may be missed. */
void watch_warn(struct pk_run *run);

/* trust.c determines whether the result of a run can be trusted. The status of a run describes the
 * path that was computed. If this path left the true motion earlier, the status does not tell. */
/* an energy drift above this fraction of the energy's scale is wrong */
#define TRUST_WRONG PK_C(1e-2)
/* The status in the report of a run whose steps went on past the end of the motion. Only trust.c
 * detects this case, so the status is not in enum pk_status. */
#define TRUST_BEYOND_NAME "RUN_BEYOND_END"
#define TRUST_BEYOND_TEXT "the motion ends before these steps do"
enum { TRUST_BEYOND_CODE = -100 };

/* Sets run->besides to a text that follows the reason of a failure. The text gives the time after
 * which the energy of a conservative system is wrong. If the method has fixed steps or a loose
 * tolerance, dop853 with tolerance 1e-9 integrates the same motion, and the text gives the time at
 * which that ends. dop853 also checks a run of fixed steps that did not fail, but whose energy is
 * wrong. If dop853 then finds an end of the motion before the end of the run, run->beyond is set,
 * and run->ends to the time of this end. */
void trust_judge(struct pk_run *run);
/* Returns the last time up to which the run is valid; call trust_judge() before. */
pk_real trust_last_valid(const struct pk_run *run);
/* Writes a warning if the run was completed with a wrong energy; returns 0 if not. */
int trust_warning(const struct pk_run *run, char *text, size_t size);
/* Writes the reason why the run ended. */
void trust_reason(const struct pk_run *run, char *text, size_t size);

#endif

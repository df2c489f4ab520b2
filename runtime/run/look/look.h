/* What looks at a run: rows, expectations, drifts, events, trust. Each is an observer, a row of the
 * table in steps/observe.c, and knows nothing of who calls it.
 */
#ifndef RUN_LOOK_H
#define RUN_LOOK_H

#include <pk/keep.h>

#include "../base/json.h"
#include "../base/state.h"

/* The functions that an observer has no use for are NULL. */
struct observer {
    void (*begin)(struct pk_run *run); /* takes memory */
    /* At the start, and where each step ends. */
    void (*step)(struct pk_run *run, const struct moment *at);
    /* Of an event, or behind these of a switch. */
    void (*event)(struct pk_run *run, size_t event, const struct moment *at);
    void (*row)(struct pk_run *run, const struct moment *at);
    void (*end)(struct pk_run *run);                          /* of one trajectory */
    void (*report)(const struct pk_run *run, struct json *j); /* members of the report, in JSON */
    void (*keep)(struct pk_run *run, struct pk_keep *k);      /* what it knows, for a checkpoint */
};

extern const struct observer watch_observer, rows_observer, expect_observer, drift_observer,
    trust_observer, condition_observer, reduce_observer;

/* run/diagnose, which a program may be linked without. */
struct pk_run_diagnose {
    const struct observer *observers[2];
    /* Makes what the settings ask for and keeps it as JSON for the report; messages too. The code,
     * `code` unless a diagnostic failed. */
    enum pk_run_code (*run)(struct pk_run *run, enum pk_run_code code);
    void (*report)(const struct pk_run *run, struct json *j); /* the member "diagnostics" */
    void (*free)(struct pk_run *run);
    /* The largest exponent of a member that runs by itself; not a number where it fails. */
    pk_real (*lyapunov)(struct pk_run *of);
    /* The area of an ensemble whose members are a closed loop of starts. Room for them at the start
     * and `count` times; else the exit code. */
    enum pk_run_code (*area_begin)(struct pk_run *run, const pk_real *t, size_t count);
    /* A member's state, its parameters in the settings; kept where it is at the next of its rows. */
    void (*area_note)(struct pk_run *run, pk_real t, const pk_real *q, const pk_real *v);
    /* Into the report; the code, `code` unless it failed. `gone`: why members may have ended. */
    enum pk_run_code (*area_find)(struct pk_run *run, enum pk_run_code code, const char *gone);
};

/* run/ensemble, which a program may be linked without. */
struct pk_run_ensemble {
    enum pk_run_code (*run)(struct pk_run *run);
    int (*fixed)(const struct settings *s); /* whether the members take fixed steps */
};

/* Rows. */
void rows_header(struct pk_run *run);
/* The rows that a member has kept, behind those of the run. */
void rows_take(struct pk_run *run, const struct pk_run *from);
/* A column's value; `out` are the outputs there, where the system has any. */
pk_real rows_value(const struct pk_run *run, const struct pk_run_column *column,
                   const struct moment *at, const pk_real *out);
/* All are written; the code with what there is to say. */
enum pk_run_code rows_end(struct pk_run *run, enum pk_run_code code);
/* Says what in them was not finite; the code with that. */
enum pk_run_code rows_told(struct pk_run *run, enum pk_run_code code);
/* Whether all are. */
int rows_whole(const struct pk_run *run);
/* The first output of theirs, or "energy", that was not finite; NULL where all were. */
const char *rows_not_finite(const struct pk_run *run, char *name, size_t size);

/* The cells of a row, run->cells; the column of the first that is not finite, or NULL. */
const struct pk_run_column *rows_fill(struct pk_run *run, const struct moment *at);

/* What is kept of members. */
/* A member has ended here: its numbers go to those of all, and the next one begins. `of` is its own
 * run, or that of all. */
void reduce_end(struct pk_run *run, struct pk_run *of, size_t member, enum pk_status status,
                const struct moment *at);

/* What a scene expects of its run: columns compared at times, at events or in all rows, and drifts
 * of outputs. It is measured here; what is said of it is pkgen's. */
/* The next time behind `from`, up to `limit`, at which something is expected. */
pk_real expect_limit(const struct pk_run *run, pk_real from, pk_real limit);
/* At such a time within a step. */
void expect_landed(struct pk_run *run, const struct moment *at);
/* Whether the drift of the energy is asked for. It is then watched where the equations do not show
 * it to be constant as well: a parameter that makes it so may be left to the run (--no-reduce). */
int expect_uses_h(const struct pk_run *run);
/* Whether nothing is expected of steps: neither drifts nor anything where a step ends. */
int expect_lean(const struct pk_run *run);
/* What is to be known, of which nothing is yet, in memory of a member's own; and what is known of
 * one goes to that of all, in their order. */
void expect_own(struct settings *s);
void expect_merge(struct settings *all, const struct settings *one);
/* The members "expects" and "expect_drifts" of the report. */
void expect_report(const struct pk_run *run, struct json *j);

/* Drifts of what is constant along a run. */
/* Memory and reference values of the drifts; those of a member of an ensemble each time anew. */
void drift_begin(struct pk_run *run, const struct pk_problem *problem);
/* {"name": ..., "max": ...} of it; as a member where it has a key. */
void report_drift(struct json *j, const char *key, const char *name, const struct pk_drift *drift);

/* Events: their times for the report, and what is doubtful of them. */
enum { WATCH_TIMES = 1000 };   /* of an event, in the report */
#define WATCH_NOISE PK_C(1e-8) /* of the size of what is subtracted: no more than errors */

/* Of an event, or behind these of a switch; why crossings of it may be missed. */
const char *watch_name(const struct pk_system *system, size_t k);
#define WATCH_TOO_OFTEN                                                                           \
    "its function turns too often within a step for all its crossings to be found: take shorter " \
    "steps (--step, --max-step)"
/* Says which events are crossings of errors alone, and which may be missing. */
void watch_warn(struct pk_run *run);

/* How far a run that failed can be trusted. A status is about the path that the steps made, and
 * that may have left the motion long before: then it says nothing about the motion. */
#define TRUST_WRONG PK_C(1e-2) /* of the energy's scale */
/* The status in a report of steps that went on behind the end of the motion: known to the driver
 * alone, so it is none of the core's. */
#define TRUST_BEYOND_NAME "RUN_BEYOND_END"
#define TRUST_BEYOND_TEXT "the motion ends before these steps do"
enum { TRUST_BEYOND_CODE = -100 };

/* Sets run->besides to what there is to say behind the reason of a failure: since when the energy
 * of a conservative system is wrong, and what dop853 at 1e-9 makes of the same motion where the
 * method's own steps are no judge of it (fixed, or of a loose tolerance). Likewise asks it of fixed
 * steps that arrive, or stop at an event, with a wrong energy: run->beyond where the motion ends
 * before they do, at run->ends. */
void trust_judge(struct pk_run *run);
/* Of a run that was judged. The time until which it is right, as far as is known; its reason. */
pk_real trust_last_valid(const struct pk_run *run);
/* What there is to say of one that arrived with a wrong energy all the same; 0 if nothing. */
int trust_warning(const struct pk_run *run, char *text, size_t size);
void trust_reason(const struct pk_run *run, char *text, size_t size);

#endif

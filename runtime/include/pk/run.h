/* A run of a model as one call: settings in, rows and a report out. `pkgen run`, pkgen's Python and
 * the programs of `pkgen build` are made of this layer. It allocates memory of its own, writes
 * where it is told to, and never ends the process. Numbers of settings are in SI.
 *
 *     struct pk_run_settings s = pk_run_defaults();
 *     s.method = "gauss";
 *     s.until = 20;
 *     s.every = 0.01;
 *     struct pk_run *run = pk_run_new(&model, &s);
 *     int code = pk_run_go(run);
 *     size_t columns, count = pk_run_rows(run, &rows, &low, &columns);
 *     puts(pk_run_report(run)), puts(pk_run_messages(run));
 *     pk_run_free(run);
 *
 * One run is for one thread at a time; several runs may go on at once.
 */
#ifndef PK_RUN_H
#define PK_RUN_H

#include <pk/apart.h>
#include <pk/method.h>
#include <pk/system.h>

PK_BEGIN

struct pk_run;
/* Tables of functions of the runtime: diagnostics, and ensembles. */
struct pk_run_diagnose;
struct pk_run_ensemble;
extern const struct pk_run_diagnose pk_run_diagnose;
extern const struct pk_run_ensemble pk_run_ensemble;

/* A model, and what a program that runs it is linked with. */
struct pk_run_model {
    const struct pk_system *system;
    const struct pk_part *parts; /* blocks of coordinates, each integrated by itself; or NULL */
    size_t n_parts;
    const struct pk_method *const *methods; /* those of the model come first */
    size_t n_own, n_methods;
    const struct pk_run_diagnose *diagnose; /* &pk_run_diagnose, or NULL */
    const struct pk_run_ensemble *ensemble; /* &pk_run_ensemble, or NULL */
};

/* What a run ends with: also the exit code of a program. */
enum pk_run_code {
    PK_RUN_DONE = 0,
    PK_RUN_USAGE = 2,        /* wrong settings, or output that cannot be written */
    PK_RUN_FAILED = 4,       /* the numerics failed, or what rows show was not finite */
    PK_RUN_LEFT = 75,        /* by `poll`, with a checkpoint from which it can go on */
    PK_RUN_INTERRUPTED = 130 /* by `poll` */
};

/* One number: of a parameter, an input, a start. `member` counts from 0 in a family kept as a loop.
 */
struct pk_run_value {
    size_t index, member;
    double value;
};

/* A column of the rows, or of an ensemble's members. */
struct pk_run_column {
    char kind;            /* rows: q, v, o of an output, e of the energy; members: p, i, q, v */
    size_t index, member; /* of a family of parameters of members the one, from 0 */
};

/* A relation between columns, to be measured: a = b up to `within`, a < b, or a > b. */
struct pk_run_expected {
    char relation;                     /* =, <, > */
    char when;                         /* r in all rows, t at a time, e at an event */
    struct pk_run_column a, b, within; /* within.kind 0: none */
    double at;
    size_t event;
};

/* How one block of coordinates is integrated; NULL and 0: as the whole. */
struct pk_run_part {
    const char *method;
    double step, rtol, h_max;
};

/* One number that is kept of each member: `what` is f the final value of a column of the rows, M, m
 * and a the largest, the smallest and the mean of its rows, n how often an event happened, t when
 * it first did, d a drift of `drifts`, x whether a relation of `expected` was met (1 or 0), l the
 * largest Lyapunov exponent. n, t and l need `watch`. */
struct pk_run_reduced {
    char what;
    size_t index; /* of the column behind t, the event, the drift, the relation */
};

struct pk_run_settings {
    const char *method;
    double until; /* > 0 */
    double every; /* between rows; 0: each step; < 0: none but at events, or `until`/1000 */
    double step, rtol, atol; /* step 0: the method's own; atol < 0: of the motion */
    double h_min, h_max;     /* of adaptive steps; 0: none */
    int fixed_point;         /* iteration of implicit methods, in place of Newton's */
    unsigned long max_steps; /* 0: no limit */
    int land; /* on rows: 1 by steps that end there, 0 between steps, -1 as it is best */
    size_t n_sizes, n_parameters, n_inputs, n_q, n_v;
    const struct pk_run_value *sizes, *parameters, *inputs, *q, *v;
    size_t n_columns; /* of rows behind t; 0: all */
    const struct pk_run_column *columns;
    size_t n_hidden; /* outputs that are no columns where there are all */
    const size_t *hidden;
    size_t at; /* 1 + the event that has rows; 0: none */
    size_t n_expected, n_drifts;
    const struct pk_run_expected *expected;
    const struct pk_run_column *drifts; /* o, e: outputs and the energy, over all steps */
    unsigned diagnose;                  /* of pk_run_diagnostic() */
    size_t n_parts;                     /* of the model's, or 0 */
    const struct pk_run_part *parts;
    int bare;     /* steps alone: no events, no second opinion, and no rows
                                  without `every` but the final state */
    int compared; /* with other runs: no second opinion; and where no event was met that
                                  has rows, the start and the end are rows */
    double cap;   /* seconds of the processor after which it is given up; 0: none */

    size_t members; /* 0: one trajectory. Else an ensemble: */
    size_t n_member_columns;
    const struct pk_run_column *member_columns;
    const double *member_values; /* members by n_member_columns */
    const char *member_name;     /* of the column that counts members; NULL: "member" */
    long first_member;
    size_t threads; /* 0: all */
    int watch; /* events of members are looked for; 2: and their first times reported; < 0, of one
                       trajectory too: no drifts, but those that are expected */
    size_t n_reduced;
    const struct pk_run_reduced *reduced; /* what pk_run_members() has */
    int no_rows;                          /* no more than that */
    int lenient; /* a member whose parameters are refused fails alone, not the whole */

    const char *checkpoint;         /* the file of checkpoints; NULL: there are none */
    const char *checkpoint_note;    /* text that it holds for who resumes; or NULL */
    double checkpoint_every;        /* seconds; 0: only where `poll` ends the run */
    unsigned long checkpoint_after; /* steps (of parts rows, of an ensemble batches) after which
                                       the run leaves with one; 0: it goes on */
    int resume;                     /* it goes on from there, after the last row */

    /* Inputs that the caller computes: called with t, while q and v stand in `seen`, it writes all
     * of them to `computed`; not 0: end the run. NULL: inputs are constant. `stop` is 1 at the times
     * of `stops`, in order, where steps end; 0 at each evaluation, unless `only_stops`. */
    int (*compute)(void *context, double t, int stop);
    int only_stops;
    size_t n_stops;
    const double *stops;
    double *seen, *computed;

    int csv;    /* file descriptor for rows as CSV; < 0: they are kept in memory */
    int header; /* of names above the CSV */
    int (*poll)(void *context, double part); /* some ten times a second, with the part of the way
                                                that is done; not 0: stop. NULL: never */
    void *context;
};

struct pk_run_settings pk_run_defaults(void);

/* Copies what it needs of the settings. Never NULL but without memory. */
struct pk_run *pk_run_new(const struct pk_run_model *model, const struct pk_run_settings *settings);
/* To the end; the code. Rows up to the last valid time are there, whatever it is. */
enum pk_run_code pk_run_go(struct pk_run *run);
/* Step by step, in place of pk_run_go(): begun, then advanced to t, or by one step towards it. `u` are
 * the inputs until the next call; `state` becomes t, q and v. The status (enum pk_status): below 0 it
 * has failed, PK_STOPPED_EVENT at an event that stops. Without rows and report. */
enum pk_run_code pk_run_begin(struct pk_run *run);
int pk_run_advance(struct pk_run *run, double t, int one_step, const double *u, double *state);
/* How many rows are kept; each has *columns numbers, t first. Where pk_real has more digits than a
 * double, low[i] is what rows[i] lacks: the value is rows[i] + low[i]; else low is NULL. */
size_t pk_run_rows(const struct pk_run *run, const double **rows, const double **low,
                   size_t *columns);
/* Of each member 2 + n_reduced numbers, which *columns says: how it ended (enum pk_status), its last
 * valid time, and what is kept; not a number of a member that failed, and where an event never
 * was. How many members there are; 0 without `reduced` and `no_rows`. */
size_t pk_run_members(const struct pk_run *run, const double **numbers, size_t *columns);
/* The name of column i of the rows, its unit in *unit; 0 behind the last. */
int pk_run_column_name(const struct pk_run *run, size_t i, char *name, size_t size,
                       const char **unit);
/* How it went, in JSON (docs/commands.md), after pk_run_go(). */
const char *pk_run_report(struct pk_run *run);
/* What there is to say to a person, a line each. */
const char *pk_run_messages(const struct pk_run *run);
/* The failure of the run's parameters, by PK_FAILURE() and PK_FAILURE_AT() of real.h; 0: none. */
int pk_run_refused(const struct pk_run *run);
/* The processor's seconds for one bare run from the start, the fastest of laps over `seconds` or
 * more; 0 if it fails. After pk_run_go(). */
double pk_run_laps(struct pk_run *run, double seconds);
/* A kernel at `count` states: "acceleration", "force", "momenta" (n numbers a state), "mass" (n by
 * n), "energy" (1), "outputs", or "jacobian" (da/dq, then da/dv, n by n each), with the run's
 * parameters. q and v have n numbers a state, u one for each input (NULL: the run's own), out as many as
 * pk_run_width() says, t one.
 * How many failed, whose numbers are NAN: M is singular there. */
size_t pk_run_evaluate(struct pk_run *run, const char *what, size_t count, const double *t,
                       const double *q, const double *v, const double *u, double *out);
size_t pk_run_width(const struct pk_run *run, const char *what); /* 0: there is no such kernel */
/* Parameters and start in JSON, as they are in memory. */
const char *pk_run_given(struct pk_run *run);
void pk_run_free(struct pk_run *run);
/* 1: all runs and questions of this library end as soon as they can, also those in other threads;
 * those to come too, until 0. A signal's handler may call it. */
void pk_run_stop(int whether);

/* sizeof of pk_run_settings, pk_run_expected, pk_run_part, pk_run_reduced, pk_stability_question: 0
 * to 4. */
size_t pk_run_size(int which);
/* The bit of a diagnostic; 0: there is none of that name. */
unsigned pk_run_diagnostic(const char *name);

PK_END

#endif

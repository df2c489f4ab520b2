/* A run of a model in one call: settings in, rows and a report out. `pkgen run`, pkgen's Python
 * package and the programs of `pkgen build` use this layer. It allocates memory, writes only to the
 * given files, and never ends the process. Numbers of settings are in SI units.
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
 * A run is used by one thread at a time; several runs may go on at once. */
#ifndef PK_RUN_H
#define PK_RUN_H

#include <pk/subsystems.h>
#include <pk/method.h>
#include <pk/system.h>

PK_BEGIN

struct pk_run;
/* Tables of functions for diagnostics and ensembles; a program links them only if it uses them. */
struct pk_run_diagnose;
struct pk_run_ensemble;
extern const struct pk_run_diagnose pk_run_diagnose;
extern const struct pk_run_ensemble pk_run_ensemble;

/* A model, and the methods and features that a program is linked with. */
struct pk_run_model {
    const struct pk_system *system;
    const struct pk_part *parts; /* independent blocks of coordinates, or NULL */
    size_t n_parts;
    const struct pk_method *const *methods; /* all methods, the model's own (n_own) first */
    size_t n_own, n_methods;
    const struct pk_run_diagnose *diagnose; /* &pk_run_diagnose, or NULL: no diagnostics */
    const struct pk_run_ensemble *ensemble; /* &pk_run_ensemble, or NULL: no ensembles */
};

/* The result of a run, also used as the exit code of a program. */
enum pk_run_code {
    PK_RUN_DONE = 0,
    PK_RUN_USAGE = 2,  /* wrong settings, or output that cannot be written */
    PK_RUN_FAILED = 4, /* a numerical failure, or a number in the rows is not finite */
    /* `poll` ended the run; a checkpoint was written, from which it can resume */
    PK_RUN_LEFT = 75,
    PK_RUN_INTERRUPTED = 130 /* interrupted by `poll` */
};

/* A value of a parameter, size, input or coordinate. For an indexed name such as q[1..N], `member`
 * is the position in the index range, from 0. */
struct pk_run_value {
    size_t index, member;
    double value;
};

/* A column of the rows that a run writes, or of the table with the values of ensemble members. */
struct pk_run_column {
    /* a letter. In the rows of a run: q, v, o for an output, e for the energy. In the table of
     * members: p for a parameter, i for an input, q, v */
    char kind;
    /* member: for an indexed parameter, the position in its index range, from 0 */
    size_t index, member;
};

/* A relation between columns to check: |a - b| <= within, a < b, or a > b. */
struct pk_run_expected {
    char relation; /* the relation: '=', '<' or '>' */
    /* when the relation must hold. r: in all rows, t: at the time `at`, e: at event `event` */
    char when;
    /* `within` is the tolerance of the relation =; within.kind = 0: there is no tolerance */
    struct pk_run_column a, b, within;
    double at;
    size_t event;
};

/* The method and options of one independent block of coordinates. A member that is NULL or 0 has
 * the value set for the whole model. */
struct pk_run_part {
    const char *method;
    double step, rtol, h_max;
};

/* A number stored for each ensemble member. The letter `what` says which. For a column of the rows,
 * f is the final, M the largest, m the smallest and a the mean value. For an event, n is the number
 * of its occurrences and t the time of the first one. d is one of the `drifts`; x is 1 if a
 * relation in `expected` held, else 0; l: the largest Lyapunov exponent. n, t, l require
 * `watch`. */
struct pk_run_reduced {
    char what;
    size_t index; /* index of a column (not counting t), event, drift or relation */
};

/* The data of table number `index` of the model; see pk/table.h. */
struct pk_run_table {
    size_t index, count_x, count_y, coefficients; /* lengths of the arrays */
    const double *x, *y, *c;
    double period_x, period_y;
    int strict;
};

struct pk_run_settings {
    const char *method;
    double until; /* end time of the run, > 0 */
    /* time between two rows; 0: a row after each step; < 0: until/1000 or, with `at`, only there */
    double every;
    double step, rtol, atol; /* step 0: default of the method; atol < 0: derived from the motion */
    double h_min, h_max;     /* bounds of adaptive step sizes; 0: none */
    /* 1: implicit methods use fixed-point iteration instead of Newton's method */
    int fixed_point;
    unsigned long max_steps; /* limit of steps; 0: no limit */
    /* 1: steps end at the times of rows; 0: dense output gives the rows; -1: the runtime chooses */
    int land;
    size_t n_sizes, n_parameters, n_inputs, n_q, n_v;
    const struct pk_run_value *sizes, *parameters, *inputs, *q, *v;
    size_t n_tables; /* tables whose data are not compiled in, or replaced */
    const struct pk_run_table *tables;
    size_t n_columns; /* number of columns in addition to t; 0: all */
    const struct pk_run_column *columns;
    size_t n_hidden; /* if n_columns is 0: number of outputs that get no column */
    const size_t *hidden;
    size_t at; /* 1 + index of an event whose occurrences are rows; 0: none */
    size_t n_expected, n_drifts;
    const struct pk_run_expected *expected;
    /* quantities whose drift is computed: outputs (kind o) and the energy (kind e) */
    const struct pk_run_column *drifts;
    unsigned diagnose; /* diagnostics to compute: bits of pk_run_diagnostic() */
    size_t n_parts;    /* number of blocks integrated separately: n_parts of the model, or 0 */
    const struct pk_run_part *parts;
    /* 1: the run makes only its steps; it detects no events and makes no check by a second
     * method. With `every` < 0 the only row is the final state */
    int bare;
    /* 1: the run is compared with other runs. It makes no check by a second method, and if event
     * `at` never occurs, the start and the end are rows */
    int compared;
    unsigned long seed; /* of noise; member numbers are those of the streams */
    double cap;         /* limit in processor seconds; 0: no limit */

    size_t members; /* number of ensemble members; 0: one trajectory */
    size_t n_member_columns;
    const struct pk_run_column *member_columns;
    /* values of the member_columns: `members` rows of n_member_columns numbers */
    const double *member_values;
    const char *member_name; /* name of the column with the member numbers; NULL: "member" */
    long first_member;
    size_t threads; /* number of threads; 0: all available */
    /* 1: events of ensemble members are detected; 2: the times of their first occurrences are also
     * reported; < 0: no drifts but those in `drifts`, in a run of one trajectory too */
    int watch;
    size_t n_reduced;
    const struct pk_run_reduced *reduced; /* the numbers that pk_run_members() returns */
    int no_rows;                          /* 1: no rows are stored */
    int tape;                             /* 1: each step is kept, for pk_run_tape() */
    int lenient;                          /* 1: refused parameters of a member do not end the run */

    const char *checkpoint;      /* checkpoint file; NULL: none */
    const char *checkpoint_note; /* text stored in the checkpoint, or NULL */
    double checkpoint_every;     /* seconds between checkpoints; 0: only if `poll` ends the
                                       run */
    /* the run ends with a checkpoint after this number of steps; 0: never. For a model in parts
     * rows are counted instead, for an ensemble batches of members */
    unsigned long checkpoint_after;
    int resume; /* 1: the run resumes from the checkpoint file */

    /* Function of the caller that computes inputs. compute() finds t as argument and q and v in
     * `seen`, and writes all inputs to `computed`; it returns nonzero to end the run. NULL:
     * constant inputs. `stop` is 1 at the ascending times `stops`, where steps end, otherwise 0;
     * with only_stops it is called only at these times. */
    int (*compute)(void *context, double t, int stop);
    int only_stops;
    size_t n_stops;
    const double *stops;
    double *seen, *computed;
    /* Function of the caller in place of sample blocks, or NULL. It finds q and v in `seen`, and in
     * `computed` the inputs, which it changes; it returns 1. If it returns 0, the block with this
     * index itself runs; after < 0 the run ends. */
    int (*sample)(void *context, double t, size_t block);

    int csv;    /* file descriptor for rows as CSV; < 0: rows stay in memory */
    int header; /* 1: the CSV begins with a line of names */
    int (*poll)(void *context, double part); /* called about ten times a second with the fraction
                                                done; nonzero stops the run. NULL: never */
    void *context;
};

struct pk_run_settings pk_run_defaults(void);

/* Copies the settings, with their lists and texts; `seen`, `computed` and `context` are not copied.
 * Returns NULL only if memory runs out. */
struct pk_run *pk_run_new(const struct pk_run_model *model, const struct pk_run_settings *settings);
/* Runs to the end. Rows up to the last valid time are stored also if the run fails. */
enum pk_run_code pk_run_go(struct pk_run *run);
/* pk_run_begin() and pk_run_advance() are used instead of pk_run_go() if the caller makes the run
 * step by step; such a run stores no rows and no report. pk_run_advance() integrates to t, or one
 * step towards it, with constant inputs u, and writes t, q and v to `state`; in u it replaces those
 * that sample blocks set. It returns an enum
 * pk_status: negative on failure, PK_STOPPED_EVENT at an event that ends the run. */
enum pk_run_code pk_run_begin(struct pk_run *run);
int pk_run_advance(struct pk_run *run, double t, int one_step, double *u, double *state);
/* Returns the number of rows in memory, each of *columns numbers, t first. If pk_real has more
 * digits than double, a value is rows[i] + low[i]; otherwise *low is NULL. */
size_t pk_run_rows(const struct pk_run *run, const double **rows, const double **low,
                   size_t *columns);
/* Returns the number of ensemble members for which `numbers` has a row; 0 if neither `reduced` nor
 * `no_rows` is set. The row of a member has *columns = 2 + n_reduced numbers: its final enum
 * pk_status, its last valid time, and the numbers of `reduced`, which are NaN for a failed member
 * and for the time of an event that did not occur. */
size_t pk_run_members(const struct pk_run *run, const double **numbers, size_t *columns);
/* Writes the name and the unit of column i of the rows. Returns 0 if there is no column i. */
int pk_run_column_name(const struct pk_run *run, size_t i, char *name, size_t size,
                       const char **unit);
/* Returns the report in JSON (docs/commands.md), after pk_run_go(). */
const char *pk_run_report(struct pk_run *run);
/* Returns the messages to the user, one per line. */
const char *pk_run_messages(const struct pk_run *run);
/* Returns the failure by which prepare() refused parameters (PK_FAILURE() in real.h), or 0. */
int pk_run_refused(const struct pk_run *run);
/* Returns the processor seconds of one run without rows from the start, the least of repetitions
 * that take at least `seconds` in all; 0 if the run fails. Call it after pk_run_go(). */
double pk_run_laps(struct pk_run *run, double seconds);
/* Evaluates a kernel at `count` states, with the run's parameters: "acceleration", "force",
 * "momenta" (n numbers per state), "free momenta" (those without constraints), "mass" (n by n),
 * "energy" (1), "outputs", "jacobian" (da/dq, then da/dv, n by n each), "momentum jacobian" (dp/dq,
 * d(pdot)/dq, d(pdot)/dv), "constraint jacobian" (J: n numbers for each constraint row) or
 * "constraint rates" (J v + j0). Per state: t has 1 number, q and v have n each, u has n_inputs (u
 * NULL: the run's inputs), out has pk_run_width() numbers. Returns how many states failed because M
 * is singular; their results are NaN. */
size_t pk_run_evaluate(struct pk_run *run, const char *what, size_t count, const double *t,
                       const double *q, const double *v, const double *u, double *out);
size_t pk_run_width(const struct pk_run *run, const char *what); /* 0: unknown kernel name */
/* Returns the number of steps of a run with the setting `tape`, after pk_run_go(). Unless `rows` is
 * NULL, writes a row for each: t at its start and its end; a mark; q and v at the start, then at the
 * end, before a jump (n numbers each); the inputs. The mark is 0, or 1 + the number of the event or
 * switch (after the events) at which the motion jumps or changes its equations at the end, or -1 if
 * there are several. */
size_t pk_run_tape(const struct pk_run *run, double *rows);
/* Writes q' and v', n numbers each, at the start (end = 0) or the end (1) of a row of the tape, with
 * the equations of its step. end = 2: writes the derivative of the state at the end by the time of
 * this end, which differs by the error of a step. Returns a status. */
int pk_run_tape_rates(struct pk_run *run, size_t row, int end, double *rates);
/* Writes the derivative of the state (q, v) and of the inputs after the event at the end of a row
 * along a displacement D before it, whose dt shifts the time. PK_NO_CONTACT: neighbours go on with
 * other contacts. */
int pk_run_tape_jump(struct pk_run *run, size_t row, const double *D, double *out);
/* Propagates small displacements, the columns of D, through the steps from `begin` to before `end`,
 * by the derivative of each step. A column is dq (n numbers), dv (n), du (n_inputs), dp
 * (n_parameters) and dt, by which the times of fixed steps shift. At each of the ascending times,
 * which are within these steps, q and v are written to `out`, then dq and dv of each column.
 * Returns a status. */
int pk_run_tangent(struct pk_run *run, size_t begin, size_t end, size_t columns, double *D,
                   size_t n_times, const double *times, double *out);
/* Takes the derivatives lambda of a number by the displacements after the rows from `begin` to before
 * `end`, in the order of a column of D, and replaces them by those before these rows. `shifts`:
 * whether dt may differ from 0. PK_REFUSED: only Runge-Kutta methods, and splitting methods of
 * separable systems (constant M, forces that do not depend on rates), go backwards, without
 * constraints and rotations. */
int pk_run_adjoint(struct pk_run *run, size_t begin, size_t end, int shifts, double *lambda);
/* Returns parameters and start values in JSON. */
const char *pk_run_given(struct pk_run *run);
void pk_run_free(struct pk_run *run);
/* pk_run_stop(1) ends all runs and integrations of this library, in all threads, as soon as
 * possible; new ones end at once. pk_run_stop(0) allows runs again. A signal handler may call
 * it. */
void pk_run_stop(int whether);

/* Returns the size of pk_run_settings, _expected, _part or _reduced for `which` = 0, 1, 2 or 3. */
size_t pk_run_size(int which);
/* Returns the bit of a diagnostic in `diagnose`; 0: unknown name. */
unsigned pk_run_diagnostic(const char *name);

PK_END

#endif

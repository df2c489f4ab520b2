/* The state of a run, shared by all files of run/. Not installed. */
#ifndef RUN_STATE_H
#define RUN_STATE_H

#include <errno.h>
#include <math.h>
#include <setjmp.h>
#include <signal.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <pk/pk.h>
#include <pk/run.h>

struct pk_run;

/* The memory of a run; see memory.c. Allocated memory is 0; a failed allocation ends the run. */
struct memory {
    struct piece *pieces;
    jmp_buf none; /* memory_try() sets this target of the jump that follows a failed allocation */
    FILE *text;   /* the text opened by run_text() until run_text_end(), or NULL */
    size_t text_size; /* length of the text, set by open_memstream() when it is closed */
};
/* Calls `work`. Returns 0 if an allocation in it failed. */
int memory_try(struct memory *m, void (*work)(void *context), void *context);
void *memory_take(struct memory *m, size_t count, size_t size);
/* like memory_take(), but returns NULL if memory runs out */
void *memory_ask(struct memory *m, size_t count, size_t size);
void *memory_grow(struct memory *m, void *old, size_t count, size_t size);
/* Returns the array `old`. Without room for `count` elements it is enlarged, and *room doubled. */
void *memory_room(struct memory *m, void *old, size_t count, size_t *room, size_t size);
void memory_drop(struct memory *m, void *begin);
void memory_end(struct memory *m);
/* run_say() appends a line to the messages. run_text() opens a text for writing, one at a time;
 * run_text_end() sets *text, which the caller frees. */
#if defined __GNUC__
__attribute__((format(printf, 2, 3)))
#endif
void run_say(struct pk_run *run, const char *format, ...);
FILE *run_text(struct pk_run *run, char **text);
void run_text_end(struct pk_run *run);

/* A relation a = b, a < b or a > b that a scene expects; its checks and worst case. */
struct expected {
    struct pk_run_expected of;
    unsigned long count, missed; /* `count`: checks so far; `missed`: failed ones */
    /* The worst case: how far it is off, a, b, the tolerance and the time. */
    pk_real off, value, bound, allowed, t;
    size_t member;               /* ensemble member in which the worst case occurred */
    unsigned long counted, lost; /* values of `count` and `missed` when the previous member ended */
};

/* An output, or the energy, whose drift is requested; of an ensemble, the largest one. */
struct drifting {
    int energy;
    size_t output, member, members; /* `member` has the largest drift; `members` have ended */
    struct pk_drift drift;
    /* `max`: largest drift of all members; `last`: drift of the member that ended last */
    pk_real max, last;
};

/* Requests to stop a run; shared by the members of an ensemble. */
struct control {
    volatile sig_atomic_t stop;
    /* In seconds: `last`: wall clock at the last call of `poll`; `began`: CPU time at the start. */
    double last, began;
    int slow;       /* whether the run ended because its CPU time exceeded settings.asked.cap */
    double looked;  /* wall clock when the run last read it */
    unsigned often; /* steps between two readings of the clock */
};

/* Name and hash of a setting. A checkpoint can only be resumed by a run with the same hashes. */
enum { MARKS = 38 };
struct mark {
    const char *name;
    uint64_t of;
};

/* Settings in the form that the run uses. */
struct settings {
    struct pk_run_settings asked; /* the caller's settings; lists and texts are copies */
    struct pk_run *run;
    const struct pk_system *system;
    const struct pk_part *parts;
    size_t n_parts;
    const struct pk_method *method;
    struct memory *memory;
    struct control *control;
    pk_real until, every; /* `every`: time between rows; < 0: until / 1000; 0: a row at each step */
    struct pk_options options;
    int has_every, has_step, polls;
    size_t n;                /* degrees of freedom */
    void *params, *families; /* `families`: memory that system->families.attach() uses */
    size_t families_size;
    unsigned char *given;       /* one flag per parameter: whether the caller has set it */
    pk_real *q, *v, *u;         /* `q`, `v`: initial state; `u`: current values of the inputs */
    unsigned char *start_given; /* 2 n flags: whether the caller has set each initial q and v */
    struct pk_run_column *show; /* the columns of a row that follow its time t */
    size_t n_show;
    struct expected *expected;
    struct drifting *drifting;
    struct mark marks[MARKS]; /* only computed if checkpoints are written */
};

/* The state of steps/checkpoint.c. */
struct checkpoint {
    double began, last; /* wall clock at the run's start (`began`) and at the last checkpoint */
    /* `looks`: calls of checkpoint_look(); `failures`: checkpoints not written */
    unsigned long looks, failures;
    /* Flags: the last checkpoint was written; the run was resumed from one; it was refused. */
    int written, resumed, refused;
    int left; /* flag: the run was stopped and has written a checkpoint */
};

/* A time and the state at this time; q is NULL if the state cannot be computed. */
struct moment {
    pk_real t;
    const pk_real *q, *v;
};

/* The crossings of one event or switch, and the times of the first WATCH_TIMES crossings. */
struct crossed {
    unsigned long count;
    pk_real *t;
    unsigned long states; /* number of step ends at which the event function g was evaluated */
    unsigned long doubts; /* number of intervals within steps in which crossings may be missed */
    pk_real doubtful_t;   /* time of the first such interval */
    int leaves;           /* whether |g| has exceeded WATCH_NOISE times its scale `parts` */
    pk_real parts;        /* scale of g: largest |dg/dx_i| |x_i| so far */
};

struct pk_run {
    const struct pk_run_model *model;
    const struct observer *observers[16]; /* ends with NULL; see observers/observers.h */
    struct settings settings;
    struct memory memory;
    struct control control;
    char *said;
    char *report, *told; /* JSON texts of pk_run_report() and pk_run_given(); must be freed */
    char *csv;           /* CSV rows of an ensemble member; must be freed */
    enum pk_run_code code;
    int refused;           /* result of prepare() on the parameters */
    struct pk_system bare; /* copy of the system; if settings.asked.bare, without events */
    struct pk_problem problem;
    struct pk_integrator it;
    struct pk_monitor monitor;
    struct pk_subsystems subsystems;  /* blocks of coordinates with integrators of their own */
    struct pk_choice *choices;        /* method and options of each of these blocks */
    struct pk_monitor *part_monitors; /* monitors the energy of each of these blocks */
    void *block, *monitor_block;
    struct pk_events events;
    struct crossed *crossed; /* one for each event, then for each switch; or NULL */
    pk_real *event_values;   /* scratch memory of crossings.c */
    pk_real *expected;       /* values of the outputs for expect.c */
    size_t member;           /* index of the current ensemble member */
    pk_real *row, *cells;    /* at a row: `row`: q, v, outputs; `cells`: its columns */
    FILE *out;               /* file to which rows are written as CSV; NULL: memory */
    /* Rows in memory. If pk_real exceeds double, kept_low holds the remainders of the rounding. */
    double *kept, *kept_low;
    size_t n_kept, room;
    double *members;       /* the table that pk_run_members() returns, or NULL */
    pk_real *reduced;      /* reductions of the current member so far */
    unsigned long reduces; /* number of rows included in these reductions */
    int reduces_rows;      /* whether any reduction reads the rows */
    struct moment now;     /* memory for the result of run_moment() */
    struct pk_sampler sampler;
    struct pk_actor actor;
    size_t acts; /* length of its work memory; 0 if nothing acts */
    size_t stops; /* number of times in settings.asked.stops that are past */
    /* Row k is at time k * every. `count`: index of the final row; `next`: of the next one. */
    pk_real count, next;
    pk_real expecting;          /* time up to which expectations within fixed steps are checked */
    struct pk_integrator aside; /* computes states within fixed steps; initialised at first use */
    void *aside_block;
    pk_real last_row; /* time of the last row */
    int at_event;     /* whether the row being written is at an event */
    unsigned long rows;
    int begun;             /* whether the integrator was initialised without error */
    int lean;              /* whether a member is only observed at its start and its end */
    pk_real h_min, h_max;  /* sizes of steps; h_min only counts those limited by their error */
    unsigned long look_at; /* number of the step after which drifts are next measured */
    int looked;            /* whether drifts were measured after the last step */
    pk_real trusted;       /* last time at which the energy drift was below TRUST_WRONG */
    int distrusted;
    pk_real ends;  /* time at which the motion ends according to dop853 */
    int beyond;    /* whether the run has made steps after the time `ends` */
    int goes_on;   /* whether dop853 continues past the time at which the run failed */
    char *besides; /* text to append to the reason of a failure, or NULL; must be freed */
    int interrupted;
    int write_failed; /* errno of a failed write of rows, or 0 */
    /* column of the first value that was not finite, or NULL */
    const struct pk_run_column *not_finite;
    double bad_t;           /* time of the first row with such a value */
    unsigned long bad_rows; /* number of rows with such a value */
    const struct pk_run_column
        *lost;     /* column of the first value lost to rounding near a singularity, or NULL */
    double lost_t; /* time of the first row with such a value */
    unsigned long lost_rows;         /* number of rows with such a value */
    double part;                     /* fraction of the ensemble that is finished */
    double seconds, processor;       /* wall clock and CPU time of the steps and rows */
    struct diagnostics *diagnostics; /* NULL if no diagnostic is requested */
    struct tape *tape;               /* NULL unless settings.asked.tape */
    struct looking *looking;         /* state of condition.c */
    /* For the diagnostic `area`: the loop that the members form; otherwise NULL. */
    struct loop *loop;
    struct checkpoint checkpoint;
};

/* Returns the number of values in a row: the ensemble member (if any), t, the columns. */
static inline size_t run_width(const struct pk_run *run)
{
    return (run->settings.asked.members ? 2u : 1u) + run->settings.n_show;
}

static inline int run_fixed(const struct pk_run *run) { return pk_is_fixed(run->settings.method); }

/* Says why the settings are refused, and is the exit code. */
#define run_refuse(run, ...) (run_say(run, __VA_ARGS__), PK_RUN_USAGE)

/* Returns the number of coordinates. */
static inline size_t settings_coordinates(const struct settings *s)
{
    return pk_system_coordinates(s->system, s->params);
}

/* In control.c: return the wall clock, and the CPU time of this thread, in seconds. */
double run_now(void);
double run_processor(void);
/* Returns whether the run shall stop; calls `poll` about ten times a second. */
int run_stopped(struct pk_run *run, double part);
int run_ending(void *context); /* for pk_options.stop: returns whether all runs shall end */
/* Opens the file descriptor for rows as CSV; returns 0, with errno set, if that fails. */
int run_open(struct pk_run *run, int fd);

#endif

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

/* Memory of a run, see memory.c. It is zeroed; without memory the run ends. */
struct memory {
    struct piece *pieces;
    jmp_buf none;     /* jump target when an allocation fails, set by memory_try() */
    FILE *text;       /* the open text of run_text(), or NULL */
    size_t text_size; /* its length, set by open_memstream() when the text is closed */
};
/* Calls `work`. Returns 0 if an allocation in it failed. */
int memory_try(struct memory *m, void (*work)(void *context), void *context);
void *memory_take(struct memory *m, size_t count, size_t size);
void *memory_ask(struct memory *m, size_t count, size_t size); /* NULL without memory */
void *memory_grow(struct memory *m, void *old, size_t count, size_t size);
/* Returns `old`, grown if *room is less than `count` elements; *room is then doubled. */
void *memory_room(struct memory *m, void *old, size_t count, size_t *room, size_t size);
void memory_drop(struct memory *m, void *begin);
void memory_end(struct memory *m);
/* run_say() adds a line to the messages. run_text() opens a text in memory of malloc(), one at a
 * time; *text is set by run_text_end(). */
#if defined __GNUC__
__attribute__((format(printf, 2, 3)))
#endif
void run_say(struct pk_run *run, const char *format, ...);
FILE *run_text(struct pk_run *run, char **text);
void run_text_end(struct pk_run *run);

/* An expected relation a = b, a < b or a > b: how often it was checked, and its worst case. */
struct expected {
    struct pk_run_expected of;
    unsigned long count, missed;           /* checks; failed checks */
    pk_real off, value, bound, allowed, t; /* worst case: excess, a, b, tolerance, time */
    size_t member;                         /* ensemble member of the worst case */
    unsigned long counted, lost;           /* count and missed at the end of the previous member */
};

/* An output, or the energy, whose drift is requested; in an ensemble, the worst member's drift. */
struct drifting {
    int energy;
    size_t output, member, members; /* `member`: the worst; `members`: number that have ended */
    struct pk_drift drift;
    pk_real max, last; /* largest drift of all members; of the member that ended last */
};

/* Requests to stop a run; shared by the members of an ensemble. */
struct control {
    volatile sig_atomic_t stop;
    double last, began; /* wall clock at the last `poll`; CPU time at the start; seconds */
    int slow;           /* the run was ended at settings.cap */
    double looked;      /* wall clock at its last reading */
    unsigned often;     /* steps between two readings */
};

/* A hash of each setting: a checkpoint is only resumed by a run with the same settings. */
enum { MARKS = 37 };
struct mark {
    const char *name;
    uint64_t of;
};

/* Settings as the run uses them. */
struct settings {
    struct pk_run_settings asked; /* its lists and texts are copies */
    struct pk_run *run;
    const struct pk_system *system;
    const struct pk_part *parts;
    size_t n_parts;
    const struct pk_method *method;
    struct memory *memory;
    struct control *control;
    pk_real until, every; /* every: < 0 until / 1000, 0 a row at each step */
    struct pk_options options;
    int has_every, has_step, polls;
    size_t n;                /* degrees of freedom */
    void *params, *families; /* `families`: the memory for families.attach() */
    size_t families_size;
    unsigned char *given;       /* flag of each parameter: set by the caller */
    pk_real *q, *v, *u;         /* initial q and v; current inputs */
    unsigned char *start_given; /* 2 n flags: initial q, then v, set by the caller */
    struct pk_run_column *show; /* the columns of rows behind t */
    size_t n_show;
    struct expected *expected;
    struct drifting *drifting;
    struct mark marks[MARKS]; /* set if there are checkpoints */
};

/* State of steps/checkpoint.c. */
struct checkpoint {
    double began, last;            /* wall clock at the start of the run, and of the last one */
    unsigned long looks, failures; /* calls of checkpoint_look(); checkpoints not written */
    int written, resumed, refused; /* the last one is on disk; the run resumed one, or could not */
    int left;                      /* the run has ended with one */
};

/* A time and the state at it; q is NULL where there is no state. */
struct moment {
    pk_real t;
    const pk_real *q, *v;
};

/* The crossings of one event or switch, with the times of the first WATCH_TIMES. */
struct crossed {
    unsigned long count;
    pk_real *t;
    unsigned long states; /* ends of steps at which its function g was evaluated */
    unsigned long doubts; /* parts of steps in which crossings may be missed, */
    pk_real doubtful_t;   /* and the time of the first */
    int leaves;           /* |g| was above WATCH_NOISE times `parts` at some step */
    pk_real parts;        /* largest |dg/dx_i| |x_i| so far */
};

struct pk_run {
    const struct pk_run_model *model;
    const struct observer *observers[16]; /* NULL behind the last; see observers/observers.h */
    struct settings settings;
    struct memory memory;
    struct control control;
    char *said;
    char *report, *told; /* JSON of pk_run_report() and pk_run_given(); of malloc() */
    char *csv;           /* rows of an ensemble member; of malloc() */
    char *equilibria;    /* JSON of pk_stability_equilibria(); of malloc() */
    enum pk_run_code code;
    int refused;           /* result of prepare() for the parameters */
    struct pk_system bare; /* copy of the system, without events in a bare run */
    struct pk_problem problem;
    struct pk_integrator it;
    struct pk_monitor monitor;
    struct pk_subsystems subsystems;  /* blocks of coordinates integrated apart */
    struct pk_choice *choices;        /* method and options of each block */
    struct pk_monitor *part_monitors; /* energy of each block */
    void *block, *monitor_block;
    struct pk_events events;
    struct crossed *crossed; /* of each event, then of each switch; NULL without any */
    pk_real *event_values;   /* work of crossings.c */
    pk_real *expected;       /* outputs; work of expect.c */
    size_t member;           /* the ensemble member whose state is observed */
    pk_real *row, *cells;    /* q, v and outputs of a row; the numbers of its columns */
    FILE *out;               /* file of the rows as CSV; NULL: they are kept in memory */
    double *kept, *kept_low; /* rows in memory; what a double lacks of pk_real, or NULL */
    size_t n_kept, room;
    double *members;            /* table of pk_run_members(), or NULL */
    pk_real *reduced;           /* reductions of the current member so far, */
    unsigned long reduces;      /* over this number of rows */
    int reduces_rows;           /* whether any reduction reads the rows */
    struct moment now;          /* result of run_moment() */
    size_t stops;               /* number of settings.stops already passed */
    pk_real count, next;        /* rows by time after the first; number of the next one */
    pk_real expecting;          /* expectations within fixed steps are checked up to this time */
    struct pk_integrator aside; /* for states within fixed steps, made at the first use */
    void *aside_block;
    pk_real last_row; /* time of the last row */
    int at_event;     /* whether the row being written is at an event */
    unsigned long rows;
    int begun;             /* whether the integrator was initialised without an error */
    int lean;              /* a member that is observed at its start and end only */
    pk_real h_min, h_max;  /* step sizes; h_min: least of the steps bounded by their error alone */
    unsigned long look_at; /* the step at which drifts are measured next; see observers/drifts.c */
    int looked;            /* whether they were measured at this step */
    pk_real trusted;       /* last time at which the energy was right; see observers.h */
    int distrusted;
    pk_real ends;  /* end of the motion according to dop853 */
    int beyond;    /* the steps have gone on past that end */
    int goes_on;   /* dop853 finds that the motion goes on past the failure */
    char *besides; /* text to append to the reason of a failure, or NULL; of malloc() */
    int interrupted;
    int write_failed;                       /* errno of a failed write of rows, or 0 */
    const struct pk_run_column *not_finite; /* first energy or output not finite, or NULL */
    double bad_t;                           /* time of its row; number of such rows */
    unsigned long bad_rows;
    const struct pk_run_column
        *lost;     /* the first value lost to rounding at a singular position, or NULL */
    double lost_t; /* time of its row; number of such rows */
    unsigned long lost_rows;
    double part;                     /* finished fraction of an ensemble */
    double seconds, processor;       /* wall clock and CPU time of the steps and rows */
    struct diagnostics *diagnostics; /* NULL: none requested */
    struct looking *looking;         /* of condition.c */
    struct loop *loop;               /* the members as a closed loop, for its area; or NULL */
    struct checkpoint checkpoint;
};

/* Returns the numbers per row: the member (of an ensemble), t, the columns. */
static inline size_t run_width(const struct pk_run *run)
{
    return (run->settings.asked.members ? 2u : 1u) + run->settings.n_show;
}

static inline int run_fixed(const struct pk_run *run)
{
    return !(run->settings.method->traits & PK_ADAPTIVE);
}

/* Of control.c: seconds of the wall clock, and of this thread's CPU time. */
double run_now(void);
double run_processor(void);
/* Returns whether the run is to stop; calls `poll` about ten times a second. */
int run_stopped(struct pk_run *run, double part);
int run_ending(void *context); /* for pk_options.stop: whether all runs are to end */
/* Sends rows to this file descriptor as CSV; returns 0, with errno set, if that fails. */
int run_open(struct pk_run *run, int fd);

#endif

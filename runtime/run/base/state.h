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
    jmp_buf none;     /* jump target when an allocation fails, set by memory_try() */
    FILE *text;       /* the open text of run_text(), or NULL */
    size_t text_size; /* length of the text, set by open_memstream() when it is closed */
};
/* Calls `work`. Returns 0 if an allocation in it failed. */
int memory_try(struct memory *m, void (*work)(void *context), void *context);
void *memory_take(struct memory *m, size_t count, size_t size);
void *memory_ask(struct memory *m, size_t count, size_t size); /* returns NULL if memory runs out */
void *memory_grow(struct memory *m, void *old, size_t count, size_t size);
/* Returns `old`, enlarged if it has room for less than `count` elements; *room is then doubled. */
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

/* An expected relation a = b, a < b or a > b: how often it was checked, and its worst case. */
struct expected {
    struct pk_run_expected of;
    unsigned long count, missed;           /* number of checks; number of failed checks */
    pk_real off, value, bound, allowed, t; /* worst case: excess, a, b, tolerance, time */
    size_t member;                         /* ensemble member of the worst case */
    unsigned long counted, lost; /* `count` and `missed` at the end of the previous member */
};

/* An output, or the energy, whose drift is requested; in an ensemble, the worst of the members. */
struct drifting {
    int energy;
    size_t output, member, members; /* which member drifts most; how many have ended */
    struct pk_drift drift;
    pk_real max, last; /* largest drift of all members; drift of the member that ended last */
};

/* Requests to stop a run; shared by the members of an ensemble. */
struct control {
    volatile sig_atomic_t stop;
    double last, began; /* wall clock at the last `poll`; CPU time at the start; in seconds */
    int slow;           /* whether the limit settings.cap of CPU time ended the run */
    double looked;      /* wall clock when it was last read */
    unsigned often;     /* steps between two readings of the clock */
};

/* A hash of each setting: a checkpoint can only be resumed by a run with the same settings. */
enum { MARKS = 37 };
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
    pk_real until, every; /* every: interval of rows; < 0: until / 1000; 0: each step */
    struct pk_options options;
    int has_every, has_step, polls;
    size_t n;                /* degrees of freedom */
    void *params, *families; /* `families`: memory for families.attach() */
    size_t families_size;
    unsigned char *given;       /* flag of each parameter: the caller has set it */
    pk_real *q, *v, *u;         /* initial q, initial v; current inputs */
    unsigned char *start_given; /* 2 n flags for initial q, v: the caller has set it */
    struct pk_run_column *show; /* the columns of rows after t */
    size_t n_show;
    struct expected *expected;
    struct drifting *drifting;
    struct mark marks[MARKS]; /* set if checkpoints are written */
};

/* The state of steps/checkpoint.c. */
struct checkpoint {
    double began, last;            /* wall clock at the start of the run, at the last checkpoint */
    unsigned long looks, failures; /* calls of checkpoint_look(); checkpoints that failed */
    int written, resumed, refused; /* last one is on disk; the run resumed one; it could not */
    int left;                      /* the run was stopped and has written a checkpoint */
};

/* A time and the state at this time; q is NULL if there is no state. */
struct moment {
    pk_real t;
    const pk_real *q, *v;
};

/* The crossings of one event or switch, and the times of the first WATCH_TIMES crossings. */
struct crossed {
    unsigned long count;
    pk_real *t;
    unsigned long states; /* number of ends of steps at which g was evaluated */
    unsigned long doubts; /* number of parts of steps in which crossings may be missed */
    pk_real doubtful_t;   /* time of the first such part */
    int leaves;           /* whether |g| has exceeded WATCH_NOISE times `parts` */
    pk_real parts;        /* scale of g: largest |dg/dx_i| |x_i| so far */
};

struct pk_run {
    const struct pk_run_model *model;
    const struct observer *observers[16]; /* NULL after the last; see observers/observers.h */
    struct settings settings;
    struct memory memory;
    struct control control;
    char *said;
    char *report, *told; /* JSON of pk_run_report(), of pk_run_given(); must be freed */
    char *csv;           /* CSV rows of an ensemble member; must be freed */
    char *equilibria;    /* JSON of pk_stability_equilibria(); must be freed */
    enum pk_run_code code;
    int refused;           /* result of prepare() on the parameters */
    struct pk_system bare; /* copy of the system, without events in a bare run */
    struct pk_problem problem;
    struct pk_integrator it;
    struct pk_monitor monitor;
    struct pk_subsystems subsystems;  /* blocks of coordinates with integrators of their own */
    struct pk_choice *choices;        /* method and options of each block */
    struct pk_monitor *part_monitors; /* energy of each block */
    void *block, *monitor_block;
    struct pk_events events;
    struct crossed *crossed; /* for each event, then each switch; NULL if there are none */
    pk_real *event_values;   /* scratch memory of crossings.c */
    pk_real *expected;       /* values of outputs, in expect.c */
    size_t member;           /* the current ensemble member */
    pk_real *row, *cells;    /* q, v and outputs at a row; the values of its columns */
    FILE *out;               /* CSV file of the rows; NULL: rows are kept in memory */
    double *kept, *kept_low; /* rows in memory; their low parts if pk_real exceeds double */
    size_t n_kept, room;
    double *members;            /* table of pk_run_members(), or NULL */
    pk_real *reduced;           /* reductions of the current member so far */
    unsigned long reduces;      /* number of rows in these reductions */
    int reduces_rows;           /* whether any reduction reads the rows */
    struct moment now;          /* result of run_moment() */
    size_t stops;               /* number of settings.stops that t has passed */
    pk_real count, next;        /* index of the last row by time; index of the next one */
    pk_real expecting;          /* expectations within fixed steps are checked up to this time */
    struct pk_integrator aside; /* integrates to states within fixed steps; made at first use */
    void *aside_block;
    pk_real last_row; /* time of the last row */
    int at_event;     /* whether the row being written is at an event */
    unsigned long rows;
    int begun;             /* whether the integrator was initialised without error */
    int lean;              /* whether the member is observed only at its start and end */
    pk_real h_min, h_max;  /* step sizes; h_min: least of the steps limited by their error */
    unsigned long look_at; /* step at which drifts are measured next; see observers/drifts.c */
    int looked;            /* whether drifts were measured at this step */
    pk_real trusted;       /* last time at which the energy was right; see observers.h */
    int distrusted;
    pk_real ends;  /* end of the motion according to dop853 */
    int beyond;    /* whether the steps have gone on past `ends` */
    int goes_on;   /* whether dop853 continues past the failure of the run */
    char *besides; /* text to append to the reason of a failure, or NULL; must be freed */
    int interrupted;
    int write_failed;                       /* errno of a failed write of rows, or 0 */
    const struct pk_run_column *not_finite; /* first column that was not finite, or NULL */
    double bad_t;                           /* time of the first such row; number of such rows */
    unsigned long bad_rows;
    const struct pk_run_column
        *lost;     /* first column lost to rounding at a singular position, or NULL */
    double lost_t; /* time of the first such row; number of such rows */
    unsigned long lost_rows;
    double part;                     /* fraction of the ensemble that is finished */
    double seconds, processor;       /* wall clock and CPU time of the steps and rows */
    struct diagnostics *diagnostics; /* NULL if none is requested */
    struct looking *looking;         /* state of condition.c */
    struct loop *loop; /* the members as a closed loop, for the diagnostic `area`; or NULL */
    struct checkpoint checkpoint;
};

/* Returns the number of values in a row: the ensemble member (if any), t, the columns. */
static inline size_t run_width(const struct pk_run *run)
{
    return (run->settings.asked.members ? 2u : 1u) + run->settings.n_show;
}

static inline int run_fixed(const struct pk_run *run)
{
    return !(run->settings.method->traits & PK_ADAPTIVE);
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

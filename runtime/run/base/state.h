/* A run while it is made: what all files of runs share. Not installed. */
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

/* Memory of a run, of memory.c: zeroed, or the run ends. */
struct memory {
    struct piece *pieces;
    jmp_buf none;     /* where control goes without memory: in memory_try() */
    FILE *text;       /* being written, of run_text() */
    size_t text_size; /* which open_memstream() sets when the text is closed */
};
/* Does `work`; 0: there was no memory for it. */
int memory_try(struct memory *m, void (*work)(void *context), void *context);
void *memory_take(struct memory *m, size_t count, size_t size);
void *memory_ask(struct memory *m, size_t count, size_t size); /* or NULL */
void *memory_grow(struct memory *m, void *old, size_t count, size_t size);
/* For `count`, with what is to come: twice the room where that is too small. */
void *memory_room(struct memory *m, void *old, size_t count, size_t *room, size_t size);
void memory_drop(struct memory *m, void *begin);
void memory_end(struct memory *m);
/* A line for a person; a text in memory of malloc(), one at a time, there once it is ended. */
#if defined __GNUC__
__attribute__((format(printf, 2, 3)))
#endif
void run_say(struct pk_run *run, const char *format, ...);
FILE *run_text(struct pk_run *run, char **text);
void run_text_end(struct pk_run *run);

/* By how much a relation was missed at the worst. */
struct expected {
    struct pk_run_expected of;
    unsigned long count, missed;
    pk_real off, value, bound, allowed, t;
    size_t member;
    unsigned long counted, lost; /* of the members before: count and missed */
};

/* An output whose drift is wanted, or the energy; of an ensemble the worst member's. */
struct drifting {
    int energy;
    size_t output, member, members;
    struct pk_drift drift;
    pk_real max, last; /* of all, and of the member that has ended */
};

/* Whether a run is to stop; shared by an ensemble's members. */
struct control {
    volatile sig_atomic_t stop;
    double last, began; /* seconds of the processor */
    int slow;           /* given up at the cap */
    double looked;      /* at the clock, last, */
    unsigned often;     /* and the steps from one look to the next */
};

/* Of each setting what a checkpoint knows it by. */
enum { MARKS = 34 };
struct mark {
    const char *name;
    uint64_t of;
};

/* Settings as the run uses them. */
struct settings {
    struct pk_run_settings asked; /* of its lists those of parts and members are there for long */
    struct pk_run *run;
    const struct pk_system *system;
    const struct pk_part *parts;
    size_t n_parts;
    const struct pk_method *method;
    struct memory *memory;
    struct control *control;
    pk_real until, every; /* every: < 0 until / 1000, 0 each step */
    struct pk_options options;
    int has_every, has_step, polls;
    size_t n;                /* degrees of freedom */
    void *params, *families; /* what families.attach() takes */
    size_t families_size;
    unsigned char *given;       /* which parameters were set */
    pk_real *q, *v, *u;         /* the start */
    unsigned char *start_given; /* 2 n flags */
    struct pk_run_column *show; /* the columns of rows behind t */
    size_t n_show;
    struct expected *expected;
    struct drifting *drifting;
    struct mark marks[MARKS]; /* of what was asked for, where there are checkpoints */
};

/* Of steps/checkpoint.c. */
struct checkpoint {
    double began, last; /* when the run did, and when one was written */
    unsigned long looks, failures;
    int written, resumed, refused; /* the last one is; the run goes on from one, or cannot */
    int left;                      /* the run has ended with one */
};

/* The motion at a time. */
struct moment {
    pk_real t;
    const pk_real *q, *v;
};

/* The crossings of one event; the first of them by their times. */
struct crossed {
    unsigned long count;
    pk_real *t;
    unsigned long states; /* of steps, at which its function was looked at */
    unsigned long doubts; /* parts of steps in which crossings may be missed, */
    pk_real doubtful_t;   /* and the first's time */
    int leaves;           /* it has been away from zero by more than errors, */
    pk_real parts;        /* beside the largest contribution to it so far */
};

struct pk_run {
    const struct pk_run_model *model;
    const struct observer *observers[16]; /* NULL behind the last; see look/look.h */
    struct settings settings;
    struct memory memory;
    struct control control;
    char *said;
    char *report, *told; /* JSON; of malloc() */
    char *csv;           /* of a member, its rows; of malloc() */
    enum pk_run_code code;
    int refused;           /* what prepare() made of the parameters */
    struct pk_system bare; /* the system, of a bare run without events */
    struct pk_problem problem;
    struct pk_integrator it;
    struct pk_monitor monitor;
    struct pk_apart apart;            /* of blocks integrated apart, */
    struct pk_choice *choices;        /* by these, */
    struct pk_monitor *part_monitors; /* each watched */
    void *block, *monitor_block;
    struct pk_events events;
    struct crossed *crossed; /* of each event */
    pk_real *event_values;   /* work of watch.c */
    pk_real *expected;       /* outputs, work of expect.c */
    size_t member;           /* of an ensemble, whose state is looked at */
    pk_real *row, *cells;    /* q, v, observed of a row; the numbers of one */
    FILE *out;               /* where rows go as CSV; NULL: they are kept */
    double *kept, *kept_low; /* rows; what they lack of more digits */
    size_t n_kept, room;
    double *members;       /* of pk_run_members(), */
    pk_real *reduced;      /* and what of the member at hand is known so far, */
    unsigned long reduces; /* from so many rows */
    int reduces_rows;      /* some of it is of these */
    struct moment now;     /* of run_moment() */
    size_t stops;          /* of computed inputs, that are behind */
    pk_real count, next;   /* rows by time behind the first, and the number of the next one */
    pk_real expecting;     /* what is expected at times within steps was looked at up to here */
    struct pk_integrator aside; /* for states within fixed steps, made when one is asked for */
    void *aside_block;
    pk_real last_row; /* its time */
    int at_event;     /* the row being written is at one */
    unsigned long rows;
    int begun;            /* it could start */
    int lean;             /* of a member: nobody looks at its steps, but where it begins and ends */
    pk_real h_min, h_max; /* steps made; the least of those that their error alone bounds */
    unsigned long look_at; /* the step at which drifts are looked at next; see look/drifts.c */
    int looked;            /* whether they were at this one */
    pk_real trusted;       /* until when the energy was what it is to be; see look.h */
    int distrusted;
    pk_real ends;  /* end of the motion according to dop853 */
    int beyond;    /* the steps have gone on past that end */
    int goes_on;   /* dop853 finds that the motion goes on past the failure */
    char *besides; /* behind the reason of a failure, or NULL; of malloc() */
    int interrupted;
    int write_failed;
    const struct pk_run_column *not_finite; /* the first energy or output that was not, or NULL */
    double bad_t;                           /* and in which row, and how many rows there were */
    unsigned long bad_rows;
    const struct pk_run_column
        *lost;     /* the first value lost to rounding at a singular position, or NULL */
    double lost_t; /* as above */
    unsigned long lost_rows;
    double part;               /* of an ensemble that is done */
    double seconds, processor; /* on the wall's clock and the processor's, of the steps and rows */
    struct diagnostics *diagnostics; /* NULL: none asked for */
    struct looking *looking;         /* of condition.c */
    struct loop *loop;               /* of members, for their area */
    struct checkpoint checkpoint;
};

/* Numbers of a row: the member of an ensemble, t, the columns. */
static inline size_t run_width(const struct pk_run *run)
{
    return (run->settings.asked.members ? 2u : 1u) + run->settings.n_show;
}

static inline int run_fixed(const struct pk_run *run)
{
    return !(run->settings.method->traits & PK_ADAPTIVE);
}

/* Of control.c: seconds on the wall's clock, and of this thread on the processor's. */
double run_now(void);
double run_processor(void);
/* Whether it is to stop: asks `poll` now and then. */
int run_stopped(struct pk_run *run, double part);
int run_ending(void *context); /* of pk_options.stop: whether all runs are to end */
/* Rows go to this file descriptor as CSV; 0: they cannot, which errno tells. */
int run_open(struct pk_run *run, int fd);

#endif

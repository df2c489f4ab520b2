/* What a run writes: rows of a CSV, a report in JSON. */
#ifndef RUN_OUTPUT_H
#define RUN_OUTPUT_H

#include <stdio.h>

#include "settings.h"

/* The crossings of one event; the first of them by their times. */
struct crossed {
    unsigned long count;
    pk_real *t;
    unsigned long states; /* of steps, at which its function was looked at: */
    unsigned long doubts; /* parts of steps in which crossings may be missed, and the first's time */
    pk_real doubtful_t;
    int leaves;    /* it has been away from zero by more than errors, */
    pk_real parts; /* beside the largest contribution to it so far */
};

struct run {
    struct settings settings;
    struct pk_problem problem;
    struct pk_integrator it;
    struct pk_monitor monitor;
    struct pk_apart apart;            /* of blocks integrated apart, */
    struct pk_choice *choices;        /* by these, */
    struct pk_monitor *part_monitors; /* each watched */
    void *part_block;
    void *block, *monitor_block;
    struct pk_events events;
    void *events_block;
    struct crossed *crossed; /* of each event */
    pk_real *event_values;   /* work of watch.c */
    pk_real *expected;       /* outputs, work of expect.c */
    size_t member;     /* of an ensemble, whose state is looked at */
    pk_real *row;      /* q, v, observed, quadratures of a row */
    FILE *out;           /* where rows go */
    pk_real count, next; /* rows by time behind the first, and the number of the next one */
    pk_real expecting;   /* what is expected at times within steps was looked at up to here */
    struct pk_integrator aside; /* for states within fixed steps, made when one is asked for */
    void *aside_block;
    pk_real last_row;    /* its time */
    int at_event;        /* the row being written is at one */
    unsigned long rows;
    pk_real h_min, h_max; /* steps made */
    pk_real trusted; /* until when the energy was what it is to be; see trust.h */
    int distrusted;
    pk_real ends; /* where dop853 says that the motion does, */
    int beyond;   /* and the steps have gone on behind it */
    int goes_on;  /* by dop853 the motion does, where the steps ended */
    char *besides; /* behind the reason of a failure, or NULL */
    int interrupted;
    int write_failed;
    const char *not_finite; /* the first energy or observed value that was not, or NULL */
    double bad_t;           /* and in which row, and how many rows there were */
    unsigned long bad_rows;
    double seconds;
    struct diagnostics *diagnostics; /* NULL: none asked for */
    struct loop *loop;               /* of members, for their area */
    struct rows *kept;               /* where rows go instead of to a file; see choose_rows.h */
};

void output_header(struct run *run, FILE *file);
/* z: the quadratures, where the system has any. */
void output_row(struct run *run, FILE *file, pk_real t, const pk_real *q, const pk_real *v,
                const pk_real *z);
/* A column's value; `out` are the outputs there, where the system has any. */
pk_real output_value(const struct run *run, const struct shown *column, pk_real t,
                     const pk_real *q, const pk_real *v, const pk_real *z, const pk_real *out);
/* 0, or a message on standard error. */
int output_report(struct run *run, const char *path);
/* Whether all rows are written. */
int output_whole(const struct run *run);
/* A file to be written, and its end: 0, or a message and no file. */
FILE *output_begin(const char *path);
int output_end(FILE *file, const char *path);
/* After the rows; the exit code. Who has read enough of them is told nothing. */
int output_rows_end(struct run *run, int code);
/* Pieces of JSON. */
void output_text(FILE *file, const char *text);
void output_real(FILE *file, pk_real x);
void output_numbers(FILE *file, const char *key, const pk_real *x, size_t count); /* "key": [..] */
void output_drift(FILE *file, const char *name, const struct pk_drift *drift);
/* One JSON object a line. */
int output_methods(FILE *file);

#endif

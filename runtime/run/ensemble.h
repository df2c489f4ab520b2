/* An ensemble in place of one trajectory: `member,t,...` rows, a report of who arrived. */
#ifndef RUN_ENSEMBLE_H
#define RUN_ENSEMBLE_H

#include "output.h"

/* Reads the lines members, column, threads into the settings. 1 if it was one of them. */
int ensemble_setting(struct settings *s, const struct pk_system *system, size_t line,
                     char *const word[], int *code);
/* The number under which a member, from 0 on, is spoken of. */
long ensemble_number(const struct settings *s, size_t member);
/* Whether the members take fixed steps. */
int ensemble_fixed(const struct settings *s);
/* What has become of the members. */
struct tally {
    size_t done, failed, stopped, first_failed;
    size_t astray, first_astray; /* whose energy at the end is wrong */
    enum pk_status status;       /* of the first that failed, */
    pk_real t;
    char reason[512];            /* in words */
    unsigned long *crossings; /* of events and switches, in all, */
    unsigned long *never;     /* and how many members had none, */
    unsigned long *doubts;    /* or may have missed some */
    pk_real *first; /* when each event was first in each member, infinite without; or NULL */
};
/* Of watched.c: members that run one by one since events are watched or there are switches.
 * Memory of the tally; so many members; the members "events" and "switches" of the report. */
struct batch;
enum { WATCHED_AT_ONCE = 1024 };
int watched_by_one(const struct settings *s);
void watched_begin(struct tally *tally, const struct settings *s);
void watched_batch(const struct batch *b, struct run *run, size_t first, size_t count,
                   struct tally *tally);
void watched_warn(const struct tally *tally);
void watched_report(const struct tally *tally, const struct settings *s, FILE *file);
/* All of it, rows at `count` intervals of settings.every; the process's exit code. */
int ensemble_run(struct run *run, pk_real count);

/* Of main.c. */
int run_interrupted(void);
void run_interrupt(int whether);
/* A run of settings that were read, in one or in blocks apart: settings that depend on one another;
 * its memory, integrators and events (both an exit code); all its rows. run_free() gives all back but
 * the settings. */
int run_settle(struct run *run);
int run_begin(struct run *run);
void run_rows(struct run *run);
void run_free(struct run *run);
double run_now(void);
void run_progress(const struct run *run, double part, int force);
/* Of integrate.c. */
pk_real run_intervals(pk_real whole, pk_real part);
/* A step that was asked for, made a whole part of the interval where it is one but for rounding. */
pk_real run_step(pk_real interval, pk_real h);
/* Of row k of `count`: a double in every precision, as it is written. */
pk_real run_row_time(const struct run *run, pk_real k, pk_real count);

#endif

/* An ensemble in place of one trajectory: rows with the member in front, a report of who arrived.
 */
#ifndef RUN_ENSEMBLE_H
#define RUN_ENSEMBLE_H

#include "state.h"

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
    char reason[512];         /* in words */
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
void watched_begin(struct tally *tally, struct run *run);
void watched_batch(const struct batch *b, struct run *run, size_t first, size_t count,
                   struct tally *tally);
void watched_warn(struct run *run, const struct tally *tally);
void watched_report(const struct tally *tally, const struct settings *s, FILE *file);
/* All of it, rows at equal times up to the end. */
enum pk_run_code ensemble_run(struct run *run);

#endif

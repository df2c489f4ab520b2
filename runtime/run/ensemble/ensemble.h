/* An ensemble in place of one trajectory: rows with the member in front, a report of who arrived.
 */
#ifndef RUN_ENSEMBLE_H
#define RUN_ENSEMBLE_H

#include "../steps/checkpoint.h"

/* A batch of members: parameters, starts and inputs, and room for their rows. */
struct batch {
    struct pk_ensemble e;
    const struct pk_system *system;
    size_t n, size;          /* members that it has room for */
    char *params, *families; /* of each member: what families.attach() takes */
    size_t families_size;
    pk_real *q0, *v0, *u, *t;
    struct pk_run_value *own; /* parameters of one member */
    void *block;
    size_t block_size, threads;
};

/* Room for as many members as fit. */
void members_allocate(struct batch *b, struct pk_run *run, size_t rows);
/* The next `count` members, of which `first` is the first. */
enum pk_run_code members_set(struct batch *b, size_t first, size_t count, struct pk_run *run);
/* Every member once, without running: a parameter out of bounds shows before the first row. */
enum pk_run_code members_check(struct batch *b, struct pk_run *run);

/* Whether the members take fixed steps. */
int member_fixed(const struct settings *s);

/* Members that failed in the same way, and the first of them. */
struct failed {
    enum pk_status status;
    size_t count, member;
    pk_real t;
    char reason[512]; /* in words */
};

/* What has become of the members. */
struct tally {
    size_t done, failed;
    struct failed *first_failed, failures[-PK_STATUS_LAST];
    size_t astray, first_astray; /* whose energy at the end is wrong */
    unsigned long *crossings;    /* of events and switches, in all, */
    unsigned long *never;        /* and how many members had none, */
    unsigned long *doubts;       /* or may have missed some */
    pk_real *first; /* when each event was first in each member, infinite without; or NULL */
};
/* Members that run one by one since events are watched or there are switches: memory of the tally;
 * so many members; the members "events" and "switches" of the report. */
enum { WATCHED_AT_ONCE = 1024, WHOLE_BLOCKS = 64 };
void watched_begin(struct tally *tally, struct pk_run *run);
/* 0: the run is to end, and goes on another time before them. */
int watched_batch(const struct batch *b, struct pk_run *run, size_t first, size_t count,
                  struct tally *tally);
void watched_warn(struct pk_run *run, const struct tally *tally);
void watched_keep(struct tally *tally, const struct settings *s, struct pk_keep *k);
void watched_report(const struct tally *tally, const struct settings *s, struct json *j);

/* Counts how a member ended; of the first that fails in a way, room for the reason: TALLY_REASON
 * characters. */
#define TALLY_REASON sizeof((struct failed *)0)->reason
char *tally_note(struct tally *tally, size_t member, enum pk_status status, pk_real t, int astray);

#endif

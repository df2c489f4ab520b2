/* An ensemble in place of one trajectory: rows start with the member, a report counts the failures.
 */
#ifndef RUN_ENSEMBLE_H
#define RUN_ENSEMBLE_H

#include "../steps/checkpoint.h"

/* A batch of members: parameters, starts and inputs, and room for their rows. */
struct batch {
    struct pk_ensemble e;
    const struct pk_system *system;
    size_t n, size;          /* degrees of freedom; members that it has room for */
    char *params, *families; /* per member: parameters, memory for families.attach() */
    size_t families_size;
    pk_real *q0, *v0, *u, *t;
    struct pk_run_value *own; /* parameters of one member */
    void *block;
    size_t block_size, threads;
};

/* Allocates a batch of as many members as fit. */
void members_allocate(struct batch *b, struct pk_run *run, size_t rows);
/* Sets parameters, starts and inputs of `count` members from number `first` on. */
enum pk_run_code members_set(struct batch *b, size_t first, size_t count, struct pk_run *run);
/* Sets every member without running it, to find refused parameters before the first row. */
enum pk_run_code members_check(struct batch *b, struct pk_run *run);

/* Returns whether the members take fixed steps. */
int member_fixed(const struct settings *s);

/* Members that failed with the same status, and the first of them. */
struct failed {
    enum pk_status status;
    size_t count, member; /* number of them; the first */
    pk_real t;            /* the first's last valid time and reason */
    char reason[512];
};

/* The results of the members so far. */
struct tally {
    size_t done, failed;
    struct failed *first_failed, failures[-PK_STATUS_LAST];
    size_t astray, first_astray; /* members whose energy at the end is wrong */
    unsigned long *crossings;    /* per event and switch: crossings of all members, */
    unsigned long *never;        /* members that had none, */
    unsigned long *doubts;       /* members that may have missed some */
    pk_real *first; /* per event and member: time of the first crossing, else infinity; or NULL */
};
/* Members that run one by one, since events are watched or there are switches: allocates the tally;
 * runs `count` members; writes "events" and "switches" of the report. */
enum { WATCHED_AT_ONCE = 1024, WHOLE_BLOCKS = 64 };
void watched_begin(struct tally *tally, struct pk_run *run);
/* Returns 0 if the run is to end and a checkpoint will repeat these members. */
int watched_batch(const struct batch *b, struct pk_run *run, size_t first, size_t count,
                  struct tally *tally);
void watched_warn(struct pk_run *run, const struct tally *tally);
void watched_keep(struct tally *tally, const struct settings *s, struct pk_keep *k);
void watched_report(const struct tally *tally, const struct settings *s, struct json *j);

/* Counts how a member ended. Returns a buffer of TALLY_REASON characters for the reason, if it is
 * the first member that failed with this status; else NULL. */
#define TALLY_REASON sizeof((struct failed *)0)->reason
char *tally_note(struct tally *tally, size_t member, enum pk_status status, pk_real t, int astray);

#endif

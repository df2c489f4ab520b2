/* An ensemble instead of one trajectory: rows begin with the member, and a report counts
 * failures. */
#ifndef RUN_ENSEMBLE_H
#define RUN_ENSEMBLE_H

#include "../steps/checkpoint.h"

/* A batch of members: their parameters, initial states and inputs, and memory for their rows. */
struct batch {
    struct pk_ensemble e;
    const struct pk_system *system;
    size_t n, size;          /* degrees of freedom; largest number of members */
    char *params, *families; /* per member: parameters; memory for families.attach() */
    size_t families_size;
    pk_real *q0, *v0, *u, *t;
    struct pk_run_value *own; /* the given parameters of one member */
    void *block;
    size_t block_size, threads;
};

/* Allocates a batch of as many members as fit. */
void members_allocate(struct batch *b, struct pk_run *run, size_t rows);
/* Sets parameters, initial states and inputs of `count` members, the first with index `first`. */
enum pk_run_code members_set(struct batch *b, size_t first, size_t count, struct pk_run *run);
/* Sets all members without running them, to find refused parameters before rows are written. */
enum pk_run_code members_check(struct batch *b, struct pk_run *run);

/* Returns whether the members take fixed steps. */
int member_fixed(const struct settings *s);

/* Members that failed with one status. */
struct failed {
    enum pk_status status;
    size_t count, member; /* number of members; index of the first one */
    pk_real t;            /* last valid time, and reason, of the first one */
    char reason[512];
};

/* The results of the members so far. */
struct tally {
    size_t done, failed;
    struct failed *first_failed, failures[-PK_STATUS_LAST];
    size_t astray, first_astray; /* members whose final energy is wrong: number, first */
    unsigned long *crossings;    /* per event and switch: crossings of all members */
    unsigned long *never;        /* per event and switch: members without crossings */
    unsigned long *doubts;       /* per event and switch: members that may have missed some */
    pk_real *first; /* time of first crossing by event and member, or infinity; or NULL */
};
/* Ensembles with watched events or switches, whose members run one by one: watched_begin()
 * allocates the tally; watched_batch() runs members; watched_report() writes "events" and
 * "switches". */
enum { WATCHED_AT_ONCE = 1024, WHOLE_BLOCKS = 64 };
void watched_begin(struct tally *tally, struct pk_run *run);
/* Returns 0 if the run must end; a resumed run repeats these members. */
int watched_batch(const struct batch *b, struct pk_run *run, size_t first, size_t count,
                  struct tally *tally);
void watched_warn(struct pk_run *run, const struct tally *tally);
void watched_keep(struct tally *tally, const struct settings *s, struct pk_keep *k);
void watched_report(const struct tally *tally, const struct settings *s, struct json *j);

/* Counts the status with which a member ended. If it is the first member that failed with this
 * status, returns a buffer of TALLY_REASON characters for the reason; else NULL. */
#define TALLY_REASON sizeof((struct failed *)0)->reason
char *tally_note(struct tally *tally, size_t member, enum pk_status status, pk_real t, int astray);

#endif

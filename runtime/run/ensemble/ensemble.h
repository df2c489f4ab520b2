/* Runs an ensemble instead of one trajectory: each row begins with the number of the member, and
 * the report counts members that failed. */
#ifndef RUN_ENSEMBLE_H
#define RUN_ENSEMBLE_H

#include "../steps/checkpoint.h"

/* A batch of members: their parameters, initial states and inputs, and memory for their rows. */
struct batch {
    struct pk_ensemble e;
    const struct pk_system *system;
    size_t n, size; /* `n`: degrees of freedom; `size`: largest number of members in a batch */
    /* for each member: `params`: parameters; `families`: memory for families.attach() */
    char *params, *families;
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
    size_t count, member; /* `count`: number of these members; `member`: index of the first */
    pk_real t;            /* the first such member's last valid time, and its reason */
    char reason[512];
};

/* The results of the members so far. */
struct tally {
    size_t done, failed;
    struct failed *first_failed, failures[-PK_STATUS_LAST];
    /* number of members whose final energy is wrong; index of the first */
    size_t astray, first_astray;
    unsigned long *crossings; /* for each event and switch: crossings, summed over members */
    unsigned long *never;     /* for each event and switch: number of members without crossings */
    /* for each event and switch: number of members that may have missed crossings */
    unsigned long *doubts;
    /* Time of the first crossing, for each event and member; infinity if there is none. NULL
     * unless settings.asked.watch > 1. */
    pk_real *first;
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

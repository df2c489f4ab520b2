/* Members that run one by one since events are watched or there are switches. */
#ifndef RUN_WATCHED_H
#define RUN_WATCHED_H

#include "../base/json.h"
#include "members.h"

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
/* Memory of the tally; so many members; the members "events" and "switches" of the report. */
enum { WATCHED_AT_ONCE = 1024 };
void watched_begin(struct tally *tally, struct run *run);
void watched_batch(const struct batch *b, struct run *run, size_t first, size_t count,
                   struct tally *tally);
void watched_warn(struct run *run, const struct tally *tally);
void watched_report(const struct tally *tally, const struct settings *s, struct json *j);

#endif

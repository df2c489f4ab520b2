/* A run's state in a file, and a run that goes on from there (docs/dev/checkpoints.md). */
#ifndef RUN_STEPS_CHECKPOINT_H
#define RUN_STEPS_CHECKPOINT_H

#include "steps.h"

/* What a run has of its own, into k or from there; `context` is the caller's. */
typedef enum pk_status checkpoint_keep(struct pk_run *run, void *context, struct pk_keep *k);

/* Before the first step, with all memory there. Goes on from the file where that is asked for,
 * run->checkpoint.resumed; 0 where it does not fit, which is said. */
int checkpoint_begin(struct pk_run *run, checkpoint_keep *keep, void *context);
/* Between steps: writes it where it is time, and where the run is to end. */
void checkpoint_look(struct pk_run *run, checkpoint_keep *keep, void *context);
/* Whatever the time. */
void checkpoint_write(struct pk_run *run, checkpoint_keep *keep, void *context);

#endif

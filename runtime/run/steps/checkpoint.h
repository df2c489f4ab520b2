/* Checkpoints: a run's state in a file, and resuming from it (docs/dev/checkpoints.md). */
#ifndef RUN_STEPS_CHECKPOINT_H
#define RUN_STEPS_CHECKPOINT_H

#include "steps.h"

/* Saves the state of a run to k, or restores it from k; `context` is the caller's. */
typedef enum pk_status checkpoint_keep(struct pk_run *run, void *context, struct pk_keep *k);

/* Called before the first step, after all memory is allocated. If requested, restores the run from
 * the file and sets run->checkpoint.resumed. Returns 0, with a message, if that fails. */
int checkpoint_begin(struct pk_run *run, checkpoint_keep *keep, void *context);
/* Called between steps: writes a checkpoint if one is due or the run must end. */
void checkpoint_look(struct pk_run *run, checkpoint_keep *keep, void *context);
/* Writes a checkpoint now. */
void checkpoint_write(struct pk_run *run, checkpoint_keep *keep, void *context);

#endif

/* An ensemble in place of one trajectory: rows with the member in front, a report of who arrived.
 */
#ifndef RUN_ENSEMBLE_H
#define RUN_ENSEMBLE_H

#include "../base/state.h"

/* All of it, rows at equal times up to the end. */
enum pk_run_code ensemble_run(struct run *run);

#endif

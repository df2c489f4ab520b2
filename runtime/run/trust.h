/* How far a run that failed can be trusted. A status is about the path that the steps made, and that
 * may have left the motion long before: then it says nothing about the motion.
 */
#ifndef RUN_TRUST_H
#define RUN_TRUST_H

#include "output.h"

/* After each step. */
void trust_step(struct run *run);
/* Sets run->besides to what there is to say behind the reason of a failure: since when the energy of
 * a conservative system is wrong, and what dop853 at 1e-9 makes of the same motion where the
 * method's own steps are no judge of it (fixed, or of a loose tolerance). Likewise of fixed steps that
 * arrive with a wrong energy, if the motion itself does not arrive. 1 where the motion ends before
 * the run does. */
int trust_judge(struct run *run);

#endif

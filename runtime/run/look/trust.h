/* How far a run that failed can be trusted. A status is about the path that the steps made, and
 * that may have left the motion long before: then it says nothing about the motion.
 */
#ifndef RUN_TRUST_H
#define RUN_TRUST_H

#include "../base/state.h"

#define TRUST_WRONG PK_C(1e-2) /* of the energy's scale */
/* The status in a report of steps that went on behind the end of the motion: known to the driver
 * alone, so it is none of the core's. */
#define TRUST_BEYOND_NAME "RUN_BEYOND_END"
#define TRUST_BEYOND_TEXT "the motion ends before these steps do"
enum { TRUST_BEYOND_CODE = -100 };

/* Sets run->besides to what there is to say behind the reason of a failure: since when the energy
 * of a conservative system is wrong, and what dop853 at 1e-9 makes of the same motion where the
 * method's own steps are no judge of it (fixed, or of a loose tolerance). Likewise asks it of fixed
 * steps that arrive, or stop at an event, with a wrong energy: run->beyond where the motion ends
 * before they do, at run->ends. */
void trust_judge(struct run *run);
/* Of a run that was judged. The time until which it is right, as far as is known; its reason. */
pk_real trust_last_valid(const struct run *run);
/* What there is to say of one that arrived with a wrong energy all the same; 0 if nothing. */
int trust_warning(const struct run *run, char *text, size_t size);
void trust_reason(const struct run *run, char *text, size_t size);

#endif

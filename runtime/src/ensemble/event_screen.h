/* Screens steps made in advance in lanes: finds those that certainly cross no event and no switch.
 * All other steps are examined one by one as pk/events.h describes. */
#ifndef PK_SRC_EVENT_SCREEN_H
#define PK_SRC_EVENT_SCREEN_H

#include <pk/adaptive_lanes.h>

/* Returns the memory size of a screen, in pk_real. */
size_t pk_screen_size(const struct pk_block *b);
void pk_screen_init(struct pk_screen *s, const struct pk_block *b,
                    const struct pk_block_stepper *stepper, pk_real *base);
/* Returns those of the lanes `of` whose steps certainly cross no event and no switch. s->a0 and
 * s->a1 hold the accelerations at both ends of the steps. `known`: lanes screened before. */
unsigned long long pk_screen(struct pk_screen *s, struct pk_block *b, const struct pk_lane *lanes,
                             unsigned long long of, unsigned long long known, pk_real far);

#endif

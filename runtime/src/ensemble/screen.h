/* Screens steps made ahead in lanes: finds those that certainly cross no event and no switch. All
 * others are examined one by one as pk/events.h describes.
 */
#ifndef PK_SRC_SCREEN_H
#define PK_SRC_SCREEN_H

#include <pk/adaptive_lanes.h>

enum { PK_SCREENED = 8 }; /* intervals between the samples of a step */

/* pk_screen_bend(): sets s->bends, the difference between motion and cubic (events_look.c); `bad`
 * is not 0 in lanes where it is so large that the interpolant is useless. _between(): the
 * interpolant at x of 0 .. 1, into s->trial. _judge(): `bad` is not 0 in lanes where the function
 * with samples g, `stride` apart, may be zero, or is not `far` from it. */
void pk_screen_bend(const struct pk_screen *s, struct pk_block *b, pk_bits *bad);
void pk_screen_between(const struct pk_screen *s, const struct pk_block *b, pk_real x);
void pk_screen_judge(const pk_real *g, size_t stride, pk_real far, pk_bits *PK_RESTRICT bad);

size_t pk_screen_size(const struct pk_system *system, size_t n_q, size_t n, size_t W);
void pk_screen_init(struct pk_screen *s, const struct pk_block *b,
                    const struct pk_block_stepper *stepper, pk_real *base);
/* Returns those lanes of `of`, whose steps are made, that cross nothing; s->a0 and s->a1 hold the
 * accelerations at both ends. `known`: lanes screened in the step before this one. */
unsigned long long pk_screen(struct pk_screen *s, struct pk_block *b, const struct pk_lane *lanes,
                             unsigned long long of, unsigned long long known, pk_real far);

#endif

/* Steps made ahead, in lanes: which of them meet no event and no switch for sure. What is not sure
 * is left to the look of pk/events.h, of each alone.
 */
#ifndef PK_SRC_SCREEN_H
#define PK_SRC_SCREEN_H

#include <pk/abreast.h>

enum { PK_SCREENED = 8 }; /* samples of a step, and one more */

/* What the cubics of events_look.c lack, into s->bends; not 0 of lanes where that is so large
 * that the interpolant says nothing. The interpolant at x of 0 .. 1, into s->trial. Not 0 of lanes where the
 * function with these samples, `stride` apart, may be zero, or is not so far from it. */
void pk_screen_bend(const struct pk_screen *s, struct pk_block *b, pk_bits *bad);
void pk_screen_between(const struct pk_screen *s, const struct pk_block *b, pk_real x);
void pk_screen_judge(const pk_real *g, size_t stride, pk_real far, pk_bits *PK_RESTRICT bad);

size_t pk_screen_size(const struct pk_system *system, size_t n_q, size_t n, size_t W);
void pk_screen_init(struct pk_screen *s, const struct pk_block *b,
                    const struct pk_block_stepper *stepper, pk_real *base);
/* The lanes of these, whose steps are made, that cross nothing; with s->a0 and s->a1, the
 * accelerations at both ends. Of the lanes `known` it has seen the step before this one. */
unsigned long long pk_screen(struct pk_screen *s, struct pk_block *b,
                             const struct pk_abreast_lane *lanes, unsigned long long of,
                             unsigned long long known, pk_real far);

#endif

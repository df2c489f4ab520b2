/* A step that was made ahead, in a lane beside those of other integrators: pk/abreast.h. The
 * integrator, which then comes to that step, takes it in place of making it, and all that it does
 * around a step it does as ever.
 */
#ifndef PK_STEP_AHEAD_H
#define PK_STEP_AHEAD_H

#include <pk/step/numbers.h>

/* The step that an adaptive method tries, from `planned` on. `left`: to the limit; below `least` no
 * step moves t, and what is left that is no longer is one step. */
struct pk_trial {
    pk_real sign, left, least, planned, h; /* h: of the one tried, signed */
    int rejected, lands;
};

struct pk_ahead {
    const pk_real *next, *slopes; /* number i of the new state, of the stages: [i * lanes] */
    size_t lanes;
    pk_real from, end, h;
    int ready;          /* it is a step of the state that the integrator has */
    int clear;          /* no event and no switch is met in it */
    unsigned long many; /* so many steps lead there, in which nothing is to be looked at */
    unsigned long cost; /* accelerations of a step */
    int taken;          /* and is now the state */
    int waits;          /* it was rejected, and the next trial is to be this one */
    int again;          /* whether the step can wait for it: nothing else is under way */
    struct pk_trial trial;
};

/* Whether the step at hand is there. Where it is not, what the lane has is the state no more. */
static inline int pk_ahead_serves(struct pk_ahead *a, pk_real t, pk_real h, pk_real end)
{
    if (!a)
        return 0;
    a->taken = a->ready && !(a->h < h) && !(a->h > h) && !(a->from < t) && !(a->from > t) &&
               !(a->end < end) && !(a->end > end);
    a->ready = 0;
    return a->taken;
}

#endif

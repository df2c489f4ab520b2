/* A step made ahead in a SIMD lane together with those of other integrators: pk/adaptive_lanes.h. An
 * integrator that reaches this step takes its result instead of making it, and does the rest of its
 * work around the step as usual.
 */
#ifndef PK_STEP_AHEAD_H
#define PK_STEP_AHEAD_H

#include <pk/step/numbers.h>

/* A trial step of an adaptive method. `planned`: wanted step size; `left`: distance to the limit;
 * `least`: shortest step that moves t. If `left` is no longer, it is one step. */
struct pk_trial {
    pk_real sign, left, least, planned, h; /* h: signed size of the current trial */
    int rejected, lands;
};

struct pk_ahead {
    const pk_real *next, *slopes; /* number i of the new state, of the stages, is at [i * lanes] */
    size_t lanes;
    pk_real from, end, h;
    int ready;          /* a step from the integrator's state is there */
    int clear;          /* no event and no switch is crossed in it */
    unsigned long many; /* number of steps to `next` if none of them needs to be examined; or 0 */
    unsigned long cost; /* accelerations per step */
    int taken;          /* it was taken, and `next` is the integrator's state */
    int waits;          /* a trial was rejected, and `trial` is to be made ahead */
    int again;          /* whether the step may wait for it: nothing else is in progress */
    struct pk_trial trial;
};

/* Whether the current step was made ahead. If not, the lane no longer has the current state. */
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

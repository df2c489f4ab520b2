/* A step computed in advance in a SIMD lane, together with steps of other integrators: see
 * pk/adaptive_lanes.h. The integrator takes the result of this step instead of computing it; step
 * control, events and counters are as usual. */
#ifndef PK_STEP_AHEAD_H
#define PK_STEP_AHEAD_H

#include <pk/step/numbers.h>

/* A trial step of an adaptive method. planned: desired step size; left: time from it->t to the
 * limit; least: shortest step that changes t. If left <= least, one step goes to the limit. h:
 * signed size of the current trial step. */
struct pk_trial {
    pk_real sign, left, least, planned, h; /* h: signed size of the current trial step */
    int rejected, lands;
};

struct pk_ahead {
    /* number i of the state is next[i * lanes], that of a stage slopes[i * lanes] */
    const pk_real *next, *slopes;
    size_t lanes;
    pk_real from, end, h;
    int ready; /* 1: a step from the integrator's current state is available */
    int clear; /* 1: the step crosses no event and no switch */
    /* number of steps that the lane made at once, as none needs a check for events; or 0 */
    unsigned long many;
    unsigned long cost; /* number of accelerations per step */
    int taken;          /* 1: the integrator has taken the step, so that `next` is its state */
    /* 1: a trial step was rejected, and the next one, `trial`, is to be computed in a lane */
    int waits;
    int again; /* 1: a rejected trial may be repeated in a lane */
    struct pk_trial trial;
};

/* Returns whether the step from t to `end` was computed in advance. Any other is discarded. */
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

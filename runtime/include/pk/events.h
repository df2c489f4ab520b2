/* Events: times at which a function g(t, q, v) of the motion crosses zero, declared by `event`
 * (struct pk_event in pk/system_singular.h). Events do not change an integrator's steps; a root of
 * g within a step is located by shorter steps of the same method.
 *
 *     struct pk_events events;
 *     size_t size = pk_events_size(&problem, method);              (bytes)
 *     pk_events_init(&events, &it, block, size);
 *     events.found = my_function;                                  (if it is to be called)
 *     status = pk_events_to(&events, &it, 10);     PK_STOPPED_EVENT: it.t, it.q, it.v are there
 *
 * Location of roots. After each step g is sampled at 9 or 17 points of an interpolant of the
 * motion. This is the method's dense output, or, without dense output, the quintic Hermite
 * polynomial through q, v and the accelerations at the ends of the step. If that polynomial is
 * inaccurate (the second derivatives of the cubic one through q and v differ from the
 * accelerations), g is sampled at states that shorter steps reach. Adaptive Runge-Kutta methods
 * first try the quintic polynomial: if all samples of |g| on it are at least twice the variation of
 * g, there is no root, and dense output is not computed. The step is bisected repeatedly until the
 * polynomial through the samples is far from zero, or its last coefficients are so small that it
 * represents g. Where the polynomial crosses zero, or comes within 1/32 of its variation, g is
 * recomputed at a state that a second integrator reaches by one shorter step from the start of the
 * step. Only values at such states decide where a root is, so a root is as accurate as the method's
 * steps, and the trajectory is the same as without events. If g grows 64-fold in an adaptive step
 * much longer than all steps before it, such as the first, the step does not resolve the start of
 * g, and is repeated with an eighth of its length.
 *
 * If a step contains an odd number of roots, at least one is found. A pair of roots is found if g
 * on the interpolant comes close to zero between them. If intervals of 1/4096 of a step do not
 * resolve g, roots may be missed, and doubtful() is called. A feature of g that lies between two
 * samples is missed. A root without a sign change is no event, unless g is exactly zero at the end
 * of a step. The reported state is just after the root, where g has its new sign or is zero, within
 * about four units in the last place of t.
 *
 * Before a singularity, where a step fails (PK_SINGULAR_TIME, PK_SINGULAR_COORDINATES), steps of
 * half the remaining time each approach it, and roots in them are found.
 *
 * If g is exactly zero at the start, or stays zero, that is no event: an event occurs when g
 * reaches zero from another value. A sign change between steps, by pk_integrator_reset(), is no
 * event. An event with `stop` = 2 is a limit of the motion. If the first step begins beyond the
 * limit, or on it with the motion directed outward, the run ends at once. If a later step begins so
 * on the limit, it crosses it.
 *
 * Switches of the system (struct pk_part_switches) are located like events. The side of a switch,
 * the sign of its function that the equations use, is constant within a step, so that the equations
 * are smooth and every method keeps its order. The step ends at the root of a switch, and the next
 * step begins with the opposite side. At the start, and after a reset, the sides are the signs at
 * the state; a switch that is zero there gets the sign that it has just afterwards, or NaN while it
 * stays exactly zero. The integrator stores the sides in a copy of the params, which it makes for
 * each step from the params of the caller; there the sides stay 0. If a switch stays at its root,
 * as under dry friction at rest, the status is PK_SLIDING.
 *
 * If L or a constraint jumps across a switch (system->switches.impulses), the impulse of the jump
 * is added to the momenta before the next step. If the jump of the potential is too high to pass,
 * the motion is reflected and the side is unchanged. If the impulse is not determined, or a
 * position would have to jump, the status is PK_NO_IMPULSE. */
#ifndef PK_EVENTS_H
#define PK_EVENTS_H

#include <stddef.h>

#include <pk/integrator.h>

PK_BEGIN

struct pk_shape;

struct pk_events {
    /* The root at which found(), switched() or doubtful() is called. */
    size_t which;  /* index of the event in system->events.table */
    int direction; /* +1: g increases with t, -1: g decreases */
    pk_real t;
    const pk_real *q, *v;

    /* Called at each root at which g changes its sign in the direction that the event was declared
     * with. Calls are in the order of times, and for equal times in the order of declaration. It
     * returns nonzero to stop there, as an event declared with `stop` does. It may call no function
     * of the integrator but pk_integrator_dense(). NULL (the default): not called. */
    int (*found)(void *context, const struct pk_events *events);
    void *context;

    /* Called at each root of a switch, before its side changes; `which` is the index in
     * system->switches. It may call no function of the integrator but pk_integrator_dense(). */
    void (*switched)(void *context, const struct pk_events *events);

    /* Called if the function of an event or of a switch oscillates so fast after time t that its
     * roots may be missed. `which` is the index of the event, or n_events + that of the switch. */
    void (*doubtful)(void *context, const struct pk_events *events);

    unsigned long doubts; /* number of intervals, parts of steps, in which roots may be missed */
    unsigned long count;  /* number of events reported */
    unsigned long switchings; /* number of roots of switches passed */
    unsigned long tries;      /* number of states computed to locate roots */

    /* Private to the runtime. */
    struct pk_integrator scout;
    size_t n_q, n, n_events, n_switches;
    int proposes; /* flag: events are located on the method's dense output */
    int dense;    /* flag: the method's dense output is as accurate as its steps */
    int by_steps; /* flag: no interpolant of this step is accurate enough */
    int by_ends;  /* flag: the quintic polynomial is used although the method has dense output */
    pk_real from; /* start time of the step */
    /* start and length of the part of the step that is searched; `at` is a time minus `from` */
    pk_real at, width;
    pk_real *q0, *v0, *trial, *trial_v, *u, *g, *ends, *list, *at_near, *at_last;
    pk_real *a0, *a1, *a_between; /* accelerations at both ends and at a quarter of the step */
    pk_real *bend;                /* errors of the cubic Hermite interpolants */
    struct pk_shape *shapes;
    int cut; /* flag: the step ends early, at an event or a switch */
    size_t listed, most_listed;
    pk_real near; /* time just after the first switch in the step */
    /* times of the states at_near and at_last; -1: the state is not known */
    pk_real near_known, last;
    void *params; /* copy of the problem's params; `sides` points into it */
    pk_real *sides;
    pk_real *fresh; /* flags: the switch is zero at the start, so its side is a guess */
    int again;      /* flag: a guessed side was wrong, and the step is repeated */
    int brief;      /* number of successive switchings after very short steps */
    int slow;       /* number of switchings from slow_from on, within rounding of the time left */
    pk_real slow_from, limit; /* limit: where the step may end */
    int at_switch;            /* flag: the step begins at the root of a switch */
    int begun;     /* flag: the first step was made; also if the start is a limit, where it ends */
    int kept;      /* flag: the next step begins at the time `left`, where the last one ended */
    pk_real left;  /* end time of the last step */
    pk_real tried; /* length of the last step that an event or a switch has cut */
    /* for each event a number whose size is the rounding error of g: if |g| at the start of the
     * step is smaller than it, its sign is taken for that of g */
    pk_real *held;
    /* For each event a number that is subtracted from g: for a limit (`stop` = 2) its value at the
     * start if that is zero up to rounding; of a contact see act.c. */
    pk_real *off;
    pk_real *room; /* work memory for impulses */
};

/* Returns the bytes of the block for pk_events_init(), aligned for pk_real; 0 if
 * pk_integrator_size() is 0. */
size_t pk_events_size(const struct pk_problem *problem, const struct pk_method *method);

/* Prepares events for an initialised integrator; copies its problem, method and options. If the
 * system has no events and switches, pk_events_step() and pk_events_to() are those of the
 * integrator. */
enum pk_status pk_events_init(struct pk_events *events, const struct pk_integrator *it, void *block,
                              size_t block_size);

/* Makes one step of `it` towards `limit`, as pk_integrator_step(), and calls found() for each event
 * in it. PK_STOPPED_EVENT: `it` is just after event number it->event - 1, and after all events at
 * the same time (within about four units in the last place of t); the next step continues from
 * there. PK_NOT_FINITE with it->event != 0: g is not finite there. */
enum pk_status pk_events_step(struct pk_events *events, struct pk_integrator *it, pk_real limit);

/* Makes steps until it->t == t_end, or until an event ends the run. */
enum pk_status pk_events_to(struct pk_events *events, struct pk_integrator *it, pk_real t_end);

/* Frees memory. Needed only after methods that allocate (GSL's). */
void pk_events_free(struct pk_events *events);

PK_END

#endif

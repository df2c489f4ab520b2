/* Events: times at which a function g(t, q, v) of the motion crosses zero, declared by `event`
 * (struct pk_event in pk/system_singular.h). An integrator steps as it would without them; if g has
 * a root within a step, the method itself locates it.
 *
 *     struct pk_events events;
 *     size_t size = pk_events_size(&problem, method);              (bytes)
 *     pk_events_init(&events, &it, block, size);
 *     events.found = my_function;                                  (if it is to be called)
 *     status = pk_events_to(&events, &it, 10);     PK_STOPPED_EVENT: it.t, it.q, it.v are there
 *
 * Location of roots. After each step g is sampled at 9 or 17 points of an interpolant: the method's
 * dense output, else the quintic Hermite polynomial through q, v and accelerations, or, if the
 * cubic through q and v bends otherwise than the motion, states of shorter steps. Adaptive
 * Runge-Kutta methods try the quintic first: if g is twice as far from zero on it as it varies, no
 * dense output is made. Either the polynomial through the samples shows that g is far from zero, or
 * its last coefficients show that it represents g; otherwise the step is bisected, repeatedly.
 * Where the polynomial crosses zero, or comes within 1/32 of its variation, g is recomputed at a
 * state that a second integrator reaches by one shorter step from the start of the step. Only such
 * states decide, so a root is as accurate as the method's steps, and the trajectory is the same as
 * without events. An adaptive step much longer than all before it, such as a first one, in which g
 * grows 64-fold, does not resolve the start of g: it is repeated at an eighth of its length.
 *
 * Of an odd number of roots in a step at least one is always found; a pair is found if the
 * interpolant shows the dip. If g is not resolved by 1/4096 of a step, roots may be missed, and
 * doubtful() is called. A feature narrower than the sample spacing, absent at all samples, is
 * missed. A touch without a sign change is no event, unless g is exactly zero at the end of a step.
 * The reported state lies just behind the root, where g has its new sign or is zero, within about
 * four units in the last place of t.
 *
 * Before a singularity, where a step fails (PK_SINGULAR_TIME, PK_SINGULAR_COORDINATES), shorter
 * steps lead up to it, each half of the rest, and roots in them are found.
 *
 * If g is exactly zero at the start, or stays zero, nothing has crossed: an event fires when g
 * reaches zero from elsewhere. Each step starts from the state of `it`: a sign change by a jump
 * (pk_integrator_reset()) is no event. Limits (stop 2) differ: a first step that begins beyond a
 * limit, or on it and leads out, ends at once, and a later step that begins on it and leads out
 * crosses it.
 *
 * Switches of the system (struct pk_part_switches) are located like events. Each is held on the
 * current side, so that within a step the equations are smooth and every method keeps its order;
 * the step ends at the root of a switch, and the next one begins on the other side. At the start,
 * and after a reset, the sides follow the state; a switch that is zero there gets the side towards
 * which the motion goes, or else 1. The sides are in a copy of the params that the integrator uses
 * during a step; the caller's params keep 0 and are read again for each step. If the motion does
 * not leave a root, as under dry friction at rest, the status is PK_SLIDING.
 *
 * If L or a constraint jumps across a switch (system->switches.impulses), the rates get the impulse
 * of the jump before the next step. If the barrier is too high, the motion is reflected and keeps
 * its side. If the impulse is not determined, or a position would have to jump, the status is
 * PK_NO_IMPULSE.
 */
#ifndef PK_EVENTS_H
#define PK_EVENTS_H

#include <stddef.h>

#include <pk/integrator.h>

PK_BEGIN

struct pk_shape;

struct pk_events {
    /* The current root, for found(). */
    size_t which;  /* index into system->events.table */
    int direction; /* +1: g rises with t, -1: it falls */
    pk_real t;
    const pk_real *q, *v;

    /* Called at each root with a direction that its event asks for, in the order of the motion; at
     * equal times in the order of declaration. Not 0: stop here, as an event declared with `stop`
     * does. NULL, as after init: not called. It must leave the integrator alone, except for
     * pk_integrator_dense(). */
    int (*found)(void *context, const struct pk_events *events);
    void *context;

    /* Called at each root of a switch, before its side changes; `which` is its index in
     * system->switches. It must leave the integrator alone, as found(). */
    void (*switched)(void *context, const struct pk_events *events);

    /* Called if a function turns so often after t that roots may be missed; `which` is the index of
     * the event, or n_events + the index of the switch. */
    void (*doubtful)(void *context, const struct pk_events *events);

    unsigned long doubts;     /* windows of steps in which roots may be missed */
    unsigned long count;      /* events reported */
    unsigned long switchings; /* roots of switches passed */
    unsigned long tries;      /* states computed to locate roots */

    /* For the runtime alone. */
    struct pk_integrator scout;
    size_t n_q, n, n_events, n_switches;
    int proposes;      /* interpolates by the dense output of the method, which */
    int dense;         /* is as accurate as its steps */
    int by_steps;      /* no interpolant of this step is accurate enough */
    int by_ends;       /* the quintic is used all the same */
    pk_real from;      /* start time of the step */
    pk_real at, width; /* the current window, relative to `from` */
    pk_real *q0, *v0, *trial, *trial_v, *u, *g, *ends, *list, *at_near, *at_last;
    pk_real *a0, *a1, *a_between; /* accelerations at the ends of the step, and at a quarter */
    pk_real *bend; /* defect of the cubics: of coordinates at both ends, then of states */
    struct pk_shape *shapes;
    int cut; /* the step ends early, at an event or a switch */
    size_t listed, most_listed;
    pk_real near; /* just behind the first switch in the list; nothing later is listed */
    pk_real near_known, last; /* where the values at_near and at_last are exact; -1: nowhere */
    void *params;             /* the copy of the params, and its sides */
    pk_real *sides;
    pk_real *fresh; /* flags: zero at the start of the step, so the side is a guess */
    int again;      /* a guess was wrong: repeat the step */
    int brief;      /* number of switchings in immediate succession */
    int at_switch;  /* the step begins at a switch */
    int begun;      /* the first step was made, or refused by a limit */
    int kept;       /* the step starts at `left`, where the last one ended */
    pk_real left;   /* end of the last step; there switches with impulses keep their sides */
    pk_real *held;  /* signed rounding of events; an event within it keeps its sign */
    pk_real *off;   /* rounding of limits on which the first step begins; subtracted */
    pk_real *room;  /* work for impulses */
};

/* Returns the bytes of the block for pk_events_init(), aligned for pk_real; 0 as
 * pk_integrator_size(). */
size_t pk_events_size(const struct pk_problem *problem, const struct pk_method *method);

/* Prepares events for an initialised integrator; copies its problem, method and options. If the
 * system has no events and switches, the functions below act as without struct pk_events. */
enum pk_status pk_events_init(struct pk_events *events, const struct pk_integrator *it, void *block,
                              size_t block_size);

/* Makes one step of `it` towards `limit`, as pk_integrator_step(), and calls found() for each event
 * in it. PK_STOPPED_EVENT: `it` is at event `it->event` - 1, behind all others at the same time
 * (within about four units in its last place); the next step continues from there. PK_NOT_FINITE
 * with it->event != 0: g is not finite there. */
enum pk_status pk_events_step(struct pk_events *events, struct pk_integrator *it, pk_real limit);

/* Makes steps until it->t == t_end or an event stops. */
enum pk_status pk_events_to(struct pk_events *events, struct pk_integrator *it, pk_real t_end);

/* Needed after methods that allocate (GSL's), harmless after others. */
void pk_events_free(struct pk_events *events);

PK_END

#endif

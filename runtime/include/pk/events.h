/* Events: times at which a function g(t, q, v) of the motion crosses zero, as `event` declares them
 * (struct pk_event in pk/system.h). An integrator steps as it would without them; where g changes
 * its sign within a step the crossing is located by the method itself.
 *
 *     struct pk_events events;
 *     size_t size = pk_events_size(&problem, method);              (bytes)
 *     pk_events_init(&events, &it, block, size);
 *     events.found = my_function;                                  (if it is to be called)
 *     status = pk_events_to(&events, &it, 10);     PK_STOPPED_EVENT: it.t, it.q, it.v are there
 *
 * How a crossing is located. After each step g is looked at at its ends and in between, at 9 or 17
 * points of an interpolant: the method's own dense output, else the quintic of Hermite through q, v
 * and accelerations, or, where that of q and v alone bends otherwise than the motion, states by
 * shorter steps. Of adaptive Runge-Kutta methods the quintic comes first: where g is twice as far
 * from zero on it as it varies, no dense output is made. Either the polynomial through these points shows that g is far from zero, or its
 * last coefficients show that it represents g; else the step is looked at in halves, and these in
 * halves. Where the polynomial crosses zero, or dips to 1/32 of what it varies by, g is computed
 * anew at a state that a second integrator reaches by the same method in one shorter step from
 * where the step began. Only such states decide; so a crossing is as accurate as the method's own
 * step, and the trajectory is what it is without events. An adaptive step much longer than all
 * before it, a first one say, in which g grows 64-fold, does not show how g began: it is made anew,
 * an eighth as long.
 *
 * Of an odd number of crossings in a step at least one is always found; two are found where
 * the interpolant shows the dip. Where 1/4096 of a step is still too long for g, crossings may
 * be missed, and doubtful() is called. What is narrower than the sample spacing, and constant
 * at all of them, is not seen. A touch without a crossing is no event,
 * unless g is exactly zero at the end of a step. The time is that of a state just behind the
 * crossing, where g has its new sign or is zero, within some four units in the last place of t.
 *
 * Before a singularity, where a step fails (PK_SINGULAR_TIME, PK_SINGULAR_COORDINATES), shorter
 * ones lead up to it, each half of what is left, and what they cross is found.
 *
 * Where g is exactly zero at the start, or stays so, nothing has crossed: an event fires when g
 * reaches zero from somewhere else. Each step begins anew with the state that `it` has: after a
 * jump (pk_integrator_reset()) g may be on the other side, and that is no crossing. A limit (stop 2)
 * is not passed so: a first step that begins beyond it, or on it and leads out, ends at once, and a
 * later one that begins on it crosses it where it leads out.
 *
 * Switches of the system (struct pk_system) are located as events are. Each is held on the side on
 * which the motion is, so that within a step the equations are smooth, every method has its order
 * and may be used; where one crosses zero the step ends, and the next one begins on the other side.
 * At the start, and after a reset, the sides are those of the state; of a switch that is zero there
 * the one to which the motion goes, or else 1. The sides are in a copy of the params that is the
 * integrator's during a step; those of the caller keep 0 and are read anew for each step. Where the
 * motion does not leave a zero, as under dry friction at rest, the status is PK_SLIDING.
 *
 * Where L or a constraint jumps across a switch (system->switches.impulses) the jump's
 * impulse is given to the rates before the next step begins. If the barrier is too high, the
 * motion is turned back and stays on its side. Where the impulse is not determined, or a position
 * would have to jump, the status is PK_NO_IMPULSE.
 */
#ifndef PK_EVENTS_H
#define PK_EVENTS_H

#include <stddef.h>

#include <pk/integrator.h>

PK_BEGIN

struct pk_shape;

struct pk_events {
    /* The crossing at hand, to be read in found(). */
    size_t which;  /* of system->events.table */
    int direction; /* +1: g rises with t, -1: it falls */
    pk_real t;
    const pk_real *q, *v;

    /* Called at each crossing in a direction that its event asks for, in the order in which the
     * integrator meets them; of those at the same time the one declared first comes first. Not 0:
     * stop here, as at an event that is declared with `stop`. NULL, as after init: nothing is
     * called. It must leave the integrator alone, but for pk_integrator_dense(). */
    int (*found)(void *context, const struct pk_events *events);
    void *context;

    /* Called where a switch crosses zero, before its side changes: `which` is of system->switches.
     * The integrator is to be left alone, as in found(). */
    void (*switched)(void *context, const struct pk_events *events);

    /* Called where a function turns so often, from t on, that crossings may be missed: `which` is
     * of events, and behind these of switches. */
    void (*doubtful)(void *context, const struct pk_events *events);

    unsigned long doubts;     /* parts of steps in which that was so */
    unsigned long count;      /* of crossings reported */
    unsigned long switchings; /* of switches */
    unsigned long tries;      /* states computed to locate them */

    /* For the runtime alone. */
    struct pk_integrator scout;
    size_t n_q, n, n_events, n_switches;
    int proposes;      /* the method's own dense output does, */
    int dense;         /* and is as accurate as its steps */
    int by_steps;      /* no interpolant of this step is worth anything */
    int by_ends;       /* looked at by the quintic all the same */
    pk_real from;      /* time where the step began */
    pk_real at, width; /* the window that is looked at, from there */
    pk_real *q0, *v0, *trial, *trial_v, *u, *g, *ends, *list, *at_near, *at_last;
    pk_real *a0, *a1, *a_between; /* accelerations at the ends of the step, and at a quarter */
    pk_real *bend; /* what the cubics lack: of coordinates at both ends, then of states */
    struct pk_shape *shapes;
    int cut; /* the step ends at an event or a switch in it */
    size_t listed, most_listed;
    pk_real near; /* behind the first switch in the list; nothing is listed from there on */
    pk_real near_known, last; /* where the values at_near and at_last are true ones; -1: nowhere */
    void *params;             /* with sides: */
    pk_real *sides;
    pk_real *fresh; /* flags: zero at the start of the step, so that its side is a guess */
    int again;      /* a guess was wrong; step again */
    int brief;      /* switchings one upon another */
    int at_switch;  /* the step begins at one */
    int begun;      /* the first step is made, or refused by a limit */
    int kept;       /* the step starts where the last one ended, at `left` */
    pk_real left;   /* end of the last step; impulse switches keep sides */
    pk_real *held;  /* signed rounding; an event within it keeps the side of `held` */
    pk_real *off;   /* of limits on which the first step begins: rounding, taken off */
    pk_real *room;  /* for impulses */
};

/* Bytes of the block that pk_events_init() wants, aligned for pk_real; 0 as
 * pk_integrator_size(). */
size_t pk_events_size(const struct pk_problem *problem, const struct pk_method *method);

/* For an integrator that is initialised; takes its problem, method and options. Without
 * events and switches in the system all below is as without struct pk_events. */
enum pk_status pk_events_init(struct pk_events *events, const struct pk_integrator *it, void *block,
                              size_t block_size);

/* One step of `it` towards `limit`, as pk_integrator_step(), and found() for all that was crossed
 * in it. PK_STOPPED_EVENT: `it` is at the event, behind all others at the same time (some four
 * units in its last place), `it->event` - 1 says which; a next step goes on from there.
 * PK_NOT_FINITE with it->event: g is no finite number there. */
enum pk_status pk_events_step(struct pk_events *events, struct pk_integrator *it, pk_real limit);

/* Steps until it->t == t_end or an event that stops. */
enum pk_status pk_events_to(struct pk_events *events, struct pk_integrator *it, pk_real t_end);

/* Needed for methods that allocate (GSL's), harmless for others. */
void pk_events_free(struct pk_events *events);

PK_END

#endif

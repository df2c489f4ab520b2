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
 * How a crossing is located. After each step g is compared at its ends and in between, at as many
 * points of an interpolant as suit the method's stages: its own dense output where that is as
 * accurate as its steps, else the cubic of Hermite through q and v, or, where its second derivative
 * at the ends is not the motion's, states by shorter steps. Where the interpolant crosses
 * zero, or dips towards it, g is computed anew at a state that a second integrator reaches by the
 * same method in one shorter step from where the step began. Only such states decide; so a crossing
 * is as accurate as the method's own step, and the trajectory is what it is without events.
 *
 * What is found: an odd number of crossings in a step always, at least one of them; two of them
 * that lie nearer to each other than the points in between (2 to 16 a step) may be missed, the more
 * so where g comes close to zero without crossing by much. A touch without a crossing is none,
 * unless g is exactly zero at the end of a step. The time is that of a state just behind the
 * crossing, where g has its new sign or is zero, within some four units in the last place of t.
 *
 * Before a singularity, where a step fails (PK_SINGULAR_TIME, PK_SINGULAR_COORDINATES), shorter
 * ones lead up to it, each half of what is left, and what they cross is found.
 *
 * Where g is exactly zero at the start, or stays so, nothing has crossed: an event fires when g
 * reaches zero from somewhere else. Each step begins anew with the state that `it` has: after a jump
 * (pk_integrator_reset()) g may be on the other side, and that is no crossing.
 *
 * Switches of the system (struct pk_system) are located as events are. Each is held on the side on
 * which the motion is, so that within a step the equations are smooth, every method has its order
 * and may be used; where one crosses zero the step ends, and the next one begins on the other side.
 * At the start, and after a reset, the sides are those of the state; of a switch that is zero there
 * the one to which the motion goes, or else 1. The sides are in a copy of the params that is the
 * integrator's during a step; those of the caller keep 0 and are read anew for each step. Where the
 * motion does not leave a zero, as under dry friction at rest, the status is PK_SLIDING.
 *
 * Where L or a constraint jumps across a switch (system->impulses) the rates get the impulse that
 * the jump gives, before the next step begins; of a barrier that is too high the motion is turned
 * back, and stays on its side. Where the impulse is not determined, or a position would have to
 * jump, the status is PK_NO_IMPULSE.
 */
#ifndef PK_EVENTS_H
#define PK_EVENTS_H

#include <stddef.h>

#include <pk/integrator.h>

#ifdef __cplusplus
extern "C" {
#endif

struct pk_events {
    /* The crossing at hand, to be read in found(). */
    size_t which;  /* of system->events */
    int direction; /* +1: g rises with t, -1: it falls */
    pk_real t;
    const pk_real *q, *v;
    const pk_real *z; /* the quadratures; NULL: there are none */

    /* Called at each crossing in a direction that its event asks for, in the order in which the
     * integrator meets them; of those at the same time the one declared first comes first. Not 0:
     * stop here, as at an event that is declared with `stop`. NULL, as after init: nothing is
     * called. It must leave the integrator alone, but for pk_integrator_dense(). */
    int (*found)(void *context, const struct pk_events *events);
    void *context;

    /* Called where a switch crosses zero, before its side changes: `which` is of system->switches.
     * The integrator is to be left alone, as in found(). */
    void (*switched)(void *context, const struct pk_events *events);

    unsigned long count; /* of crossings reported */
    unsigned long switchings; /* of switches */
    unsigned long tries; /* states computed to locate them */

    /* For the runtime alone. */
    struct pk_integrator scout;
    size_t n, n_events, n_switches;
    int samples; /* intervals of a step that are looked at */
    int dense;   /* by the method's own dense output */
    pk_real from; /* time where the step began */
    pk_real *q0, *v0, *z0, *trial, *u, *g, *list;
    size_t listed;
    void *params;    /* with sides: */
    pk_real *sides;
    pk_real *fresh;  /* flags: zero where the step begins, so that the side is a guess, */
    int again;       /* and was a wrong one */
    int brief;       /* switchings one upon another */
    int at_switch;   /* the step begins at one */
    int kept;        /* the step goes on from where the last one ended, at */
    pk_real left;    /* this time: switches with an impulse keep their sides */
    pk_real *room;   /* for impulses */
};

/* Bytes of the block that pk_events_init() wants, aligned for pk_real; 0 as
 * pk_integrator_size(). */
size_t pk_events_size(const struct pk_problem *problem, const struct pk_method *method);

/* For an integrator that is initialised; takes its problem, method and options. Without
 * events and switches in the system all below is as without struct pk_events. */
enum pk_status pk_events_init(struct pk_events *events, const struct pk_integrator *it,
                              void *block, size_t block_size);

/* One step of `it` towards `limit`, as pk_integrator_step(), and found() for all that was crossed
 * in it. PK_STOPPED_EVENT: `it` is at the event, behind all others at the same time (some four
 * units in its last place), `it->event` - 1 says which; a next step goes on from there.
 * PK_NOT_FINITE with it->event: g is no finite number there. */
enum pk_status pk_events_step(struct pk_events *events, struct pk_integrator *it, pk_real limit);

/* Steps until it->t == t_end or an event that stops. */
enum pk_status pk_events_to(struct pk_events *events, struct pk_integrator *it, pk_real t_end);

/* Needed for methods that allocate (GSL's), harmless for others. */
void pk_events_free(struct pk_events *events);

#ifdef __cplusplus
}
#endif

#endif

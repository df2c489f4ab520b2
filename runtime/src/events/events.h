/* Shared by the files of events. Not installed. */
#ifndef PK_SRC_EVENTS_H
#define PK_SRC_EVENTS_H

#include <pk/events.h>

#include "../core/internal.h"

/* The last sample of a window has the index PK_MOST_SAMPLES. A function has at most PK_MOST_NODES
 * nodes (times with exact values) in a window. Each crossing in the list has PK_EVENT_ENTRY
 * numbers: time from the start of the step, function, direction. */
enum { PK_MOST_SAMPLES = 16, PK_MOST_NODES = 4 * PK_MOST_SAMPLES, PK_EVENT_ENTRY = 3 };

/* The list of crossings ends at the first switch: at most so many crossings of it are listed. */
enum { PK_MOST_TOGETHER = 4 };

/* An interpolant may be less accurate than the method's own. On such an interpolant, an event
 * function g has no root if |g| is larger than its variation by this factor. */
#define PK_CLEAR_OF PK_C(2.0)

/* One function in a window: the polynomial sum c_k cos(k angle) through its samples. */
struct pk_shape {
    pk_real c[PK_MOST_SAMPLES + 1];
    pk_real range, tail;    /* max - min of the samples; sum of the last few |c_k| */
    pk_real others;         /* sum of |c_k| over k > 0, plus `tail` */
    pk_real last_x, last_g; /* last node: its time and the exact value there */
    int order;
    /* clear: the polynomial agrees with the function up to 1/40 of the range, or the function has
     * no root. lost: the polynomial does not resolve the function. crosses: the function may have a
     * root. jumps: the function has a jump. */
    int clear, lost, crosses, jumps;
    int in_a_row; /* number of narrowest windows in succession with `lost` */
};

/* Returns the number of functions: events, then switches. */
static inline size_t pk_events_count(const struct pk_events *e)
{
    return e->n_events + e->n_switches;
}

/* Returns the values of all functions g at sample j of the window. Sample 0 is at the start of the
 * window and sample PK_MOST_SAMPLES at its end; one more sample is scratch memory. */
static inline pk_real *pk_events_sample(const struct pk_events *e, int j)
{
    return e->g + pk_events_count(e) * (size_t)j;
}

/* Returns the values of all functions at the start (0) or the end (1) of the step. */
static inline pk_real *pk_events_end(const struct pk_events *e, int end)
{
    return e->ends + (end ? pk_events_count(e) : 0);
}

/* Returns the time t of a point of the step. x is the time from the start of the step to this
 * point, positive also in a motion backwards in time. */
static inline pk_real pk_events_time(const struct pk_events *e, const struct pk_integrator *it,
                                     pk_real x)
{
    return x < pk_abs(it->t - e->from) ? e->from + pk_direction(it) * x : it->t;
}

/* Returns whether there is an impulse at switch k. */
static inline int pk_switches_impulse(const struct pk_integrator *it, size_t k)
{
    const struct pk_system *system = it->problem.system;
    return system->switches.impulses && system->switches.impulses[k];
}

/* Returns whether switch k is counted; see struct pk_system. */
static inline int pk_switches_counted(const struct pk_integrator *it, size_t k)
{
    const struct pk_system *system = it->problem.system;
    return PK_SYSTEM_HAS(system, counted) && system->counted && system->counted[k];
}

/* Returns the accuracy of a root at x: two units in the last place of its time, either side. */
static inline pk_real pk_events_width(const struct pk_events *e, const struct pk_integrator *it,
                                      pk_real x)
{
    const pk_real t = pk_max(pk_abs(e->from), pk_abs(pk_events_time(e, it, x)));
    return 4 * PK_EPS * t + PK_EPS * PK_EPS * pk_abs(it->t - e->from);
}

/* Returns whether the next step is not the first one and no crossing cut the step before it. */
static inline int pk_events_goes_on(const struct pk_events *e) { return e && e->begun && !e->cut; }

/* Returns whether steps made in advance (pk/adaptive_lanes.h) are known to cross nothing. */
static inline int pk_events_ahead(const struct pk_events *e, const struct pk_integrator *it)
{
    const struct pk_ahead *a = it->own->ahead;
    return pk_events_goes_on(e) && a && (a->many || (a->ready && a->clear));
}

/* Computes the state at t within the step by the method itself, into e->trial and e->trial_v. */
enum pk_status pk_events_reach(struct pk_events *e, struct pk_integrator *it, pk_real t);
/* Finds all crossings in the step, window by window, and reports them. */
enum pk_status pk_events_look(struct pk_events *e, struct pk_integrator *it);
/* cos(pi j / 16). pk_events_node() returns the time of sample j from the start of the step. */
extern const pk_real pk_events_cosines[PK_MOST_SAMPLES + 1];
pk_real pk_events_node(const struct pk_events *e, int j);
/* Evaluates all event and switch functions g at a state. */
void pk_events_functions(const struct pk_events *e, const struct pk_integrator *it, pk_real t,
                         const pk_real *q, const pk_real *v, pk_real *g);
/* Copies the caller's params into e->params, which `it` uses during a step. */
void pk_switches_enter(struct pk_events *e, struct pk_integrator *it);
/* Records the state at the end of the step. */
void pk_switches_leave(struct pk_events *e, const struct pk_integrator *it);
/* Sets the side of each switch by the state of `it`, unless `it` has already made a step. */
enum pk_status pk_switches_settle(struct pk_events *e, struct pk_integrator *it);
/* Returns whether switches that were exactly zero at the start of the step remained so, and get no
 * side, or left zero, and get one. If so, resets `it` to the start of the step. */
int pk_switches_free(struct pk_events *e, struct pk_integrator *it);
/* Returns whether switches that were zero at the start of the step went to another side than
 * guessed. If so, sets the side to which they went, and resets `it` to the start of the step. */
int pk_switches_turn(struct pk_events *e, struct pk_integrator *it);
/* Moves the listed switches that cross up to the time `last` to their new sides. `attempted`:
 * length of the step before it was cut. */
enum pk_status pk_switches_pass(struct pk_events *e, struct pk_integrator *it, pk_real last,
                                pk_real attempted);
/* Returns the number of pk_real for impulses, or 0 if there are none. */
size_t pk_impulse_size(const struct pk_system *system, size_t n);
/* Applies the impulses at `count` switches that are crossed at once, at e->t, e->q, e->v; the
 * switch which[i] goes to side[i]. Changes the rates in e->trial_v and the sides. Returns
 * PK_NO_IMPULSE on failure. */
enum pk_status pk_impulse(struct pk_events *e, struct pk_integrator *it, const size_t *which,
                          const pk_real *side, size_t count);
int pk_impulse_reason(const struct pk_integrator *it, char *text, size_t size);
/* Evaluates the arguments of all switches, with current inputs. */
void pk_switches_values(const struct pk_events *e, const struct pk_integrator *it, pk_real t,
                        const pk_real *q, const pk_real *v, pk_real *x);
enum pk_status pk_events_not_finite(struct pk_integrator *it, size_t k);
/* Adds the crossings of function k in the window to the list, in the order of the motion. */
enum pk_status pk_events_seek(struct pk_events *e, struct pk_integrator *it, size_t k);
/* Reports the listed crossings in order, up to the first event that stops the run or the first
 * switch, and the crossings at the same time as this one. */
enum pk_status pk_events_report(struct pk_events *e, struct pk_integrator *it);

#endif

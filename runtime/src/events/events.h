/* Shared by the files of events. Not installed. */
#ifndef PK_SRC_EVENTS_H
#define PK_SRC_EVENTS_H

#include <pk/events.h>

#include "../core/internal.h"

/* Samples of a window; most nodes of a function in it; size of an entry of the list of crossings: x
 * from the start of the step, function, direction. */
enum { PK_MOST_SAMPLES = 16, PK_MOST_NODES = 4 * PK_MOST_SAMPLES, PK_EVENT_ENTRY = 3 };

/* Most crossings of one switch in the list: none lies behind the first switch, where the step
 * ends. */
enum { PK_MOST_TOGETHER = 4 };

/* On an interpolant less accurate than the method's own, g has no root if it is this many times
 * farther from zero than it varies. */
#define PK_CLEAR_OF PK_C(2.0)

/* One function in a window: the polynomial through its samples, sum c_k cos(k angle). */
struct pk_shape {
    pk_real c[PK_MOST_SAMPLES + 1];
    pk_real range, tail;    /* max - min of the samples; sum of the last |c_k| */
    pk_real others;         /* sum of |c_k|, k > 0, plus tail */
    pk_real last_x, last_g; /* the last exact value computed */
    int order;
    /* The polynomial is the function within 1/40 of the range, or has no root; does not resolve the
     * function; may have a root; the function jumps. */
    int clear, lost, crosses, jumps;
    int in_a_row; /* consecutive narrowest windows in which it was lost */
};

/* Number of functions: the events', then the switches'. */
static inline size_t pk_events_count(const struct pk_events *e)
{
    return e->n_events + e->n_switches;
}

/* Returns g at sample j of the window, from 0, its start, to PK_MOST_SAMPLES, its end. One more
 * sample is scratch for other times. */
static inline pk_real *pk_events_sample(const struct pk_events *e, int j)
{
    return e->g + pk_events_count(e) * (size_t)j;
}

/* Returns g at the start or the end of the step. */
static inline pk_real *pk_events_end(const struct pk_events *e, int end)
{
    return e->ends + (end ? pk_events_count(e) : 0);
}

/* Returns the time at x from the start of the step. */
static inline pk_real pk_events_time(const struct pk_events *e, const struct pk_integrator *it,
                                     pk_real x)
{
    return x < pk_abs(it->t - e->from) ? e->from + (pk_real)it->own->direction * x : it->t;
}

/* Whether there is an impulse at switch k. */
static inline int pk_switches_impulse(const struct pk_integrator *it, size_t k)
{
    const struct pk_system *system = it->problem.system;
    return system->switches.impulses && system->switches.impulses[k];
}

/* Returns about two units in the last place of the time at x, on either side: the accuracy of a
 * root. */
static inline pk_real pk_events_width(const struct pk_events *e, const struct pk_integrator *it,
                                      pk_real x)
{
    const pk_real t = pk_max(pk_abs(e->from), pk_abs(pk_events_time(e, it, x)));
    return PK_C(4.0) * PK_EPS * t + PK_EPS * PK_EPS * pk_abs(it->t - e->from);
}

/* Whether the next step is neither the first one nor follows a step that was cut. */
static inline int pk_events_goes_on(const struct pk_events *e) { return e && e->begun && !e->cut; }

/* Whether steps made ahead are known to cross nothing. */
static inline int pk_events_ahead(const struct pk_events *e, const struct pk_integrator *it)
{
    const struct pk_ahead *a = it->own->ahead;
    return pk_events_goes_on(e) && a && (a->many || (a->ready && a->clear));
}

/* Computes the state at t within the step by the method itself, into e->trial and e->trial_v. */
enum pk_status pk_events_reach(struct pk_events *e, struct pk_integrator *it, pk_real t);
/* Finds all crossings in the step, window by window, and reports them. */
enum pk_status pk_events_look(struct pk_events *e, struct pk_integrator *it);
/* cos(pi j / 16). Returns x of sample j. */
extern const pk_real pk_events_cosines[PK_MOST_SAMPLES + 1];
pk_real pk_events_node(const struct pk_events *e, int j);
/* Evaluates all g at a state. */
void pk_events_functions(const struct pk_events *e, const struct pk_integrator *it, pk_real t,
                         const pk_real *q, const pk_real *v, pk_real *g);
/* Copies the caller's params into e->params, which `it` uses during a step. */
void pk_switches_enter(struct pk_events *e, struct pk_integrator *it);
/* Records the end of the step. */
void pk_switches_leave(struct pk_events *e, const struct pk_integrator *it);
/* Sets the sides from the state of `it`, if no step was made from it. */
enum pk_status pk_switches_settle(struct pk_events *e, struct pk_integrator *it);
/* Whether switches that were zero at the start of the step went the other way than guessed: if so,
 * they get that side, and `it` is reset to the start of the step. */
int pk_switches_turn(struct pk_events *e, struct pk_integrator *it);
/* Passes the switches listed up to `last` to the other side; `attempted`: length of the step. */
enum pk_status pk_switches_pass(struct pk_events *e, struct pk_integrator *it, pk_real last,
                                pk_real attempted);
/* Returns the pk_reals for impulses; 0: there are none. */
size_t pk_impulse_size(const struct pk_system *system, size_t n);
/* Applies the impulses at `count` switches at once, which[i] going to side[i], at the state e->t,
 * e->q, e->v: changes the rates in e->trial_v and the sides. Returns PK_NO_IMPULSE on failure. */
enum pk_status pk_impulse(struct pk_events *e, struct pk_integrator *it, const size_t *which,
                          const pk_real *side, size_t count);
int pk_impulse_reason(const struct pk_integrator *it, char *text, size_t size);
/* Evaluates the arguments of all switches, with inputs filled. */
void pk_switches_values(const struct pk_events *e, const struct pk_integrator *it, pk_real t,
                        const pk_real *q, const pk_real *v, pk_real *x);
enum pk_status pk_events_not_finite(struct pk_integrator *it, size_t k);
/* Adds the crossings of function k in the window to the list, which is in the order of the
 * motion. */
enum pk_status pk_events_seek(struct pk_events *e, struct pk_integrator *it, size_t k);
/* Reports the listed crossings up to the first event that stops or the first switch, and those at
 * the same time. */
enum pk_status pk_events_report(struct pk_events *e, struct pk_integrator *it);

#endif

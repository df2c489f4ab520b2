/* What the files of events share. Not installed. */
#ifndef PK_SRC_EVENTS_H
#define PK_SRC_EVENTS_H

#include <pk/events.h>

#include "../core/internal.h"

/* Samples of a window, nodes of one event in it, numbers of an entry of the list of crossings: x
 * from where the step began, which event, direction. */
enum { PK_MOST_SAMPLES = 16, PK_MOST_NODES = 4 * PK_MOST_SAMPLES, PK_EVENT_ENTRY = 3 };

/* Crossings of a switch in the list: none behind the first one of all, where the step is to end. */
enum { PK_MOST_TOGETHER = 4 };

/* Of a look by less than the method's own interpolant: how much farther from zero than it varies. */
#define PK_CLEAR_OF PK_C(2.0)

/* One function in a window: the polynomial through its samples, sum c_k cos(k angle). */
struct pk_shape {
    pk_real c[PK_MOST_SAMPLES + 1];
    pk_real range, tail;    /* how much it varies by, and what the last terms come to */
    pk_real others;         /* all terms but the first, with the last ones once more */
    pk_real last_x, last_g; /* the last true value that was looked at */
    int order;
    /* The polynomial is the function, but for 1/40 of the range, or does not show it; it may be
     * zero; the function jumps. */
    int clear, lost, crosses, jumps;
    int in_a_row; /* windows of the least width in which it was lost */
};

/* Functions of a step: the events', then the switches'. */
static inline size_t pk_events_count(const struct pk_events *e)
{
    return e->n_events + e->n_switches;
}

/* g of a sample of the window, from its begin, 0, to its end. One more is room for the values at a
 * time of one's own. */
static inline pk_real *pk_events_sample(const struct pk_events *e, int j)
{
    return e->g + pk_events_count(e) * (size_t)j;
}

/* g where the step begins, or ends. */
static inline pk_real *pk_events_end(const struct pk_events *e, int end)
{
    return e->ends + (end ? pk_events_count(e) : 0);
}

/* The time at x from where the step began. */
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

/* Some two units in the last place of the time at x, on either side: a crossing is known no better. */
static inline pk_real pk_events_width(const struct pk_events *e, const struct pk_integrator *it,
                                      pk_real x)
{
    const pk_real t = pk_max(pk_abs(e->from), pk_abs(pk_events_time(e, it, x)));
    return PK_C(4.0) * PK_EPS * t + PK_EPS * PK_EPS * pk_abs(it->t - e->from);
}

/* Whether a step like others comes next: not the first one, nor one from where the last was cut. */
static inline int pk_events_goes_on(const struct pk_events *e) { return e && e->begun && !e->cut; }

/* Whether steps were made ahead in which nothing is met. */
static inline int pk_events_ahead(const struct pk_events *e, const struct pk_integrator *it)
{
    const struct pk_ahead *a = it->own->ahead;
    return pk_events_goes_on(e) && a && (a->many || (a->ready && a->clear));
}

/* The motion at t within the step, by the method itself, into e->trial. */
enum pk_status pk_events_reach(struct pk_events *e, struct pk_integrator *it, pk_real t);
/* All that is crossed in the step: found window by window, and told. */
enum pk_status pk_events_look(struct pk_events *e, struct pk_integrator *it);
/* cos(pi j / 16); x of sample j. */
extern const pk_real pk_events_cosines[PK_MOST_SAMPLES + 1];
pk_real pk_events_node(const struct pk_events *e, int j);
/* All g at a state. */
void pk_events_functions(const struct pk_events *e, const struct pk_integrator *it, pk_real t,
                         const pk_real *q, const pk_real *v, pk_real *g);
/* The caller's params into the copy, which `it` has during a step. */
void pk_switches_enter(struct pk_events *e, struct pk_integrator *it);
/* After a step: where it has ended. */
void pk_switches_leave(struct pk_events *e, const struct pk_integrator *it);
/* The sides of the state of `it`, where it has made no step from there. */
enum pk_status pk_switches_settle(struct pk_events *e, struct pk_integrator *it);
/* Whether switches that were zero where the step began went the other way from there: then they are
 * on that side, and `it` is back where it was. */
int pk_switches_turn(struct pk_events *e, struct pk_integrator *it);
/* To the other side of those that the list has up to `last`, of a step of that length. */
enum pk_status pk_switches_pass(struct pk_events *e, struct pk_integrator *it, pk_real last,
                                pk_real attempted);
/* Room for impulses, in pk_real; 0: there are none. */
size_t pk_impulse_size(const struct pk_system *system, size_t n);
/* The impulses at `count` switches at once, which[i] to side[i], of the state that `it` has got to,
 * e->t, e->q and e->v: the rates in e->trial and the sides behind them. PK_NO_IMPULSE. */
enum pk_status pk_impulse(struct pk_events *e, struct pk_integrator *it, const size_t *which,
                          const pk_real *side, size_t count);
int pk_impulse_reason(const struct pk_integrator *it, char *text, size_t size);
/* The arguments of all switches, with inputs filled. */
void pk_switches_values(const struct pk_events *e, const struct pk_integrator *it, pk_real t,
                        const pk_real *q, const pk_real *v, pk_real *x);
enum pk_status pk_events_not_finite(struct pk_integrator *it, size_t k);
/* Adds the crossings of event k in the window to the list, which is in the order in which they are
 * met. */
enum pk_status pk_events_seek(struct pk_events *e, struct pk_integrator *it, size_t k);
/* Reports what is in the list, as far as the first event that stops, or the first switch, and what
 * is at the same time. */
enum pk_status pk_events_report(struct pk_events *e, struct pk_integrator *it);

#endif

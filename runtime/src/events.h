/* What events.c and crossings.c share. Not installed. */
#ifndef PK_SRC_EVENTS_H
#define PK_SRC_EVENTS_H

#include <pk/events.h>

#include "internal.h"

/* Samples of a step, nodes of one event in it, numbers of an entry of the list of crossings: x from
 * where the step began, which event, direction. */
enum { PK_MOST_SAMPLES = 16, PK_MOST_NODES = 3 * PK_MOST_SAMPLES, PK_EVENT_ENTRY = 3 };

/* g of a sample: 0 where the step begins, e->samples where it ends; these two are true. One more
 * is room for the values at a time of one's own. */
static inline pk_real *pk_events_sample(const struct pk_events *e, int j)
{
    return e->g + e->n_events * (size_t)j;
}

/* The time at x from where the step began. */
static inline pk_real pk_events_time(const struct pk_events *e, const struct pk_integrator *it,
                                     pk_real x)
{
    return x < pk_abs(it->t - e->from) ? e->from + (pk_real)it->direction * x : it->t;
}

/* The motion at t within the step, by the method itself, into e->trial. */
enum pk_status pk_events_reach(struct pk_events *e, struct pk_integrator *it, pk_real t);
/* All g at the samples within the step. */
enum pk_status pk_events_look(struct pk_events *e, struct pk_integrator *it);
/* All g at a state. */
void pk_events_functions(const struct pk_events *e, const struct pk_integrator *it, pk_real t,
                         const pk_real *q, const pk_real *v, pk_real *g);
enum pk_status pk_events_not_finite(struct pk_integrator *it, size_t k);
/* Adds the crossings of event k to the list, which is in the order in which they are met. */
enum pk_status pk_events_seek(struct pk_events *e, struct pk_integrator *it, size_t k);

#endif

/* A system with events of its own, run with a list of what was found. */
#ifndef TEST_EVENT_WATCH_H
#define TEST_EVENT_WATCH_H

#include "fixture.h"

struct watch {
    struct pk_system system;
    struct pk_event declared[4];
    struct fixture f;
    struct pk_events events;
    double block[4096];
    int count, stop_after;
    size_t which[200];
    int direction[200];
    double t[200], q[200], v[200];
};

typedef void event_function(const void *, pk_real, const pk_real *, const pk_real *,
                            const pk_real *, pk_real *);

/* Before watch_init(): the system with n events of function g, as `declared` says. */
void watch_set(struct watch *w, const struct pk_system *system, event_function *g, size_t n);
/* Of q = cos t. */
void watch_cosine(struct watch *w, event_function *g, size_t n);
void watch_init(struct watch *w, const char *method, double h);
void watch_free(struct watch *w);

/* Functions of events: q, q'. */
event_function at_zero, at_rest;

#endif

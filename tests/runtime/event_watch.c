/* See event_watch.h. */
#include "event_watch.h"

static const struct pk_event one_event[] = {{{"crossing", "", ""}, 0, 0}};

static int note(void *context, const struct pk_events *events)
{
    struct watch *w = (struct watch *)context;
    CU_ASSERT_FATAL(w->count < 200);
    w->which[w->count] = events->which;
    w->direction[w->count] = events->direction;
    w->t[w->count] = events->t;
    w->q[w->count] = events->q[0];
    w->v[w->count] = events->v[0];
    w->count++;
    return w->count == w->stop_after;
}

void watch_set(struct watch *w, const struct pk_system *system, event_function *g, size_t n)
{
    memset(w, 0, sizeof *w);
    w->system = *system;
    w->system.events = (struct pk_part_events){.n = n, .table = w->declared, .values = g};
    for (size_t k = 0; k < n; k++)
        w->declared[k] = one_event[0];
    fixture_set(&w->f, &w->system);
}

void watch_init(struct watch *w, const char *method, double h)
{
    const struct pk_method *m = pk_method_find(method);
    if (!m)
        m = pk_gsl_method_find(method);
    CU_ASSERT_PTR_NOT_NULL_FATAL(m);
    if (m->traits & PK_ADAPTIVE)
        w->f.options.rtol = w->f.options.atol = h;
    else
        w->f.options.h = h;
    CU_ASSERT_FATAL(fixture_init(&w->f, method) == PK_DONE);
    CU_ASSERT_FATAL(pk_events_size(&w->f.problem, m) <= sizeof w->block);
    CU_ASSERT_FATAL(pk_events_init(&w->events, &w->f.it, w->block,
                                   pk_events_size(&w->f.problem, m)) == PK_DONE);
    w->events.found = note;
    w->events.context = w;
}

void watch_free(struct watch *w)
{
    pk_events_free(&w->events);
    pk_integrator_free(&w->f.it);
}

void at_zero(ARGS, pk_real *g)
{
    UNUSED;
    g[0] = q[0];
}

void at_rest(ARGS, pk_real *g)
{
    UNUSED;
    g[0] = v[0];
}

void watch_cosine(struct watch *w, event_function *g, size_t n)
{
    watch_set(w, &oscillator_system, g, n);
    w->f.params.g = 1;
    w->system.prepare(&w->f.params);
    w->f.q0[0] = 1;
    w->f.v0[0] = 0;
}

/* The particles of a run; see bodies.h. The kernel of the event `pericentre` only gets the
 * parameters, so it reads the particles of this thread's run from `watched`. */
#include "bodies.h"

void bodies_relative(const struct bodies *b, const pk_real *x, pk_real *out)
{
    for (size_t k = 0; k < 3; k++)
        out[k] = b->n > 1 ? x[3 + k] - x[k] : x[k];
}

pk_real bodies_approach(const struct bodies *b)
{
    pk_real r[3], v[3];
    bodies_relative(b, b->r, r);
    bodies_relative(b, b->v, v);
    return r[0] * v[0] + r[1] * v[1] + r[2] * v[2];
}

static _Thread_local struct bodies *watched; /* particles of the event `pericentre` */

static void approach(const void *params, pk_real t, const pk_real *q, const pk_real *v,
                     const pk_real *u, pk_real *out)
{
    struct bodies *b = watched;
    memset(b->qa, 0, b->run->settings.n * sizeof *b->qa);
    b->system.particles.at(params, t, q, v, u, b->qa, b->m, b->r, b->v, b->a);
    out[0] = bodies_approach(b);
}

static void place(struct bodies *b, pk_real t, const pk_real *q, const pk_real *v)
{
    const struct pk_problem *p = &b->problem;
    if (p->input)
        p->input(p->context, t, b->u);
    memset(b->qa, 0, b->run->settings.n * sizeof *b->qa);
    b->system.acceleration(p->params, t, q, v, b->u, b->qa);
    b->system.particles.at(p->params, t, q, v, b->u, b->qa, b->m, b->r, b->v, b->a);
}

static int found(void *context, const struct pk_events *events)
{
    struct bodies *b = context;
    place(b, events->t, events->q, events->v);
    b->pericentre(b->context, b, events->t);
    return 0;
}

enum pk_status bodies_follow(struct bodies *b)
{
    const struct settings *s = &b->run->settings;
    static const struct pk_event pericentres[] = {{{"pericentre", "", ""}, +1, 0}};
    if (b->pericentre) {
        b->system.events.n = 1;
        b->system.events.table = pericentres;
        b->system.events.values = approach;
    }
    const size_t it_size = pk_integrator_size(&b->problem, s->method);
    const size_t events_size = pk_events_size(&b->problem, s->method);
    void *block = memory_take(&b->run->memory, it_size, 1);
    void *events_block = memory_take(&b->run->memory, events_size + 1, 1);
    struct pk_integrator *it = &b->it;
    struct pk_events events = {0};
    enum pk_status status =
        pk_integrator_init(it, &b->problem, s->method, &s->options, 0, s->q, s->v, block, it_size);
    if (status >= 0)
        status = pk_events_init(&events, it, events_block, events_size);
    events.found = b->pericentre ? found : NULL;
    events.context = b;
    while (status >= 0 && it->t < b->run->it.t) {
        status = pk_events_step(&events, it, b->run->it.t);
        if (status < 0 || status == PK_STOPPED_USER)
            break;
        place(b, it->t, it->q, it->v);
        b->see(b->context, b, it->t);
    }
    pk_events_free(&events);
    pk_integrator_free(it);
    return status < 0 ? status : PK_DONE;
}

int bodies_begin(struct bodies *b, struct pk_run *run)
{
    const struct pk_system *system = run->problem.system;
    memset(b, 0, sizeof *b);
    if (!system->particles.at || !system->acceleration)
        return 0;
    b->run = run;
    b->n = system->particles.n;
    b->system = *system;
    b->system.events.n = 0;
    b->problem = run->problem;
    b->problem.system = &b->system;
    b->m = memory_take(&run->memory, 10 * b->n + run->settings.n + system->n_inputs, sizeof *b->m);
    b->r = b->m + b->n;
    b->v = b->r + 3 * b->n;
    b->a = b->v + 3 * b->n;
    b->qa = b->a + 3 * b->n;
    b->u = b->qa + run->settings.n;
    watched = b;
    place(b, 0, run->settings.q, run->settings.v);
    return 1;
}

/* The particles of a run; see bodies.h. The kernel of the event `pericentre` only gets the
 * parameters, so it reads the particles of this thread's run from `watched`. */
#include "bodies.h"

struct relative bodies_relative(const struct bodies *b)
{
    struct relative x;
    for (size_t k = 0; k < 3; k++) {
        x.r[k] = b->n > 1 ? b->r[3 + k] - b->r[k] : b->r[k];
        x.v[k] = b->n > 1 ? b->v[3 + k] - b->v[k] : b->v[k];
        x.a[k] = b->n > 1 ? b->a[3 + k] - b->a[k] : b->a[k];
    }
    return x;
}

static _Thread_local struct bodies *watched; /* particles of the event `pericentre` */

/* The event function r.r' of the relative position r and velocity r'. */
static void approach(const void *params, pk_real t, const pk_real *q, const pk_real *v,
                     const pk_real *u, pk_real *out)
{
    struct bodies *b = watched;
    memset(b->qa, 0, b->run->settings.n * sizeof *b->qa);
    b->system.particles.at(params, t, q, v, u, b->qa, b->m, b->r, b->v, b->a);
    const struct relative x = bodies_relative(b);
    out[0] = pk_dot3(x.r, x.v);
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
    static const struct pk_event pericentres[] = {{{"pericentre", "", ""}, +1, 0}};
    struct motion *m = &b->motion;
    struct pk_integrator *it = &m->it;
    struct pk_events events = {0};
    if (b->pericentre) {
        b->system.events.n = 1;
        b->system.events.table = pericentres;
        b->system.events.values = approach;
    }
    const size_t size = pk_events_size(m->problem, m->method);
    void *block = memory_take(m->memory, size + 1, 1);
    enum pk_status status = motion_begin(m);
    if (status >= 0)
        status = pk_events_init(&events, it, block, size);
    events.found = b->pericentre ? found : NULL;
    events.context = b;
    while (status >= 0 && it->t < m->end) {
        status = pk_events_step(&events, it, m->end);
        if (status < 0 || status == PK_STOPPED_USER)
            break;
        place(b, it->t, it->q, it->v);
        b->see(b->context, b, it->t);
    }
    pk_events_free(&events);
    pk_integrator_free(it);
    return status < 0 ? status : PK_DONE;
}

int bodies_begin(struct bodies *b, struct diagnostics *d, size_t most)
{
    struct pk_run *run = d->run;
    const struct pk_system *system = run->problem.system;
    const int has = system->particles.at && system->acceleration;
    memset(b, 0, sizeof *b);
    if (!has || system->particles.n > most) {
        diagnose_told(
            d, PK_REFUSED,
            has ? "it is of one particle, or of two about each other"
                : "the kinetic energy is not seen to be a sum of m/2 r'^2 over particles; "
                  "named, it says why",
            NULL);
        return 0;
    }
    b->run = run;
    b->n = system->particles.n;
    b->system = *system;
    b->system.events.n = 0;
    b->problem = run->problem;
    b->problem.system = &b->system;
    b->motion = motion_of(run);
    b->motion.problem = &b->problem;
    b->m = memory_take(&run->memory, 10 * b->n + run->settings.n + system->n_inputs, sizeof *b->m);
    b->r = b->m + b->n;
    b->v = b->r + 3 * b->n;
    b->a = b->v + 3 * b->n;
    b->qa = b->a + 3 * b->n;
    b->u = b->qa + run->settings.n;
    watched = b;
    place(b, 0, b->motion.q, b->motion.v);
    return 1;
}

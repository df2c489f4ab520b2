/* What a run keeps of its particles: angular momentum, and the vector of Laplace, Runge and Lenz. The
 * run is made again from its start, step by step; pericentres are events of it.
 */
#include <stdlib.h>
#include <string.h>

#include "diagnose_parts.h"
#include "ensemble.h"
#include "words.h"

static const char NONE[] = "the kinetic energy is no sum over particles: write it as a sum of "
                           "m/2*(x'^2 + y'^2), with x, y and z coordinates or definitions";
static const double ROUND = 1e-8; /* an eccentricity of rounding: the orbit has no direction */

/* The particles at a state. */
struct bodies {
    struct run *run;
    struct pk_system system; /* the model's, with the event `pericentre` alone */
    struct pk_problem problem;
    size_t n;
    pk_real *m, *r, *v, *a; /* n, and 3 n each */
    pk_real *qa, *u;        /* of the coordinates */
    void (*see)(void *context, struct bodies *b, pk_real t);
    void (*pericentre)(void *context, struct bodies *b, pk_real t);
    void *context;
};

/* Of the second from the first of two; of one from the origin. */
static void relative(const struct bodies *b, const pk_real *x, pk_real *out)
{
    for (size_t k = 0; k < 3; k++)
        out[k] = b->n > 1 ? x[3 + k] - x[k] : x[k];
}

static pk_real product(const struct bodies *b)
{
    pk_real r[3], v[3];
    relative(b, b->r, r);
    relative(b, b->v, v);
    return r[0] * v[0] + r[1] * v[1] + r[2] * v[2];
}

static struct bodies *watched; /* by the event, whose kernel knows parameters alone */

static void approach(const void *params, pk_real t, const pk_real *q, const pk_real *v,
                     const pk_real *u, pk_real *out)
{
    struct bodies *b = watched;
    memset(b->qa, 0, b->run->settings.n * sizeof *b->qa);
    b->system.particles(params, t, q, v, u, b->qa, b->m, b->r, b->v, b->a);
    out[0] = product(b);
}

static void place(struct bodies *b, pk_real t, const pk_real *q, const pk_real *v)
{
    const struct pk_problem *p = &b->problem;
    if (p->input)
        p->input(p->context, t, b->u);
    memset(b->qa, 0, b->run->settings.n * sizeof *b->qa);
    b->system.acceleration(p->params, t, q, v, b->u, b->qa);
    b->system.particles(p->params, t, q, v, b->u, b->qa, b->m, b->r, b->v, b->a);
}

static int found(void *context, const struct pk_events *events)
{
    struct bodies *b = (struct bodies *)context;
    place(b, events->t, events->q, events->v);
    b->pericentre(b->context, b, events->t);
    return 0;
}

/* Through all steps; `begin` at the start may refuse. */
static enum pk_status follow(struct bodies *b, char *reason, size_t size)
{
    const struct settings *s = &b->run->settings;
    const size_t it_size = pk_integrator_size(&b->problem, s->method);
    const size_t events_size = pk_events_size(&b->problem, s->method);
    void *block = words_allocate(it_size, 1), *events_block = words_allocate(events_size + 1, 1);
    struct pk_integrator it = {0};
    struct pk_events events = {0};
    enum pk_status status = pk_integrator_init(&it, &b->problem, s->method, &s->options, 0, s->q,
                                               s->v, block, it_size);
    if (status >= 0)
        status = pk_events_init(&events, &it, events_block, events_size);
    events.found = b->pericentre ? found : NULL;
    events.context = b;
    while (status >= 0 && it.t < b->run->it.t) {
        status = pk_events_step(&events, &it, b->run->it.t);
        if (status < 0)
            break;
        place(b, it.t, it.q, it.v);
        b->see(b->context, b, it.t);
        run_progress(b->run, (double)(it.t / b->run->it.t), 0);
    }
    snprintf(reason, size, "%s", pk_status_text(status < 0 ? status : PK_DONE));
    if (status < 0 && it.method)
        pk_integrator_reason(&it, reason, size);
    pk_events_free(&events);
    pk_integrator_free(&it);
    free(block);
    free(events_block);
    return status < 0 ? status : PK_DONE;
}

static const struct pk_event pericentres[] = {{{"pericentre", "", ""}, +1, 0}};

/* 0: there are none. */
static int begin(struct bodies *b, struct run *run)
{
    const struct pk_system *system = run->problem.system;
    memset(b, 0, sizeof *b);
    if (!system->particles || !system->acceleration)
        return 0;
    b->run = run;
    b->n = system->n_particles;
    b->system = *system;
    b->system.n_events = 0;
    b->problem = run->problem;
    b->problem.system = &b->system;
    b->m = (pk_real *)words_allocate(10 * b->n + run->settings.n + system->n_inputs,
                                     sizeof *b->m);
    b->r = b->m + b->n;
    b->v = b->r + 3 * b->n;
    b->a = b->v + 3 * b->n;
    b->qa = b->a + 3 * b->n;
    b->u = b->qa + run->settings.n;
    watched = b;
    place(b, 0, run->settings.q, run->settings.v);
    return 1;
}

/* -- angular momentum ------------------------------------------------------------------------ */

struct turning {
    struct pk_drift drift[2][3]; /* about the origin, about the centre of mass */
    pk_real first[2][3], last[2][3], torque[2], arm[2];
    int spatial;
};

static void turn(void *context, struct bodies *b, pk_real t)
{
    struct turning *x = (struct turning *)context;
    for (int centre = 0; centre < 2; centre++) {
        pk_real size, torque[3];
        pk_angular_momentum(b->n, b->m, b->r, b->v, centre, x->last[centre], &size);
        for (int k = 0; k < 3; k++)
            pk_drift_update_scaled(&x->drift[centre][k], t, x->last[centre][k], size);
        pk_angular_momentum(b->n, b->m, b->r, b->a, centre, torque, &size);
        for (int k = 0; k < 3; k++)
            x->torque[centre] = PK_F(fmax)(x->torque[centre], PK_F(fabs)(torque[k]));
        x->arm[centre] = PK_F(fmax)(x->arm[centre], size);
    }
    for (size_t i = 0; i < b->n; i++)
        x->spatial |= PK_F(fabs)(b->r[3 * i + 2]) > 0 || PK_F(fabs)(b->v[3 * i + 2]) > 0;
}

static void about(FILE *file, const struct turning *x, int centre)
{
    static const char *const axes[] = {"L_x", "L_y", "L_z"};
    fputs("{", file);
    output_numbers(file, "first", x->first[centre], 3);
    fputs(", ", file);
    output_numbers(file, "final", x->last[centre], 3);
    fputs(", \"torque\": ", file);
    output_real(file, x->arm[centre] > 0 ? x->torque[centre] / x->arm[centre] : 0);
    fputs(", \"drifts\": [", file);
    for (int k = x->spatial ? 0 : 2; k < 3; k++) {
        fputs(k > 0 && x->spatial ? ", " : "", file);
        output_drift(file, axes[k], &x->drift[centre][k]);
    }
    fputs("]}", file);
}

void diagnose_angular_momentum(struct run *run, struct diagnostics *d)
{
    struct bodies b;
    struct turning x = {0};
    char reason[512];
    if (!begin(&b, run)) {
        diagnose_member(d, "angular_momentum", PK_REFUSED, NONE);
        return;
    }
    b.see = turn;
    b.context = &x;
    turn(&x, &b, 0);
    memcpy(x.first, x.last, sizeof x.first);
    const enum pk_status status = follow(&b, reason, sizeof reason);
    if (diagnose_member(d, "angular_momentum", status, reason)) {
        fprintf(d->file, ", \"particles\": %zu, \"origin\": ", b.n);
        about(d->file, &x, 0);
        fputs(", \"centre\": ", d->file);
        if (b.n > 1)
            about(d->file, &x, 1);
        else
            fputs("null", d->file);
        fputs("}", d->file);
    }
    free(b.m);
}

/* -- Laplace, Runge and Lenz ------------------------------------------------------------------ */

struct apsides {
    struct pk_lrl lrl;
    struct pk_drift size, angle;
    pk_real rate;
    unsigned long count; /* pericentres */
    pk_real first_t, first_angle, last_t, last_angle;
};

static void update(struct apsides *x, struct bodies *b)
{
    pk_real r[3], v[3], a[3];
    relative(b, b->r, r);
    relative(b, b->v, v);
    relative(b, b->a, a);
    pk_lrl_update(&x->lrl, r, v, a);
}

static void orbit(void *context, struct bodies *b, pk_real t)
{
    struct apsides *x = (struct apsides *)context;
    update(x, b);
    pk_drift_update(&x->size, t, x->lrl.eccentricity);
    pk_drift_update(&x->angle, t, x->lrl.angle);
    x->rate = PK_F(fmax)(x->rate, x->lrl.rate);
}

static void passage(void *context, struct bodies *b, pk_real t)
{
    struct apsides *x = (struct apsides *)context;
    update(x, b);
    if (x->count++ == 0) {
        x->first_t = t;
        x->first_angle = x->lrl.angle;
    }
    x->last_t = t;
    x->last_angle = x->lrl.angle;
}

static void write_orbit(struct diagnostics *d, const struct bodies *b, const struct apsides *x,
                        const pk_real *direction)
{
    const int round = !(x->size.first > (pk_real)ROUND);
    const pk_real periods = x->count > 1 ? (pk_real)(x->count - 1) : 0;
    const int turns = periods > 0 && !round;
    fprintf(d->file, ", \"particles\": %zu", b->n);
    diagnose_real(d, "k", x->lrl.k);
    diagnose_real(d, "eccentricity", x->size.first);
    fputs(", ", d->file);
    output_numbers(d->file, "direction", direction, round ? 0 : 3);
    diagnose_real(d, "varies", x->rate);
    diagnose_real(d, "turned", round ? PK_INFINITY : x->lrl.angle);
    diagnose_real(d, "rate", round ? PK_INFINITY : x->angle.cov / x->angle.var_t);
    fprintf(d->file, ", \"pericentres\": %lu", round ? 0 : x->count);
    diagnose_real(d, "period", turns ? (x->last_t - x->first_t) / periods : PK_INFINITY);
    diagnose_real(d, "per_period",
                  turns ? (x->last_angle - x->first_angle) / periods : PK_INFINITY);
    fputs(", \"drift\": ", d->file);
    output_drift(d->file, "eccentricity", &x->size);
    fputs("}", d->file);
}

void diagnose_lrl(struct run *run, struct diagnostics *d)
{
    struct bodies b;
    struct apsides x = {0};
    char reason[512];
    pk_real r[3], v[3], a[3];
    if (!begin(&b, run) || b.n > 2) {
        diagnose_member(d, "lrl", PK_REFUSED,
                        b.n > 2 ? "it is of one particle, or of two about each other" : NONE);
        free(b.m);
        return;
    }
    relative(&b, b.r, r);
    relative(&b, b.v, v);
    relative(&b, b.a, a);
    enum pk_status status = pk_lrl_init(&x.lrl, r, v, a);
    strcpy(reason, b.n > 1 ? "at the start the two do not attract each other"
                           : "at the start the particle is not drawn to the origin");
    if (status >= 0) {
        const pk_real direction[3] = {x.lrl.along[0], x.lrl.along[1], x.lrl.along[2]};
        const pk_real closing = product(&b), swift = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
        const pk_real distance = PK_F(sqrt)(r[0] * r[0] + r[1] * r[1] + r[2] * r[2]);
        b.system.n_events = 1;
        b.system.events = pericentres;
        b.system.event = approach;
        b.see = orbit;
        b.pericentre = passage;
        b.context = &x;
        orbit(&x, &b, 0);
        if (PK_F(fabs)(closing) <= 16 * PK_EPSILON * distance * PK_F(sqrt)(swift) &&
            swift * distance > x.lrl.k)
            passage(&x, &b, 0);
        status = follow(&b, reason, sizeof reason);
        if (diagnose_member(d, "lrl", status, reason))
            write_orbit(d, &b, &x, direction);
    } else {
        diagnose_member(d, "lrl", status, reason);
    }
    free(b.m);
}

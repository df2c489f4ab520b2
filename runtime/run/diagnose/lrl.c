/* The Laplace-Runge-Lenz vector along a run, and the rotation of the pericentre. */
#include "bodies.h"

static const double ROUND = 1e-8; /* eccentricity below which an orbit counts as a circle */
/* Two pericentres count as one if the time between them is below this fraction of r/|r'|, the
 * distance over the relative speed. */
static const double AGAIN = 1e-6;

struct apsides {
    struct pk_lrl lrl;
    struct pk_drift size, angle;
    pk_real rate;
    unsigned long count; /* pericentres */
    pk_real first_t, first_angle, last_t, last_angle;
};

static pk_real length(const pk_real *x)
{
    return PK_F(sqrt)(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
}

static void update(struct apsides *x, struct bodies *b)
{
    pk_real r[3], v[3], a[3];
    bodies_relative(b, b->r, r);
    bodies_relative(b, b->v, v);
    bodies_relative(b, b->a, a);
    pk_lrl_update(&x->lrl, r, v, a);
}

static void orbit(void *context, struct bodies *b, pk_real t)
{
    struct apsides *x = context;
    update(x, b);
    pk_drift_update(&x->size, t, x->lrl.eccentricity);
    pk_drift_update(&x->angle, t, x->lrl.angle);
    x->rate = PK_F(fmax)(x->rate, x->lrl.rate);
}

static void passage(void *context, struct bodies *b, pk_real t)
{
    struct apsides *x = context;
    pk_real r[3], v[3];
    bodies_relative(b, b->r, r);
    bodies_relative(b, b->v, v);
    if (x->count > 0 && (t - x->last_t) * length(v) < (pk_real)AGAIN * length(r))
        return;
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
    struct json *j = &d->json;
    json_integer(j, "particles", b->n);
    json_reals(j, {"k", x->lrl.k}, {"eccentricity", x->size.first});
    json_numbers(j, "direction", direction, round ? 0 : 3);
    json_reals(j, {"varies", x->rate}, {"turned", round ? PK_INFINITY : x->lrl.angle},
               {"rate", round ? PK_INFINITY : x->angle.cov / x->angle.var_t});
    json_integer(j, "pericentres", round ? 0 : x->count);
    json_reals(j, {"period", turns ? (x->last_t - x->first_t) / periods : PK_INFINITY},
               {"per_period", turns ? (x->last_angle - x->first_angle) / periods : PK_INFINITY});
    report_drift(j, "drift", "eccentricity", &x->size);
}

void diagnose_lrl(struct pk_run *run, struct diagnostics *d)
{
    struct bodies b;
    struct apsides x = {0};
    pk_real r[3], v[3], a[3];
    if (!bodies_begin(&b, run) || b.n > 2) {
        const char *several = "it is of one particle, or of two about each other";
        diagnose_told(d, PK_REFUSED, b.n > 2 ? several : BODIES_NONE, NULL);
        return;
    }
    bodies_relative(&b, b.r, r);
    bodies_relative(&b, b.v, v);
    bodies_relative(&b, b.a, a);
    const enum pk_status status = pk_lrl_init(&x.lrl, r, v, a);
    if (status < 0) {
        diagnose_told(d, status,
                      b.n > 1 ? "at the start the two do not attract each other"
                              : "at the start the particle is not drawn to the origin",
                      NULL);
        return;
    }
    const pk_real direction[3] = {x.lrl.along[0], x.lrl.along[1], x.lrl.along[2]};
    const pk_real distance = length(r), speed = length(v);
    b.see = orbit;
    b.pericentre = passage;
    b.context = &x;
    orbit(&x, &b, 0);
    if (PK_F(fabs)(bodies_approach(&b)) <= 16 * PK_EPSILON * distance * speed &&
        speed * speed * distance > x.lrl.k)
        passage(&x, &b, 0);
    if (diagnose_told(d, bodies_follow(&b), NULL, &b.it))
        write_orbit(d, &b, &x, direction);
}

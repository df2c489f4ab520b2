/* The Laplace-Runge-Lenz vector along a run, and the rotation of the pericentre. */
#include "bodies.h"

static const double ROUND = 1e-8; /* eccentricity below which an orbit counts as a circle */
/* Two pericentres count as one if the time between them is below this fraction of r/|r'|, the
 * distance over the relative speed. */
static const double AGAIN = 1e-6;

/* Computes the vector e, its length, and its rate of change. */
static void vector(struct lrl *lrl, const struct relative *x)
{
    pk_real l[3], torque[3], e[3], b[3], c[3], rate[3];
    const pk_real distance = norm(x->r), inwards = pk_dot3(x->r, x->v) / (distance * distance);
    pk_cross(x->r, x->v, l);
    pk_cross(x->v, l, e);
    pk_cross(x->r, x->a, torque);
    pk_cross(x->a, l, b);
    pk_cross(x->v, torque, c);
    for (size_t k = 0; k < 3; k++) {
        lrl->e[k] = e[k] / lrl->k - x->r[k] / distance;
        rate[k] = (b[k] + c[k]) / lrl->k - (x->v[k] - x->r[k] * inwards) / distance;
    }
    lrl->eccentricity = norm(lrl->e);
    lrl->rate = norm(rate) * distance / norm(x->v);
}

int lrl_begin(struct lrl *lrl, const struct relative *x)
{
    pk_real l[3];
    memset(lrl, 0, sizeof *lrl);
    lrl->k = -norm(x->r) * pk_dot3(x->r, x->a);
    if (!(lrl->k > 0))
        return 0;
    vector(lrl, x);
    pk_cross(x->r, x->v, l);
    pk_cross(l, lrl->e, lrl->across);
    const pk_real length = norm(lrl->across);
    for (size_t k = 0; k < 3 && lrl->eccentricity > 0; k++) {
        lrl->along[k] = lrl->e[k] / lrl->eccentricity;
        lrl->across[k] = length > 0 ? lrl->across[k] / length : 0;
    }
    return 1;
}

/* Finds the plane of a motion that began at rest or radially, once it leaves its straight line. */
static void find_plane(struct lrl *lrl, const struct relative *x)
{
    pk_real l[3], across[3];
    pk_cross(x->r, x->v, l);
    if (!(norm(l) > 64 * PK_EPSILON * norm(x->r) * norm(x->v)))
        return;
    pk_cross(l, lrl->along, across);
    const pk_real length = norm(across);
    for (size_t k = 0; k < 3 && length > 0; k++)
        lrl->across[k] = across[k] / length;
}

void lrl_update(struct lrl *lrl, const struct relative *x)
{
    vector(lrl, x);
    if (!(norm(lrl->across) > 0))
        find_plane(lrl, x);
    const pk_real turn = 2 * PK_PI;
    const pk_real now = PK_F(atan2)(pk_dot3(lrl->e, lrl->across), pk_dot3(lrl->e, lrl->along));
    lrl->angle = now + turn * PK_F(round)((lrl->angle - now) / turn);
}

struct apsides {
    struct lrl lrl;
    struct pk_drift size, angle;
    pk_real rate;
    unsigned long count; /* pericentres */
    pk_real first_t, first_angle, last_t, last_angle;
};

static void orbit(void *context, struct bodies *b, pk_real t)
{
    struct apsides *x = context;
    const struct relative at = bodies_relative(b);
    lrl_update(&x->lrl, &at);
    pk_drift_update(&x->size, t, x->lrl.eccentricity);
    pk_drift_update(&x->angle, t, x->lrl.angle);
    x->rate = PK_F(fmax)(x->rate, x->lrl.rate);
}

static void passage(void *context, struct bodies *b, pk_real t)
{
    struct apsides *x = context;
    const struct relative at = bodies_relative(b);
    if (x->count > 0 && (t - x->last_t) * norm(at.v) < (pk_real)AGAIN * norm(at.r))
        return;
    lrl_update(&x->lrl, &at);
    if (x->count++ == 0) {
        x->first_t = t;
        x->first_angle = x->lrl.angle;
    }
    x->last_t = t;
    x->last_angle = x->lrl.angle;
}

void diagnose_lrl(struct diagnostics *d)
{
    struct bodies b;
    struct apsides x = {0};
    struct json *j = &d->json;
    if (!bodies_begin(&b, d, 2))
        return;
    const struct relative at = bodies_relative(&b);
    if (!lrl_begin(&x.lrl, &at)) {
        diagnose_told(d, PK_REFUSED,
                      b.n > 1 ? "at the start the two do not attract each other"
                              : "at the start the particle is not drawn to the origin",
                      NULL);
        return;
    }
    const pk_real direction[3] = {x.lrl.along[0], x.lrl.along[1], x.lrl.along[2]};
    const pk_real distance = norm(at.r), speed = norm(at.v);
    b.see = orbit;
    b.pericentre = passage;
    b.context = &x;
    orbit(&x, &b, 0);
    if (PK_F(fabs)(pk_dot3(at.r, at.v)) <= 16 * PK_EPSILON * distance * speed &&
        speed * speed * distance > x.lrl.k)
        passage(&x, &b, 0);
    if (!diagnose_told(d, bodies_follow(&b), NULL, &b.motion.it))
        return;
    const int round = !(x.size.first > (pk_real)ROUND);
    const pk_real periods = x.count > 1 ? (pk_real)(x.count - 1) : 0;
    const int turns = periods > 0 && !round;
    json_integer(j, "particles", b.n);
    json_reals(j, {"k", x.lrl.k}, {"eccentricity", x.size.first});
    json_numbers(j, "direction", direction, round ? 0 : 3);
    json_reals(j, {"varies", x.rate}, {"turned", round ? PK_INFINITY : x.lrl.angle},
               {"rate", round ? PK_INFINITY : x.angle.cov / x.angle.var_t});
    json_integer(j, "pericentres", round ? 0 : x.count);
    json_reals(j, {"period", turns ? (x.last_t - x.first_t) / periods : PK_INFINITY},
               {"per_period", turns ? (x.last_angle - x.first_angle) / periods : PK_INFINITY});
    report_drift(j, "drift", "eccentricity", &x.size);
}

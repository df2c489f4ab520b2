/* Switches: equations that change at zeros keep the order of every method, against closed forms. */
#include <stdlib.h>

#include "fixture.h"

#define STEP(side, x) ((side) > 0 ? 1 : (side) < 0 ? 0 : (x) >= 0 ? 1 : 0)

struct parameters {
    double k, F;
    double side[2];
};
#define KERNEL(name)                                                                \
    static int name(const void *params, double t, const double *q, const double *v, \
                    const double *u, double *a)
#define SWITCHING(name)                                                              \
    static void name(const void *params, double t, const double *q, const double *v, \
                     const double *u, double *x)
typedef void event_values(const void *, double, const double *, const double *, const double *,
                          double *);

/* A spring where x < 0 alone, and a constant force. */
SWITCHING(of_spring) { UNUSED, x[0] = -q[0]; }
KERNEL(spring)
{
    const struct parameters *p = (const struct parameters *)params;
    UNUSED;
    a[0] = p->F - p->k * q[0] * STEP(p->side[0], -q[0]);
    return 0;
}

/* A force that two switches turn on at the same time. */
SWITCHING(of_both) { UNUSED, x[0] = t - 1.1, x[1] = 2.2 - 2 * t; }
KERNEL(both)
{
    const struct parameters *p = (const struct parameters *)params;
    UNUSED;
    a[0] = STEP(p->side[0], t - 1.1) - 4 * STEP(p->side[1], 2.2 - 2 * t);
    return 0;
}

/* The argument of one switch jumps with another. */
static double moved(const struct parameters *p, double t, double q)
{
    return q - 2 * STEP(p->side[0], t - 1);
}
SWITCHING(of_nested)
{
    UNUSED;
    x[0] = t - 1;
    x[1] = moved((const struct parameters *)params, t, q[0]);
}
KERNEL(nested)
{
    const struct parameters *p = (const struct parameters *)params;
    UNUSED;
    a[0] = STEP(p->side[1], moved(p, t, q[0]));
    return 0;
}

/* Dry friction. */
SWITCHING(of_friction) { UNUSED, x[0] = v[0]; }
KERNEL(friction)
{
    const struct parameters *p = (const struct parameters *)params;
    UNUSED;
    a[0] = p->F - p->k * (2 * STEP(p->side[0], v[0]) - 1);
    return 0;
}

static const struct pk_quantity names[] = {{"x", "", ""}, {"y", "", ""}};

struct run {
    struct pk_system system;
    struct pk_problem problem;
    struct parameters params;
    struct pk_options options;
    struct pk_integrator it;
    struct pk_events events;
    double q, v, block[4096], room[4096];
    double t[300];
    int count;
};

static void note(void *context, const struct pk_events *events)
{
    struct run *r = (struct run *)context;
    if (r->count < 300)
        r->t[r->count] = events->t;
    r->count++;
}

static void set(struct run *r, acceleration_function *a, event_values *x, size_t switches)
{
    memset(r, 0, sizeof *r);
    r->system = (struct pk_system){.abi = PK_ABI,
                                   .name = "test",
                                   .facts = PK_MASS_CONSTANT | PK_MASS_DIAGONAL | PK_QUADRATIC |
                                            PK_SEPARABLE | (switches ? PK_SWITCHED : 0u),
                                   .n = 1,
                                   .params_size = sizeof r->params,
                                   .coordinates = names,
                                   .rates = names,
                                   .acceleration = a,
                                   .switches.n = switches,
                                   .switches.names = names,
                                   .switches.sides = offsetof(struct parameters, side),
                                   .switches.values = x};
    r->problem = (struct pk_problem){.system = &r->system, .params = &r->params};
    r->params.k = 4;
    r->options = pk_options_default();
}

/* From (q, v) at t0 on, by a method at a step or a tolerance. */
static void begin(struct run *r, const char *method, double setting, double t0)
{
    const struct pk_method *m = pk_method_find(method);
    if (m->traits & PK_ADAPTIVE)
        r->options.rtol = r->options.atol = setting;
    else
        r->options.h = setting;
    CU_ASSERT_FATAL(pk_integrator_init(&r->it, &r->problem, m, &r->options, t0, &r->q, &r->v,
                                       r->block, sizeof r->block) == PK_DONE);
    CU_ASSERT_FATAL(pk_events_init(&r->events, &r->it, r->room, sizeof r->room) == PK_DONE);
    r->events.switched = note;
    r->events.context = r;
}

static double error_at(struct run *r, double t, double exact)
{
    CU_ASSERT_FATAL(pk_events_to(&r->events, &r->it, t) == PK_DONE);
    return fabs(r->it.q[0] - exact);
}

/* The spring's motion from x > 0 down, at t: with F < 0 it comes back again and again. */
static double bounced(double q, double v, double k, double F, double t)
{
    const double root = sqrt(v * v - 2 * F * q), in = (-v - root) / F, down = -root;
    const double first = F < 0 ? (v + root) / -F : in, w = sqrt(k), c = F / k, b = down / w;
    double turn = 2 * atan2(b, -c), s = t;
    if (s < first)
        return q + v * s + F * s * s / 2;
    while (turn < 0)
        turn += 2 * acos(-1);
    for (s -= first;;) {
        if (s < turn / w)
            return c - c * cos(w * s) + b * sin(w * s);
        s -= turn / w;
        if (F > 0 || s < -2 * root / F)
            return root * s + F * s * s / 2;
        s += 2 * root / F;
    }
}

TEST("orders across them")
{
    static const struct {
        const char *method;
        int order;
    } of[] = {{"euler", 1}, {"rk2", 2},          {"verlet", 2},      {"rk3", 3},
              {"rk4", 4},   {"blanes_moan4", 4}, {"blanes_moan6", 6}};
    static struct run r;
    for (size_t i = 0; i < sizeof of / sizeof *of; i++) {
        double h[4], error[4];
        for (int j = 0; j < 4; j++) {
            set(&r, spring, of_spring, 1);
            r.q = 0.5, r.v = 0.3, r.params.F = -1;
            h[j] = (of[i].order > 4 ? 0.3 : 0.04) / (1 << j);
            begin(&r, of[i].method, h[j], 0);
            error[j] = error_at(&r, 9.3, bounced(0.5, 0.3, 4, -1, 9.3));
            CU_ASSERT_EQUAL(r.count, 4);
            CU_ASSERT(r.events.switchings == 4 && r.params.side[0] == 0);
        }
        const double slope = fit_slope(h, error, 4);
        CU_ASSERT(slope > of[i].order - 0.5 && slope < of[i].order + 0.5);
        CU_ASSERT(error[3] > 0);
    }
    for (int i = 0; i < 2; i++) {
        set(&r, spring, of_spring, 1);
        r.q = 0.5, r.v = 0.3, r.params.F = -1;
        begin(&r, i ? "dop853" : "gauss", 1e-14, 0);
        CU_ASSERT(error_at(&r, 20, bounced(0.5, 0.3, 4, -1, 20)) < 4e-13);
        CU_ASSERT(fabs(r.it.q[0] - 0.5) > 0.01 && r.count > 7);
    }
}

/* A motion that only just touches, one that dips a little, and back again. */
TEST("touches and dips, forward and back")
{
    static struct run r;
    const double slower[] = {1e-2, 1e-3, 1e-4, 1e-6, 0};
    for (int i = 0; i < 5; i++) {
        set(&r, spring, of_spring, 1);
        r.q = 0.5, r.v = -1 - slower[i], r.params.F = 1, r.params.k = 400;
        begin(&r, "gauss", 1e-14, 0);
        CU_ASSERT(error_at(&r, 3, bounced(0.5, r.v, 400, 1, 3)) < 1e-12);
        CU_ASSERT(slower[i] > 0 ? r.count == 2 : r.count == 0 || r.count == 2);
        CU_ASSERT(error_at(&r, 0, 0.5) < 1e-12); /* the way back */
        CU_ASSERT(fabs(r.it.v[0] - r.v) < 1e-12);
        CU_ASSERT(slower[i] > 0 ? r.count == 4 : 1);
    }
}

/* The side of a start at the zero is that to which the motion goes. */
TEST("starts at a zero")
{
    static struct run r;
    const double v[] = {-1, 0, 1}, F[] = {-1, 1};
    for (int i = 0; i < 6; i++) {
        set(&r, spring, of_spring, 1);
        r.q = 0, r.v = v[i / 2], r.params.F = F[i % 2];
        begin(&r, i < 3 ? "gauss" : "rk4", i < 3 ? 1e-14 : 0.01, 0);
        const int below = r.v < 0 || (r.v == 0 && r.params.F < 0);
        const double c = r.params.F / 4, s = 0.25;
        const double exact = below ? c - c * cos(2 * s) + r.v / 2 * sin(2 * s)
                                   : r.v * s + r.params.F * s * s / 2;
        CU_ASSERT(error_at(&r, s, exact) < (i < 3 ? 1e-15 : 1e-10));
        CU_ASSERT(r.count == 0 && fabs(r.it.q[0]) > 0.01);
    }
}

TEST("at the same time, and one within another")
{
    static struct run r;
    const char *const method[] = {"gauss", "dop853", "rk4"};
    for (int i = 0; i < 3; i++) {
        set(&r, both, of_both, 2);
        r.q = 0.3, r.v = 0;
        begin(&r, method[i], i < 2 ? 1e-13 : 0.3, 0);
        const double at = 0.3 - 2 * 1.21, s = 2 - 1.1;
        CU_ASSERT(error_at(&r, 2, at - 4.4 * s + s * s / 2) < 3e-14);
        CU_ASSERT(r.count == 2 && r.it.count.steps < 30);
        CU_ASSERT(fabs(r.t[0] - 1.1) < 4e-15 && fabs(r.t[1] - 1.1) < 4e-15);
        set(&r, nested, of_nested, 2);
        r.q = 0.5, r.v = 0;
        begin(&r, method[i], i < 2 ? 1e-13 : 0.3, 0);
        CU_ASSERT(error_at(&r, 3, 3.5) < 1e-14);
        CU_ASSERT_EQUAL(r.count, 2); /* a jump of the argument crosses nothing */
    }
}

/* Rest under dry friction: the equations have no solution there, and say so in a few steps. */
TEST("a motion that stays")
{
    static struct run r;
    const char *const method[] = {"gauss", "dop853", "rk4", "euler"};
    for (int i = 0; i < 4; i++)
        for (int moving = 0; moving < 2; moving++) {
            set(&r, friction, of_friction, 1);
            r.q = 2, r.v = moving, r.params.F = 1;
            begin(&r, method[i], i < 2 ? 1e-12 : 0.05, 0);
            CU_ASSERT(pk_events_to(&r.events, &r.it, 10) == PK_SLIDING);
            CU_ASSERT(fabs(r.it.t - moving / 3.0) < 1e-12 && fabs(r.it.v[0]) < 1e-12);
            CU_ASSERT(r.it.count.steps < 200);
            CU_ASSERT(says(&r.it, "the motion stays on x = 0"));
            CU_ASSERT(pk_events_to(&r.events, &r.it, 10) == PK_SLIDING);
        }
    set(&r, friction, of_friction, 1); /* a force that it cannot hold */
    r.q = 2, r.v = 1, r.params.F = -5;
    begin(&r, "gauss", 1e-12, 0);
    CU_ASSERT(error_at(&r, 1, 2 + 1 / 18.0 - (1 - 1 / 9.0) * (1 - 1 / 9.0) / 2) < 1e-14);
}

/* What needs smooth equations is refused where nobody gives the sides; a reset finds them anew;
 * params that the caller changes are those of the next step. */
TEST("who gives the sides")
{
    static struct run r;
    set(&r, spring, of_spring, 1);
    r.q = 0.5, r.params.F = -1;
    begin(&r, "gauss", 1e-13, 0);
    CU_ASSERT(pk_integrator_to(&r.it, 1) == PK_REFUSED && r.it.t == 0);
    CU_ASSERT(says(&r.it, "pk_events_step()"));
    CU_ASSERT(pk_events_to(&r.events, &r.it, 1.5) == PK_DONE && r.it.q[0] < 0);
    CU_ASSERT(r.it.problem.params == &r.params);
    r.q = 1, r.v = 0, r.params.F = -2;
    CU_ASSERT(pk_integrator_reset(&r.it, 0, &r.q, &r.v) == PK_DONE);
    CU_ASSERT(error_at(&r, 0.5, 0.75) < 1e-15);
    set(&r, spring, of_spring, 0); /* not smooth, and nobody knows where */
    CU_ASSERT(pk_integrator_init(&r.it, &r.problem, pk_method_find("gauss"), &r.options, 0, &r.q,
                                 &r.v, r.block, sizeof r.block) == PK_REFUSED);
}

/* Switches of a family kept as loops, one for each member: x'' = -sign(x) has a closed form. Each
 * crossing is found, also where many members cross at once, the sides are those of the integrator's
 * own copy, names have the member's index.
 */
#include <stddef.h>

#include "fixture.h"

enum { MOST = 300, TIMES = 4 * MOST };

struct parameters {
    size_t count;
    double *side;
};

static double friction; /* of x'' = -friction sign(x'), 0: the motion above */

static size_t count(const void *params) { return ((const struct parameters *)params)->count; }

static double sign(double side, double x)
{
    return side > 0 ? 1 : side < 0 ? -1 : x > 0 ? 1 : x < 0 ? -1 : 0;
}

static int acceleration(ARGS, double *a)
{
    const struct parameters *p = (const struct parameters *)params;
    (void)t, (void)u;
    for (size_t i = 0; i < p->count; i++)
        a[i] = friction > 0 ? -friction * sign(p->side[i], v[i]) : -sign(p->side[i], q[i]);
    return 0;
}

static void values(ARGS, double *x)
{
    (void)t, (void)u;
    memcpy(x, friction > 0 ? v : q, count(params) * sizeof *x);
}

static void place(const void *params, size_t k, struct pk_place *at)
{
    (void)params;
    *at = (struct pk_place){0, (ptrdiff_t)k + 1, 0};
}

static const struct pk_quantity names[] = {{"x[i]", "", ""}};

struct run {
    struct pk_system system;
    struct pk_problem problem;
    struct parameters params;
    struct pk_options options;
    struct pk_integrator it;
    struct pk_events events;
    double q[MOST], v[MOST], side[MOST], block[400 * MOST], room[1000 * MOST];
    double t[TIMES];
    size_t which[TIMES], found;
};

static void note(void *context, const struct pk_events *events)
{
    struct run *r = (struct run *)context;
    if (r->found < TIMES) {
        r->t[r->found] = events->t;
        r->which[r->found] = events->which;
    }
    r->found++;
}

static void begin(struct run *r, size_t n, const char *method, double setting)
{
    const struct pk_method *m = pk_method_find(method);
    r->system = (struct pk_system){.abi = PK_ABI,
                                   .name = "members",
                                   .facts = PK_MASS_CONSTANT | PK_MASS_DIAGONAL | PK_QUADRATIC |
                                            PK_SEPARABLE | PK_SWITCHED,
                                   .n = 1,
                                   .params_size = sizeof r->params,
                                   .coordinates = names,
                                   .rates = names,
                                   .acceleration = acceleration,
                                   .families.count = count,
                                   .switches = {.n = 1,
                                                .names = names,
                                                .sides = offsetof(struct parameters, side),
                                                .values = values,
                                                .count = count,
                                                .place = place}};
    r->params = (struct parameters){n, r->side};
    r->problem = (struct pk_problem){.system = &r->system, .params = &r->params};
    r->options = pk_options_default();
    if (m->traits & PK_ADAPTIVE)
        r->options.rtol = r->options.atol = setting;
    else
        r->options.h = setting;
    CU_ASSERT_FATAL(pk_integrator_size(&r->problem, m) <= sizeof r->block);
    CU_ASSERT_FATAL(pk_events_size(&r->problem, m) <= sizeof r->room);
    CU_ASSERT_FATAL(pk_integrator_init(&r->it, &r->problem, m, &r->options, 0, r->q, r->v, r->block,
                                       sizeof r->block) == PK_DONE);
    CU_ASSERT_FATAL(pk_events_init(&r->events, &r->it, r->room, sizeof r->room) == PK_DONE);
    r->events.switched = note;
    r->events.context = r;
}

/* From rest at A; where it is, and how often it has crossed 0. */
static double there(double A, double t, size_t *crossings)
{
    const double quarter = sqrt(2 * A), half = 2 * quarter;
    const double s = fmod(t, half), left = half - s;
    const double x = s < quarter ? A - s * s / 2 : left * left / 2 - A;
    const double turns = floor(t / half);
    *crossings = (size_t)turns + (s > quarter);
    return fmod(turns, 2) > 0 ? -x : x;
}

TEST("each is found")
{
    static struct run r;
    static const struct {
        const char *method;
        double setting, end;
        size_t n, alike;
    } of[] = {{"dop853", 1e-13, 4, 40, 1},
              {"verlet", 0.05, 4, 40, 1},
              {"yoshida4", 0.1, 4, 40, 1},
              {"gauss", 1e-13, 4, 300, 60},
              {"rk4", 0.3, 4, 300, 300}};
    friction = 0;
    for (size_t k = 0; k < sizeof of / sizeof *of; k++) {
        size_t all = 0;
        memset(&r, 0, sizeof r);
        for (size_t i = 0; i < of[k].n; i++)
            r.q[i] = 0.3 + 0.011 * (double)(i / of[k].alike * 7 % 40);
        begin(&r, of[k].n, of[k].method, of[k].setting);
        double q[MOST];
        memcpy(q, r.q, sizeof q);
        CU_ASSERT(pk_events_to(&r.events, &r.it, of[k].end) == PK_DONE);
        for (size_t i = 0; i < of[k].n; i++) {
            size_t crossings;
            CU_ASSERT(fabs(r.it.q[i] - there(q[i], of[k].end, &crossings)) < 1e-11);
            all += crossings;
            for (size_t j = 0, seen = 0; j < r.found && j < TIMES; j++)
                if (r.which[j] == i)
                    CU_ASSERT(fabs(r.t[j] - sqrt(2 * q[i]) * (double)(2 * seen++ + 1)) < 1e-11);
        }
        CU_ASSERT(r.found == all && all >= 2 * of[k].n);
        CU_ASSERT(r.events.switchings == all);
        for (size_t i = 0; i < of[k].n; i++)
            CU_ASSERT(r.side[i] == 0); /* the caller's */
    }
}

/* Members that come to rest one by one: the first of them ends the run, and has its name. */
TEST("the one that rests")
{
    static struct run r;
    char text[400];
    memset(&r, 0, sizeof r);
    friction = 0.5;
    for (size_t i = 0; i < 20; i++)
        r.v[i] = 1 + 0.1 * (double)((i + 7) % 20);
    begin(&r, 20, "dop853", 1e-12);
    CU_ASSERT(pk_events_to(&r.events, &r.it, 10) == PK_SLIDING);
    CU_ASSERT(fabs(r.it.t - 2) < 1e-10 && r.it.reason.index == 13);
    CU_ASSERT(says(&r.it, "stays on x[14] = 0"));
    CU_ASSERT(pk_system_switch_name(&r.system, &r.params, 20, text, sizeof text) == 1);
    CU_ASSERT_STRING_EQUAL(text, "x");
}

/* What needs a smooth system is refused by itself, with the name of a member. */
TEST("by itself")
{
    static struct run r;
    memset(&r, 0, sizeof r);
    friction = 0;
    r.q[0] = r.q[1] = 1;
    begin(&r, 2, "gauss", 1e-10);
    CU_ASSERT(pk_integrator_step(&r.it, 1) == PK_REFUSED);
    CU_ASSERT(says(&r.it, "changes where x[1] vanishes"));
}

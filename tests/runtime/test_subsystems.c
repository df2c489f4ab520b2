/* Blocks integrated apart: a slow and a fast pendulum, pushed by an input each and with an angle
 * that only follows, against the two together; and what fails in one of them.
 */
#include <stdlib.h>

#include "fixture.h"

struct whole_params {
    double fast, slow, end; /* names that are not in this order in the parts */
};
struct slow_params {
    double tilt, slow; /* one of its own, which follows */
};
struct fast_params {
    double end, fast;
};

static const struct pk_quantity coordinates[] = {{"x", "", ""}, {"y", "", ""}, {"phi", "", ""}};
static const struct pk_quantity slow_coordinates[] = {{"x", "", ""}, {"phi", "", ""}};
static const struct pk_quantity inputs[] = {{"push", "", ""}, {"pull", "", ""}};
#define PARAMETER(name, of) {{#name, "", ""}, offsetof(struct of, name), 0, 0, 0}
static const struct pk_parameter of_whole[] = {
    PARAMETER(fast, whole_params), PARAMETER(slow, whole_params), PARAMETER(end, whole_params)};
static const struct pk_parameter of_slow[] = {PARAMETER(tilt, slow_params),
                                              PARAMETER(slow, slow_params)};
static const struct pk_parameter of_fast[] = {PARAMETER(end, fast_params),
                                              PARAMETER(fast, fast_params)};

static double slow(double k, double x, double push) { return -k * sin(x) + push; }
static double angle(double x) { return 1 / (2 + cos(x)); } /* phi', in the whole too */
static double fast(double k, double end, double y, double t, double pull)
{
    return -k * sin(y) + pull * sqrt(end - t); /* no number behind `end` */
}

static int whole_acceleration(ARGS, double *a)
{
    const struct whole_params *p = (const struct whole_params *)params;
    a[0] = slow(p->slow, q[0], u[0]);
    a[1] = fast(p->fast, p->end, q[1], t, u[1]);
    a[2] = angle(q[0]);
    (void)v;
    return 0;
}
static int slow_acceleration(ARGS, double *a)
{
    const struct slow_params *p = (const struct slow_params *)params;
    (void)t, (void)v;
    a[0] = slow(p->tilt / 2, q[0], u[0]);
    a[1] = angle(q[0]);
    return 0;
}
static int fast_acceleration(ARGS, double *a)
{
    const struct fast_params *p = (const struct fast_params *)params;
    (void)v;
    a[0] = fast(p->fast, p->end, q[0], t, u[0]);
    return 0;
}

static void whole_defaults(void *params)
{
    *(struct whole_params *)params = (struct whole_params){900, 0.5, 100};
}
static void slow_defaults(void *params)
{
    *(struct slow_params *)params = (struct slow_params){7, 3};
}
static void slow_derive(void *params, const unsigned char *given)
{
    struct slow_params *p = (struct slow_params *)params;
    if (!given[1])
        p->slow = 3;
    if (!given[0])
        p->tilt = 2 * p->slow;
}
static void fast_defaults(void *params)
{
    *(struct fast_params *)params = (struct fast_params){1, 2};
}
static void no_derive(void *params, const unsigned char *given) { (void)params, (void)given; }
static int no_prepare(void *params)
{
    (void)params;
    return 0;
}
static int fast_prepare(void *params)
{
    return ((struct fast_params *)params)->fast > 0 ? 0 : PK_FAILED(PK_FAILURE_PARAMETER, 1);
}

#define SYSTEM(NAME, N, STATES, COORDINATES, FIRST, PREPARE, DERIVE)         \
    static const struct pk_system NAME##_system = {                          \
        .abi = PK_ABI,                                                       \
        .name = #NAME,                                                       \
        .source_hash = "by hand",                                            \
        .facts = PK_SMOOTH | PK_MASS_CONSTANT | PK_QUADRATIC | PK_SEPARABLE, \
        .n = N,                                                              \
        .params_size = sizeof(struct NAME##_params),                         \
        .n_parameters = sizeof of_##NAME / sizeof *of_##NAME,                \
        .parameters = of_##NAME,                                             \
        .n_first_order = STATES,                                             \
        .coordinates = COORDINATES,                                          \
        .n_inputs = N - STATES,                                              \
        .inputs = inputs + FIRST,                                            \
        .acceleration = NAME##_acceleration,                                 \
        .defaults = NAME##_defaults,                                         \
        .derive = DERIVE,                                                    \
        .prepare = PREPARE}
SYSTEM(whole, 3, 1, coordinates, 0, no_prepare, no_derive);
SYSTEM(slow, 2, 1, slow_coordinates, 0, no_prepare, slow_derive);
SYSTEM(fast, 1, 0, coordinates + 1, 1, fast_prepare, no_derive);

static const size_t first[] = {0, 2}, second[] = {1, 0}, outside[] = {3};
static const struct pk_part parts[] = {{&fast_system, second}, {&slow_system, first}};

static void push(void *context, double t, double *u)
{
    (void)context;
    u[0] = 0.25 * cos(t);
    u[1] = 3 * sin(40 * t);
}

struct pair {
    struct whole_params params;
    struct pk_problem whole;
    struct pk_choice choices[2];
    struct pk_subsystems apart;
    void *block;
};

static const double q0[] = {0.5, 1, 0}, v0[] = {0, 10, 1};

static enum pk_status begin(struct pair *t, const struct pk_part *of)
{
    whole_defaults(&t->params);
    t->whole = (struct pk_problem){.system = &whole_system, .params = &t->params, .input = push};
    for (int k = 0; k < 2; k++) {
        t->choices[k].method = pk_method_find(k ? "gauss" : "kahan_li8");
        t->choices[k].options = pk_options_default();
        t->choices[k].options.rtol = t->choices[k].options.atol = 1e-13;
        t->choices[k].options.h = k ? 0 : 0.002;
    }
    const size_t size = pk_subsystems_size(&t->whole, of, t->choices, 2);
    t->block = malloc(size ? size : 1);
    CU_ASSERT_PTR_NOT_NULL_FATAL(t->block);
    return pk_subsystems_init(&t->apart, &t->whole, of, t->choices, 2, 0, q0, v0, t->block, size);
}

static void end(struct pair *t)
{
    pk_subsystems_free(&t->apart);
    free(t->block);
}

TEST("against the whole")
{
    static double block[8192];
    struct pk_integrator it;
    struct pair t;
    struct pk_options options = pk_options_default();
    options.rtol = options.atol = 1e-13;
    CU_ASSERT_FATAL(begin(&t, parts) == PK_DONE);
    CU_ASSERT(t.apart.q[0] == 0.5 && t.apart.v[1] == 10 && t.apart.v[2] == 1);
    CU_ASSERT_FATAL(pk_integrator_init(&it, &t.whole, pk_method_find("gauss"), &options, 0, q0, v0,
                                       block, sizeof block) == PK_DONE);
    double worst = 0;
    for (int k = 1; k <= 8; k++) {
        CU_ASSERT(pk_subsystems_to(&t.apart, k * 0.5, k * 0.5) == PK_DONE && t.apart.t == k * 0.5);
        CU_ASSERT(pk_integrator_to(&it, k * 0.5) == PK_DONE);
        for (int i = 0; i < 2; i++) {
            worst = fmax(worst, fabs(t.apart.q[i] - it.q[i]));
            worst = fmax(worst, fabs(t.apart.v[i] - it.v[i]) / 30);
        }
        worst = fmax(worst, fabs(t.apart.v[2] - it.v[2]));
    }
    const unsigned long many = t.apart.parts[0].it.count.steps;
    const unsigned long few = t.apart.parts[1].it.count.steps;
    printf("\n    apart %lu and %lu steps, together %lu: %.1e", many, few, it.count.steps, worst);
    CU_ASSERT(worst > 0 && worst < 2e-11);
    CU_ASSERT(many == 2000 && few < 20 && it.count.steps > 100);
    CU_ASSERT(pk_subsystems_to(&t.apart, 0, 0) == PK_DONE);
    CU_ASSERT(fabs(t.apart.v[2] - 1) < 1e-12 && fabs(t.apart.q[1] - 1) < 1e-10);
    end(&t);
}

/* One fails: the whole stays where all were, and the reason is that of the part. */
TEST("failure of one")
{
    struct pair t;
    char reason[500];
    CU_ASSERT_FATAL(begin(&t, parts) == PK_DONE);
    end(&t);
    t.params.end = 1.25;
    const size_t size = pk_subsystems_size(&t.whole, parts, t.choices, 2);
    t.block = malloc(size);
    CU_ASSERT_FATAL(t.block && pk_subsystems_init(&t.apart, &t.whole, parts, t.choices, 2, 0, q0,
                                                  v0, t.block, size) == PK_DONE);
    CU_ASSERT(pk_subsystems_to(&t.apart, 1, 1) == PK_DONE);
    const double x = t.apart.q[0], y = t.apart.q[1];
    CU_ASSERT(pk_subsystems_to(&t.apart, 2, 2) == PK_NOT_FINITE && t.apart.failed == 1);
    CU_ASSERT(t.apart.t == 1 && t.apart.q[0] == x && t.apart.q[1] == y);
    pk_subsystems_reason(&t.apart, reason, sizeof reason);
    CU_ASSERT(strstr(reason, "part 1 (y): the motion is no longer finite; last valid time 1.2") !=
              NULL);
    CU_ASSERT(strstr(reason, "the whole is at t = 1") != NULL);
    CU_ASSERT(pk_subsystems_to(&t.apart, 1.5, 1.5) == PK_NOT_FINITE && t.apart.t == 1);
    end(&t);
}

/* What is kept of them goes on to the bit, also where the whole is within steps. */
TEST("kept")
{
    static unsigned char bytes[65536];
    struct pair a, b;
    struct pk_keep out = {.to = bytes, .size = sizeof bytes}, in = {.from = bytes};
    CU_ASSERT_FATAL(begin(&a, parts) == PK_DONE && begin(&b, parts) == PK_DONE);
    CU_ASSERT(pk_subsystems_to(&a.apart, 0.501, 4) == PK_DONE);
    CU_ASSERT(pk_subsystems_keep(&a.apart, &out) == PK_DONE);
    in.size = out.used - 1;
    CU_ASSERT(pk_subsystems_keep(&b.apart, &in) == PK_BLOCK_TOO_SMALL);
    end(&b);
    CU_ASSERT_FATAL(begin(&b, parts) == PK_DONE);
    in = (struct pk_keep){.from = bytes, .size = out.used};
    CU_ASSERT(pk_subsystems_keep(&b.apart, &in) == PK_DONE);
    for (int k = 0; k < 2; k++) {
        CU_ASSERT(a.apart.t == b.apart.t);
        CU_ASSERT(memcmp(a.apart.q, b.apart.q, sizeof q0) == 0);
        CU_ASSERT(memcmp(a.apart.v, b.apart.v, sizeof v0) == 0);
        for (int i = 0; i < 2; i++) {
            const struct pk_subsystem *x = &a.apart.parts[i], *y = &b.apart.parts[i];
            CU_ASSERT((x->there == &x->aside) == (y->there == &y->aside));
            CU_ASSERT(x->aside.count.evaluations == y->aside.count.evaluations);
        }
        pk_subsystems_to(&a.apart, 0.5011, 4), pk_subsystems_to(&b.apart, 0.5011, 4);
    }
    end(&a), end(&b);
}

TEST("refused")
{
    const struct pk_part twice[] = {{&fast_system, second}, {&slow_system, second}};
    const struct pk_part beyond[] = {{&fast_system, outside}, {&slow_system, first}};
    struct pk_system stranger = fast_system;
    stranger.inputs = coordinates;
    const struct pk_part strange[] = {{&stranger, second}, {&slow_system, first}};
    struct pair t;
    char reason[500];
    CU_ASSERT(begin(&t, twice) == PK_BAD_ARGUMENT);
    pk_subsystems_reason(&t.apart, reason, sizeof reason);
    CU_ASSERT(strstr(reason, "the parts are not the whole") != NULL);
    CU_ASSERT(pk_subsystems_to(&t.apart, 1, 1) == PK_BAD_ARGUMENT);
    end(&t);
    CU_ASSERT(begin(&t, beyond) == PK_BAD_ARGUMENT && t.apart.failed == 1);
    end(&t);
    CU_ASSERT(begin(&t, strange) == PK_BAD_ARGUMENT && t.apart.failed == 1);
    end(&t);
    CU_ASSERT(begin(&t, parts) == PK_DONE);
    CU_ASSERT(pk_subsystems_init(&t.apart, &t.whole, parts, t.choices, 2, 0, q0, v0, t.block, 64) ==
              PK_BLOCK_TOO_SMALL);
    /* What a part's method needs, and its parameters' bounds, are asked of each. */
    t.choices[1].method = pk_method_find("exponential");
    t.choices[1].options.h = 0.1;
    const size_t size = pk_subsystems_size(&t.whole, parts, t.choices, 2);
    void *block = malloc(size);
    CU_ASSERT(pk_subsystems_init(&t.apart, &t.whole, parts, t.choices, 2, 0, q0, v0, block, size) ==
              PK_REFUSED);
    pk_subsystems_reason(&t.apart, reason, sizeof reason);
    CU_ASSERT(strstr(reason, "part 2 (x): exponential needs ") != NULL);
    t.params.fast = -1;
    CU_ASSERT(pk_subsystems_init(&t.apart, &t.whole, parts, t.choices, 2, 0, q0, v0, block, size) ==
              PK_OUT_OF_BOUNDS);
    pk_subsystems_reason(&t.apart, reason, sizeof reason);
    CU_ASSERT(strstr(reason, "part 1 (y): a parameter is outside its bounds: fast") != NULL);
    end(&t);
    free(block); /* that the parts are in */
    CU_ASSERT(pk_subsystems_size(&t.whole, NULL, t.choices, 2) == 0);
}

/* What memory held before is seen in no number: each method, on systems of each kind, in a block of
 * zeros and in blocks of other patterns, at the start and again at each reset, with more and more
 * parameters behind those that are read. The traces are equal to the bit.
 *
 * A pattern must not be NaN alone: `if (!(x > 0))` takes NaN for zero.
 */
#include "fixture.h"
#include "core/internal.h"

#if defined __has_feature
#if __has_feature(memory_sanitizer)
#include <sanitizer/msan_interface.h>
#define WATCHED /* what is read before it is written, decides and is an address or a result */
#endif
#endif

#ifdef WATCHED
enum { REALS = 1 << 15, PADDING = 1, TRACE = 4096 };
#else
enum { REALS = 1 << 15, PADDING = 300, TRACE = 4096 };
#endif

struct pattern {
    const char *name;
    unsigned long long bits;
};
static const struct pattern zero = {"zero", 0};
static const struct pattern patterns[] = {
    {"signalling NaN", 0x7ff4dead0000beefull}, {"all ones", ~0ull}, {"one", 0x3ff0000000000000ull},
    {"-2e300", 0xfe47e43c8800759cull},         {"least number", 1},
};
enum { PATTERNS = sizeof patterns / sizeof *patterns };

static const struct pk_system *const systems[] = {
    &pendulum_system, &oscillator_system,   &double_pendulum_system,
    &kepler_system,   &relativistic_system, &driven_system,
    &forced_system,   &van_der_pol_system,  &damped_system,
    &turning_system,  &brusselator_system,  &maxwell_system,
    &pushed_system,   &free_body_system,    &top_system,
    &carriage_system, &swift_system,        &rod_system,
    &rods_system,     &wire_system,         &jointed_system,
    &sleigh_system,   &ball_system,         &barred_system,
};
enum { SYSTEMS = sizeof systems / sizeof *systems };

struct trace {
    size_t count;
    double x[TRACE];
};

static void note(struct trace *to, double x)
{
#ifdef WATCHED
    __msan_check_mem_is_initialized(&x, sizeof x);
#endif
    if (to->count < TRACE)
        to->x[to->count++] = x;
}

static void fill(void *at, size_t bytes, const struct pattern *with)
{
    for (size_t i = 0; i + sizeof with->bits <= bytes; i += sizeof with->bits)
        memcpy((char *)at + i, &with->bits, sizeof with->bits);
}

/* As memory that nobody has written. */
static void poison(void *at, size_t bytes, const struct pattern *with)
{
    fill(at, bytes, with);
#ifdef WATCHED
    __msan_poison(at, bytes);
#endif
}

static const struct pk_method *method_at(size_t i)
{
#ifdef WATCHED /* which does not see what GSL writes */
    return pk_method_at(i);
#else
    return fixture_method(i);
#endif
}

static void note_all(struct trace *to, const double *x, size_t count)
{
    for (size_t i = 0; x && i < count; i++)
        note(to, x[i]);
}

/* The state; the motion inside the last step and at its end. */
static void look(struct trace *to, struct pk_integrator *it)
{
    const size_t n = it->n;
    note(to, it->status);
    note(to, it->t);
    note(to, (double)it->count.evaluations);
    note_all(to, it->q, n);
    note_all(to, it->v, n);
    note_all(to, it->p, n);
    for (int k = 1; it->status >= 0 && it->method->dense && k <= 3; k++) {
        double q[16], v[16];
        const double t = k == 3 ? it->t : it->last_t + k * (it->t - it->last_t) / 3;
        const enum pk_status status = pk_integrator_dense(it, t, q, v);
        note(to, status);
        note_all(to, q, status < 0 ? 0 : n);
        note_all(to, v, status < 0 ? 0 : n);
    }
}

static void steps(struct trace *to, struct pk_integrator *it, int count, double limit)
{
    while (count-- > 0) {
        if (pk_integrator_step(it, limit) == PK_REFUSED)
            return;
        look(to, it);
    }
}

static double room[2 * REALS];

/* Steps forth, a reset, steps back, another step. The status of init. */
static enum pk_status motion(const struct pk_system *of, const struct pk_method *method,
                             const struct pattern *with, size_t padding, struct trace *to)
{
    static union {
        struct test_params p;
        double x[128 + PADDING];
    } params;
    struct pk_system system = *of;
    const struct pk_problem problem = {.system = &system, .params = &params};
    struct pk_options options = pk_options_default();
    struct pk_integrator it;
    double q0[16], v0[16];
    to->count = 0;
    system.defaults(&params);
    system.start(&params, q0, v0);
    fill((char *)&params + system.params_size, padding * sizeof(double), with);
    system.params_size += padding * sizeof(double);
    options.h = 0.01;
    options.rtol = options.atol = 1e-7;
    const size_t size = pk_integrator_size(&problem, method);
    CU_ASSERT_FATAL(size <= sizeof room / 2 && system.n <= 16);
    poison(room, size, with);
    enum pk_status status =
        pk_integrator_init(&it, &problem, method, &options, 0, q0, v0, room, size);
    note(to, status);
    if (status >= 0) {
        steps(to, &it, 4, 1);
        it.own->made = 0;                          /* no tables are there any more */
        char *const state = (char *)it.own->state; /* all but the private part */
        poison(state, size - (size_t)(state - (char *)room), with);
        note(to, pk_integrator_reset(&it, 0.7, q0, v0));
        steps(to, &it, 3, -1);
        note(to, pk_integrator_set_step(&it, 0.02));
        steps(to, &it, 2, -1);
        steps(to, &it, 2, 1);
    }
    pk_integrator_free(&it);
    return status;
}

/* Where the traces differ, or -1. */
static long difference(const struct trace *a, const struct trace *b)
{
    for (size_t i = 0; i < a->count || i < b->count; i++)
        if (i >= a->count || i >= b->count || memcmp(&a->x[i], &b->x[i], sizeof *a->x))
            return (long)i;
    return -1;
}

static struct trace plain, other;

static int same(const char *what, const struct pk_system *system, const struct pk_method *method,
                const struct pattern *with, size_t padding)
{
    const long at = difference(&plain, &other);
    if (at >= 0)
        printf(
            "\n    %s: %s, %s in memory of %s, %zu parameters more: number %ld is %.17g, not %.17g",
            what, system->name, method->name, with->name, padding, at, other.x[at], plain.x[at]);
    return at < 0;
}

static void every_method(void)
{
    size_t made = 0, moved = 0;
    for (size_t k = 0; k < SYSTEMS; k++)
        for (size_t i = 0; method_at(i); i++) {
            const struct pk_method *method = method_at(i);
            if (motion(systems[k], method, &zero, 0, &plain) < 0)
                continue;
            made++;
            moved += plain.count > 20 && plain.x[plain.count - 1] != plain.x[4];
            for (size_t p = 0; p < PATTERNS && p < (size_t)PADDING; p++) {
                motion(systems[k], method, &patterns[p], 0, &other);
                CU_ASSERT(same("memory", systems[k], method, &patterns[p], 0));
            }
            for (size_t padding = 1; padding <= PADDING; padding += 1 + padding) {
                const struct pattern *with = &patterns[padding % PATTERNS];
                motion(systems[k], method, with, padding, &other);
                CU_ASSERT(same("parameters", systems[k], method, with, padding));
            }
        }
    printf("\n    %zu pairs of a system and a method, %zu patterns each", made, (size_t)PATTERNS);
    CU_ASSERT(made > 500 && moved == made);
}

/* Everything else that takes a block: what it leaves in `to`, of a block with that pattern. */

static void product(const void *p, pk_real t, const pk_real *q, const pk_real *v, const pk_real *u,
                    pk_real *g)
{
    (void)p, (void)u;
    g[0] = q[0] - 0.9 + t / 8;
    g[1] = q[0] * v[0];
}

static int noted(void *context, const struct pk_events *events)
{
    struct trace *to = (struct trace *)context;
    note(to, (double)events->which);
    note(to, events->t);
    note(to, events->q[0]);
    return 0;
}

struct use {
    const struct pk_problem *problem;
    const struct pk_method *method;
    const struct pk_options *options;
    const double *q, *v;
};

static void events(const struct use *use, const struct pattern *with, struct trace *to)
{
    static const struct pk_event two[2] = {{{"a", "", ""}, 0, 0}, {{"b", "", ""}, 1, 0}};
    struct pk_system system = *use->problem->system;
    struct pk_problem problem = *use->problem;
    struct pk_integrator it;
    struct pk_events events;
    problem.system = &system;
    system.events.n = 2, system.events.table = two, system.events.values = product;
    const size_t size = pk_integrator_size(&problem, use->method);
    double *more = room + REALS;
    const size_t most = pk_events_size(&problem, use->method);
    CU_ASSERT_FATAL(size <= sizeof room / 2 && most <= sizeof room / 2);
    poison(room, sizeof room, with);
    note(to, pk_integrator_init(&it, &problem, use->method, use->options, 0, use->q, use->v, room,
                                size));
    note(to, pk_events_init(&events, &it, more, most));
    events.found = noted;
    events.context = to;
    if (it.status >= 0) {
        note(to, pk_events_to(&events, &it, 0.2));
        note(to, pk_integrator_reset(&it, 0.1, use->q, use->v));
        note(to, pk_events_to(&events, &it, -0.1));
        look(to, &it);
    }
    pk_events_free(&events);
    pk_integrator_free(&it);
}

static void ensemble(const struct use *use, const struct pattern *with, struct trace *to)
{
    enum { MEMBERS = 9 };
    static struct test_params params[MEMBERS];
    static double q0[16 * MEMBERS], v0[16 * MEMBERS], q[32 * MEMBERS], v[32 * MEMBERS];
    static const double t[] = {0.03, 0.05};
    double last_t[MEMBERS];
    size_t done[MEMBERS];
    enum pk_status status[MEMBERS];
    const struct pk_system *system = use->problem->system;
    struct pk_ensemble e = {.system = system,
                            .method = use->method,
                            .options = *use->options,
                            .members = MEMBERS,
                            .params = params,
                            .q0 = q0,
                            .v0 = v0,
                            .rows = 2,
                            .t = t,
                            .q = q,
                            .v = v,
                            .done = done,
                            .last_t = last_t,
                            .status = status};
    for (size_t i = 0; i < MEMBERS; i++) {
        memcpy(&params[i], use->problem->params, sizeof *params);
        memcpy(q0 + i * system->n, use->q, system->n * sizeof *q0);
        memcpy(v0 + i * system->n, use->v, system->n * sizeof *v0);
    }
    memset(q, 0, sizeof q), memset(v, 0, sizeof v);
    CU_ASSERT_FATAL(pk_ensemble_size(&e) <= sizeof room);
    poison(room, sizeof room, with);
    note(to, pk_ensemble_run(&e, 0, MEMBERS, room, sizeof room));
    note_all(to, q, 2 * MEMBERS * system->n);
    note_all(to, v, 2 * MEMBERS * system->n);
    note_all(to, last_t, MEMBERS);
}

static void variations(const struct use *use, const struct pattern *with, struct trace *to)
{
    struct pk_lyapunov l;
    struct pk_reversal r;
    struct pk_integrator it;
    struct pk_stepmap map;
    const struct pk_problem *problem = use->problem;
    if (!problem->system->linear)
        return;
    CU_ASSERT_FATAL(pk_lyapunov_size(problem, use->method) <= sizeof room);
    poison(room, sizeof room, with);
    note(to, pk_lyapunov_init(&l, problem, use->method, use->options, 0, use->q, use->v, 0.05, room,
                              sizeof room));
    for (int k = 0; k < 3 && to->x[to->count - 1] >= 0; k++) {
        note(to, pk_lyapunov_step(&l));
        note(to, l.growth);
        note_all(to, l.it.q, l.it.n);
    }
    pk_lyapunov_free(&l);
    poison(room, sizeof room, with);
    note(to, pk_reversal_find(&r, &it, problem, use->method, use->options, 0, use->q, use->v, 0.1,
                              1e-3, room, sizeof room));
    for (size_t k = 0; k < r.count; k++)
        note(to, r.at[k].t), note(to, r.at[k].error);
    pk_integrator_free(&it);
    poison(room, sizeof room, with);
    note(to, pk_stepmap_find(&map, problem, use->method, use->options, 0.01, 0, use->q, use->v,
                             NULL, room, sizeof room));
    if (to->x[to->count - 1] >= 0)
        note(to, map.defect), note(to, map.volume);
}

static void least_action(const struct use *use, const struct pattern *with, struct trace *to)
{
    struct pk_least_action found;
    const size_t size = pk_least_action_size(use->problem, use->method, 4, 3);
    if (!size || size > sizeof room || !use->problem->system->linear)
        return;
    poison(room, sizeof room, with);
    note(to, pk_least_action_find(&found, use->problem, use->method, use->options, 0, use->q,
                                  use->v, 0.3, 4, 3, room, sizeof room));
    if (to->x[to->count - 1] >= 0) {
        note(to, found.action);
        note_all(to, found.C, 9 * found.n * found.n);
    }
    pk_least_action_free(&found);
}

static void residuals(const struct use *use, const struct pattern *with, struct trace *to)
{
    struct pk_residuals found;
    struct pk_monitor monitor;
    CU_ASSERT_FATAL(pk_constraint_size(use->problem) <= sizeof room);
    poison(room, sizeof room, with);
    note(to, pk_constraint_residuals(use->problem, 0, use->q, use->v, &found, room, sizeof room));
    note(to, found.position), note(to, found.rate);
    poison(room, sizeof room, with);
    note(to, pk_monitor_init(&monitor, use->problem, room, sizeof room));
}

static void (*const uses[])(const struct use *, const struct pattern *, struct trace *) = {
    events, ensemble, variations, least_action, residuals};

static void every_block(void)
{
    static const char *const methods[] = {"radau",           "rk4",        "verlet", "gauss4",
                                          "gauss8",          "gauss",      "dop853", "rattle4",
                                          "adaptive_verlet", "exponential"};
    size_t made = 0;
    for (size_t k = 0; k < SYSTEMS; k++)
        for (size_t i = 0; i < sizeof methods / sizeof *methods; i++)
            for (size_t j = 0; j < sizeof uses / sizeof *uses; j++) {
                static struct test_params params;
                double q[16], v[16];
                if (systems[k] == &damped_system && uses[j] == events)
                    continue; /* stiff: seconds */
                struct pk_options options = pk_options_default();
                const struct pk_problem problem = {.system = systems[k], .params = &params};
                const struct use use = {&problem, pk_method_find(methods[i]), &options, q, v};
                systems[k]->defaults(&params);
                systems[k]->start(&params, q, v);
                options.h = 0.01;
                plain.count = 0;
                uses[j](&use, &zero, &plain);
                made += plain.count > 4;
                for (size_t p = 0; p < 3 && p < (size_t)PADDING; p++) {
                    other.count = 0;
                    uses[j](&use, &patterns[p], &other);
                    CU_ASSERT(same("a block", systems[k], use.method, &patterns[p], 0));
                }
            }
    printf("\n    %zu", made);
    CU_ASSERT(made > 300);
}

void add_memory(void)
{
    CU_pSuite suite = CU_add_suite("memory", NULL, NULL);
    CU_add_test(suite, "of an integrator", every_method);
    CU_add_test(suite, "of all else", every_block);
}

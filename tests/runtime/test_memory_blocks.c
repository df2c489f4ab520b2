/* As test_memory.c, for everything else that takes a block: what it leaves in `to`, of a block with
 * that pattern. */
#include "blocks.h"

static void product(ARGS, pk_real *g)
{
    UNUSED;
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

static void (*const uses[])(const struct use *, const struct pattern *,
                            struct trace *) = {events, ensemble, residuals};

TEST("of all else")
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

/* libFuzzer over integrators, events and ensembles of the hand-written systems of tests/runtime: bytes
 * choose a system, a method, options, a start, events, and calls in any order. Whatever they are: no
 * undefined behaviour, an end, a status that the reader can tell, and a finite state.
 */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <pk/pk.h>

#include <pk/step/state.h>

#include "systems.h"

static const struct pk_system *const systems[] = {
    &pendulum_system, &oscillator_system,   &stiffening_system,  &double_pendulum_system,
    &kepler_system,   &relativistic_system, &folded_system,      &broken_system,
    &driven_system,   &forced_system,       &van_der_pol_system, &damped_system,
    &dipping_system,  &turning_system,      &brusselator_system, &maxwell_system,
    &pushed_system,   &free_body_system,    &top_system,         &carriage_system,
    &swift_system,    &rod_system,          &twice_system,       &rods_system,
    &wire_system,     &jointed_system,      &sleigh_system,      &ball_system,
    &barred_system,
};
enum { SYSTEMS = sizeof systems / sizeof *systems, SIZE = 1 << 15, MOST = 16, MEMBERS = 9 };

struct bytes {
    const uint8_t *at;
    size_t left;
};

static unsigned byte(struct bytes *b)
{
    if (!b->left)
        return 0;
    b->left--;
    return *b->at++;
}

/* Mostly of ordinary size; sometimes any bits at all. */
static double number(struct bytes *b)
{
    const unsigned kind = byte(b);
    if (kind == 255) {
        uint64_t bits = 0;
        double x;
        for (int i = 0; i < 8; i++)
            bits = bits << 8 | byte(b);
        memcpy(&x, &bits, sizeof x);
        return x;
    }
    const double x = ((int)(byte(b) << 8 | byte(b)) - 32768) / 8192.0;
    return kind < 128 ? x : ldexp(x, (int)(kind % 64) - 48);
}

static struct pk_system system_;
static unsigned shape;

static void event(const void *p, pk_real t, const pk_real *q, const pk_real *v, const pk_real *u,
                  pk_real *g)
{
    (void)p, (void)u;
    g[0] = q[0] - shape / 256.0;
    g[1] = shape % 2 ? sin(20 * t) : v[0] * q[0];
}

static void fail(const char *what)
{
    fprintf(stderr, "fuzz: %s\n", what);
    abort();
}

static void check(const struct pk_integrator *it)
{
    char text[400];
    if (pk_integrator_reason(it, text, sizeof text) < 3 || strstr(text, "(null)"))
        fail("no reason");
    if (it->own->ready && (!pk_all_finite(it->q, it->n) || !pk_all_finite(it->v, it->n)))
        fail("a state that is not finite");
}

static void ensemble(const struct pk_problem *problem, const struct pk_method *method,
                     const struct pk_options *options, const double *q, const double *v,
                     void *block, size_t size)
{
    static struct test_params params[MEMBERS];
    static double q0[MEMBERS * MOST], v0[MEMBERS * MOST], rows[4 * MEMBERS * MOST];
    static const double t[] = {0.01, 0.03};
    const size_t n = problem->system->n;
    size_t done[MEMBERS];
    enum pk_status status[MEMBERS];
    double last[MEMBERS];
    char text[300];
    struct pk_ensemble e = {.system = problem->system,
                            .method = method,
                            .options = *options,
                            .members = MEMBERS,
                            .params = params,
                            .q0 = q0,
                            .v0 = v0,
                            .rows = 2,
                            .t = t,
                            .q = rows,
                            .v = rows + 2 * MEMBERS * MOST,
                            .done = done,
                            .last_t = last,
                            .status = status};
    for (size_t i = 0; i < MEMBERS; i++) {
        memcpy(&params[i], problem->params, sizeof *params);
        memcpy(q0 + i * n, q, n * sizeof *q);
        memcpy(v0 + i * n, v, n * sizeof *v);
        q0[i * n] += (double)i / 64;
    }
    if (pk_ensemble_size(&e) <= size && pk_ensemble_run(&e, 0, MEMBERS, block, size) < 0)
        pk_ensemble_reason(&e, 0, block, size, text, sizeof text);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t length)
{
    static const struct pk_event events_of[2] = {{{"low", "", ""}, 0, 0}, {{"wave", "", ""}, 1, 1}};
    struct bytes b = {data, length};
    struct test_params params = {0};
    struct pk_integrator it;
    struct pk_events events;
    double q[MOST] = {0}, v[MOST] = {0};
    size_t methods = 0;
    while (pk_method_at(methods))
        methods++;
    system_ = *systems[byte(&b) % SYSTEMS];
    const struct pk_method *method = pk_method_at(byte(&b) % methods);
    const size_t n = system_.n;
    struct pk_options options = pk_options_default();
    const unsigned set = byte(&b);
    shape = byte(&b);
    if (set & 1)
        system_.events.n = 2, system_.events.table = events_of, system_.events.values = event;
    if (set & 2)
        system_.steppers = NULL, system_.block_steppers = NULL;
    options.h = set & 4 ? number(&b) : 0.01;
    options.rtol = set & 8 ? number(&b) : 1e-6;
    options.atol = set & 8 ? number(&b) : 1e-6;
    options.h_max = set & 16 ? number(&b) : 0;
    options.newton_tol = set & 32 ? number(&b) : 0;
    options.iteration = set & 64 ? PK_FIXED_POINT : PK_NEWTON;
    options.max_steps = 60;
    system_.defaults(&params);
    system_.start(&params, q, v);
    if (set & 128) {
        params.g = number(&b), params.limit = number(&b);
        if (!system_.n_rotations && !system_.constraints.n)
            for (size_t i = 0; i < n; i++)
                q[i] = number(&b), v[i] = number(&b);
        system_.prepare(&params);
    }
    /* Of exactly the sizes that are asked for, and not zeroed. */
    const struct pk_problem problem = {.system = &system_, .params = &params};
    const size_t size = pk_integrator_size(&problem, method);
    void *block = malloc(size), *more = malloc(pk_events_size(&problem, method));
    enum pk_status status =
        pk_integrator_init(&it, &problem, method, &options, 0, q, v, block, size);
    check(&it);
    const int watched = status >= 0 &&
                        pk_events_init(&events, &it, more, pk_events_size(&problem, method)) >= 0;
    for (int calls = 0; watched && b.left && calls < 12; calls++) {
        const unsigned call = byte(&b) % 8;
        if (call < 2)
            pk_events_step(&events, &it, it.t + number(&b));
        else if (call == 2)
            pk_integrator_step(&it, it.t + number(&b));
        else if (call == 3 && n <= MOST)
            pk_integrator_dense(&it, it.last_t + (it.t - it.last_t) * number(&b) / 4, q, v);
        else if (call == 4)
            pk_integrator_set_step(&it, number(&b));
        else if (call == 5)
            pk_integrator_reset(&it, number(&b), it.q, it.v);
        else
            pk_integrator_steps(&it, it.t + number(&b) / 16, 5);
        check(&it);
    }
    if (watched)
        pk_events_free(&events);
    pk_integrator_free(&it);
    if (set & 1 && shape > 200) {
        static double crowd[4 * SIZE];
        system_.start(&params, q, v);
        system_.events.n = 0;
        options.max_steps = 30;
        ensemble(&problem, method, &options, q, v, crowd, sizeof crowd);
    }
    free(block), free(more);
    return 0;
}

/* Emitted C under clang's sanitizers: each method on the system MODEL (NAME_system), a few steps forth,
 * output inside them, a reset, steps back; steps in one pass over memory, and an ensemble. What they
 * lead to is tested elsewhere. See test_sanitized.py.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <pk/ensemble.h>
#include <pk/pk.h>

extern const struct pk_system MODEL;

enum { MEMBERS = 17, ROWS = 2 };

static void *room(size_t bytes) { return calloc(1, bytes + 1); }

static void *prepared(void)
{
    void *params = room(MODEL.params_size);
    if (MODEL.families.set_sizes)
        MODEL.families.set_sizes(params);
    if (MODEL.families.attach)
        MODEL.families.attach(params, room(MODEL.families.block_size(params)));
    MODEL.defaults(params);
    return params;
}

static void integrate(const struct pk_problem *problem, const struct pk_method *method,
                      const pk_real *q, const pk_real *v)
{
    struct pk_options options = pk_options_default();
    struct pk_integrator it;
    const size_t size = pk_integrator_size(problem, method),
                 n = pk_system_count(&MODEL, problem->params);
    void *block = room(size);
    pk_real *x = (pk_real *)room(2 * n * sizeof *x);
    char text[300];
    options.h = 1e-3;
    if (pk_integrator_init(&it, problem, method, &options, 0, q, v, block, size) >= 0) {
        for (int k = 0; k < 5 && pk_integrator_step(&it, 1) >= 0; k++)
            pk_integrator_dense(&it, (it.last_t + it.t) / 2, x, x + n);
        pk_integrator_steps(&it, it.t + 0.0105, 10);
        pk_integrator_reset(&it, 0.1, q, v);
        pk_integrator_to(&it, 0.095);
    }
    pk_integrator_reason(&it, text, sizeof text);
    free(block), free(x);
}

static void crowd(const void *params, const pk_real *q, const pk_real *v, const char *method)
{
    static const pk_real t[ROWS] = {0.01, 0.0125};
    const size_t n = pk_system_count(&MODEL, params);
    size_t done[MEMBERS];
    enum pk_status status[MEMBERS];
    pk_real last[MEMBERS];
    char *all = (char *)room(MEMBERS * MODEL.params_size);
    pk_real *x = (pk_real *)room((2 + 2 * ROWS) * MEMBERS * n * sizeof *x), *at = x;
    struct pk_ensemble e = {.system = &MODEL,
                            .method = pk_method_find(method),
                            .options = pk_options_default(),
                            .members = MEMBERS,
                            .params = all,
                            .rows = ROWS,
                            .t = t,
                            .done = done,
                            .status = status,
                            .last_t = last};
    e.options.h = 1e-3;
    for (size_t i = 0; i < MEMBERS; i++) {
        memcpy(all + i * MODEL.params_size, params, MODEL.params_size);
        memcpy(x + i * n, q, n * sizeof *q);
        memcpy(x + (MEMBERS + i) * n, v, n * sizeof *v);
    }
    e.q0 = at, at += MEMBERS * n;
    e.v0 = at, at += MEMBERS * n;
    e.q = at, at += ROWS * MEMBERS * n;
    e.v = at;
    const size_t size = pk_ensemble_size(&e);
    void *block = aligned_alloc(64, size ? size : 64);
    pk_ensemble_run(&e, 0, MEMBERS, block, size);
    free(block), free(x), free(all);
}

int main(void)
{
    void *params = prepared();
    const struct pk_problem problem = {.system = &MODEL, .params = params};
    const size_t n = pk_system_count(&MODEL, params);
    pk_real *x = (pk_real *)room(2 * n * sizeof *x);
    MODEL.start(params, x, x + n);
    size_t count = 0;
    for (; pk_method_at(count); count++)
        if (n < 60 || !(pk_method_at(count)->traits & (PK_JACOBIANS | PK_LINEAR)))
            integrate(&problem, pk_method_at(count), x, x + n);
    static const char *const methods[] = {"rk4", "verlet", "yoshida6", "gauss", "dop853"};
    for (size_t i = 0; i < sizeof methods / sizeof *methods; i++)
        crowd(params, x, x + n, methods[i]);
    printf("%s: %zu methods, n = %zu\n", MODEL.name, count, n);
    return 0; /* without free(): LeakSanitizer is not asked about params */
}

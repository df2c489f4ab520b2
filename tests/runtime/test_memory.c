/* What memory held before is seen in no number: each method, on systems of each kind, in a block of
 * zeros and in blocks of other patterns, at the start and again at each reset, with more and more
 * parameters behind those that are read. The traces are equal to the bit.
 *
 * A pattern must not be NaN alone: `if (!(x > 0))` takes NaN for zero.
 */
#include "blocks.h"

static const struct pk_method *method_at(size_t i)
{
#ifdef WATCHED /* which does not see what GSL writes */
    return pk_method_at(i);
#else
    return fixture_method(i);
#endif
}

static void steps(struct trace *to, struct pk_integrator *it, int count, double limit)
{
    while (count-- > 0) {
        if (pk_integrator_step(it, limit) == PK_REFUSED)
            return;
        look(to, it);
    }
}

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

TEST("of an integrator")
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

/* pk/keep.h: what is kept of an integrator and read into a fresh one goes on to the bit, by every
 * method on systems of each kind; and what is of another shape is refused.
 */
#include "blocks.h"

static unsigned char bytes[sizeof room];

struct motion {
    struct pk_system system;
    struct pk_problem problem;
    struct test_params params;
    struct pk_integrator it;
    struct pk_events events;
};

/* In a block of its own, which held something before. */
static enum pk_status begin(struct motion *m, const struct pk_system *system,
                            const struct pk_method *method, double *block)
{
    struct pk_options options = pk_options_default();
    double q[16], v[16];
    m->system = *system;
    m->problem = (struct pk_problem){.system = &m->system, .params = &m->params};
    system->defaults(&m->params);
    system->start(&m->params, q, v);
    options.h = 0.01;
    options.rtol = options.atol = 1e-7;
    const size_t size = pk_integrator_size(&m->problem, method);
    CU_ASSERT_FATAL(size <= sizeof room / 2);
    fill(block, size, &patterns[0]);
    return pk_integrator_init(&m->it, &m->problem, method, &options, 0, q, v, block, size);
}

static void steps(struct trace *to, struct motion *m, int count)
{
    to->count = 0;
    if (m->it.count.steps) /* a motion inside the last one */
        look(to, &m->it);
    for (; count > 0 && m->it.status >= 0; count--) {
        pk_integrator_step(&m->it, 1);
        look(to, &m->it);
    }
}

static enum pk_status written(struct pk_integrator *it, size_t *size)
{
    struct pk_keep counted = {0}, out = {.to = bytes};
    pk_integrator_keep(it, &counted);
    CU_ASSERT_FATAL(counted.used <= sizeof bytes);
    out.size = *size = counted.used;
    const enum pk_status status = pk_integrator_keep(it, &out);
    CU_ASSERT(status < 0 || (out.used == counted.used && !out.wrong));
    return status;
}

static enum pk_status read_from(struct pk_integrator *it, size_t size)
{
    struct pk_keep in = {.from = bytes, .size = size};
    const enum pk_status status = pk_integrator_keep(it, &in);
    CU_ASSERT(status == PK_REFUSED || in.wrong == (status == PK_BLOCK_TOO_SMALL));
    return status;
}

/* After an odd number of steps and an even one, since each turns the two states. */
TEST("every method goes on to the bit")
{
    static struct motion a, b;
    size_t made = 0, size;
    for (size_t k = 0; k < SYSTEMS; k++)
        for (size_t i = 0; fixture_method(i); i++) {
            const struct pk_method *method = fixture_method(i);
            if (begin(&a, systems[k], method, room) >= 0) {
                steps(&plain, &a, 1 + (int)(i % 2));
                pk_integrator_set_step(&a.it, 0.02);
                steps(&plain, &a, 2);
                const double *const state = a.it.own->state;
                const enum pk_status status = written(&a.it, &size);
                CU_ASSERT(a.it.own->state == state);
                if (status >= 0 && a.it.status >= 0) {
                    steps(&plain, &a, 3);
                    begin(&b, systems[k], method, room + REALS);
                    CU_ASSERT(read_from(&b.it, size) == PK_DONE);
                    steps(&other, &b, 3);
                    CU_ASSERT(same("what is kept", systems[k], method, &patterns[0], 0));
                    pk_integrator_free(&b.it);
                    made++;
                }
                CU_ASSERT(status == PK_DONE || (status == PK_REFUSED && method->release));
            }
            pk_integrator_free(&a.it);
        }
    printf("\n    %zu pairs of a system and a method", made);
    CU_ASSERT(made > 500);
}

/* What is told of a step that failed. */
TEST("failure")
{
    static struct motion a, b;
    const struct pk_method *method = pk_method_find("dop853");
    size_t size;
    begin(&a, &kepler_system, method, room);
    steps(&plain, &a, 3);
    a.it.status = PK_NOT_FINITE, a.it.reason.index = 3, a.it.reason.value = 0.5;
    CU_ASSERT(written(&a.it, &size) == PK_DONE);
    begin(&b, &kepler_system, method, room + REALS);
    CU_ASSERT(read_from(&b.it, size) == PK_DONE);
    CU_ASSERT(b.it.status == PK_NOT_FINITE && b.it.reason.index == 3 && b.it.reason.value == 0.5);
    a.it.event = 1 + kepler_system.events.n; /* no event of this system's */
    CU_ASSERT(written(&a.it, &size) == PK_DONE);
    begin(&b, &kepler_system, method, room + REALS);
    CU_ASSERT(read_from(&b.it, size) == PK_BLOCK_TOO_SMALL);
    CU_ASSERT(b.it.t == a.it.t && b.it.last_t == a.it.last_t && b.it.last_t > 0);
}

TEST("other shapes")
{
    static struct motion a, b;
    const struct pk_method *method = pk_method_find("verlet"),
                           *of_its_size = pk_method_find("yoshida4");
    size_t size;
    begin(&a, &kepler_system, method, room);
    CU_ASSERT_FATAL(written(&a.it, &size) == PK_DONE);
    struct pk_keep out = {.to = bytes, .size = size - 1};
    bytes[size - 1] = (unsigned char)~bytes[size - 1];
    const unsigned char behind = bytes[size - 1];
    CU_ASSERT(pk_integrator_keep(&a.it, &out) == PK_BLOCK_TOO_SMALL);
    CU_ASSERT(out.wrong && out.used == size && bytes[size - 1] == behind);
    CU_ASSERT(written(&a.it, &size) == PK_DONE);

    begin(&b, &kepler_system, method, room + REALS);
    CU_ASSERT(read_from(&b.it, size) == PK_DONE);
    CU_ASSERT(read_from(&b.it, size - 1) == PK_BLOCK_TOO_SMALL);
    CU_ASSERT(read_from(&b.it, 0) == PK_BLOCK_TOO_SMALL);
    CU_ASSERT(pk_integrator_size(&a.problem, method) ==
              pk_integrator_size(&a.problem, of_its_size));
    begin(&b, &kepler_system, of_its_size, room + REALS);
    CU_ASSERT(read_from(&b.it, size) == PK_BLOCK_TOO_SMALL);
    begin(&b, &oscillator_system, method, room + REALS);
    CU_ASSERT(read_from(&b.it, sizeof bytes) == PK_BLOCK_TOO_SMALL);
    struct pk_method alone = *pk_gsl_method_find("gsl_rk8pd");
    alone.keep = NULL;
    begin(&b, &oscillator_system, &alone, room + REALS);
    CU_ASSERT(read_from(&b.it, sizeof bytes) == PK_REFUSED);
    pk_integrator_free(&b.it);
    begin(&b, &oscillator_system, pk_gsl_method_find("gsl_msadams"), room + REALS);
    CU_ASSERT(read_from(&b.it, sizeof bytes) == PK_REFUSED);
    pk_integrator_free(&b.it);
}

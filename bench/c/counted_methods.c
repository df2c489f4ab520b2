/* pkgen's own methods, with what an integration took, on any system: with states, rotations,
 * constraints, or what is left of one after a reduction. argv: the method, then names of parameters
 * that depend on the start. -DBENCH_SYSTEM=NAME_system, -DBENCH_N and -DBENCH_P: how many
 * degrees of freedom and such parameters.
 *
 * y: q, v, these parameters, steps, evaluations; of the last two only the answer's count.
 */
#include <stdlib.h>
#include <string.h>

#include <pk/pk.h>

#include "harness.h"

extern const struct pk_system BENCH_SYSTEM;

enum { V = BENCH_N, P = 2 * BENCH_N, COUNTS = P + BENCH_P };
const size_t bench_length = COUNTS + 2;
static const struct pk_method *method;
static struct pk_problem problem = {.system = &BENCH_SYSTEM};
static struct pk_integrator it;
static void *block, *params;
static size_t block_size, offsets[BENCH_P + 1];
static char why[256];

static int find_parameter(const char *name, size_t *offset)
{
    for (size_t i = 0; i < BENCH_SYSTEM.n_parameters; i++)
        if (strcmp(BENCH_SYSTEM.parameters[i].what.name, name) == 0) {
            *offset = BENCH_SYSTEM.parameters[i].offset;
            return 1;
        }
    return 0;
}

const char *bench_open(int argc, char **argv)
{
    method = argc > 1 ? pk_method_find(argv[1]) : NULL;
    if (!method) return "this build of pkgen has no such method";
    if (BENCH_SYSTEM.n != BENCH_N) return "the model has another number of coordinates";
    if (argc != 2 + BENCH_P) return "another number of parameters";
    for (int i = 0; i < BENCH_P; i++)
        if (!find_parameter(argv[2 + i], &offsets[i])) return "the model has no such parameter";
    params = calloc(1, BENCH_SYSTEM.params_size);
    BENCH_SYSTEM.defaults(params);
    problem.params = params;
    block_size = pk_integrator_size(&problem, method);
    block = malloc(block_size);
    return NULL;
}

const char *bench_prepare(double setting, const double *y0, double t_end)
{
    struct pk_options options = pk_options_default();

    for (size_t i = 0; i < BENCH_P; i++)
        memcpy((char *)params + offsets[i], &y0[P + i], sizeof *y0);
    if (BENCH_SYSTEM.prepare(params)) return "a parameter is out of bounds";
    if (method->traits & PK_ADAPTIVE)
        options.rtol = options.atol = setting;
    else /* a whole number of steps */
        options.h = t_end / (double)(unsigned long)(t_end / setting + 0.5);
    if (pk_integrator_init(&it, &problem, method, &options, 0, y0, y0 + V, block, block_size) ==
        PK_DONE)
        return NULL;
    pk_integrator_reason(&it, why, sizeof why);
    return why;
}

const char *bench_integrate(double setting, double *y, double t_end)
{
    (void)setting;
    const struct pk_counters before = it.count;
    if (pk_integrator_reset(&it, 0, y, y + V) != PK_DONE ||
        pk_integrator_to(&it, t_end) != PK_DONE) {
        pk_integrator_reason(&it, why, sizeof why);
        return why;
    }
    memcpy(y, it.q, BENCH_N * sizeof *y);
    memcpy(y + V, it.v, BENCH_N * sizeof *y);
    y[COUNTS] = (double)(it.count.steps - before.steps);
    y[COUNTS + 1] = (double)(it.count.evaluations - before.evaluations);
    return NULL;
}

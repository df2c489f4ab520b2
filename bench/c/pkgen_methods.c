/* pkgen's own methods. argv: the method, then NAME=VALUE for each parameter. The model comes as
 * -DBENCH_SYSTEM=NAME_system and the number of its coordinates as -DBENCH_N.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <pk/pk.h>

#include "harness.h"

extern const struct pk_system BENCH_SYSTEM;

const size_t bench_length = 2 * BENCH_N;
static const struct pk_method *method;
static struct pk_problem problem = {.system = &BENCH_SYSTEM};
static struct pk_integrator it;
static void *block, *params;
static size_t block_size;
static char why[256];

static int set_parameter(const char *assignment)
{
    const char *equals = strchr(assignment, '=');

    for (size_t i = 0; equals && i < BENCH_SYSTEM.n_parameters; i++) {
        const struct pk_parameter *p = &BENCH_SYSTEM.parameters[i];
        const size_t length = (size_t)(equals - assignment);
        if (strlen(p->what.name) != length || strncmp(p->what.name, assignment, length)) continue;
        *(double *)((char *)params + p->offset) = strtod(equals + 1, NULL);
        return 1;
    }
    return 0;
}

const char *bench_open(int argc, char **argv)
{
    method = argc > 1 ? pk_method_find(argv[1]) : NULL;
    if (!method) return "this build of pkgen has no such method";
    if (BENCH_SYSTEM.n != BENCH_N) return "the model has another number of coordinates";
    params = calloc(1, BENCH_SYSTEM.params_size);
    BENCH_SYSTEM.defaults(params);
    for (int i = 2; i < argc; i++)
        if (!set_parameter(argv[i])) return "the model has no such parameter";
    if (BENCH_SYSTEM.prepare(params)) return "a parameter is out of bounds";
    problem.params = params;
    block_size = pk_integrator_size(&problem, method);
    block = malloc(block_size);
    return NULL;
}

const char *bench_prepare(double setting, const double *y0, double t_end)
{
    struct pk_options options = pk_options_default();
    size_t begin = 0;

    if (method->traits & PK_ADAPTIVE)
        options.rtol = options.atol = setting;
    else /* a whole number of steps */
        options.h = t_end / (double)(unsigned long)(t_end / setting + 0.5);
    if (pk_integrator_init(&it, &problem, method, &options, 0, y0, y0 + BENCH_N, block,
                           block_size) == PK_DONE)
        return NULL;
    if (it.status == PK_REFUSED) /* no failure: contender.py */
        begin = (size_t)snprintf(why, sizeof why, "refused: ");
    pk_integrator_reason(&it, why + begin, sizeof why - begin);
    return why;
}

const char *bench_integrate(double setting, double *y, double t_end)
{
    (void)setting;
    if (pk_integrator_reset(&it, 0, y, y + BENCH_N) != PK_DONE ||
        pk_integrator_to(&it, t_end) != PK_DONE) {
        pk_integrator_reason(&it, why, sizeof why);
        return why;
    }
    memcpy(y, it.q, BENCH_N * sizeof *y);
    memcpy(y + BENCH_N, it.v, BENCH_N * sizeof *y);
    return NULL;
}

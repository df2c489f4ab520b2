/* pkgen's chain, kept as a loop with N at run time: pk_integrator_steps() with verlet. */
#include <stdlib.h>

#include <pk/pk.h>

#include "chain.h"
#include "fput.h"

static struct fput_params params;
static struct pk_problem problem = {.system = &fput_system, .params = &params};
static struct pk_integrator it;

const char *chain_open(size_t n, double h, double *q, double *v)
{
    struct pk_options options = pk_options_default();
    const struct pk_method *method = pk_method_find("verlet");

    fput_sizes(&params);
    params.N = (ptrdiff_t)n;
    const size_t own = fput_block_size(&params);
    fput_attach(&params, own ? malloc(own) : NULL);
    fput_defaults(&params);
    options.h = h;
    const size_t size = pk_integrator_size(&problem, method);
    void *block = aligned_alloc(64, (size + 63) / 64 * 64);
    if (!block) return "no memory";
    return pk_integrator_init(&it, &problem, method, &options, 0, q, v, block, size) < 0
               ? "pk_integrator_init() refused"
               : NULL;
}

const char *chain_run(unsigned long steps)
{
    return pk_integrator_steps(&it, 1e9, steps) < 0 ? "pk_integrator_steps() failed" : NULL;
}

double chain_at(size_t i) { return it.q[i]; }

/* pkgen's ensembles: pk_ensemble_run_threads() with rk4, its steps compiled into the model. */
#include <stdlib.h>

#include <pk/ensemble.h>
#include <pk/pk.h>

#include "double_pendulum.h"
#include "ensemble.h"

/* Parameters, which a user has as he has the starts, and room for results: made in the first call,
 * the one that warms up, so that no time is that of fresh pages. */
static struct double_pendulum_params *params;
static size_t *done;
static pk_real *last;
static enum pk_status *status;

static int set_up(size_t members)
{
    params = malloc(members * sizeof *params);
    done = malloc(members * sizeof *done);
    last = malloc(members * sizeof *last);
    status = malloc(members * sizeof *status);
    if (!params || !done || !last || !status) return 0;
    for (size_t i = 0; i < members; i++) double_pendulum_defaults(&params[i]);
    return 1;
}

const char *ensemble_run(size_t members, unsigned long steps, double h, int threads, real *q,
                         real *v)
{
    const pk_real t_end = (pk_real)((double)steps * h);
    if (!params && !set_up(members)) return "no memory";
    struct pk_ensemble e = {.system = &double_pendulum_system,
                            .method = pk_method_find("rk4"),
                            .options = pk_options_default(),
                            .members = members,
                            .params = params,
                            .q0 = q,
                            .v0 = v,
                            .rows = 1,
                            .t = &t_end,
                            .q = q,
                            .v = v,
                            .done = done,
                            .last_t = last,
                            .status = status};
    enum pk_status end = PK_NO_MEMORY;

    e.options.h = (pk_real)h;
    const size_t size = pk_ensemble_size(&e) * (size_t)threads;
    void *block = aligned_alloc(64, size);
    if (block) end = pk_ensemble_run_threads(&e, (size_t)threads, block, size);
    free(block);
    return end < 0 ? "pk_ensemble_run_threads() failed" : NULL;
}

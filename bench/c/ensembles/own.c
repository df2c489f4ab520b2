/* pkgen's ensembles: pk_ensemble_run_threads() with rk4, its steps compiled into the model. */
#include <stdlib.h>

#include <pk/ensemble.h>
#include <pk/pk.h>

#include "double_pendulum.h"
#include "ensemble.h"

const char *ensemble_run(size_t members, unsigned long steps, double h, int threads, real *q,
                         real *v)
{
    const pk_real t_end = (pk_real)((double)steps * h);
    struct double_pendulum_params *params = malloc(members * sizeof *params);
    size_t *done = malloc(members * sizeof *done);
    pk_real *last = malloc(members * sizeof *last);
    enum pk_status *status = malloc(members * sizeof *status);
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
    if (params && done && last && status) {
        for (size_t i = 0; i < members; i++) double_pendulum_defaults(&params[i]);
        const size_t size = pk_ensemble_size(&e) * (size_t)threads;
        void *block = aligned_alloc(64, size);
        if (block) end = pk_ensemble_run_threads(&e, (size_t)threads, block, size);
        free(block);
    }
    free(params), free(done), free(last), free(status);
    return end < 0 ? "pk_ensemble_run_threads() failed" : NULL;
}

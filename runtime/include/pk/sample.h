/* Sample blocks: controllers of a model that run at given times. Inputs keep their values between
 * samples.
 *
 *     struct pk_sampler s = {.system = &arm_system, .params = &params, .u = u};
 *     struct pk_constant_input held = {u, n_inputs};       (problem.input = pk_constant_input)
 *     status = pk_sampler_start(&s, &it, end, work);       (pk_sampler_reals() numbers)
 *     while (status == PK_DONE && it.t < end) {
 *         status = pk_integrator_to(&it, pk_sampler_limit(&s, end));
 *         if (status == PK_DONE)
 *             status = pk_sampler_run(&s, &it);
 *     } */
#ifndef PK_SAMPLE_H
#define PK_SAMPLE_H

#include <pk/integrator.h>
#include <pk/keep.h>
#include <pk/system.h>

PK_BEGIN

/* The caller sets `system`, `params`, and `u` with n_inputs numbers. Those of inputs that no block
 * sets are the caller's. `replace` is NULL, or a function in place of the blocks: it changes `next`,
 * which has the inputs before the sample, and returns 1; if it returns 0, the block itself runs. */
struct pk_sampler {
    const struct pk_system *system;
    const void *params;
    pk_real *u;
    int (*replace)(void *context, size_t block, pk_real t, const pk_real *q, const pk_real *v,
                   pk_real *next);
    void *context;
    pk_real *next, *times,
        *done; /* times: period and first time of each block; done: its samples */
};

size_t pk_sampler_reals(const struct pk_system *system);
/* Begins with an integrator at its start: sets u to the values at the start, and computes the times
 * of the blocks. Fails with PK_BAD_ARGUMENT if a period is not positive, is below the round-off of
 * the time `end`, or a first time is negative. */
enum pk_status pk_sampler_start(struct pk_sampler *s, struct pk_integrator *it, pk_real end,
                                pk_real *work);
/* Returns the time of the next sample, or `limit` if that is earlier. */
pk_real pk_sampler_limit(const struct pk_sampler *s, pk_real limit);
int pk_sampler_is_due(const struct pk_sampler *s, const struct pk_integrator *it);
/* Runs the blocks due at it->t, in order, after the start too. If u changes, a reset follows. */
enum pk_status pk_sampler_run(struct pk_sampler *s, struct pk_integrator *it);
void pk_sampler_keep(struct pk_sampler *s, struct pk_keep *k);

PK_END

#endif

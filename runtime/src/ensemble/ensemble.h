/* Shared by the two ways to run an ensemble: one member after the other (ensemble.c), and blocks of
 * members in lanes (block.c). */
#ifndef PK_SRC_ENSEMBLE_H
#define PK_SRC_ENSEMBLE_H

#include <pk/ensemble.h>

#include "lanes.h"

struct pk_problem pk_ensemble_problem(const struct pk_ensemble *e, size_t member);
int pk_ensemble_stopped(const struct pk_ensemble *e);
static inline size_t pk_ensemble_padded(size_t bytes) { return (bytes + 63) / 64 * 64; }

/* A member in the memory block, followed by its integrator's memory. Members in lanes share one
 * integrator, unless the system has singularities: each lane then has its own integrator, which
 * watches for singularities. */
struct pk_member {
    struct pk_integrator it;
    struct pk_constant_input input;
};
size_t pk_member_size(const struct pk_ensemble *e);
static inline struct pk_member *pk_member_at(const struct pk_ensemble *e, void *memory, size_t k)
{
    return (struct pk_member *)(void *)((char *)memory + k * pk_member_size(e));
}
/* Returns the number of struct pk_member in memory if W lanes share their steps. */
size_t pk_member_count(const struct pk_ensemble *e, size_t W);
/* Initialises the integrator of a member; pk_member_begin() also resets its rows and last time. */
enum pk_status pk_member_integrator(const struct pk_ensemble *e, size_t member,
                                    struct pk_member *m);
enum pk_status pk_member_begin(const struct pk_ensemble *e, size_t member, struct pk_member *m);
/* Passes a step made in a lane to the member's integrator: next[i * W] is number i of the state at
 * its end, and `status` tells whether the step failed. Returns PK_DONE or the failure, which is a
 * singularity if that is the cause. */
enum pk_status pk_member_step(struct pk_member *m, const struct pk_integrator *clock,
                              const pk_real *next, size_t W, enum pk_status status);

/* Returns the bytes of a block, not counting its members. */
size_t pk_block_size(const struct pk_ensemble *e);
void pk_block_run(const struct pk_ensemble *e, const struct pk_block_stepper *s, size_t first,
                  size_t count, char *memory);

#endif

/* Members in SIMD lanes: the memory of a block of lanes, and the steps that it makes. Blocks have
 * two uses. In block.c all lanes share the time and length of each step, and output rows are copied
 * from the lanes. In adaptive_lanes.c each lane has its own time and step, and the lane's
 * integrator takes over the step. */
#ifndef PK_SRC_LANES_H
#define PK_SRC_LANES_H

#include <pk/step/block.h>

#include "../core/internal.h"

/* Returns the stepper of blocks: the system's own, a generic one, or NULL if there is none. */
const struct pk_block_stepper *pk_block_stepper_of(const struct pk_system *system,
                                                   const struct pk_method *method);
/* Returns the number of stages whose slopes a block keeps. */
int pk_block_stages(const struct pk_method *method);
/* Describes a block for this system and method, and assigns its memory, which includes b->spare if
 * `spares` is nonzero. Returns the number of pk_real; if base is NULL, it does no more. */
size_t pk_block_lay_out(struct pk_block *b, const struct pk_problem *problem,
                        const struct pk_method *method, int spares, pk_real *base);
/* Copies an integrator's state, params and inputs to lane l. */
void pk_block_load(struct pk_block *b, const struct pk_integrator *it, const void *params,
                   size_t l);
/* Copies all numbers of a lane to another, whose own are missing or would fail again. */
void pk_block_copy_lane(struct pk_block *b, size_t from, size_t to);

/* Returns the index of the lowest bit that is set; `bits` is not 0. */
static inline size_t pk_lowest(unsigned long long bits)
{
    size_t l = 0;
    while (!(bits >> l & 1))
        l++;
    return l;
}

#endif

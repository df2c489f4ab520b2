/* Integrators abreast: the next steps of several integrators of one system and one method, each
 * with a state, parameters, a time and a length of step of its own, made at once in vector lanes.
 *
 *     size_t size = pk_abreast_size(&problem, method);      (bytes; 0: there are no lanes for it)
 *     pk_abreast_init(&abreast, &problem, method, block, size);
 *     while (...) {
 *         lanes[l] = (struct pk_abreast_lane){&it[l], params, limit[l]};   (abreast.lanes of them)
 *         pk_abreast_make(&abreast, lanes);
 *         pk_integrator_step(&it[l], limit[l]);             (of each, or pk_events_step())
 *     }
 *
 * An integrator comes to the step that was made for it and takes it, if that is the step that it
 * would make: of this state, to this time. It does all else as ever, looks at events, rejects,
 * fails. What was not made, or failed, it makes by itself. So with -ffp-contract=off nothing comes
 * out other than without lanes, to the bit, whoever is in them.
 *
 * Explicit Runge-Kutta and splitting methods have lanes, adaptive ones too: a rejected step is made
 * again alone. Inputs are to be constant.
 */
#ifndef PK_ABREAST_H
#define PK_ABREAST_H

#include <pk/step/block.h>

PK_BEGIN

struct pk_abreast_lane {
    struct pk_integrator *it; /* NULL: nobody */
    const void *params;       /* those that its step will have */
    pk_real limit;
};

struct pk_abreast {
    size_t lanes;

    /* For the runtime alone. */
    const struct pk_method *method;
    const struct pk_block_stepper *stepper;
    struct pk_block b;
    struct pk_ahead ahead[PK_BLOCK_MOST];
    unsigned long long loaded; /* lanes whose numbers are finite */
};

/* How many there are at once; the block is to be aligned for pk_real. */
size_t pk_abreast_lanes(const struct pk_problem *problem, const struct pk_method *method);
size_t pk_abreast_size(const struct pk_problem *problem, const struct pk_method *method);
void pk_abreast_init(struct pk_abreast *a, const struct pk_problem *problem,
                     const struct pk_method *method, void *block, size_t size);
void pk_abreast_make(struct pk_abreast *a, const struct pk_abreast_lane *lanes);
/* It goes on by itself. */
void pk_abreast_leave(struct pk_integrator *it);

PK_END

#endif

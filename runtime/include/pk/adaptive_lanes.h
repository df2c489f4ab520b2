/* Makes the next steps of several integrators at once, in SIMD lanes. They share system and method;
 * each has its own state, parameters, time and step size.
 *
 *     size_t size = pk_lanes_size(&problem, method);      (bytes; 0: there are no lanes for it)
 *     pk_lanes_init(&steps, &problem, method, block, size);
 *     while (...) {
 *         lanes[l] = (struct pk_lane){&it[l], NULL, limit[l], it[l].t};  (for all lanes)
 *         pk_lanes_make(&steps, lanes);
 *         pk_integrator_step(&it[l], limit[l]);  (of each that is not idle, or pk_events_step())
 *     }
 *
 * An integrator takes the step made ahead for it if that is the step it would make: from this
 * state, to this time. All else it does as usual: events, rejections, failures. A step that was not
 * made ahead, or failed, it makes itself. So with -ffp-contract=off results have the same bits as
 * without lanes, with any neighbours.
 *
 * Lanes serve explicit Runge-Kutta methods, adaptive ones too, and splitting methods, but no
 * systems with constraints, since projection is most of their step. Inputs must be constant.
 */
#ifndef PK_ADAPTIVE_LANES_H
#define PK_ADAPTIVE_LANES_H

#include <pk/step/block.h>

PK_BEGIN

struct pk_events;

struct pk_lane {
    struct pk_integrator *it; /* NULL: an empty lane */
    struct pk_events *events; /* the events of its steps; NULL: none are detected */
    pk_real limit;
    /* No step up to this time is examined, so a call may make many fixed steps. it->t: every step
     * is examined. */
    pk_real free;
};

/* For the runtime alone: event functions and switches along steps. */
struct pk_screen {
    size_t functions;
    pk_real *a0, *a1, *a_between, *bends, *trial, *g, *one;
    unsigned long long (*members)(struct pk_block *b, const pk_real *q, const pk_real *v,
                                  pk_real *a);
    void (*values)(const struct pk_block *b, const pk_real *q, const pk_real *v, pk_real *g);
};

struct pk_lanes {
    size_t lanes;

    /* For the runtime alone. */
    const struct pk_method *method;
    const struct pk_block_stepper *stepper;
    struct pk_block b;
    struct pk_ahead ahead[PK_BLOCK_MOST];
    struct pk_screen screen;
    unsigned long long loaded; /* lanes whose numbers are finite */
    unsigned long long single; /* lanes with one step, whose state is still at its start */
    unsigned long long idle;   /* lanes whose integrators make no step this time */
};

/* Return the number of lanes; the bytes of the block, which must be aligned for pk_real. */
size_t pk_lanes_count(const struct pk_problem *problem, const struct pk_method *method);
size_t pk_lanes_size(const struct pk_problem *problem, const struct pk_method *method);
void pk_lanes_init(struct pk_lanes *a, const struct pk_problem *problem,
                   const struct pk_method *method, void *block, size_t size);
void pk_lanes_make(struct pk_lanes *a, const struct pk_lane *lanes);
/* Drops the steps made ahead for an integrator, which then continues alone. */
void pk_lanes_leave(struct pk_integrator *it);

PK_END

#endif

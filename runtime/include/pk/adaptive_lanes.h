/* Makes the next steps of several integrators at once, in SIMD lanes. They share system and method;
 * each has its own state, parameters, time and step size.
 *
 *     size_t size = pk_lanes_size(&problem, method);      (bytes; 0: the method has no lanes)
 *     pk_lanes_init(&steps, &problem, method, block, size);
 *     while (...) {
 *         lanes[l] = (struct pk_lane){&it[l], NULL, limit[l], it[l].t};  (for all lanes)
 *         pk_lanes_make(&steps, lanes);
 *         pk_integrator_step(&it[l], limit[l]);  (for each lane not idle; or pk_events_step())
 *     }
 *
 * An integrator takes the step made ahead for it if that step has the start and the end that its
 * own step would have. The integrator handles events, rejected steps and failures as usual, and
 * makes a step itself if none was made ahead or if that one failed. So with -ffp-contract=off
 * results have the same bits as without lanes, whatever states are in the other lanes.
 *
 * Lanes serve explicit Runge-Kutta methods, also adaptive ones, and splitting methods. They do not
 * serve systems with constraints, whose steps are mostly projection. Inputs must be constant. */
#ifndef PK_ADAPTIVE_LANES_H
#define PK_ADAPTIVE_LANES_H

#include <pk/step/block.h>

PK_BEGIN

struct pk_events;

struct pk_lane {
    struct pk_integrator *it; /* NULL: the lane is empty */
    struct pk_events *events; /* the events to detect in the steps; NULL: none */
    pk_real limit;
    /* The caller guarantees that no event occurs before the time `free`. So a call may make many
     * fixed steps up to that time without checks for events. With free = it->t every step is
     * checked. */
    pk_real free;
};

/* Private to the runtime: the test whether an event function or a switch changes its sign. */
struct pk_screen {
    size_t functions;
    pk_real *a0, *a1, *a_between, *bends, *trial, *g, *one;
    unsigned long long (*members)(struct pk_block *b, const pk_real *q, const pk_real *v,
                                  pk_real *a);
    void (*values)(const struct pk_block *b, const pk_real *q, const pk_real *v, pk_real *g);
};

struct pk_lanes {
    size_t lanes;

    /* Private to the runtime. */
    const struct pk_method *method;
    const struct pk_block_stepper *stepper;
    struct pk_block b;
    struct pk_ahead ahead[PK_BLOCK_MOST];
    struct pk_screen screen;
    unsigned long long loaded; /* bit mask of lanes that were filled with a finite state */
    /* bit mask of lanes whose last result is one step, stored with its start state */
    unsigned long long single;
    unsigned long long idle; /* bit mask of lanes whose integrators make no step in this call */
};

/* pk_lanes_count() returns the number of lanes, pk_lanes_size() the bytes of the aligned block. */
size_t pk_lanes_count(const struct pk_problem *problem, const struct pk_method *method);
size_t pk_lanes_size(const struct pk_problem *problem, const struct pk_method *method);
void pk_lanes_init(struct pk_lanes *a, const struct pk_problem *problem,
                   const struct pk_method *method, void *block, size_t size);
void pk_lanes_make(struct pk_lanes *a, const struct pk_lane *lanes);
/* Discards the step that a lane made ahead for `it`, which then computes its own steps. */
void pk_lanes_leave(struct pk_integrator *it);

PK_END

#endif

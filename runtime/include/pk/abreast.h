/* Integrators abreast: the next steps of several integrators of one system and one method, each
 * with a state, parameters, a time and a length of step of its own, made at once in vector lanes.
 *
 *     size_t size = pk_abreast_size(&problem, method);      (bytes; 0: there are no lanes for it)
 *     pk_abreast_init(&abreast, &problem, method, block, size);
 *     while (...) {
 *         lanes[l] = (struct pk_abreast_lane){&it[l], NULL, limit[l], it[l].t}; (abreast.lanes of them)
 *         pk_abreast_make(&abreast, lanes);
 *         pk_integrator_step(&it[l], limit[l]);  (of each that is not idle, or pk_events_step())
 *     }
 *
 * An integrator comes to the step that was made for it and takes it, if that is the step that it
 * would make: of this state, to this time. It does all else as ever, looks at events, rejects,
 * fails. What was not made, or failed, it makes by itself. So with -ffp-contract=off nothing comes
 * out other than without lanes, to the bit, whoever is in them.
 *
 * Explicit Runge-Kutta and splitting methods have lanes, adaptive ones too, but not of systems with
 * constraints, whose projection is most of a step. Inputs are to be constant.
 */
#ifndef PK_ABREAST_H
#define PK_ABREAST_H

#include <pk/step/block.h>

PK_BEGIN

struct pk_events;

struct pk_abreast_lane {
    struct pk_integrator *it; /* NULL: nobody */
    struct pk_events *events; /* by which its steps are made; NULL: none are looked for */
    pk_real limit;
    /* Up to there nobody looks at each step: where steps are fixed, a call may make many. it->t:
     * there are none such. */
    pk_real free;
};

/* For the runtime alone: functions of events and switches along steps. */
struct pk_screen {
    size_t functions;
    pk_real *a0, *a1, *a_between, *bends, *trial, *g, *one;
    unsigned long long (*members)(struct pk_block *b, const pk_real *q, const pk_real *v,
                                  pk_real *a);
    void (*values)(const struct pk_block *b, const pk_real *q, const pk_real *v, pk_real *g);
};

struct pk_abreast {
    size_t lanes;

    /* For the runtime alone. */
    const struct pk_method *method;
    const struct pk_block_stepper *stepper;
    struct pk_block b;
    struct pk_ahead ahead[PK_BLOCK_MOST];
    struct pk_screen screen;
    unsigned long long loaded; /* lanes whose numbers are finite */
    unsigned long long single; /* lanes with one step, whose state is where it began */
    unsigned long long idle;   /* lanes whose integrators are to make no step this time */
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

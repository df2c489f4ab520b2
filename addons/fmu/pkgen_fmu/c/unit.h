/* A model as a functional mock-up unit (FMU): the code common to FMI 2 and FMI 3, which calls
 * pk_host.h. A unit is an instance of the FMU. All data that changes is in one array of numbers,
 * `all`, so that an FMU state is a copy of this array. Other data (params, the integrator, values)
 * is computed from `all` when it is needed. A function returns UNIT_OK, or reports its failure by
 * unit_say(). */
#ifndef UNIT_H
#define UNIT_H

#include <stddef.h>

#include <pk/events.h>
#include <pk/integrator.h>

#include "pk_host.h"

enum unit_status { UNIT_OK, UNIT_WARNING, UNIT_DISCARD, UNIT_ERROR, UNIT_FATAL };

/* A value reference is a kind and an index: kind << UNIT_SHIFT | index. */
enum { UNIT_SHIFT = 20 };
enum unit_kind {
    UNIT_TIME,
    UNIT_PARAMETER, /* each member of a family is one parameter */
    UNIT_INPUT,
    UNIT_SLOPE, /* time derivative of an input */
    UNIT_STATE, /* coordinates, then rates and first-order variables */
    UNIT_RATE,  /* time derivatives of states */
    UNIT_OUTPUT,
    UNIT_ENERGY,
    UNIT_CLAIM,
    UNIT_INDICATOR, /* event functions, then switching functions */
    UNIT_SETTING,   /* the index is an enum unit_setting */
    UNIT_KINDS
};
enum unit_setting { UNIT_METHOD, UNIT_STEP, UNIT_RTOL, UNIT_SETTINGS };

/* Methods and defaults, generated for the model by model_c.py. */
struct unit_model {
    const char *token;
    const struct pk_method *const *methods;
    size_t n_methods, method;
    double step, rtol;
};
extern const struct unit_model unit_model;

enum unit_mode {
    UNIT_INSTANTIATED = 1,
    UNIT_INITIALIZATION = 2,
    UNIT_EVENT = 4,
    UNIT_CONTINUOUS = 8, /* model exchange between events */
    UNIT_STEPPING = 16,  /* co-simulation */
    UNIT_TERMINATED = 32,
    /* not a mode: in an argument `modes`, allows the call from within a callback of a step */
    UNIT_WITHIN = 64
};
enum {
    UNIT_BEFORE = UNIT_INSTANTIATED | UNIT_INITIALIZATION,
    UNIT_RUNNING = UNIT_EVENT | UNIT_CONTINUOUS | UNIT_STEPPING,
    UNIT_ANY = UNIT_BEFORE | UNIT_RUNNING | UNIT_TERMINATED,
    UNIT_ORDERS = 3, /* highest order of derivatives of inputs */
    UNIT_LONGEST_TEXT = 600
};

struct unit {
    const struct unit_model *model;
    const struct pk_system *system;
    char *name;
    int co_simulation;
    void (*log)(const struct unit *unit, enum unit_status status, const char *category,
                const char *text); /* NULL if nothing is logged */
    void *environment, *callback;
    int logging;
    /* Calls the importer, which sets the inputs for time t. If NULL, inputs are extrapolated to t
     * by their derivatives `slopes`. */
    void (*inputs_at)(struct unit *unit, double t);
    /* Tells the importer that a step has reached time t. Returns nonzero if the importer requests
     * that the step returns early. */
    int (*stepped)(struct unit *unit, double t);

    size_t n, n_q, n_x, n_inputs, n_outputs, n_events, n_switches, n_all;
    double *all;
    double *mode, *time, *input_time, *settings, *length; /* parts of the array `all` */
    double *parameters, *is_set, *start, *start_is_set, *y, *inputs, *slopes, *sides, *before,
        *anchor; /* unit_bound.c */

    /* `held` is a copy of params in which the switches' branches are fixed */
    void *params, *held;
    /* `values` and `indicators` are valid if their bits in `known` are set */
    double *values[PK_HOST_MOMENTA], *indicators;
    double *near; /* work space for one state vector */
    /* the inputs that the integrator reads; if NULL, it reads `inputs` */
    const double *given;
    unsigned known;
    int stale; /* params must be recomputed from `all` */
    /* whether the integrator `it` is initialised: at the current state, or in model exchange at
     * `anchor` */
    int ready;
    int busy; /* whether a callback of a step is running */
    struct pk_integrator it;
    struct pk_events events;
    void *block, *events_block;
};

struct unit *unit_new(const char *name, const char *token, int co_simulation);
void unit_free(struct unit *unit);

/* Logs a message and returns `status`. */
enum unit_status unit_say(const struct unit *unit, enum unit_status status, const char *category,
                          const char *format, ...)
#if defined __GNUC__
    __attribute__((format(printf, 4, 5)))
#endif
    ;
/* Returns UNIT_ERROR unless the unit exists and `modes` contains its mode. */
enum unit_status unit_allowed(const struct unit *unit, const char *call, int modes);

enum unit_status unit_reset(struct unit *unit);
enum unit_status unit_enter_initialization(struct unit *unit, double t, int with_rtol, double rtol);
enum unit_status unit_exit_initialization(struct unit *unit);

enum unit_status unit_get(struct unit *unit, unsigned reference, double *value);
enum unit_status unit_set(struct unit *unit, unsigned reference, double value);
enum unit_status unit_slope(struct unit *unit, unsigned reference, int order, double value);

/* Model exchange. */
enum unit_status unit_set_time(struct unit *unit, double t);
enum unit_status unit_set_states(struct unit *unit, const double *x, size_t n);
enum unit_status unit_get_states(struct unit *unit, double *x, size_t n);
enum unit_status unit_derivatives(struct unit *unit, double *rates, size_t n);
enum unit_status unit_indicators(struct unit *unit, double *values, size_t n);
enum unit_status unit_enter_event(struct unit *unit);
enum unit_status unit_update(struct unit *unit, int *ends); /* detects events, updates switches */
/* whether a projection has changed the state since the last call of unit_moved() */
int unit_moved(struct unit *unit);
/* Completes a step of the importer; sets *event to 1 if the unit requests event mode. */
enum unit_status unit_completed(struct unit *unit, int *event);

/* Co-simulation. */
struct unit_stepped {
    double t;  /* the time at which the step ended: the last one with a valid state */
    int ends;  /* whether an event ended the motion */
    int early; /* whether the importer requested an early return at time t */
};
enum unit_status unit_step(struct unit *unit, double t, double length, struct unit_stepped *made);
/* Reports that an event ended the step; returns UNIT_DISCARD. */
enum unit_status unit_early(const struct unit *unit);

/* Computes the directional derivative `sensitivity` = J seed, or the adjoint derivative J^T seed if
 * `transposed`. J is the Jacobian of the unknowns by the knowns. */
enum unit_status unit_derivative(struct unit *unit, const unsigned *unknowns, size_t n_unknowns,
                                 const unsigned *knowns, size_t n_knowns, const double *seed,
                                 int transposed, double *sensitivity);

/* Saved states. A serialised state is a hash of the model, then a copy of `all`. */
double *unit_state(const struct unit *unit);
enum unit_status unit_restore(struct unit *unit, const double *state);
size_t unit_serial_size(const struct unit *unit);
void unit_serialise(const struct unit *unit, const double *state, unsigned char *bytes);
double *unit_deserialise(const struct unit *unit, const unsigned char *bytes, size_t size);

/* The functions below are internal to this folder. */
static inline enum unit_kind unit_kind_of(unsigned reference)
{
    const unsigned kind = reference >> UNIT_SHIFT;
    return kind < UNIT_KINDS ? (enum unit_kind)kind : UNIT_KINDS;
}
static inline size_t unit_index_of(unsigned reference)
{
    return reference & ((1u << UNIT_SHIFT) - 1);
}
static inline double *unit_v(const struct unit *unit) { return unit->y + unit->n_q; }
/* updates params; before the run, also the state y */
enum unit_status unit_refresh(struct unit *unit);
/* copies `sides` to `held`, so that each switch stays on its side */
void unit_hold_sides(struct unit *unit);
const void *unit_params(const struct unit *unit);
void unit_forget(struct unit *unit);               /* marks computed values as invalid */
void unit_inputs(void *unit, double t, double *u); /* a function of the type of pk_problem.input */
void unit_move_inputs(struct unit *unit, double t);
enum unit_status unit_rates(struct unit *unit);
enum unit_status unit_functions(struct unit *unit);
struct pk_problem unit_problem(struct unit *unit);
/* Initialises the integrator at state y; h is the step of a fixed-step method if none is set. */
enum unit_status unit_integrator(struct unit *unit, double h, double t, const double *y);
enum unit_status unit_said(struct unit *unit,
                           enum unit_status status); /* logs the integrator's failure */

/* Constraints and unit quaternions in model exchange: unit_bound.c. */
int unit_bound(const struct unit *unit);
size_t unit_anchor_size(const struct unit *unit);
enum unit_status unit_bound_start(struct unit *unit);
enum unit_status unit_bound_off(struct unit *unit, int *off);
enum unit_status unit_bound_return(struct unit *unit);

#endif

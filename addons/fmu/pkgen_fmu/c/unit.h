/* A model as a functional mock-up unit: what FMI 2 and FMI 3 have in common, over struct pk_system.
 *
 * All that changes while a unit is used is one array of numbers, `all`, so that its state is a copy
 * of it. What follows from that array (params, the integrator, values) is made anew when it is
 * asked for. A call returns UNIT_OK, or says by unit_say() why not.
 */
#ifndef UNIT_H
#define UNIT_H

#include <stddef.h>

#include <pk/events.h>
#include <pk/integrator.h>

enum unit_status { UNIT_OK, UNIT_WARNING, UNIT_DISCARD, UNIT_ERROR, UNIT_FATAL };

/* A value reference is a kind and an index: kind << UNIT_SHIFT | index. */
enum { UNIT_SHIFT = 20 };
enum unit_kind {
    UNIT_TIME,
    UNIT_PARAMETER, /* flat: each member of a family is one */
    UNIT_INPUT,
    UNIT_SLOPE, /* d/dt of an input */
    UNIT_STATE, /* coordinates, then rates and first-order variables */
    UNIT_RATE,  /* d/dt of these */
    UNIT_OUTPUT,
    UNIT_ENERGY,
    UNIT_CLAIM,
    UNIT_INDICATOR, /* functions of events, then of switches */
    UNIT_SETTING,   /* of enum unit_setting */
    UNIT_KINDS
};
enum unit_setting { UNIT_METHOD, UNIT_STEP, UNIT_RTOL, UNIT_SETTINGS };

/* Generated with the model. Parameters and starts that follow others do so until they are set to
 * other values than these, since importers set all starts that they find. */
struct unit_model {
    const struct pk_system *system;
    const char *token;
    const double *parameters, *lo, *hi, *inputs, *start;
    const unsigned char *follows, *start_follows;
    const char *const *names; /* of parameters */
    size_t n_parameters;
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
    UNIT_WITHIN = 64 /* of a call: in a callback of a step too */
};
enum {
    UNIT_BEFORE = UNIT_INSTANTIATED | UNIT_INITIALIZATION,
    UNIT_RUNNING = UNIT_EVENT | UNIT_CONTINUOUS | UNIT_STEPPING,
    UNIT_ANY = UNIT_BEFORE | UNIT_RUNNING | UNIT_TERMINATED,
    UNIT_ORDERS = 3, /* derivatives of inputs */
    UNIT_LONGEST_TEXT = 600
};

struct unit {
    const struct unit_model *model;
    const struct pk_system *system;
    char *name;
    int co_simulation;
    void (*log)(const struct unit *unit, enum unit_status status, const char *category,
                const char *text); /* NULL: nobody listens */
    void *environment, *callback;
    int logging;
    /* Asks the importer for the inputs at t, which it sets; NULL: inputs are held, or follow their
     * derivatives. */
    void (*inputs_at)(struct unit *unit, double t);
    /* Tells it that a step has come to t; not 0: it wants to return there. */
    int (*stepped)(struct unit *unit, double t);

    size_t n, n_q, n_x, n_inputs, n_outputs, n_events, n_switches, n_all;
    double *all;
    double *mode, *time, *input_time, *settings, *length; /* parts of `all` */
    double *parameters, *is_set, *start, *start_is_set, *q, *v, *inputs, *slopes, *sides, *before,
        *anchor; /* unit_bound.c */

    void *params, *held, *room;                    /* held: params with the sides of switches */
    double **places;                               /* of parameters in params */
    double *rates, *outputs, *claims, *indicators; /* values, as far as `known` */
    double *near;                                  /* room for a state */
    const double *given;                           /* what the inputs are instead; or NULL */
    unsigned known;
    int stale; /* params do not follow from `all` yet */
    int ready; /* the integrator stands at time, q, v; in model exchange at the anchor */
    int busy;  /* within a callback of a step */
    struct pk_integrator it;
    struct pk_events events;
    void *block, *events_block;
};

struct unit *unit_new(const char *name, const char *token, int co_simulation);
void unit_free(struct unit *unit);

/* Says it to the log; returns status. */
enum unit_status unit_say(const struct unit *unit, enum unit_status status, const char *category,
                          const char *format, ...)
#if defined __GNUC__
    __attribute__((format(printf, 4, 5)))
#endif
    ;
/* UNIT_ERROR unless the unit is there and in one of these modes. */
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
enum unit_status unit_update(struct unit *unit, int *ends); /* what has crossed zero */
int unit_moved(struct unit *unit); /* whether the state, since it was asked */
/* A step of the importer's; not 0 in *event: the unit wants one. */
enum unit_status unit_completed(struct unit *unit, int *event);

/* Co-simulation. */
struct unit_stepped {
    double t;  /* the last valid time */
    int ends;  /* an event of the model that stops */
    int early; /* the importer wanted to return here */
};
enum unit_status unit_step(struct unit *unit, double t, double length, struct unit_stepped *made);
/* UNIT_DISCARD: an event ended the step. */
enum unit_status unit_early(const struct unit *unit);

/* `sensitivity` = J seed, J by rows of unknowns and columns of knowns; or by `transposed` its
 * transpose. */
enum unit_status unit_derivative(struct unit *unit, const unsigned *unknowns, size_t n_unknowns,
                                 const unsigned *knowns, size_t n_knowns, const double *seed,
                                 int transposed, double *sensitivity);

/* States. A serialised one is its numbers behind a mark of the model. */
double *unit_state(const struct unit *unit);
enum unit_status unit_restore(struct unit *unit, const double *state);
size_t unit_serial_size(const struct unit *unit);
void unit_serialise(const struct unit *unit, const double *state, unsigned char *bytes);
double *unit_deserialise(const struct unit *unit, const unsigned char *bytes, size_t size);

/* For the files of a unit. */
static inline enum unit_kind unit_kind_of(unsigned reference)
{
    const unsigned kind = reference >> UNIT_SHIFT;
    return kind < UNIT_KINDS ? (enum unit_kind)kind : UNIT_KINDS;
}
static inline size_t unit_index_of(unsigned reference)
{
    return reference & ((1u << UNIT_SHIFT) - 1);
}
static inline double *unit_x(const struct unit *unit, size_t i) /* state i */
{
    return i < unit->n_q ? unit->q + i : unit->v + (i - unit->n_q);
}
enum unit_status unit_refresh(struct unit *unit); /* params and, before the run, the start */
void unit_hold_sides(struct unit *unit);          /* of switches, in `held` */
const void *unit_params(const struct unit *unit);
void unit_forget(struct unit *unit);               /* the state has changed */
void unit_inputs(void *unit, double t, double *u); /* as pk_problem.input */
void unit_move_inputs(struct unit *unit, double t);
enum unit_status unit_rates(struct unit *unit);
enum unit_status unit_functions(struct unit *unit);
struct pk_problem unit_problem(struct unit *unit);
/* The integrator at a state, by the unit's method; h is the step where none is set. */
enum unit_status unit_integrator(struct unit *unit, double h, double t, const double *q,
                                 const double *v);
enum unit_status unit_said(struct unit *unit, enum unit_status status); /* of the integrator */

/* Of states that constraints and quaternions bind, in model exchange: unit_bound.c. */
int unit_bound(const struct unit *unit);
size_t unit_anchor_size(const struct unit *unit);
enum unit_status unit_bound_start(struct unit *unit);
enum unit_status unit_bound_off(struct unit *unit, int *off);
enum unit_status unit_bound_return(struct unit *unit);

#endif

/* Integration of a pk_system in time, in memory that the caller owns.
 *
 *     struct pk_problem problem = {.system = &pendulum_system, .params = &params};
 *     const struct pk_method *method = pk_method_find("dop853");
 *     struct pk_options options = pk_options_default();
 *     size_t size = pk_integrator_size(&problem, method);     (bytes)
 *     pk_integrator_init(&it, &problem, method, &options, t0, q0, v0, block, size);
 *     status = pk_integrator_to(&it, 10);                      it.t, it.q, it.v
 *
 * t, q, v, p are in SI units, or in the model's own if it has none; q0 and it.q hold n_q numbers,
 * the coordinates; v0, it.v and it.p hold n, their rates and behind them the states. They point
 * into the block; a step moves them elsewhere in it, so read them from `it` after each.
 *
 * No function allocates, prints or exits (a method of pk/gsl.h allocates in init, and
 * pk_integrator_free() gives that back). A step that fails leaves t, q, v and p as they were.
 * One integrator is used by one thread at a time; different ones are independent.
 */
#ifndef PK_INTEGRATOR_H
#define PK_INTEGRATOR_H

#include <stddef.h>

#include <pk/method.h>

PK_BEGIN

/* What is integrated. All of it must outlive the integrator. `params` is the model's own struct,
 * already prepared: init and reset refuse one that is out of bounds or was changed without
 * prepare(). `input` fills the n_inputs numbers u at time t, in the order and units of
 * system->inputs; it must be a function of t, since methods ask for any t of a step in any order.
 * Without it inputs are zero. `feedback`, or NULL, does the same at a state: it is called in place of
 * `input` for accelerations and events. Only explicit methods keep their order then. */
struct pk_problem {
    const struct pk_system *system;
    const void *params;
    void (*input)(void *context, pk_real t, pk_real *u);
    void *context;
    void (*feedback)(void *context, pk_real t, const pk_real *q, const pk_real *v, pk_real *u);
};

/* The default of atol: a size for each component, from the motion (see pk_options.atol). */
#define PK_ATOL_OF_MOTION PK_C(-1.0)

enum pk_iteration { PK_NEWTON, PK_FIXED_POINT };

/* The caller's names of settings, which reasons append to their advice: " (--step)". NULL: none. */
struct pk_words {
    const char *step, *rtol, *step_or_rtol, *max_step, *max_steps, *newton;
};

struct pk_options {
    pk_real h;    /* fixed step, or an adaptive method's first one (0: it chooses). Positive,
                     finite, whatever the direction. */
    pk_real rtol; /* adaptive: |error of y| <= atol + rtol |y| a step, root mean square over
                     q and v; finite, not both 0. Below some 10 PK_EPSILON it buys nothing,
                     and gauss takes 2 PK_EPSILON at least. */
    pk_real atol; /* PK_ATOL_OF_MOTION: rtol times the largest value that the coordinate or rate has
                     had, at least 1e-6 of the largest of one of the same unit */
    pk_real h_min; /* adaptive: a shorter one is PK_STEP_UNDERFLOW, as is ten ulp of t */
    pk_real
        h_max; /* adaptive, and the inner step of respa; 0: none. A last step may be 1% longer. */
    unsigned long max_steps; /* 0: no bound. PK_NO_PROGRESS ends a run early if, at the mean
                                length of the last half of the steps, more than max_steps (of 0:
                                1e9) would be needed to arrive or to double the time passed so
                                far, whichever is nearer. */
    enum pk_iteration iteration;
    pk_real newton_tol; /* relative correction that ends an iteration, < 1; 0: the next one is
                           foreseen to be far below round-off, the choice for long runs,
                           or for gauss what is left of a step's error below its tolerance */
    int max_iterations; /* 0: 50 for Newton, 1000 for fixed-point, 30 for gauss */
    /* Asked before each step; not 0: the step is not made, PK_STOPPED_USER, and only reset goes on.
     * NULL: nobody is. */
    int (*stop)(void *context);
    void *context;
    const struct pk_words *words; /* NULL: reasons say nothing of that kind */
};

struct pk_counters {
    unsigned long steps, rejections;
    unsigned long evaluations; /* of the acceleration, or of p and pdot at one stage */
    unsigned long jacobians, factorisations, iterations;
    unsigned long held; /* steps of `gauss` that its iteration, not its error, kept short */
};

/* Steps so long that a short force may be missed in them: fixed ones, or adaptive ones where t has
 * no digits for shorter ones. How many, the first one's mark (of system->marks.names) and when. */
struct pk_passed_over {
    unsigned long count;
    size_t which;
    pk_real t;
};

struct pk_integrator_private;

/* To be read, not written. q, v and p point into the block; p is NULL unless the method carries
 * momenta. */
struct pk_integrator {
    pk_real t;
    const pk_real *q, *v, *p;
    size_t n_q, n;  /* numbers in q, and in each of v and p */
    pk_real last_t; /* start of the last step made; it ended at t */
    struct pk_counters count;
    struct pk_passed_over passed_over;
    enum pk_status status; /* of the last call; pk_integrator_reason() says it in words, from */
    size_t where;          /* which coordinate or state, parameter or constraint it is about, */
    pk_real detail;        /* a number that belongs to it, */
    size_t event;          /* and 1 + which event, 0: none; see pk/events.h */
    struct pk_problem problem;
    const struct pk_method *method;
    struct pk_options options;
    struct pk_integrator_private *own; /* in the block; NULL where init refused the block itself */
};

struct pk_options pk_options_default(void);

/* Bytes of the block that pk_integrator_init() wants, 0 if an argument is null or the system of
 * another PK_ABI; it is to be aligned for pk_real, as malloc's are, and stays in use until the
 * integrator is. */
size_t pk_integrator_size(const struct pk_problem *problem, const struct pk_method *method);

/* Copies q0 and v0. PK_BAD_ARGUMENT, PK_BLOCK_TOO_SMALL, PK_REFUSED (the method), PK_OUT_OF_BOUNDS
 * (a parameter), PK_OFF_CONSTRAINTS, PK_NO_PROJECTION (constraints that depend on each other),
 * PK_NOT_FINITE, PK_NO_MEMORY (GSL): then no later call makes a step, and each
 * returns the same status. An integrator of GSL's is to be freed before it is initialised again. */
enum pk_status pk_integrator_init(struct pk_integrator *it, const struct pk_problem *problem,
                                  const struct pk_method *method, const struct pk_options *options,
                                  pk_real t0, const pk_real *q0, const pk_real *v0, void *block,
                                  size_t block_size);
/* A new state at t for the same integrator; counters go on. q and v may be
 * it->q and it->v. Call it so after a change of parameters or a jump of an input,
 * since methods keep derivatives from before. Where it is refused, nothing steps until one is
 * accepted. */
enum pk_status pk_integrator_reset(struct pk_integrator *it, pk_real t, const pk_real *q,
                                   const pk_real *v);
/* Another fixed step, or for an adaptive method another first step, from here on. */
enum pk_status pk_integrator_set_step(struct pk_integrator *it, pk_real h);
/* One step towards `limit`, never past it; a step that would end within round-off of it ends
 * exactly there. PK_DONE without a step if t is there already. */
enum pk_status pk_integrator_step(struct pk_integrator *it, pk_real limit);
/* The limit of the next fixed step if a result is wanted at t: t itself if it is
 * on the grid to rounding, else `limit`. After the step pk_integrator_aside() gives the result,
 * if needed. pk_integrator_is_at(): whether it->t is t to rounding. */
pk_real pk_integrator_limit(const struct pk_integrator *it, pk_real t, pk_real limit);
int pk_integrator_is_at(const struct pk_integrator *it, pk_real t);
/* Up to `steps` steps (0: as many as it takes) towards `limit`. Where the system can advance() by a
 * splitting method and has no singularities, all that lie on the grid at once, uncompensated and in
 * one pass over memory; if they end in what is not finite fewer are made, so that the failing one
 * is found. Else the same as so many calls of pk_integrator_step(). */
enum pk_status pk_integrator_steps(struct pk_integrator *it, pk_real limit, unsigned long steps);
/* Steps until t == t_end exactly, forward or backward. */
enum pk_status pk_integrator_to(struct pk_integrator *it, pk_real t_end);
/* The motion at t inside the last step, by the method's own interpolant, into n_q and n numbers.
 * PK_BAD_ARGUMENT for another t or method; a failure leaves the state as it is. */
enum pk_status pk_integrator_dense(struct pk_integrator *it, pk_real t, pk_real *q, pk_real *v);
/* The motion at t inside the last step, as exactly as the method steps: `side`, an integrator of
 * the same problem and method in memory of its own, makes that step again, only shorter, and is at
 * t behind it. Nothing of `it` changes but, where that fails, its status and reason. Not after a
 * reset or many steps at once. */
enum pk_status pk_integrator_aside(struct pk_integrator *it, struct pk_integrator *side, pk_real t);
/* The last status in words, with the last valid time and names. Returns its length as
 * snprintf() does. */
int pk_integrator_reason(const struct pk_integrator *it, char *text, size_t size);
/* Needed for methods that allocate (GSL's), harmless for others. */
void pk_integrator_free(struct pk_integrator *it);

PK_END

#endif

/* Integration of a pk_system in time, in memory that the caller owns.
 *
 *     struct pk_problem problem = {.system = &pendulum_system, .params = &params};
 *     const struct pk_method *method = pk_method_find("dop853");
 *     struct pk_options options = pk_options_default();
 *     size_t size = pk_integrator_size(&problem, method);     (bytes)
 *     pk_integrator_init(&it, &problem, method, &options, t0, q0, v0, block, size);
 *     status = pk_integrator_to(&it, 10);                      it.t, it.q, it.v
 *
 * t, q, v, p are in SI units, or dimensionless in a model without units. q0 and it.q have n_q
 * numbers, the coordinates. v0, it.v and it.p have n numbers: the rates, then the first-order
 * variables. it.q, it.v and it.p point into the block, and a step moves them, so read them from
 * `it` after each step.
 *
 * No function allocates, prints or exits, except that a method of pk/gsl.h allocates in init and
 * frees in pk_integrator_free(). A step that fails leaves t, q, v and p unchanged. An integrator is
 * used by one thread at a time; different ones are independent. */
#ifndef PK_INTEGRATOR_H
#define PK_INTEGRATOR_H

#include <stddef.h>

#include <pk/method.h>

PK_BEGIN

/* The problem. All of it must outlive the integrator. `params` is the model's struct after
 * system->prepare(): init and reset refuse parameters that are out of bounds or were changed
 * without prepare(). `input` writes the n_inputs numbers u at time t, in the order and units of
 * system->inputs; it must be a function of t, since methods call it for any t within a step in any
 * order. NULL: inputs are 0. `feedback`, or NULL, writes u at a state and replaces `input` for
 * accelerations and events. With `feedback`, only explicit methods have their full order. */
struct pk_problem {
    const struct pk_system *system;
    const void *params;
    void (*input)(void *context, pk_real t, pk_real *u);
    void *context;
    void (*feedback)(void *context, pk_real t, const pk_real *q, const pk_real *v, pk_real *u);
};

/* Return n and n_q, the numbers of rates and of coordinates. */
static inline size_t pk_count_of(const struct pk_problem *problem)
{
    return pk_system_count(problem->system, problem->params);
}
static inline size_t pk_coordinates_of(const struct pk_problem *problem)
{
    return pk_system_coordinates(problem->system, problem->params);
}

/* The function `input` for constant inputs; its context is this struct. */
struct pk_constant_input {
    const pk_real *u;
    size_t count;
};
void pk_constant_input(void *context, pk_real t, pk_real *u);

/* The default of atol: tolerances derived from the motion (see pk_options.atol). */
#define PK_ATOL_OF_MOTION PK_C(-1.0)

enum pk_iteration { PK_NEWTON, PK_FIXED_POINT };

/* The caller's names of options, such as " (--step)", for error texts. NULL: none. */
struct pk_words {
    const char *step, *rtol, *step_or_rtol, *max_step, *max_steps, *newton;
};

struct pk_options {
    pk_real h; /* fixed step size, or first step size of an adaptive method (0: automatic);
                     positive and finite also for integration backward in time */
    /* relative tolerance of adaptive methods: the error of each number y of q and v in a step is
     * compared with atol + rtol |y|, and the root mean square of these ratios is at most 1. rtol
     * and atol must be finite and not both 0. An rtol below about 10 PK_EPSILON does not reduce
     * errors further; gauss uses at least 2 PK_EPSILON. */
    pk_real rtol;
    /* absolute tolerance. PK_ATOL_OF_MOTION: each coordinate or rate has its own tolerance,
     * which is rtol times its largest value so far, or 1e-6 rtol times the largest value of all
     * numbers of the same unit, if that is larger */
    pk_real atol;
    /* smallest step size of an adaptive method; a smaller one fails with PK_STEP_UNDERFLOW */
    pk_real h_min;
    /* largest step size of adaptive methods, and of the inner steps of respa; 0: no limit. The
     * last step before the limit may be 1% longer. */
    pk_real h_max;
    /* largest number of steps; 0: no limit. A run ends earlier, with PK_NO_PROGRESS, if its
     * steps have become too short. The runtime extrapolates with the mean length of the last
     * half of the steps: the run ends if it would take more than max_steps further steps (1e9 if
     * max_steps is 0) to reach the limit, and also to double the time passed so far. */
    unsigned long max_steps;
    enum pk_iteration iteration;
    /* relative size, < 1, of a correction at which the iteration of an implicit method stops. 0,
     * best for long runs: the iteration stops when its next correction would be far below
     * round-off; that of gauss ends when its estimated error is below the tolerance */
    pk_real newton_tol;
    /* largest number of iterations in a step; 0: 50 for Newton's method, 1000 for fixed-point
     * iteration, 30 for gauss */
    int max_iterations;
    /* Called before each step. If it returns nonzero, the step is not made, the status is
     * PK_STOPPED_USER, and only pk_integrator_reset() can continue. NULL: not called. */
    int (*stop)(void *context);
    void *context;
    /* of models with noise: the random numbers are functions of these and of the number of the
     * step, which a step that is repeated with another length keeps */
    unsigned long long seed, member;
    const struct pk_words *words; /* names of options in error texts, or NULL */
};

struct pk_counters {
    unsigned long steps, rejections;
    /* number of evaluations of the acceleration, or, by methods in (q, p), of p and pdot */
    unsigned long evaluations;
    unsigned long jacobians, factorisations, iterations;
    unsigned long held; /* number of `gauss` steps shortened because of slow convergence */
};

/* Steps so long that they may miss a short force: fixed steps, or adaptive steps that cannot be
 * shortened because of the round-off of t. count: number of these steps; t: time of the first;
 * which: index in system->marks of the force that may be missed first. */
struct pk_passed_over {
    unsigned long count;
    size_t which;
    pk_real t;
};

/* The cause of a failure in numbers; pk_integrator_reason() returns it as text. `kind`
 * distinguishes causes with the same status; `index` is that of a coordinate, parameter, constraint
 * row, switch or singularity, `other` of a second one; `value` is a residual, a correction, a step
 * size or a pivot relative to its diagonal entry; `time` is that of the failure. Numbers without
 * meaning are 0. */
struct pk_reason {
    int kind;
    size_t index, other;
    pk_real value, time;
};

struct pk_integrator_private;

/* Read-only for callers. q, v and p point into the block; p is NULL if the method has none. */
struct pk_integrator {
    pk_real t;
    const pk_real *q, *v, *p;
    size_t n_q, n;  /* length of q; length of v and of p */
    pk_real last_t; /* start of the last step; t is its end */
    struct pk_counters count;
    struct pk_passed_over passed_over;
    enum pk_status status;   /* status of the last call */
    struct pk_reason reason; /* cause of the failure, if `status` is one */
    size_t event;            /* 1 + the index of the event at t, 0: none; see pk/events.h */
    struct pk_problem problem;
    const struct pk_method *method;
    struct pk_options options;
    struct pk_integrator_private *own; /* memory in the block; NULL if the block was refused */
};

struct pk_options pk_options_default(void);

/* Returns the bytes of the block for pk_integrator_init(), 0 if an argument is null or the system
 * has another PK_ABI. The block must be aligned as malloc() aligns, and outlive the integrator. */
size_t pk_integrator_size(const struct pk_problem *problem, const struct pk_method *method);

/* Copies q0 and v0. Fails with PK_BAD_ARGUMENT, PK_BLOCK_TOO_SMALL, PK_REFUSED (the method does not
 * suit the system), PK_OUT_OF_BOUNDS (a parameter), PK_OFF_CONSTRAINTS, PK_NO_PROJECTION (dependent
 * constraint rows), PK_NOT_FINITE, PK_NO_MEMORY (GSL). After a failure, every later call returns
 * the same status and makes no step. Free an integrator of a GSL method before another init. */
enum pk_status pk_integrator_init(struct pk_integrator *it, const struct pk_problem *problem,
                                  const struct pk_method *method, const struct pk_options *options,
                                  pk_real t0, const pk_real *q0, const pk_real *v0, void *block,
                                  size_t block_size);
/* Sets a new state at t; counters continue. q and v may be it->q and it->v. Call this function with
 * these also after a change of parameters or a jump of an input, since methods reuse derivatives of
 * the last step. If it fails, no step is made until a later reset succeeds. */
enum pk_status pk_integrator_reset(struct pk_integrator *it, pk_real t, const pk_real *q,
                                   const pk_real *v);
/* Sets the step size: of a fixed-step method for all further steps, of an adaptive method for its
 * next step. Fails with PK_BAD_ARGUMENT. */
enum pk_status pk_integrator_set_step(struct pk_integrator *it, pk_real h);
/* Makes one step towards `limit`, never past it; a step that would end within round-off of `limit`
 * ends exactly at it. Returns PK_DONE without a step if t is `limit`. */
enum pk_status pk_integrator_step(struct pk_integrator *it, pk_real limit);
/* For a caller that wants a result at time t from fixed steps: returns the limit to pass to the
 * next step. This is t if a regular step ends there up to rounding. Otherwise it is `limit`, and
 * after the step that passes t, pk_integrator_aside() computes the result at t.
 * pk_integrator_is_at() returns whether it->t is t up to rounding. */
pk_real pk_integrator_limit(const struct pk_integrator *it, pk_real t, pk_real limit);
int pk_integrator_is_at(const struct pk_integrator *it, pk_real t);
/* Makes at most `steps` steps (0: no limit) towards `limit`, with the same bits as calls of
 * pk_integrator_step(), but faster. For a system with families.advance and no singularities, all
 * steps of the fixed step size are made in one pass over memory without compensated sums, so that
 * the last bits differ; if the state after them is not finite, fewer steps are made, to find the
 * step that fails. */
enum pk_status pk_integrator_steps(struct pk_integrator *it, pk_real limit, unsigned long steps);
/* Makes steps until t == t_end exactly, forward or backward. */
enum pk_status pk_integrator_to(struct pk_integrator *it, pk_real t_end);
/* Writes the dense output at t inside the last step, n_q numbers to q and n to v. PK_BAD_ARGUMENT:
 * t is outside the last step, or there is no dense output. The state is unchanged. */
enum pk_status pk_integrator_dense(struct pk_integrator *it, pk_real t, pk_real *q, pk_real *v);
/* Computes the motion at t inside the last step as accurately as the method's steps. `side`, an
 * integrator of the same problem and method with its own memory, repeats that step up to t and
 * holds the result. `it` is unchanged, except for status and reason on failure. Not allowed after
 * pk_integrator_reset() or pk_integrator_steps(). */
enum pk_status pk_integrator_aside(struct pk_integrator *it, struct pk_integrator *side, pk_real t);
/* Writes the last status as text, with the last valid time. Returns the length like snprintf(). */
int pk_integrator_reason(const struct pk_integrator *it, char *text, size_t size);
/* Frees memory. Needed only after methods that allocate (GSL's). */
void pk_integrator_free(struct pk_integrator *it);

PK_END

#endif

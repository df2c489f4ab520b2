/* Declarations for the files of the core, in addition to pk/step/state.h: kernel calls that count
 * and report failures, checks, memory. Not installed. */
#ifndef PK_INTERNAL_H
#define PK_INTERNAL_H

#include <string.h>
#include <pk/step/linear.h>

#if defined __GNUC__
#define PK_FORMAT(text, first) __attribute__((format(printf, text, first)))
#else
#define PK_FORMAT(text, first)
#endif

static inline void pk_copy(pk_real *to, const pk_real *from, size_t count)
{
    memcpy(to, from, count * sizeof *to);
}
static inline void pk_zero(pk_real *x, size_t count) { memset(x, 0, count * sizeof *x); }

/* Returns the largest |x_i|. */
static inline pk_real pk_largest(const pk_real *x, size_t count)
{
    pk_real most = 0;
    for (size_t i = 0; i < count; i++)
        most = pk_max(most, pk_abs(x[i]));
    return most;
}
static inline pk_real pk_dot(const pk_real *x, const pk_real *y, size_t count)
{
    pk_real sum = 0;
    for (size_t i = 0; i < count; i++)
        sum += x[i] * y[i];
    return sum;
}
/* Adds a multiple of x to y. */
static inline void pk_add(pk_real *y, pk_real factor, const pk_real *x, size_t count)
{
    for (size_t i = 0; i < count; i++)
        y[i] += factor * x[i];
}

/* The arguments of a kernel, for systems written in C in this library. */
#define ARGS const void *params, pk_real t, const pk_real *q, const pk_real *v, const pk_real *u
#define UNUSED ((void)params, (void)t, (void)q, (void)v, (void)u)

/* Values of `kind` in struct pk_reason for PK_BAD_ARGUMENT: */
enum {
    BAD_POINTER = 1,
    BAD_SYSTEM,
    BAD_STEP,
    BAD_TOLERANCE,
    BAD_STATE,
    BAD_TIME,
    BAD_DENSE,
    BAD_ITERATION,
    BAD_PARAMS,
    BAD_SCALE,
    BAD_PERIOD
};

/* Kinds for PK_NO_CONVERGENCE, with the meaning of `value`. PK_BY_FIXED_POINT: the last correction
 * of the fixed-point iteration. PK_BY_NEWTON: the longest step for which Newton's method converged.
 * PK_OF_RATES: the last correction of the iteration that computes rates from momenta. */
enum { PK_BY_FIXED_POINT, PK_BY_NEWTON, PK_OF_RATES };
/* Kind for PK_NOT_FINITE: `value` is the intensity of noise `index`, which is negative. */
enum { PK_OF_NOISE = 1 };
/* Kinds for PK_OFF_CONSTRAINTS and PK_NO_PROJECTION, with the meaning of `index`: */
enum {
    PK_REASON_ROW,      /* `index` is a row whose phi is violated */
    PK_REASON_ROW_RATE, /* `index` is a row whose J v + j0 is violated */
    PK_REASON_QUATERNION,
    PK_REASON_REDUNDANT, /* `index` is a redundant row */
    PK_REASON_REDUNDANT_RATE,
    /* at `time` constraint row `index` depends on other rows, and it is not determined on which
     * branch the motion continues */
    PK_REASON_BRANCH,
    PK_REASON_NO_ROW, /* as PK_REASON_BRANCH, but the dependent row is not known */
    PK_REASON_NO_START
};
/* Kinds for PK_STEP_UNDERFLOW: what changes too fast. */
enum { PK_REASON_LENGTH, PK_REASON_TIME_SCALE };
/* Kinds for PK_NO_CONTACT: no accelerations or impulses are found, or `value` is no restitution or
 * no bound of a friction. */
enum { PK_REASON_ACCELERATIONS, PK_REASON_IMPULSES, PK_REASON_RESTITUTION, PK_REASON_BOUND };
/* A kind for PK_NO_PROGRESS: contacts and frictions change `value` times within `time`. */
enum { PK_REASON_STEPS, PK_REASON_CROWD };
/* Kinds for PK_SINGULAR_TIME: whether the acceleration grows towards the singularity. */
enum { PK_REASON_GROWS, PK_REASON_BOUNDED };

#define PK_WHY(...) ((struct pk_reason){__VA_ARGS__})

/* Sets and returns a status, and sets the kind of its reason. */
static inline enum pk_status pk_fail(struct pk_integrator *it, enum pk_status status, int kind)
{
    it->reason = (struct pk_reason){.kind = kind};
    return it->status = status;
}

/* Sets the reason and returns the status; the caller sets it->status. */
static inline enum pk_status pk_fail_with(struct pk_integrator *it, enum pk_status status,
                                          struct pk_reason reason)
{
    it->reason = reason;
    return status;
}

/* Points q, v and p at the current state. */
static inline void pk_point(struct pk_integrator *it)
{
    it->q = pk_state(it, PK_Q);
    it->v = pk_state(it, PK_V);
    if (it->p)
        it->p = pk_state(it, PK_P);
}

/* Exchanges it->own->state and it->own->next: the new state becomes current; `next` is the old. */
static inline void pk_commit_step(struct pk_integrator *it)
{
    pk_real *const left_behind = it->own->state;
    it->own->state = it->own->next;
    it->own->next = left_behind;
    pk_point(it);
}

/* Returns whether a step can be repeated with a smaller it->own->h, unlike those of GSL. */
static inline int pk_repeats(const struct pk_integrator *it)
{
    return it->method->traits & PK_ADAPTIVE && !it->method->release;
}

/* Returns whether a start was accepted. */
static inline int pk_ready(const struct pk_integrator *it) { return it->own && it->own->ready; }

/* Writes text as printf() does, then the last valid time. Returns the length as snprintf() does. */
int pk_say(const struct pk_integrator *it, char *text, size_t size, const char *format, ...)
    PK_FORMAT(4, 5);

/* pk_lay_out() divides the memory at `base` into consecutive parts, one for each slot, and sets the
 * pointers. It returns the number of pk_real of all parts. If base is NULL, it only counts. */
struct pk_slot {
    pk_real **part;
    size_t count;
};
size_t pk_lay_out(pk_real *base, const struct pk_slot *slots, size_t count);
#define PK_LAY_OUT(base, slots) pk_lay_out(base, slots, sizeof(slots) / sizeof *(slots))
/* The number of pk_real whose memory is large enough for one struct of this type, which may have
 * members of type pk_real and int. */
#define PK_REALS_OF(type) ((sizeof(type) + sizeof(pk_real) - 1) / sizeof(pk_real))

/* pk_check_params() checks the parameters at a start; `scratch` has pk_params_reals() numbers. */
size_t pk_params_reals(const struct pk_system *system);
enum pk_status pk_check_params(struct pk_integrator *it, pk_real *scratch);
/* Returns the index that describes the failure `outside` of prepare(): the index of the refused
 * parameter; n_parameters if no single parameter is the cause; n_parameters + 1 if a size is. */
size_t pk_refused_parameter(const struct pk_system *system, int outside);
enum pk_status pk_check_options(struct pk_integrator *it);
/* Returns the facts that a method needs and the system lacks. pk_sides_missing() returns whether a
 * side of a switch is 0 although the method needs smooth equations or rates jump at switches. */
unsigned pk_missing_facts(const struct pk_system *system, const struct pk_method *method);
int pk_sides_missing(const struct pk_integrator *it);
/* Returns the name of a kernel that a method needs and the system lacks; NULL: none. */
const char *pk_missing_kernel(const struct pk_system *system, const struct pk_method *method);

/* pk_step_choose() checks the limits of step number and progress before a step towards `limit`;
 * `limit` must differ from it->t. For fixed steps it also sets it->own->next_t and it->own->h.
 * pk_step_advance_time() updates the times after a step. */
/* Returns whether many trial steps since the last check of progress were rejected. */
int pk_often_rejected(const struct pk_integrator *it);
enum pk_status pk_step_choose(struct pk_integrator *it, pk_real limit, int fixed);
/* The next fixed step as the grid of steps requires it; events and short forces may shorten it. */
struct pk_planned {
    pk_real h, end;
    int off_grid;
};
struct pk_planned pk_step_planned(const struct pk_integrator *it, pk_real limit);
/* Returns the number of fixed steps that end before `limit`, at most `most`. The last step to
 * `limit` is not counted: pk_integrator_step() makes it end exactly there. */
unsigned long pk_step_count(const struct pk_integrator *it, pk_real limit, unsigned long most);
/* Replaces the state by the end of the it->own->ahead->many steps computed in advance. */
void pk_ahead_all(struct pk_integrator *it);
void pk_step_advance_time(struct pk_integrator *it, int fixed);

/* Call kernels: compute inputs, count the calls, report failures. */
enum pk_status pk_eval_acceleration(struct pk_integrator *it, pk_real t, const pk_real *q,
                                    const pk_real *v, pk_real *a);
void pk_eval_canonical(struct pk_integrator *it, pk_real t, const pk_real *q, const pk_real *v,
                       pk_real *p, pk_real *pdot);

/* Absolute tolerances, it->own->atol. pk_scale_size() returns the number of pk_real of their
 * memory; pk_scale_start() initialises them at a start; pk_scale_step() updates them after a step;
 * pk_scale_forget() resets them after a step is undone. pk_scale_attempt() (pk/step/state.h)
 * updates them before each trial step. */
size_t pk_scale_size(const struct pk_problem *problem, const struct pk_method *method, size_t n_q,
                     size_t n);
void pk_scale_start(struct pk_integrator *it);
void pk_scale_step(struct pk_integrator *it);
void pk_scale_forget(struct pk_integrator *it);
/* Called after the step size underflowed. If a coordinate has never moved, but accelerates at t +
 * h, its scale becomes the distance that it moves in the time h. Returns 1 if there is such a
 * coordinate. Without this a force that starts with a jump could never be integrated from rest,
 * since the error is as large as the motion. */
int pk_scale_raise(struct pk_integrator *it, pk_real h);

/* These functions monitor the singularities of system->singularities. _size() returns the number of
 * pk_real of their memory; _start() initialises it at a start; _here() checks whether a singularity
 * is zero at the state; _step() checks the trial step in it->own->next; _cause() finds out whether
 * a singularity is the cause of a failed step. */
size_t pk_singularity_size(size_t n_singularities, size_t n_q, size_t n);
void pk_singularity_start(struct pk_integrator *it);
enum pk_status pk_singularity_here(struct pk_integrator *it);
enum pk_status pk_singularity_step(struct pk_integrator *it);
enum pk_status pk_singularity_cause(struct pk_integrator *it, enum pk_status status, int fixed);

/* Forces that may act for a time shorter than a step (short_force_limiter.c). _size() returns the
 * number of pk_real of their memory; _limit() returns the limit of a trial step; _reject() returns
 * whether the step may miss such a force and must be repeated up to a nearer limit; _accept()
 * updates the memory after an accepted step. */
size_t pk_short_force_size(const struct pk_system *system, size_t n_q, size_t n);
pk_real pk_short_force_limit(const struct pk_integrator *it, pk_real limit);
int pk_short_force_reject(struct pk_integrator *it);
void pk_short_force_accept(struct pk_integrator *it);
/* q, v and the acceleration a at one end of a step. */
struct pk_knot {
    const pk_real *q, *v, *a;
};
/* Evaluates the cubic Hermite polynomial through q and v at the ends of a step of length h, and its
 * derivative, at x in 0 .. 1; for first-order variables that through values and rates. */
void pk_hermite(const struct pk_integrator *it, pk_real h, struct pk_knot from, struct pk_knot to,
                pk_real x, pk_real *q, pk_real *v);

#endif

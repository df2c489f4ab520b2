/* What the core's files share beyond what steps need (pk/step/state.h): kernel calls that count
 * and name their failures, small dense linear algebra. Not installed.
 */
#ifndef PK_INTERNAL_H
#define PK_INTERNAL_H

#include <pk/step/linear.h>

#if defined __GNUC__
#define PK_FORMAT(text, first) __attribute__((format(printf, text, first)))
#else
#define PK_FORMAT(text, first)
#endif

/* What a kernel is called with, of systems that are written here. */
#define ARGS const void *params, pk_real t, const pk_real *q, const pk_real *v, const pk_real *u
#define UNUSED ((void)params, (void)t, (void)q, (void)v, (void)u)

/* it->where of PK_BAD_ARGUMENT. */
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
    BAD_SCALE
};

/* A status with what it is about. */
static inline enum pk_status pk_fail(struct pk_integrator *it, enum pk_status status, size_t where)
{
    it->where = where;
    return it->status = status;
}

/* it->own->next becomes the state, and the state what the step began with. */
static inline void pk_exchange(struct pk_integrator *it)
{
    pk_real *const left_behind = it->own->state;
    it->own->state = it->own->next;
    it->own->next = left_behind;
    it->q = pk_state(it, PK_Q);
    it->v = pk_state(it, PK_V);
    if (it->p)
        it->p = pk_state(it, PK_P);
}

/* The same, left to the caller to be that of `it`; and a number that belongs to it. */
static inline enum pk_status pk_because(struct pk_integrator *it, enum pk_status status,
                                        size_t where, pk_real detail)
{
    it->where = where;
    it->detail = detail;
    return status;
}

/* How many numbers q has. */
static inline size_t pk_coordinates_of(const struct pk_problem *problem)
{
    return pk_system_coordinates(problem->system, problem->params);
}

/* Whether a step can be made again shorter, by it->own->h: GSL's methods keep a length of their own.
 */
static inline int pk_repeats(const struct pk_integrator *it)
{
    return it->method->traits & PK_ADAPTIVE && !it->method->release;
}

/* Whether a start was accepted. */
static inline int pk_ready(const struct pk_integrator *it) { return it->own && it->own->ready; }

/* Words as printf() has them, and the last valid time; the length as snprintf(). */
int pk_say(const struct pk_integrator *it, char *text, size_t size, const char *format, ...)
    PK_FORMAT(4, 5);

/* it->where of PK_NO_CONVERGENCE, and what it->detail is: the last correction of a fixed-point
 * iteration; the longest step for which Newton's found the solution; the last correction of rates
 * from momenta. */
enum { PK_BY_FIXED_POINT, PK_BY_NEWTON, PK_OF_RATES };

/* Memory laid out one part behind the other; without a base they are counted alone, so that a size
 * is what its layout takes: the number of pk_real. */
struct pk_slot {
    pk_real **part;
    size_t count;
};
size_t pk_lay_out(pk_real *base, const struct pk_slot *slots, size_t count);
#define PK_LAY_OUT(base, slots) pk_lay_out(base, slots, sizeof(slots) / sizeof *(slots))
/* For a struct of pk_real and int. */
#define PK_REALS_OF(type) ((sizeof(type) + sizeof(pk_real) - 1) / sizeof(pk_real))

/* Checks before the first step; scratch holds pk_params_reals() numbers. */
size_t pk_params_reals(const struct pk_system *system);
enum pk_status pk_check_params(struct pk_integrator *it, pk_real *scratch);
/* it->where of what prepare() refused: the parameter; n_parameters where it is none alone, and one
 * more where it is a size. */
size_t pk_refused_parameter(const struct pk_system *system, int outside);
enum pk_status pk_check_options(struct pk_integrator *it);
/* Facts that a method needs and the system lacks. pk_sides_missing(): if only smoothness across the
 * switches is lacking, or rates jump there: whether a side is not set. */
unsigned pk_missing_facts(const struct pk_system *system, const struct pk_method *method);
int pk_sides_missing(const struct pk_integrator *it);
/* A kernel that a method calls and the system was compiled without; NULL: there is none. */
const char *pk_missing_kernel(const struct pk_system *system, const struct pk_method *method);

/* The time of a step towards `limit`, which is not it->t, before it is made: it->own->next_t and,
 * where steps are fixed, it->own->h. And after. */
/* Whether many of those tried since progress was last looked at were rejected. */
int pk_often_rejected(const struct pk_integrator *it);
enum pk_status pk_step_choose(struct pk_integrator *it, pk_real limit, int fixed);
/* What the next step of a fixed method will be, as nothing but its grid has it. */
struct pk_planned {
    pk_real h, end;
    int off_grid;
};
struct pk_planned pk_step_planned(const struct pk_integrator *it, pk_real limit);
/* Its steps that end before `limit`, at most `most`; the last one is left to pk_integrator_step(),
 * which ends exactly there. */
unsigned long pk_step_whole(const struct pk_integrator *it, pk_real limit, unsigned long most);
/* Makes all that was made ahead the state: it->own->ahead->many steps. */
void pk_ahead_all(struct pk_integrator *it);
void pk_step_made(struct pk_integrator *it, int fixed);

/* Kernels through the integrator: inputs filled, calls counted, failures named. */
enum pk_status pk_eval_acceleration(struct pk_integrator *it, pk_real t, const pk_real *q,
                                    const pk_real *v, pk_real *a);
void pk_eval_canonical(struct pk_integrator *it, pk_real t, const pk_real *q, const pk_real *v,
                       pk_real *p, pk_real *pdot);

/* Absolute tolerances, it->own->atol: numbers needed; at a start; after a step. Before each attempt
 * at one pk_scale_attempt() (pk/step/state.h). */
size_t pk_scale_size(const struct pk_problem *problem, const struct pk_method *method, size_t n_q,
                     size_t n);
void pk_scale_start(struct pk_integrator *it);
void pk_scale_step(struct pk_integrator *it);
void pk_scale_forget(struct pk_integrator *it);
/* After an underflow: coordinates that never moved but accelerate at t + h get that motion as their
 * scale; 1 if there are any. Without this, a force that jumps on is never integrated from rest, for
 * the error is as large as the motion. */
int pk_scale_raise(struct pk_integrator *it, pk_real h);

/* Where the equations end: what system->singularities.table says, watched from step to step.
 * Numbers needed; at a start; whether a singularity is zero there; after a trial step, which is
 * still it->own->next; and after one that failed, whether a singularity is its cause. */
size_t pk_singularity_size(size_t n_singularities, size_t n_q, size_t n);
void pk_singularity_start(struct pk_integrator *it);
enum pk_status pk_singularity_here(struct pk_integrator *it);
enum pk_status pk_singularity_step(struct pk_integrator *it);
enum pk_status pk_singularity_cause(struct pk_integrator *it, enum pk_status status, int fixed);

/* Forces that may be shorter than a step (marks.c): numbers needed; the limit of a trial step;
 * whether it passes over too much, and is to be made again up to a nearer one; that it becomes the
 * state. */
size_t pk_marks_size(const struct pk_system *system, size_t n_q, size_t n);
pk_real pk_marks_limit(const struct pk_integrator *it, pk_real limit);
int pk_marks_reject(struct pk_integrator *it);
void pk_marks_accept(struct pk_integrator *it);
/* q, v and the rates of v at the end of a step. */
struct pk_knot {
    const pk_real *q, *v, *a;
};
/* The cubic of Hermite through q and v at the ends of a step of length h, and its derivative, at x
 * of 0 .. 1; of states the cubic through them and their rates. */
void pk_hermite(const struct pk_integrator *it, pk_real h, struct pk_knot from, struct pk_knot to,
                pk_real x, pk_real *q, pk_real *v);

#endif

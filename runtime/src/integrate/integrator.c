/* The integrator: its memory, its checks, and the loop over steps. A method's step() writes the new
 * state to it->own->next. It becomes the state only after checks in this file, so that a failed
 * step leaves the state unchanged. grid.c chooses the length of a step. */
#include <stdint.h>
#include <string.h>

#include "../core/project.h"
#include "../core/tableau.h"

/* The private part is first in the block, then the state. Both are aligned to cache lines on 64-bit
 * machines, since otherwise fused steps of a chain take a fifth longer. */
#if UINTPTR_MAX > 0xffffffff
#define ALIGNED ((size_t)64)
#else
#define ALIGNED _Alignof(struct pk_integrator_private)
#endif
#define OWN ((sizeof(struct pk_integrator_private) + ALIGNED - 1) / ALIGNED * ALIGNED)
#define PRIVATE (OWN + ALIGNED)

/* fraction of the time to the limit within which a system at rest is searched for forces */
#define FROM_REST PK_C(1e-3)

struct pk_options pk_options_default(void)
{
    struct pk_options options = {0};
    options.rtol = PK_F(sqrt)(PK_EPS) * PK_C(0.0625); /* this rtol is about 1e-9 in double */
    options.atol = PK_ATOL_OF_MOTION;
    return options;
}

/* Divides the memory at `base`, behind the struct `own`, among the pointers of `own`. Returns the
 * number of pk_real; if base is NULL, it only counts. */
static size_t lay_out(struct pk_integrator_private *own, const struct pk_problem *problem,
                      const struct pk_method *method, size_t n_q, size_t n, pk_real *base)
{
    const struct pk_system *system = problem->system;
    const size_t singularities = pk_system_singularity_count(system, problem->params);
    const struct pk_slot slots[] = {
        {&own->state, pk_state_offset(n_q, n, PK_PARTS)},
        {&own->next, pk_state_offset(n_q, n, PK_PARTS)},
        {&own->atol, pk_scale_size(problem, method, n_q, n)},
        {&own->u, system->n_inputs * (1 + PK_LANES)},
        {&own->lane, system->lanes ? 0 : n_q + 2 * n + system->n_inputs},
        {&own->work, (method->size ? method->size : pk_splitting_size)(method, problem, n)},
        {&own->singularities, pk_singularity_size(singularities, n_q, n)},
        {&own->project, pk_project_size(problem, n)},
        {&own->marks, pk_short_force_size(system, n_q, n)},
        {&own->crossing, pk_singular_crossing_size(system, n_q, n)},
        {&own->params, pk_params_reals(system)},
    };
    own->n_singularities = singularities;
    return PK_LAY_OUT(base, slots);
}

size_t pk_integrator_size(const struct pk_problem *problem, const struct pk_method *method)
{
    if (!problem || !problem->system || !method || problem->system->abi != PK_ABI)
        return 0;
    struct pk_integrator_private own;
    const size_t n = pk_count_of(problem), n_q = pk_coordinates_of(problem);
    return PRIVATE + lay_out(&own, problem, method, n_q, n, NULL) * sizeof(pk_real);
}

/* Returns the step function of this method that was compiled with the system's kernels, or the
 * method's function for any system. */
static enum pk_status (*stepper(const struct pk_system *system,
                                const struct pk_method *method))(struct pk_integrator *, pk_real)
{
    for (const struct pk_stepper *s = system->steppers; s && s->method; s++)
        if (strcmp(s->method, method->name) == 0)
            return s->step;
    return method->step;
}

enum pk_status pk_integrator_init(struct pk_integrator *it, const struct pk_problem *problem,
                                  const struct pk_method *method, const struct pk_options *options,
                                  pk_real t0, const pk_real *q0, const pk_real *v0, void *block,
                                  size_t block_size)
{
    memset(it, 0, sizeof *it);
    if (!problem || !problem->system || !method || !options || !q0 || !v0 || !block ||
        (problem->system->params_size && !problem->params))
        return pk_fail(it, PK_BAD_ARGUMENT, BAD_POINTER);
    const struct pk_system *system = problem->system;
    it->problem = *problem;
    it->method = method;
    it->options = *options;
    it->t = t0;
    it->n = system->abi == PK_ABI ? pk_count_of(problem) : 0;
    if (it->n == 0)
        return pk_fail(it, PK_BAD_ARGUMENT, BAD_SYSTEM);
    it->n_q = pk_coordinates_of(problem);
    if (block_size < PRIVATE || (size_t)block % _Alignof(pk_real))
        return pk_fail(it, PK_BLOCK_TOO_SMALL, 0);
    const size_t over = (size_t)block % ALIGNED;
    it->own = (void *)((char *)block + (over ? ALIGNED - over : 0));
    memset(it->own, 0, sizeof *it->own);
    if (pk_missing_facts(system, method) || pk_missing_kernel(system, method) ||
        (system->n_inputs && (method->traits & PK_NO_INPUTS)) ||
        (system->noise.n && !(method->traits & PK_NOISE)) ||
        ((pk_rolls(system) || system->contacts.n) && (method->traits & PK_HOLONOMIC)))
        return pk_fail(it, PK_REFUSED, 0);
    if (pk_check_options(it) < 0)
        return it->status;
    if (block_size < pk_integrator_size(problem, method))
        return pk_fail(it, PK_BLOCK_TOO_SMALL, 0);

    it->own->step = stepper(system, method);
    lay_out(it->own, problem, method, it->n_q, it->n, (pk_real *)(void *)((char *)it->own + OWN));
    const size_t scales = pk_scale_size(problem, method, it->n_q, it->n);
    if (!scales)
        it->own->atol = NULL;
    else
        pk_zero(it->own->atol, scales);
    if (!it->own->n_singularities)
        it->own->singularities = NULL;
    if (!pk_project_size(problem, it->n))
        it->own->project = NULL;
    if (!system->constraints.n)
        it->own->crossing = NULL;
    if (!system->marks.n)
        it->own->marks = NULL;
    pk_point(it);
    return pk_integrator_reset(it, t0, q0, v0);
}

enum pk_status pk_integrator_reset(struct pk_integrator *it, pk_real t, const pk_real *q,
                                   const pk_real *v)
{
    const size_t n_q = it->n_q, n = it->n;
    if (!it->own || !it->own->state)
        return it->status;
    it->own->ready = 0;
    if (it->own->ahead)
        it->own->ahead->ready = it->own->ahead->taken = it->own->ahead->waits = 0,
        it->own->ahead->many = 0;
    if (!q || !v)
        return pk_fail(it, PK_BAD_ARGUMENT, BAD_POINTER);
    if (!pk_finite(t))
        return pk_fail(it, PK_BAD_ARGUMENT, BAD_TIME);
    if (!pk_all_finite(q, n_q) || !pk_all_finite(v, n))
        return pk_fail(it, PK_BAD_ARGUMENT, BAD_STATE);
    memmove(pk_state(it, PK_Q), q, n_q * sizeof *q);
    memmove(pk_state(it, PK_V), v, n * sizeof *v);
    pk_zero(pk_state(it, PK_P), pk_state_offset(n_q, n, PK_PARTS) - pk_state_offset(n_q, n, PK_P));
    it->status = pk_check_params(it, it->own->params);
    if (it->status < 0)
        return it->status;
    /* inputs stay 0 without an input function */
    pk_zero(it->own->u, it->problem.system->n_inputs * (1 + PK_LANES));
    it->t = it->last_t = it->own->next_t = t;
    it->own->direction = 0;
    it->own->trouble.status = PK_DONE;
    it->event = 0;
    it->own->short_force.known = it->own->short_force.unlooked = 0;
    it->own->short_force.reach = it->own->short_force.calm = 0;
    it->own->flags = 0;
    it->own->h = 0;
    it->status = pk_project_start(it); /* by the size of the state before, in own->next */
    pk_zero(it->own->next, pk_state_offset(n_q, n, PK_PARTS));
    if (it->status >= 0)
        pk_scale_start(it);
    if (it->status >= 0 && it->method->init)
        it->status = it->method->init(it);
    pk_singularity_start(it);
    pk_singular_crossing_forget(it);
    it->own->ready = it->status >= 0;
    return it->status;
}

enum pk_status pk_integrator_set_step(struct pk_integrator *it, pk_real h)
{
    if (!pk_ready(it))
        return it->status < 0 ? it->status : PK_BAD_ARGUMENT;
    if (!(h > 0) || !pk_finite(h))
        return pk_fail(it, PK_BAD_ARGUMENT, BAD_STEP);
    it->options.h = h;
    it->own->direction = 0; /* the next step starts a new grid */
    return it->status = PK_DONE;
}

/* Ends a failed step: drops data of the last step, which the failed step may have overwritten.
 * After a failure at a singularity of the equations, no further step is possible. */
static enum pk_status stop(struct pk_integrator *it, enum pk_status status)
{
    it->own->flags &= ~(PK_HAVE_A | PK_HAVE_STEP | PK_HAVE_DENSE);
    if (status == PK_SINGULAR_TIME || status == PK_SINGULAR_COORDINATES)
        it->own->ready = 0;
    return it->status = status;
}

/* Returns whether q, v and p of the trial step are finite. */
static int are_numbers(const struct pk_integrator *it)
{
    return pk_all_finite(it->own->next, pk_state_offset(it->n_q, it->n, PK_LOW_Q));
}

/* Makes a step and its projection. If the projection fails and the method can repeat the step, the
 * step is retried with a quarter of its length. If the step size underflows after such a retry, the
 * status is PK_NO_PROJECTION. */
static enum pk_status advance(struct pk_integrator *it, pk_real limit)
{
    struct pk_integrator_private *const own = it->own;
    enum { CUTS = 12 };
    struct pk_reason reason = {0};
    const pk_real while_at_rest = (limit - it->t) * FROM_REST;
    int raised = 0;
    for (int cuts = 0;; cuts++) {
        if (own->ahead)
            own->ahead->again = cuts == 0 && !raised;
        enum pk_status status = own->step(it, pk_short_force_limit(it, limit));
        if (pk_waits(it))
            return PK_DONE;
        if (status >= 0 && !are_numbers(it))
            status = PK_NOT_FINITE;
        const int pushed = status == PK_STEP_UNDERFLOW && !raised &&
                           pk_scale_raise(it, while_at_rest);
        if (pushed || (status >= 0 && pk_short_force_reject(it))) {
            cuts--;
            raised |= pushed;
            own->h = pushed ? while_at_rest : own->h;
            own->flags &= ~(PK_HAVE_A | PK_HAVE_STEP | PK_HAVE_DENSE);
            continue;
        }
        if (status >= 0)
            status = pk_project_step(it);
        if (status >= 0 && own->project && !are_numbers(it))
            status = PK_NOT_FINITE;
        if (status == PK_STEP_UNDERFLOW && cuts)
            return pk_fail_with(it, PK_NO_PROJECTION, reason);
        if (status == PK_STEP_UNDERFLOW && own->project && pk_project_dependent(it))
            return PK_NO_PROJECTION;
        if (status != PK_NO_PROJECTION || !pk_repeats(it) || cuts == CUTS)
            return status;
        reason = it->reason;
        own->h = (own->next_t - it->t) / 4;
        own->flags &= ~(PK_HAVE_A | PK_HAVE_STEP | PK_HAVE_DENSE);
        it->count.rejections++;
    }
}

enum pk_status pk_integrator_step(struct pk_integrator *it, pk_real limit)
{
    if (!pk_ready(it))
        return it->status < 0 ? it->status : PK_BAD_ARGUMENT; /* init or reset refused the start */
    if (!pk_finite(limit))
        return pk_fail(it, PK_BAD_ARGUMENT, BAD_TIME);
    const pk_real left = limit - it->t;
    if (!(left > 0) && !(left < 0))
        return it->status = PK_DONE;
    if (it->options.stop && it->options.stop(it->options.context)) {
        it->own->ready = 0; /* no step is possible before a reset */
        return it->status = PK_STOPPED_USER;
    }

    if (it->own->ahead && it->own->ahead->many) {
        pk_ahead_all(it);
        return it->status = PK_DONE;
    }

    const int fixed = pk_is_fixed(it->method);
    enum pk_status status = PK_DONE;
    if (!pk_waits(it)) {
        status = pk_step_choose(it, limit, fixed);
        if (status < 0)
            return it->status = status;
        status = pk_singularity_here(it);
        if (status < 0)
            return stop(it, status);
    }
    const int near = it->own->passing.near, due = near && pk_singular_crossing_due(it, limit);
    it->own->passing.seen = 0;
    status = due ? pk_singular_crossing_step(it) : PK_NO_CONVERGENCE;
    const int passes = status != PK_NO_CONVERGENCE;
    it->own->passing.crossed = it->own->passing.crossed && passes;
    if (!passes)
        status = advance(it, near ? pk_singular_crossing_limit(it, limit) : limit);
    if (status >= 0 && pk_waits(it))
        return it->status = PK_DONE;
    if (status >= 0 && !passes && (near || it->own->passing.seen > PK_SEEN))
        status = pk_singular_crossing_judge(it);
    status = status < 0 ? pk_singularity_cause(it, status, fixed) : pk_singularity_step(it);
    if (status < 0)
        return stop(it, status);

    pk_short_force_accept(it);
    pk_commit_step(it);
    pk_step_advance_time(it, fixed);
    pk_scale_step(it);
    if (it->own->crossing && (near || it->own->passing.seen != PK_SEEN))
        pk_singular_crossing_note(it);
    return it->status = status;
}

enum pk_status pk_integrator_to(struct pk_integrator *it, pk_real t_end)
{
    do {
        const enum pk_status status = pk_integrator_step(it, t_end);
        if (status != PK_DONE)
            return status;
    } while (it->t < t_end || it->t > t_end);
    return PK_DONE;
}

enum pk_status pk_integrator_aside(struct pk_integrator *it, struct pk_integrator *side, pk_real t)
{
    const size_t n_q = it->n_q, n = it->n;
    const pk_real lo = pk_min(it->last_t, it->t), hi = pk_max(it->last_t, it->t);
    if (!(t >= lo && t <= hi))
        return pk_fail(it, PK_BAD_ARGUMENT, BAD_DENSE);
    if (it->own->atol && side->own->atol)
        pk_copy(side->own->atol, it->own->atol, pk_scale_size(&it->problem, it->method, n_q, n));
    /* a reset would refuse the start of such a step, where constraint rows are dependent */
    if (it->own->passing.crossed) {
        pk_real *q = pk_state(side, PK_Q), *v = pk_state(side, PK_V);
        pk_singular_crossing_at(it, t, q, v);
        side->t = t;
        return PK_DONE;
    }
    pk_integrator_reset(side, it->last_t, it->own->next, pk_next(it, PK_V));
    side->count.steps = it->count.steps - 1; /* the same noise */
    /* copies the parts of the state that a reset does not set, such as low parts */
    if (side->status >= 0)
        pk_copy(pk_state(side, PK_P), pk_next(it, PK_P),
                pk_state_offset(n_q, n, PK_A) - pk_state_offset(n_q, n, PK_P));
    if (side->status >= 0 && (it->method->traits & PK_ADAPTIVE) &&
        (t < it->last_t || t > it->last_t))
        pk_integrator_set_step(side, pk_abs(t - it->last_t));
    if (side->status >= 0 && pk_integrator_to(side, t) >= 0)
        return PK_DONE;
    it->reason = side->reason;
    return it->status = side->status;
}

void pk_integrator_free(struct pk_integrator *it)
{
    if (!it->own)
        return;
    if (it->method->release)
        it->method->release(it);
    it->own->extra = NULL;
}

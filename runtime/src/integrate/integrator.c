/* The integrator: its memory, its checks, and the loop over steps. A method's step() writes the
 * new state into it->next; here it is checked and only then becomes the state, so a step that
 * fails leaves no trace. How far a step goes: grid.c.
 */
#include <string.h>

#include "../core/project.h"

#define FROM_REST PK_C(1e-3) /* of a span: how far ahead what pushes a body at rest is looked for */

struct pk_options pk_options_default(void)
{
    struct pk_options options = {0};
    options.rtol = PK_F(sqrt)(PK_EPS) * PK_C(0.0625); /* about 1e-9 in double */
    options.atol = PK_ATOL_OF_MOTION;
    return options;
}

size_t pk_integrator_size(const struct pk_problem *problem, const struct pk_method *method)
{
    if (!problem || !problem->system || !method || problem->system->abi != PK_ABI)
        return 0;
    const struct pk_system *system = problem->system;
    const size_t n = pk_system_count(system, problem->params);
    const size_t lane = system->lanes ? 0 : 3 * n + system->n_inputs;
    const size_t inputs = system->n_inputs * (1 + PK_LANES);
    const size_t guards = pk_guard_size(pk_system_guard_count(system, problem->params), n);
    const size_t work = inputs + lane + method->size(method, n) + guards +
                        pk_project_size(system, n) + pk_marks_size(system, n);
    const size_t rest = PK_PARTS * n + work, params = pk_params_reals(system);
    return (pk_quadrature_size(system, n) + pk_scale_size(method, n) + PK_PARTS * n +
            (rest > params ? rest : params)) *
           sizeof(pk_real);
}

/* The system's own for this method, its kernels compiled in, or the method's for any system. */
static enum pk_status (*stepper(const struct pk_system *system, const struct pk_method *method))(
    struct pk_integrator *, pk_real)
{
    for (const struct pk_stepper *s = system->steppers; s && s->method; s++)
        if (strcmp(s->method, method->name) == 0)
            return s->step;
    return method->step;
}

enum pk_status pk_integrator_init(struct pk_integrator *it, const struct pk_problem *problem,
                                  const struct pk_method *method,
                                  const struct pk_options *options, pk_real t0,
                                  const pk_real *q0, const pk_real *v0, void *block,
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
    it->n = system->abi == PK_ABI ? pk_system_count(system, problem->params) : 0;
    if (it->n == 0)
        return pk_fail(it, PK_BAD_ARGUMENT, BAD_SYSTEM);
    if (pk_missing_facts(system, method) || pk_missing_kernel(system, method))
        return pk_fail(it, PK_REFUSED, 0);
    if (system->n_inputs && (method->traits & PK_NO_INPUTS))
        return pk_fail(it, PK_REFUSED, 0);
    if (system->n_quadratures && !method->stage)
        return pk_fail(it, PK_REFUSED, 0);
    if (pk_rolls(system) && (method->traits & PK_HOLONOMIC))
        return pk_fail(it, PK_REFUSED, 0);
    if (pk_check_options(it) < 0)
        return it->status = PK_BAD_ARGUMENT;
    if (block_size < pk_integrator_size(problem, method) || (size_t)block % _Alignof(pk_real))
        return pk_fail(it, PK_BLOCK_TOO_SMALL, 0);

    it->step = stepper(system, method);
    it->quadratures = (pk_real *)block;
    it->state = it->quadratures + pk_quadrature_size(system, it->n);
    if (pk_scale_size(method, it->n)) {
        it->atol = it->state; /* it outlives a reset, as the quadratures do */
        it->state += pk_scale_size(method, it->n);
        memset(it->atol, 0, pk_scale_size(method, it->n) * sizeof *it->atol);
    }
    it->next = it->state + PK_PARTS * it->n;
    it->u = it->next + PK_PARTS * it->n;
    it->lane = it->u + system->n_inputs * (1 + PK_LANES);
    it->work = it->lane + (system->lanes ? 0 : 3 * it->n + system->n_inputs);
    it->n_guards = pk_system_guard_count(system, problem->params);
    it->guards = it->n_guards ? it->work + method->size(method, it->n) : NULL;
    if (pk_project_size(system, it->n))
        it->project = it->work + method->size(method, it->n) + pk_guard_size(it->n_guards, it->n);
    if (system->n_marks)
        it->marks = it->work + method->size(method, it->n) + pk_guard_size(it->n_guards, it->n) +
                    pk_project_size(system, it->n);
    it->q = pk_part(it->state, it->n, PK_Q);
    it->v = pk_part(it->state, it->n, PK_V);
    enum pk_status status = pk_integrator_reset(it, t0, q0, v0);
    if (status >= 0 && system->n_quadratures && (status = pk_quadrature_start(it)) < 0)
        it->ready = 0;
    return it->status = status;
}

enum pk_status pk_integrator_reset(struct pk_integrator *it, pk_real t, const pk_real *q,
                                   const pk_real *v)
{
    const size_t n = it->n;
    it->ready = 0;
    if (!it->state)
        return it->status;
    if (!q || !v)
        return pk_fail(it, PK_BAD_ARGUMENT, BAD_POINTER);
    if (!pk_finite(t))
        return pk_fail(it, PK_BAD_ARGUMENT, BAD_TIME);
    if (!pk_all_finite(q, n) || !pk_all_finite(v, n))
        return pk_fail(it, PK_BAD_ARGUMENT, BAD_STATE);
    /* Steps exchange the two blocks; the check below needs all that lies behind the state. */
    pk_real *const first = it->state < it->next ? it->state : it->next;
    memmove(pk_part(first, n, PK_Q), q, n * sizeof *q);
    memmove(pk_part(first, n, PK_V), v, n * sizeof *v);
    it->state = first;
    it->next = first + PK_PARTS * n;
    it->q = pk_part(first, n, PK_Q);
    it->v = pk_part(first, n, PK_V);
    memset(pk_part(it->state, n, PK_P), 0, (PK_PARTS - PK_P) * n * sizeof *q);
    it->status = pk_check_params(it, it->next); /* all behind the state is free here */
    if (it->status < 0)
        return it->status;
    /* What a method does not carry stays 0, and inputs that nobody fills. */
    memset(it->next, 0,
           (PK_PARTS * n + it->problem.system->n_inputs * (1 + PK_LANES)) * sizeof *q);
    it->t = it->last_t = it->next_t = t;
    it->direction = 0;
    it->trouble = PK_DONE;
    it->event = 0;
    it->marked = it->unlooked = 0;
    it->reach = it->calm = 0;
    it->flags = 0;
    it->h = 0;
    it->status = pk_project_start(it);
    if (it->status >= 0)
        pk_scale_start(it);
    if (it->status >= 0)
        it->status = it->method->init(it);
    pk_guard_start(it);
    it->ready = it->status >= 0;
    return it->status;
}

enum pk_status pk_integrator_set_step(struct pk_integrator *it, pk_real h)
{
    if (!it->ready)
        return it->status < 0 ? it->status : PK_BAD_ARGUMENT;
    if (!(h > 0) || !pk_finite(h))
        return pk_fail(it, PK_BAD_ARGUMENT, BAD_STEP);
    it->options.h = h;
    it->direction = 0; /* the next step starts a grid of its own */
    return it->status = PK_DONE;
}

/* What methods keep of their last step may belong to the one that failed; and where the equations
 * end, no step follows. */
static enum pk_status stop(struct pk_integrator *it, enum pk_status status)
{
    it->flags &= ~(PK_HAVE_A | PK_HAVE_STEP | PK_HAVE_DENSE | PK_HAVE_SERIES);
    if (status == PK_SINGULAR_TIME || status == PK_SINGULAR_COORDINATES)
        it->ready = 0;
    return it->status = status;
}

/* One step of motion and quadratures into it->next, as short as both need it. */
static enum pk_status try_step(struct pk_integrator *it, pk_real limit)
{
    enum pk_status status;
    do {
        status = it->step(it, limit);
        if (status >= 0 && !pk_all_finite(it->next, PK_LOW_Q * it->n))
            status = PK_NOT_FINITE;
        if (status < 0 || !it->z)
            return status;
        status = pk_quadrature_step(it);
    } while (status >= 0 && pk_quadrature_rejects(it));
    return status;
}

/* That, back on the constraints; a step that is too far off is made shorter where the method can, and
 * where it then shrinks to nothing, that is why. */
static enum pk_status advance(struct pk_integrator *it, pk_real limit)
{
    enum { CUTS = 12 };
    size_t where = 0;
    pk_real detail = 0;
    const pk_real while_at_rest = (limit - it->t) * FROM_REST;
    int raised = 0;
    for (int cuts = 0;; cuts++) {
        enum pk_status status = try_step(it, pk_marks_limit(it, limit));
        const int pushed =
            status == PK_STEP_UNDERFLOW && !raised && pk_scale_raise(it, while_at_rest);
        if (pushed || (status >= 0 && pk_marks_reject(it))) {
            cuts--;
            raised |= pushed;
            it->h = pushed ? while_at_rest : it->h;
            it->flags &= ~(PK_HAVE_A | PK_HAVE_STEP | PK_HAVE_DENSE);
            continue;
        }
        if (status >= 0)
            status = pk_project_step(it);
        if (status >= 0 && it->project && !pk_all_finite(it->next, PK_LOW_Q * it->n))
            status = PK_NOT_FINITE;
        if (status == PK_STEP_UNDERFLOW && cuts) {
            it->where = where;
            it->detail = detail;
            return PK_NO_PROJECTION;
        }
        if (status == PK_STEP_UNDERFLOW && it->project && pk_project_dependent(it))
            return PK_NO_PROJECTION;
        if (status != PK_NO_PROJECTION || !it->method->stage_error || cuts == CUTS)
            return status;
        where = it->where;
        detail = it->detail;
        it->h = (it->next_t - it->t) / 4;
        it->flags &= ~(PK_HAVE_A | PK_HAVE_STEP | PK_HAVE_DENSE);
        it->count.rejections++;
    }
}

enum pk_status pk_integrator_step(struct pk_integrator *it, pk_real limit)
{
    const size_t n = it->n;
    if (!it->ready)
        return it->status < 0 ? it->status : PK_BAD_ARGUMENT; /* the refusal of its start stands */
    if (!pk_finite(limit))
        return pk_fail(it, PK_BAD_ARGUMENT, BAD_TIME);
    const pk_real left = limit - it->t;
    if (!(left > 0) && !(left < 0))
        return it->status = PK_DONE;
    if (it->options.stop && it->options.stop(it->options.context)) {
        it->ready = 0; /* what goes on all the same ends at its next step */
        return it->status = PK_STOPPED_USER;
    }

    const int fixed = !(it->method->traits & PK_ADAPTIVE);
    enum pk_status status = pk_step_choose(it, limit, fixed);
    if (status < 0)
        return it->status = status;
    status = pk_guard_here(it);
    if (status < 0)
        return stop(it, status);
    status = advance(it, limit);
    status = status < 0 ? pk_guard_cause(it, status, fixed) : pk_guard_step(it);
    if (status < 0)
        return stop(it, status);

    pk_marks_accept(it);
    pk_real *left_behind = it->state;
    it->state = it->next;
    it->next = left_behind;
    it->q = pk_part(it->state, n, PK_Q);
    it->v = pk_part(it->state, n, PK_V);
    if (it->p)
        it->p = pk_part(it->state, n, PK_P);
    if (it->z)
        pk_quadrature_accept(it);
    pk_step_made(it, fixed);
    pk_scale_step(it);
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
    const size_t n = it->n;
    const pk_real lo = pk_min(it->last_t, it->t), hi = pk_max(it->last_t, it->t);
    if (!(t >= lo && t <= hi))
        return pk_fail(it, PK_BAD_ARGUMENT, BAD_DENSE);
    if (it->atol && side->atol)
        memcpy(side->atol, it->atol, pk_scale_size(it->method, n) * sizeof *it->atol);
    pk_integrator_reset(side, it->last_t, it->next, pk_part(it->next, n, PK_V));
    if (side->status >= 0) { /* what a start lacks of a state amid the motion */
        memcpy(pk_part(side->state, n, PK_P), pk_part(it->next, n, PK_P),
               (PK_A - PK_P) * n * sizeof *it->next);
        pk_quadrature_aside(it, side);
    }
    if (side->status >= 0 && (it->method->traits & PK_ADAPTIVE) && (t < it->last_t || t > it->last_t))
        pk_integrator_set_step(side, pk_abs(t - it->last_t));
    if (side->status >= 0 && pk_integrator_to(side, t) >= 0)
        return PK_DONE;
    it->where = side->where;
    it->detail = side->detail;
    it->condition = side->condition;
    return it->status = side->status;
}

void pk_integrator_free(struct pk_integrator *it)
{
    if (it->method && it->method->release)
        it->method->release(it);
    it->extra = NULL;
}

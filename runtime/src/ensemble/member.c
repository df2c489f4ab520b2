/* One member of an ensemble: its initial state, and its singularities if its steps are made in a
 * lane. In a lane, the member's integrator makes no steps itself: it takes over those of the lane
 * and watches for singularities in them (singularity.c), by the kernels for one state. */
#include <string.h>

#include "ensemble.h"

struct pk_problem pk_ensemble_problem(const struct pk_ensemble *e, size_t member)
{
    struct pk_problem problem = {.system = e->system};
    problem.params = (const char *)e->params + member * e->system->params_size;
    return problem;
}

int pk_ensemble_stopped(const struct pk_ensemble *e)
{
    return e->options.stop && e->options.stop(e->options.context);
}

size_t pk_member_size(const struct pk_ensemble *e)
{
    const struct pk_problem problem = pk_ensemble_problem(e, 0);
    return pk_ensemble_padded(sizeof(struct pk_member)) +
           pk_ensemble_padded(pk_integrator_size(&problem, e->method));
}

size_t pk_member_count(const struct pk_ensemble *e, size_t W)
{
    return e->system->singularities.n ? W : 1;
}

enum pk_status pk_member_begin(const struct pk_ensemble *e, size_t member, struct pk_member *m)
{
    e->done[member] = 0;
    e->last_t[member] = e->t0;
    return pk_member_integrator(e, member, m);
}

enum pk_status pk_member_integrator(const struct pk_ensemble *e, size_t member, struct pk_member *m)
{
    struct pk_problem problem = pk_ensemble_problem(e, member);
    const struct pk_problem first = pk_ensemble_problem(e, 0);
    const size_t n = pk_system_count(e->system, first.params);
    const size_t n_q = pk_system_coordinates(e->system, first.params);
    memset(m, 0, sizeof *m);
    if (pk_system_count(e->system, problem.params) != n ||
        pk_system_coordinates(e->system, problem.params) != n_q)
        return PK_BAD_ARGUMENT;
    if (e->u) {
        m->input.count = e->system->n_inputs;
        m->input.u = e->u + member * m->input.count;
        problem.input = pk_constant_input;
        problem.context = &m->input;
    }
    struct pk_options options = e->options;
    options.member += member;
    return pk_integrator_init(&m->it, &problem, e->method, &options, e->t0, e->q0 + member * n,
                              e->v0 + member * n, (char *)m + pk_ensemble_padded(sizeof *m),
                              pk_integrator_size(&problem, e->method));
}

enum pk_status pk_member_step(struct pk_member *m, const struct pk_integrator *clock,
                              const pk_real *next, size_t W, enum pk_status status)
{
    struct pk_integrator *it = &m->it;
    const enum pk_status here = pk_singularity_here(it);
    if (here < 0)
        return here;
    it->own->h = clock->own->h;
    it->own->next_t = clock->own->next_t;
    it->own->direction = clock->own->direction;
    if (status < 0)
        return pk_singularity_cause(it, status, 1);
    for (size_t i = 0; i < it->n_q + it->n; i++)
        it->own->next[i] = next[i * W];
    PK_TRY(pk_singularity_step(it));
    pk_commit_step(it);
    it->t = it->own->next_t;
    return PK_DONE;
}

/* Makes many fixed steps at once: for a splitting method in one call of the system's
 * families.advance (fused steps), or one by one without the checks of pk_integrator_step(). Steps
 * made one by one give the same bits as pk_integrator_step(). The sums of fused steps are not
 * compensated, so their last bits differ. Fused steps work on a copy of the state: if they end in a
 * state that is not finite, half as many are tried: bisection finds the step that fails. */

#include "../core/internal.h"
#include "../core/tableau.h"

/* Returns how many fixed steps of full length may be made, at most `most`. */
static unsigned long allowed(const struct pk_integrator *it, pk_real limit, unsigned long most)
{
    const unsigned long steps = pk_step_count(it, limit, most);
    const unsigned long left = it->options.max_steps - it->count.steps;
    if (it->options.h <= 10 * PK_EPS * pk_abs(limit))
        return 0;
    return it->options.max_steps && left < steps ? left : steps;
}

/* Makes fused steps and returns their number, or 0 if the system does not allow them: they do not
 * check singularities and constraints between steps, and they advance all of q by v. */
static unsigned long advance(struct pk_integrator *it, pk_real limit, unsigned long most)
{
    struct pk_integrator_private *const own = it->own;
    const struct pk_system *system = it->problem.system;
    const struct pk_splitting *table = pk_splitting_table(it->method);
    const size_t n_q = it->n_q, n = it->n;
    const pk_real h = (pk_real)own->direction * it->options.h;
    if (!system->families.advance || n_q < n || !table || system->n_inputs || own->singularities ||
        own->project)
        return 0;
    unsigned long steps = allowed(it, limit, most);
    pk_real *q = pk_next(it, PK_Q), *v = pk_next(it, PK_V);
    for (;; steps /= 2) {
        if (steps < 2)
            return 0;
        pk_copy(q, it->q, n_q);
        pk_copy(v, it->v, n);
        system->families.advance(it->problem.params, table->stages, table->kick, table->drift,
                                 it->t, h, steps, q, v);
        if (pk_all_finite(q, n_q) && pk_all_finite(v, n))
            break;
    }
    pk_zero(pk_next(it, PK_LOW_Q), n_q + n);
    pk_commit_step(it);
    /* own->flags no longer has PK_HAVE_A: the acceleration of the new state is not known */
    own->flags = 0;
    own->h = h;
    it->last_t = own->grid.anchor + (own->grid.count + (pk_real)steps - 1) * h;
    own->grid.count += (pk_real)steps;
    it->t = own->next_t = own->grid.anchor + own->grid.count * h;
    it->count.steps += steps;
    /* The last kick of a step and the first kick of the next step use the same acceleration. */
    const pk_real *last = table->kick + table->stages;
    const int both = (table->kick[0] > 0 || table->kick[0] < 0) && (*last > 0 || *last < 0);
    it->count.evaluations += steps * (unsigned long)table->stages + (both ? 1 : 0);
    it->status = PK_DONE;
    return steps;
}

/* Makes fixed steps of full length, if no switches, constraints or other checks require
 * pk_integrator_step(). Returns the number of steps. If a step fails, pk_integrator_step() repeats
 * it and reports the failure. */
static unsigned long plain(struct pk_integrator *it, pk_real limit, unsigned long most)
{
    struct pk_integrator_private *const own = it->own;
    const struct pk_system *system = it->problem.system;
    const pk_real h = (pk_real)own->direction * it->options.h;
    if (it->method->traits & PK_ADAPTIVE || own->singularities || own->project || own->crossing ||
        own->ahead || own->atol || system->marks.n || system->switches.n ||
        (it->options.stop && it->options.stop(it->options.context)))
        return 0;
    const unsigned long steps = allowed(it, limit, most);
    unsigned long made = 0;
    own->trouble.status = PK_DONE;
    for (; made < steps; made++) {
        own->h = h;
        own->next_t = own->grid.anchor + (own->grid.count + 1) * h;
        own->grid.off = 0;
        if (own->step(it, limit) < 0 ||
            !pk_all_finite(own->next, pk_state_offset(it->n_q, it->n, PK_LOW_Q))) {
            own->flags &= ~(PK_HAVE_A | PK_HAVE_STEP | PK_HAVE_DENSE);
            break;
        }
        pk_commit_step(it);
        pk_step_advance_time(it, 1);
    }
    return made;
}

static unsigned long many(struct pk_integrator *it, pk_real limit, unsigned long most)
{
    const unsigned long made = advance(it, limit, most);
    return made ? made : plain(it, limit, most);
}

enum pk_status pk_integrator_steps(struct pk_integrator *it, pk_real limit, unsigned long steps)
{
    unsigned long left = steps ? steps : (unsigned long)-1;
    if (pk_ready(it) && it->own->direction &&
        it->own->direction == (limit > it->t) - (limit < it->t))
        left -= many(it, limit, left);
    while (left) {
        /* This first step sets the direction and the grid, and reports any error. */
        const enum pk_status status = pk_integrator_step(it, limit);
        if (status != PK_DONE)
            return status;
        left--;
        if (!(it->t < limit || it->t > limit))
            break;
        if (left)
            left -= many(it, limit, left);
    }
    return PK_DONE;
}

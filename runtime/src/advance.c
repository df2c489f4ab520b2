/* Many steps of a splitting method in one call of the system's own fused code. The state is copied
 * first: steps that end in what is not finite are undone, and half as many are tried, so that the
 * first that fails is found by bisection.
 */
#include <string.h>

#include "internal.h"
#include "tableau.h"

/* Steps of the grid that end before `limit`, at most `most`; the last one is left to
 * pk_integrator_step(), which ends exactly there. */
static unsigned long whole(const struct pk_integrator *it, pk_real limit, unsigned long most)
{
    const pk_real count = pk_abs(limit - it->t) / it->options.h * (1 - 4 * PK_EPS);
    const pk_real ceiling = PK_C(1e9);
    const unsigned long steps = (unsigned long)(count < ceiling ? count : ceiling);
    return steps < most ? steps : most;
}

/* 0 where nothing was done. */
static unsigned long advance(struct pk_integrator *it, pk_real limit, unsigned long most)
{
    const struct pk_system *system = it->problem.system;
    const struct pk_splitting *table = pk_splitting_table(it->method);
    const size_t n = it->n;
    const pk_real h = (pk_real)it->direction * it->options.h;
    if (!system->advance || !table || system->n_inputs)
        return 0;
    unsigned long steps = whole(it, limit, most);
    if (it->options.max_steps && it->options.max_steps - it->count.steps < steps)
        steps = it->options.max_steps - it->count.steps;
    if (it->options.h <= PK_C(10.0) * PK_EPS * pk_abs(limit))
        return 0;

    pk_real *q = pk_part(it->next, n, PK_Q), *v = pk_part(it->next, n, PK_V);
    for (;; steps /= 2) {
        if (steps < 2)
            return 0;
        memcpy(q, it->q, n * sizeof *q);
        memcpy(v, it->v, n * sizeof *v);
        system->advance(it->problem.params, table->stages, table->kick, table->drift, it->t, h,
                        steps, q, v);
        if (pk_all_finite(q, n) && pk_all_finite(v, n))
            break;
    }
    memset(pk_part(it->next, n, PK_P), 0, (PK_PARTS - PK_P) * n * sizeof *q);
    pk_real *before = it->state;
    it->state = it->next;
    it->next = before;
    it->q = q;
    it->v = v;
    it->flags = 0; /* no acceleration of this state */
    it->h = h;
    it->last_t = it->anchor + (it->grid + (pk_real)steps - 1) * h;
    it->grid += (pk_real)steps;
    it->t = it->next_t = it->anchor + it->grid * h;
    it->count.steps += steps;
    it->count.evaluations += steps * (unsigned long)table->stages;
    it->status = PK_DONE;
    return steps;
}

enum pk_status pk_integrator_steps(struct pk_integrator *it, pk_real limit, unsigned long steps)
{
    const unsigned long all = steps ? steps : (unsigned long)-1;
    unsigned long left = all;
    do {
        /* A step sets the direction and the grid, and meets whatever is wrong. */
        const enum pk_status status = pk_integrator_step(it, limit);
        if (status != PK_DONE)
            return status;
        left--;
        if (left && (it->t < limit || it->t > limit))
            left -= advance(it, limit, left);
    } while (left && (it->t < limit || it->t > limit));
    return PK_DONE;
}

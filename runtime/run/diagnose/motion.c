/* Starts the integrator of a motion; see motion.h. */
#include "motion.h"

enum pk_status motion_begin(struct motion *m)
{
    const size_t size = pk_integrator_size(m->problem, m->method);
    pk_integrator_free(&m->it);
    if (!m->block)
        m->block = memory_take(m->memory, size, 1);
    return pk_integrator_init(&m->it, m->problem, m->method, &m->options, m->t, m->q, m->v,
                              m->block, size);
}

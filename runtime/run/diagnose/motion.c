/* Starts the integrator of a motion, and notes how far the motion gets; see motion.h. */
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

void motion_note(pk_real *most, const struct settings *s, const struct pk_integrator *it)
{
    const size_t n = s->n, seen = settings_coordinates(s);
    for (size_t i = 0; i < 2 * n; i++) {
        if (i >= seen && i < n)
            continue;
        const pk_real x = i < n ? it->q[i] - s->q[i] : it->v[i - n] - s->v[i - n];
        most[i] = PK_F(fmax)(most[i], PK_F(fabs)(x));
    }
}

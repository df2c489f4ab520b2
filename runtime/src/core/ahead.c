/* Steps that were made ahead, taken: see pk/step/ahead.h. */
#include "internal.h"

static void copy(const struct pk_ahead *a, pk_real *to, const pk_real *from, size_t count)
{
    for (size_t i = 0; i < count; i++)
        to[i] = from[i * a->lanes];
}

/* Momenta are of methods that have no lanes. */
void pk_ahead_take(struct pk_integrator *it, int part, int parts)
{
    const struct pk_ahead *a = it->own->ahead;
    const size_t first = (size_t)part * it->n;
    copy(a, it->own->next + first, a->next + first * a->lanes, (size_t)parts * it->n);
}

void pk_ahead_slopes(struct pk_integrator *it, pk_real *to, int stages)
{
    copy(it->own->ahead, to, it->own->ahead->slopes, (size_t)stages * 2 * it->n);
}

/* Takes steps that were computed in advance in SIMD lanes; see pk/step/ahead.h. */
#include "internal.h"

static void copy(const struct pk_ahead *a, pk_real *to, const pk_real *from, size_t count)
{
    for (size_t i = 0; i < count; i++)
        to[i] = from[i * a->lanes];
}

/* Takes all of the fixed steps that a lane made at once; they count as one last step to it->t. */
void pk_ahead_all(struct pk_integrator *it)
{
    struct pk_ahead *a = it->own->ahead;
    pk_ahead_take(it, PK_Q, 2);
    pk_ahead_take(it, PK_LOW_Q, PK_PARTS - PK_LOW_Q);
    pk_commit_step(it);
    it->own->h = a->h;
    it->own->grid.off = 0;
    it->last_t = it->t;
    it->t = it->own->next_t = a->end;
    it->own->progress.passed += pk_abs(it->t - it->last_t);
    it->own->grid.count += (pk_real)a->many;
    it->count.steps += a->many;
    it->count.evaluations += a->many * a->cost;
    a->many = 0;
    a->taken = 1;
    it->event = 0;
}

/* Methods with momenta have no lanes. */
void pk_ahead_take(struct pk_integrator *it, int part, int parts)
{
    const struct pk_ahead *a = it->own->ahead;
    const size_t first = pk_state_offset(it->n_q, it->n, part);
    const size_t count = pk_state_offset(it->n_q, it->n, part + parts) - first;
    copy(a, it->own->next + first, a->next + first * a->lanes, count);
}

void pk_ahead_slopes(struct pk_integrator *it, pk_real *to, int stages)
{
    const struct pk_ahead *a = it->own->ahead;
    const size_t n_q = it->n_q, n = it->n;
    /* the slopes of a lane are laid out as in pk_block_reals() */
    for (size_t i = 0; i < (size_t)stages; i++, to += n_q + n) {
        copy(a, to, a->slopes + 2 * i * n * a->lanes, n_q);
        copy(a, to + n_q, a->slopes + (2 * i + 1) * n * a->lanes, n);
    }
}

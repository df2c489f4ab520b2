/* Splitting methods for separable systems, M constant and a = a(q, t), or nearly separable ones
 * (src/explicit/linear_drag.c): compositions of
 *
 *     kick   v += kappa h a(q, t)          drift   q += delta h v,  t += delta h
 *
 * Time advances in the drift, like a coordinate, so the time of a kick is that of its q, and the
 * order is the same for driven systems. The last acceleration of a step is the first of the next
 * step. Sums are compensated. Uses the macros of pk/inlined.h.
 *
 * References: E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration, 2nd ed. ("GNI"),
 * I.1, II.4; L. Verlet, Phys. Rev. 159 (1967) 98; H. Yoshida, Phys. Lett. A 150 (1990) 262. */
#include <pk/step/tables.h>

#ifndef PK_WITHOUT_RUNTIME
PK_BEGIN
enum pk_status pk_linear_drag_step(struct pk_integrator *it, const struct pk_splitting *table);
PK_END
#endif

static PK_INLINE enum pk_status PK_STEPPER(splitting)(struct pk_integrator *it,
                                                      const struct pk_splitting *table)
{
#ifndef PK_WITHOUT_RUNTIME
    if (!(it->problem.system->facts & PK_SEPARABLE))
        return pk_linear_drag_step(it, table);
#endif
    const size_t n_q = PK_STEPPER_COORDINATES(it), n = PK_STEPPER_N(it);
    const pk_real h = it->own->h, *from = it->own->state, *a = from + pk_state_offset(n_q, n, PK_A);
    pk_real *to = it->own->next, *a1 = pk_part(to, n_q, n, PK_A);
    pk_real done = 0; /* sum of the drifts made so far, as a fraction of the step */
    const int s = table->stages, ends = table->kick[s] > 0 || table->kick[s] < 0;

#ifndef PK_WITHOUT_RUNTIME
    if (pk_is_ahead(it, h)) { /* the step was computed in a lane: its state is copied */
        pk_ahead_take(it, PK_Q, 2);
        pk_ahead_take(it, PK_LOW_Q, ends ? 3 : 2);
        it->count.evaluations += (unsigned long)s;
        return PK_DONE;
    }
#endif
    PK_UNROLL_FEW
    for (int i = 0; i < s; i++) {
        if (i > 0 || !(it->own->flags & PK_HAVE_A)) {
            PK_TRY(PK_STEPPER(acceleration)(it, it->t + done * h, from, from + n_q, a1));
            a = a1;
        }
        pk_kick_drift(n_q, n, table->kick[i] * h, a, table->drift[i] * h, from, to);
        done += table->drift[i];
        from = to;
    }
    if (ends) {
        PK_TRY(PK_STEPPER(acceleration)(it, it->own->next_t, to, to + n_q, a1));
        pk_kick(n_q, n, table->kick[s] * h, a1, to);
    }
    /* The last acceleration belongs to the new state: its failure leaves the old one valid. */
    if (pk_all_finite(to, n_q + n))
        it->own->flags = ends ? it->own->flags | PK_HAVE_A : it->own->flags & ~PK_HAVE_A;
    return PK_DONE;
}

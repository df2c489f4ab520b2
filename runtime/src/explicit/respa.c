/* Impulse multiple time stepping, r-RESPA, for separable systems some of whose forces are declared
 * fast, a = a_fast(q, t) + a_slow(q, t): half a kick by a_slow, short Verlet steps by a_fast alone,
 * half a kick by a_slow,
 *
 *     v += h/2 a_slow,    `inner` steps of Verlet of h/inner,    v += h/2 a_slow.
 *
 * All forces are evaluated once a step, the fast forces also in each inner step; both are counted.
 * The method is symplectic and symmetric for any splitting of V; it is efficient if the fast part
 * is stiff and cheap. Resonant kicks excite a fast oscillation: near h omega = pi, 2 pi, ... steps
 * amplify, however short the inner steps are. Inner steps are no longer than options.h_max; if
 * h_max is 0, there are 10 inner steps (TEN). In compositions of such steps, their lengths, as
 * fractions of the whole step, are the drifts in the table of a splitting method.
 *
 * References: M. Tuckerman, B. J. Berne, G. J. Martyna, J. Chem. Phys. 97 (1992) 1990; H.
 * Grubmueller et al., Mol. Simul. 6 (1991) 121; GNI VIII.4; on the resonance J. J. Biesiadecki, R.
 * D. Skeel, J. Comput. Phys. 109 (1993) 318. */
#include <pk/step/tables.h>

#include "../core/generic.h"
#include "../core/tableau.h"

enum { TEN = 10 };

struct work {
    pk_real *fast, *slow;
};

static size_t respa_size(const struct pk_method *method, const struct pk_problem *problem, size_t n)
{
    (void)method, (void)problem;
    return 2 * n; /* of struct work */
}

static void evaluate_fast(struct pk_integrator *it, const struct work *w, pk_real t,
                          const pk_real *z)
{
    const pk_real *u = pk_eval_input(it, t);
    it->problem.system->fast(it->problem.params, t, z, z + it->n_q, u, w->fast);
    it->count.evaluations++;
}

/* Computes w->slow, the slow part of the acceleration, at the state z = (q, v) and time t: the
 * whole acceleration `a` less w->fast. If `a` is NULL, it is evaluated. */
static enum pk_status evaluate_slow(struct pk_integrator *it, const struct work *w, pk_real t,
                                    const pk_real *z, const pk_real *a)
{
    pk_real *own = pk_next(it, PK_A);
    if (!a)
        PK_TRY(pk_eval_acceleration(it, t, z, z + it->n_q, own));
    for (size_t i = 0; i < it->n; i++)
        w->slow[i] = (a ? a : own)[i] - w->fast[i];
    return PK_DONE;
}

static enum pk_status respa_step(struct pk_integrator *it, pk_real limit)
{
    struct pk_integrator_private *const own = it->own;
    const struct pk_splitting *table = (const struct pk_splitting *)it->method->table;
    const size_t n_q = it->n_q, n = it->n;
    const pk_real *from = own->state;
    pk_real *to = own->next, t = it->t;
    const struct work w = {own->work, own->work + n};
    (void)limit;
    evaluate_fast(it, &w, t, from);
    PK_TRY(evaluate_slow(it, &w, t, from, own->flags & PK_HAVE_A ? pk_state(it, PK_A) : NULL));
    for (int i = 0; i < table->stages; i++) {
        const pk_real h = table->drift[i] * own->h, most = it->options.h_max;
        const pk_real many = most > 0 ? PK_F(ceil)(pk_abs(h) / most * (1 - 8 * PK_EPS)) : TEN;
        const pk_real part = h / pk_max(many, 1), t0 = t;
        pk_kick_drift(n_q, n, h / 2, w.slow, 0, from, to);
        for (pk_real k = 1; k <= pk_max(many, 1); k++) {
            pk_kick_drift(n_q, n, part / 2, w.fast, part, to, to);
            t = t0 + k * part;
            evaluate_fast(it, &w, t, to);
            pk_kick(n_q, n, part / 2, w.fast, to);
        }
        PK_TRY(evaluate_slow(it, &w, t, to, NULL));
        pk_kick(n_q, n, h / 2, w.slow, to);
        from = to;
    }
    if (pk_all_finite(to, n_q + n))
        own->flags |= PK_HAVE_A;
    return PK_DONE;
}

#define RESPA(of) \
    .needs = PK_NEEDS_RESPA, .table = &pk_##of##_table, .size = respa_size, .step = respa_step
PK_METHODS_RESPA(PK_DEFINE_METHOD, RESPA)

/* Boris's splitting, for forces affine in the rates, M a = g(q, t) + C(q, t) v, such as magnetic
 * ones: a drift over half the step, a kick of v by the implicit midpoint rule, and a second drift
 * over half the step. The kick
 *
 *     (M - h/2 C) (v' - v) = h M a(q, t, v),
 *
 * is linear in v'. If C is antisymmetric, the kick rotates v (Cayley transform of h M^-1 C) and
 * conserves T if g is 0, and the step conserves volume. It is symplectic only if C is constant, and
 * then only after a change of v. With a drag of any strength, rates decay as they should. In
 * compositions of such steps, their lengths, as fractions of the whole step, are the drifts in the
 * table of a splitting method.
 *
 * References: J. P. Boris, Proc. 4th Conf. Num. Sim. Plasmas (1970) 3; H. Qin et al., Phys. Plasmas
 * 20 (2013) 084503; E. Hairer, C. Lubich, BIT 58 (2018) 969. */

#include <pk/step/tables.h>

#include "../core/generic.h"
#include "../core/tableau.h"

struct work {
    pk_real *a, *M, *r_q, *r_v, *r_t, *pivot, *d;
};

static size_t lay_out(struct work *w, size_t n, pk_real *base)
{
    const struct pk_slot slots[] = {{&w->a, n},       {&w->M, n * n}, {&w->r_q, n * n},
                                    {&w->r_v, n * n}, {&w->r_t, n},   {&w->pivot, n},
                                    {&w->d, n}};
    return PK_LAY_OUT(base, slots);
}

static size_t boris_size(const struct pk_method *method, const struct pk_problem *problem, size_t n)
{
    struct work w;
    (void)method, (void)problem;
    return lay_out(&w, n, NULL);
}

/* Computes the kick of v in place, at (t, q). */
static enum pk_status kick(struct pk_integrator *it, const struct work *w, pk_real t, pk_real h,
                           pk_real *to)
{
    const struct pk_system *system = it->problem.system;
    const size_t n_q = it->n_q, n = it->n;
    const pk_real *q = to, *v = to + n_q;
    PK_TRY(pk_eval_acceleration(it, t, q, v, w->a));
    system->mass(it->problem.params, t, q, v, it->own->u, w->M);
    system->linear(it->problem.params, t, q, v, it->own->u, w->a, w->r_q, w->r_v, w->r_t);
    pk_zero(w->d, n);
    pk_add_product(w->d, w->M, w->a, n);
    for (size_t i = 0; i < n * n; i++)
        w->M[i] -= h / 2 * w->r_v[i];
    it->count.factorisations++;
    if (!pk_lu_factor(w->M, w->pivot, n))
        return PK_NOT_FINITE;
    pk_lu_solve(w->M, w->pivot, n, w->d);
    pk_kick(n_q, n, h, w->d, to);
    return PK_DONE;
}

static enum pk_status boris_step(struct pk_integrator *it, pk_real limit)
{
    const struct pk_splitting *table = (const struct pk_splitting *)it->method->table;
    const size_t n_q = it->n_q, n = it->n;
    const pk_real h = it->own->h, *from = it->own->state;
    pk_real *to = it->own->next, done = 0;
    struct work w;
    (void)limit;
    lay_out(&w, n, it->own->work);
    pk_zero(w.a, n);
    for (int i = 0; i < table->stages; i++) {
        const pk_real part = table->drift[i];
        pk_kick_drift(n_q, n, 0, w.a, part / 2 * h, from, to);
        PK_TRY(kick(it, &w, it->t + (done + part / 2) * h, part * h, to));
        pk_kick_drift(n_q, n, 0, w.a, part / 2 * h, to, to);
        done += part;
        from = to;
    }
    return PK_DONE;
}

#define BORIS(of) \
    .needs = PK_NEEDS_BORIS, .table = &pk_##of##_table, .size = boris_size, .step = boris_step
PK_METHODS_BORIS(PK_DEFINE_METHOD, BORIS)

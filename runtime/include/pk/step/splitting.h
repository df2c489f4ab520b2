/* Splitting methods for separable systems, M constant and a = a(q, t): compositions of
 *
 *     kick   v += kappa h a(q, t)          drift   q += delta h v,  t += delta h
 *
 * Time moves with the drift, as a coordinate of its own would, so a kick sees the time that
 * belongs to its q and the order holds for driven systems too. The last acceleration of a step
 * is the first of the next. Sums are compensated. Written over the macros of pk/inlined.h.
 *
 * References: E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration, 2nd ed. ("GNI"),
 * I.1, II.4; L. Verlet, Phys. Rev. 159 (1967) 98; H. Yoshida, Phys. Lett. A 150 (1990) 262.
 */
#ifndef PK_STEP_SPLITTING_H
#define PK_STEP_SPLITTING_H

#include <pk/step/tableau.h>

static const pk_real pk_symplectic_euler_kick[] = {PK_C(1.0), PK_C(0.0)};
static const pk_real pk_symplectic_euler_drift[] = {PK_C(1.0)};
static const pk_real pk_verlet_kick[] = {PK_C(0.5), PK_C(0.5)};
static const pk_real pk_verlet_drift[] = {PK_C(1.0)};
/* Triple jump: w1 = 1/(2 - 2^(1/3)), w0 = 1 - 2 w1; kicks w1/2, (w1 + w0)/2, .... */
static const pk_real pk_yoshida4_kick[] = {
    PK_C(0.675603595979828817023843904485730413), PK_C(-0.175603595979828817023843904485730413),
    PK_C(-0.175603595979828817023843904485730413), PK_C(0.675603595979828817023843904485730413)};
static const pk_real pk_yoshida4_drift[] = {PK_C(1.35120719195965763404768780897146083),
                                            PK_C(-1.70241438391931526809537561794292165),
                                            PK_C(1.35120719195965763404768780897146083)};

static const struct pk_splitting pk_symplectic_euler_table = {1, pk_symplectic_euler_kick,
                                                              pk_symplectic_euler_drift};
static const struct pk_splitting pk_verlet_table = {1, pk_verlet_kick, pk_verlet_drift};
static const struct pk_splitting pk_yoshida4_table = {3, pk_yoshida4_kick, pk_yoshida4_drift};

#define PK_SPLITTING_METHODS(X) X(symplectic_euler) X(verlet) X(yoshida4)
#endif

static PK_FORCE_INLINE enum pk_status PK_STEPPER(splitting)(struct pk_integrator *it,
                                                            const struct pk_splitting *table)
{
    const size_t n = PK_STEPPER_N(it);
    const pk_real h = it->h;
    const pk_real *q0 = it->state, *v0 = pk_part(it->state, n, PK_V);
    const pk_real *low_q0 = pk_part(it->state, n, PK_LOW_Q);
    const pk_real *low_v0 = pk_part(it->state, n, PK_LOW_X);
    const pk_real *a0 = pk_part(it->state, n, PK_A);
    pk_real *q = it->next, *v = pk_part(it->next, n, PK_V), *a = pk_part(it->next, n, PK_A);
    pk_real *low_q = pk_part(it->next, n, PK_LOW_Q), *low_v = pk_part(it->next, n, PK_LOW_X);
    pk_real done = 0; /* fraction of the step drifted so far */
    int have_a = it->flags & PK_HAVE_A;

    for (size_t k = 0; k < n; k++) {
        q[k] = q0[k];
        v[k] = v0[k];
        low_q[k] = low_q0[k];
        low_v[k] = low_v0[k];
        a[k] = a0[k];
    }
    PK_UNROLL
    for (int i = 0; i <= table->stages; i++) {
        const pk_real kappa = table->kick[i] * h;
        if (table->kick[i] > 0 || table->kick[i] < 0) {
            if (!have_a) {
                const pk_real t = i == table->stages ? it->next_t : it->t + done * h;
                const enum pk_status status = PK_STEPPER(acceleration)(it, t, q, v, a);
                if (status < 0)
                    return status;
            }
            for (size_t k = 0; k < n; k++)
                v[k] = pk_sum(v[k], kappa * a[k], &low_v[k]);
            have_a = 1;
        }
        if (i < table->stages) {
            const pk_real delta = table->drift[i] * h;
            for (size_t k = 0; k < n; k++)
                q[k] = pk_sum(q[k], delta * v[k], &low_q[k]);
            done += table->drift[i];
            have_a = 0;
        }
    }
    /* The cached acceleration travels with the state, so a failure here cannot spoil it. */
    if (pk_all_finite(q, n) && pk_all_finite(v, n))
        it->flags = have_a ? it->flags | PK_HAVE_A : it->flags & ~PK_HAVE_A;
    return PK_DONE;
}

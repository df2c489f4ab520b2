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

/* v += kappa a and then q += delta v, from one place to another, each number once: sums wait for
 * one another less than passes would. */
static PK_FORCE_INLINE void PK_STEPPER(kick_drift)(size_t n, pk_real kappa, const pk_real *a,
                                                   pk_real delta, const pk_real *from, pk_real *to)
{
    for (size_t k = 0; k < n; k++) {
        pk_real low_v = from[PK_LOW_X * n + k], low_q = from[PK_LOW_Q * n + k];
        const pk_real v = pk_sum(from[PK_V * n + k], kappa * a[k], &low_v);
        to[PK_Q * n + k] = pk_sum(from[PK_Q * n + k], delta * v, &low_q);
        to[PK_V * n + k] = v;
        to[PK_LOW_X * n + k] = low_v;
        to[PK_LOW_Q * n + k] = low_q;
    }
}

/* v += kappa a alone: the end of a step. */
static PK_FORCE_INLINE void PK_STEPPER(kick)(size_t n, pk_real kappa, const pk_real *a, pk_real *to)
{
    for (size_t k = 0; k < n; k++)
        to[PK_V * n + k] =
            pk_sum(to[PK_V * n + k], kappa * a[k], &to[PK_LOW_X * n + k]);
}

static PK_FORCE_INLINE enum pk_status PK_STEPPER(splitting)(struct pk_integrator *it,
                                                            const struct pk_splitting *table)
{
    const size_t n = PK_STEPPER_N(it);
    const pk_real h = it->h, *from = it->state, *a = from + PK_A * n;
    pk_real *to = it->next, *a1 = to + PK_A * n;
    pk_real done = 0; /* fraction of the step drifted so far */
    const int s = table->stages, ends = table->kick[s] > 0 || table->kick[s] < 0;
    enum pk_status status;

    PK_UNROLL
    for (int i = 0; i < s; i++) {
        if (i > 0 || !(it->flags & PK_HAVE_A)) {
            status = PK_STEPPER(acceleration)(it, it->t + done * h, from, from + n, a1);
            if (status < 0)
                return status;
            a = a1;
        }
        PK_STEPPER(kick_drift)(n, table->kick[i] * h, a, table->drift[i] * h, from, to);
        done += table->drift[i];
        from = to;
    }
    if (ends) {
        status = PK_STEPPER(acceleration)(it, it->next_t, to, to + n, a1);
        if (status < 0)
            return status;
        PK_STEPPER(kick)(n, table->kick[s] * h, a1, to);
    }
    /* The last acceleration travels with the state, so a failure here cannot spoil it. */
    if (pk_all_finite(to, 2 * n))
        it->flags = ends ? it->flags | PK_HAVE_A : it->flags & ~PK_HAVE_A;
    return PK_DONE;
}

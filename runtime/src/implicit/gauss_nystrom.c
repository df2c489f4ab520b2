/* gauss8 for constant M and f that depends only on q and t. Then p = M v + constant, so the same
 * method in (q, q') is also symplectic, and its 8 stages are the SIMD lanes of one kernel. With
 *
 *     L_j = h b_j a_j,  V_i = v0 + sum mu_ij L_j,  P_j = h b_j V_j,  Q_i = q0 + sum mu_ij P_j
 *
 * (each product h b_j V_j is rounded once: rounded products mu_ij mu_jk, as the adaptive method uses, would break b_i a_ij + b_j
 * a_ji = b_i b_j by round-off that is the same in each step). The fixed-point iteration ends when
 * corrections no longer decrease: the remaining error is then random. If it does not converge,
 * Newton's iteration takes over; see newton.c.
 *
 * Reference: M. Antonana, J. Makazaga, A. Murua, Numer. Algorithms 76 (2017) 861, 3.3 for the end
 * of the iteration. */
#include <string.h>

#include "gauss.h"
#include "../core/generic.h"

#include <pk/step/gauss_stages.h>

static void stages(struct pk_integrator *it, const struct pk_gauss_lanes *w,
                   const struct pk_gauss_work *of, pk_real *L, pk_real *P)
{
    for (size_t i = 0; i < it->n; i++) {
        const pk_real low_v = pk_state(it, PK_LOW_X)[i];
        const pk_real *a = w->a + i * PK_GAUSS_S;
        pk_real *v = w->v + i * PK_GAUSS_S;
        pk_real dv[PK_GAUSS_S], dq[PK_GAUSS_S], l[PK_GAUSS_S], p[PK_GAUSS_S];
        for (int j = 0; j < PK_GAUSS_S; j++)
            l[j] = of->hb[j] * a[j];
        pk_gauss_rows(of->mu_columns, l, dv);
        for (int j = 0; j < PK_GAUSS_S; j++) {
            v[j] = it->v[i] + (low_v + dv[j]);
            p[j] = of->hb[j] * v[j];
        }
        L[i] = pk_gauss_sum(l);
        if (i >= it->n_q)
            continue;
        const pk_real low_q = pk_state(it, PK_LOW_Q)[i];
        pk_real *q = w->q + i * PK_GAUSS_S;
        pk_gauss_rows(of->mu_columns, p, dq);
        for (int j = 0; j < PK_GAUSS_S; j++)
            q[j] = it->q[i] + (low_q + dq[j]);
        P[i] = pk_gauss_sum(p);
    }
}

/* Replaces the stage accelerations a by the new ones. Returns the largest relative correction: for
 * each coordinate, its largest correction is divided by its largest new a. */
static pk_real take_over(const struct pk_gauss_lanes *w, size_t n)
{
    pk_real worst = 0;
    for (size_t i = 0; i < n; i++) {
        pk_real change = 0, size = PK_TINY;
        for (size_t j = i * PK_GAUSS_S; j < (i + 1) * PK_GAUSS_S; j++) {
            const pk_real d = pk_abs(w->next_a[j] - w->a[j]);
            if (!(d <= change)) /* written so that a NaN is not lost */
                change = d;
            size = pk_max(size, pk_abs(w->next_a[j]));
            w->a[j] = w->next_a[j];
        }
        if (!(change / size <= worst))
            worst = change / size;
        if (!pk_finite(change))
            return change - change;
    }
    return worst;
}

enum pk_status pk_gauss_nystrom_step(struct pk_integrator *it, const struct pk_gauss_work *of)
{
    const size_t n = it->n;
    const struct pk_gauss_lanes w = pk_gauss_lanes(it, it->n_q, n, of->rest);
    pk_real *v = pk_next(it, PK_V), *q = pk_next(it, PK_Q);
    pk_real *L = pk_next(it, PK_LOW_X), *P = pk_next(it, PK_LOW_Q);
    pk_real least = 1, before = 0;
    int idle = 0;
    struct pk_gauss_trial y;
    y.h = it->own->h;
    for (int l = 0; l < PK_GAUSS_S; l++)
        y.t[l] = it->t + y.h * pk_gauss8_c[l];
    PK_TRY(generic_gauss_predict(it, &w, &y));
    for (int count = 0;; count++) {
        stages(it, &w, of, L, P);
        PK_TRY(generic_gauss_evaluate(it, y.t, w.q, w.v, w.u, w.next_a));
        const pk_real change = take_over(&w, n);
        if (!pk_finite(change))
            return PK_NO_CONVERGENCE; /* Newton's iteration will report a NaN */
        if (change > PK_GAUSS_FAR && count && change > PK_GAUSS_FAST * before) {
            /* The iteration does not contract: Newton's iteration certifies the branch. */
            return pk_fail_with(it, PK_NO_CONVERGENCE, PK_WHY(.value = change));
        }
        before = change;
        idle = change < least ? 0 : idle + 1;
        least = pk_min(least, change);
        /* Corrections of a slow iteration oscillate, since its eigenvalues are complex. */
        if (!(change > 0) || (idle > (least <= 16 * PK_EPS ? 1 : 5) && least <= PK_GAUSS_ROUND))
            break;
        if (idle > 9 || count > 200)
            return pk_fail_with(it, PK_NO_CONVERGENCE, PK_WHY(.value = least));
    }
    stages(it, &w, of, L, P);
    for (size_t i = 0; i < n; i++) {
        const pk_real dv = L[i];
        L[i] = pk_state(it, PK_LOW_X)[i];
        v[i] = pk_sum(it->v[i], dv, &L[i]);
        pk_gauss_rows(w.M->taylor, w.a + i * PK_GAUSS_S, w.poly + i * PK_GAUSS_S);
    }
    for (size_t i = 0; i < it->n_q; i++) {
        const pk_real dq = P[i];
        P[i] = pk_state(it, PK_LOW_Q)[i];
        q[i] = pk_sum(it->q[i], dq, &P[i]);
    }
    *w.h = y.h;
    *w.rate = 0;
    pk_eval_canonical(it, it->own->next_t, q, v, pk_next(it, PK_P), w.weight);
    it->own->flags |= PK_HAVE_STEP;
    return PK_DONE;
}

/* The equations of a variational step (variational.c) as residuals r(V) of rates V at its
 * middle. */

#include "variational.h"

void pk_variational_reach(struct pk_variational_work *w)
{
    const size_t n = w->n;
    const pk_real *q = pk_variational_to(w, PK_Q), *v = pk_variational_to(w, PK_V), half = w->h / 2;
    pk_copy(w->q_end, q, w->rotation);
    pk_copy(w->q_at, q, w->rotation);
    pk_copy(w->v_end, w->V, w->m);
    pk_copy(w->v_at, w->V, w->m);
    pk_copy(w->low_q, pk_variational_to(w, PK_LOW_Q), w->rotation);
    pk_copy(w->low_v, pk_variational_to(w, PK_LOW_X), n);
    for (size_t k = 0; k < w->rotation; k++) {
        w->q_end[k] = pk_sum(q[k], w->h * w->V[k], &w->low_q[k]);
        w->q_at[k] += half * w->V[k];
    }
    for (size_t r = 0; r < w->turned; r++) {
        const struct pk_turning at = pk_variational_turning(w, r);
        pk_real Q[4], omega[3], y[3], added[4], middle[4];
        pk_gather(Q, v + at.number, 4, at.step);
        pk_gather(omega, w->V + at.rate, 3, at.step);
        pk_variational_y(w, omega, y);
        const pk_real yy = pk_dot3(y, y), weight = 2 / (1 + yy);
        const pk_real u[3] = {weight * y[0], weight * y[1], weight * y[2]};
        pk_quaternion_times(Q, -weight * yy, u, added);
        pk_quaternion_times(Q, 1, y, middle);
        for (size_t i = 0; i < 4; i++) {
            const size_t k = at.number + i * at.step;
            w->v_end[k] = pk_sum(Q[i], added[i], &w->low_v[k]);
            w->v_at[k] = middle[i] / PK_F(sqrt)(1 + yy);
        }
    }
    for (size_t k = w->states; k < n; k++) {
        w->v_end[k] = pk_sum(v[k], w->h * w->V[k], &w->low_v[k]);
        w->v_at[k] = v[k] + half * w->V[k];
    }
}

int pk_variational_evaluate(struct pk_integrator *it, struct pk_variational_work *w)
{
    const size_t n = w->n;
    pk_variational_reach(w);
    if (!w->table->ends) {
        pk_variational_momenta(it, w->t + w->h / 2, w->q_at, w->v_at, w->p, w->f);
        return pk_all_finite(w->p, n) && pk_all_finite(w->f, n);
    }
    pk_copy(w->v_at + w->m, pk_variational_to(w, PK_V) + w->m, n - w->m);
    pk_variational_momenta(it, w->t, pk_variational_to(w, PK_Q), w->v_at, w->p, w->f);
    pk_variational_momenta(it, w->end, w->q_end, w->v_end, w->p_end, w->f_end);
    return pk_all_finite(w->p, n) && pk_all_finite(w->f, n) && pk_all_finite(w->p_end, n) &&
           pk_all_finite(w->f_end, n);
}

/* Returns component k of p0 plus the kick. */
static pk_real start(const struct pk_variational_work *w, size_t k)
{
    return pk_variational_to(w, PK_P)[k] + w->pull[k];
}

void pk_variational_residual(const struct pk_variational_work *w, pk_real *out)
{
    const int ends = w->table->ends;
    const pk_real half = w->h / 2;
    for (size_t k = 0; k < w->rotation; k++) {
        const pk_real p = ends ? (w->p[k] + w->p_end[k]) / 2 : w->p[k];
        out[k] = (p - start(w, k)) - half * w->f[k];
    }
    for (size_t r = 0; r < w->turned; r++) {
        const struct pk_turning at = pk_variational_turning(w, r);
        pk_real omega[3], y[3], Pi[3], G[3], P[3], across[3];
        pk_gather(omega, w->V + at.rate, 3, at.step);
        pk_gather(Pi, w->p + at.rate, 3, at.step);
        pk_variational_y(w, omega, y);
        pk_cross(Pi, omega, G);
        for (size_t i = 0; i < 3; i++) {
            const size_t k = at.rate + i * at.step;
            G[i] = w->f[k] - G[i];
            P[i] = start(w, k) + (ends ? half * G[i] : 0);
            Pi[i] = ends ? (Pi[i] + w->p_end[k]) / 2 : Pi[i];
        }
        pk_cayley_turn(y, -1, P, P);
        pk_cross(y, G, across);
        for (size_t i = 0; i < 3; i++) {
            const pk_real torque = ends ? 0 : half * (G[i] - across[i]);
            out[at.rate + i * at.step] = (Pi[i] - P[i]) + pk_dot3(y, y) * Pi[i] - torque;
        }
    }
    for (size_t k = w->m; k < w->n; k++)
        out[k] = k < w->states ? 0 : w->V[k] - (ends ? (w->f[k] + w->f_end[k]) / 2 : w->f[k]);
}

/* The equations of a variational step as residuals, r(V) of the rates V at its middle; they stand
 * in variational.c.
 */
#include <string.h>

#include "variational.h"

/* The end of the step by V, and its middle. */
void pk_variational_reach(struct pk_variational_work *w)
{
    const size_t n = w->n;
    const pk_real *q = pk_part(w->to, n, PK_Q), *v = pk_part(w->to, n, PK_V), half = w->h / 2;
    memcpy(w->q_end, q, n * sizeof *q);
    memcpy(w->q_at, q, n * sizeof *q);
    memcpy(w->v_end, w->V, w->m * sizeof *q);
    memcpy(w->v_at, w->V, w->m * sizeof *q);
    memcpy(w->low_q, pk_part(w->to, n, PK_LOW_Q), n * sizeof *q);
    memcpy(w->low_v, pk_part(w->to, n, PK_LOW_X), n * sizeof *q);
    for (size_t k = 0; k < w->rotation; k++) {
        w->q_end[k] = pk_sum(q[k], w->h * w->V[k], &w->low_q[k]);
        w->q_at[k] += half * w->V[k];
    }
    for (size_t r = 0; r < w->turned; r++) {
        const size_t at = w->m + 4 * r;
        const pk_real *omega = w->V + w->rotation + 3 * r;
        const pk_real y[3] = {w->h * omega[0] / 4, w->h * omega[1] / 4, w->h * omega[2] / 4};
        const pk_real yy = pk_dot3(y, y), weight = 2 / (1 + yy);
        const pk_real u[3] = {weight * y[0], weight * y[1], weight * y[2]};
        pk_real added[4];
        pk_quaternion_times(v + at, -weight * yy, u, added);
        for (size_t i = 0; i < 4; i++)
            w->v_end[at + i] = pk_sum(v[at + i], added[i], &w->low_v[at + i]);
        pk_quaternion_times(v + at, 1, y, w->v_at + at);
        for (size_t i = 0; i < 4; i++)
            w->v_at[at + i] /= PK_F(sqrt)(1 + yy);
    }
    for (size_t k = w->states; k < n; k++) {
        w->v_end[k] = pk_sum(v[k], w->h * w->V[k], &w->low_v[k]);
        w->v_at[k] = v[k] + half * w->V[k];
    }
}

/* Momenta and forces at the middle; or at the start, by V, and at the end. */
int pk_variational_evaluate(struct pk_integrator *it, struct pk_variational_work *w)
{
    const size_t n = w->n;
    pk_variational_reach(w);
    if (!w->table->ends) {
        pk_variational_momenta(it, w->t + w->h / 2, w->q_at, w->v_at, w->p, w->f);
        return pk_all_finite(w->p, n) && pk_all_finite(w->f, n);
    }
    memcpy(w->v_at + w->m, pk_part(w->to, n, PK_V) + w->m, (n - w->m) * sizeof *w->v_at);
    pk_variational_momenta(it, w->t, pk_part(w->to, n, PK_Q), w->v_at, w->p, w->f);
    pk_variational_momenta(it, w->end, w->q_end, w->v_end, w->p_end, w->f_end);
    return pk_all_finite(w->p, n) && pk_all_finite(w->f, n) && pk_all_finite(w->p_end, n) &&
           pk_all_finite(w->f_end, n);
}

/* Of p0 with the kick. */
static pk_real start(const struct pk_variational_work *w, size_t k)
{
    pk_real p = pk_part(w->to, w->n, PK_P)[k];
    for (size_t i = 0; i < w->c; i++)
        p += w->J[i * w->n + k] * w->kick[i];
    return p;
}

void pk_variational_residual(const struct pk_variational_work *w, pk_real *r)
{
    const int ends = w->table->ends;
    const pk_real half = w->h / 2;
    for (size_t k = 0; k < w->rotation; k++) {
        const pk_real p = ends ? (w->p[k] + w->p_end[k]) / 2 : w->p[k];
        r[k] = (p - start(w, k)) - half * w->f[k];
    }
    for (size_t k = w->rotation; k < w->m; k += 3) {
        const pk_real *omega = w->V + k;
        const pk_real y[3] = {w->h * omega[0] / 4, w->h * omega[1] / 4, w->h * omega[2] / 4};
        pk_real G[3], P[3], across[3];
        pk_cross(w->p + k, omega, G);
        for (size_t i = 0; i < 3; i++) {
            G[i] = w->f[k + i] - G[i];
            P[i] = start(w, k + i) + (ends ? half * G[i] : 0);
        }
        pk_cayley_turn(y, -1, P, P);
        pk_cross(y, G, across);
        for (size_t i = 0; i < 3; i++) {
            const pk_real Pi = ends ? (w->p[k + i] + w->p_end[k + i]) / 2 : w->p[k + i];
            r[k + i] = (Pi - P[i]) + pk_dot3(y, y) * Pi;
            if (!ends)
                r[k + i] -= half * (G[i] - across[i]);
        }
    }
    for (size_t k = w->m; k < w->n; k++)
        r[k] = k < w->states ? 0 : w->V[k] - (ends ? (w->f[k] + w->f_end[k]) / 2 : w->f[k]);
}

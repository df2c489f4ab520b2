/* The start of a model that says `start consistent`: the state on the constraints that is nearest
 * to a given one (q0, v0), in the metric of the mass matrix M there. Positions minimise
 * (q - q0)^T M (q - q0) with phi(t, q) = 0: each iteration goes from q to the nearest point of
 *
 *     phi(q) + J(q) (x - q) = 0,   x = q0 - M^-1 J^T (J M^-1 J^T)^-1 (phi(q) - J (q - q0)),
 *
 * or, where it comes no closer, a part of that way. Rates lose their part across the constraints,
 * v = v0 - M^-1 J^T (J M^-1 J^T)^-1 (J v0 + j0). */
#include <string.h>

#include "../core/project.h"

enum { MOST = 1000 };
/* a smaller change, relative to the largest coordinate, is rounding; or one that stops falling */
#define CLOSE (64 * PK_EPS)
#define STALLED (PK_C(1e6) * PK_EPS)

/* Makes an iteration, by this part of the way. Returns the largest change by sqrt(M_kk), or NaN. */
static pk_real iterate(struct pk_projection *w, pk_real *q, const pk_real *v, const pk_real *q0,
                       pk_real part, pk_real *largest)
{
    pk_real most = 0;
    *largest = 0;
    pk_project_rows(w, q, v);
    if (pk_project_factor(w, w->h, q, v))
        return (pk_real)NAN;
    for (size_t i = 0; i < w->h; i++)
        for (size_t k = 0; k < w->rotation; k++)
            w->phi[i] -= w->J[i * w->n + k] * (q[k] - q0[k]);
    pk_project_solve(w, w->h, w->phi);
    for (size_t k = 0; k < w->rotation; k++) {
        const pk_real unit = PK_F(sqrt)(pk_project_mass(w, k)), change = q0[k] - w->d[k] - q[k];
        most += unit * pk_abs(change); /* a sum hands NaN on */
        q[k] += part * change;
        *largest = pk_max(*largest, unit * pk_max(pk_abs(q[k]), pk_abs(q0[k])));
    }
    return most;
}

int pk_project_nearest(struct pk_projection *w, pk_real *q, pk_real *v, pk_real *q0)
{
    pk_real part = 1, before = PK_INFINITY, largest = 0;
    int count = 0;
    if (pk_project_inertia(w, q, v))
        return 0;
    memcpy(q0, q, w->rotation * sizeof *q);
    for (; w->h && before > CLOSE * largest && count < MOST; count++) {
        const pk_real change = iterate(w, q, v, q0, part, &largest);
        if (!(change < before) && before <= STALLED * largest)
            break;
        part = change < before ? part : part / 2;
        before = change;
    }
    if (count == MOST || (w->h && !pk_finite(before)) || pk_project_inertia(w, q, v))
        return 0;
    pk_project_rows(w, q, v);
    if (pk_project_factor(w, w->c, q, v))
        return 0;
    pk_project_solve(w, w->c, w->rate);
    for (size_t k = 0; k < w->m; k++)
        v[k] -= w->d[k];
    return 1;
}

/* The start of a model that says `start consistent`: the state on the constraints that is nearest
 * to a given one (q0, v0), in the metric of the mass matrix M there. Positions minimise
 *
 *     (q - q0)^T M (q - q0)   with   phi(t, q) = 0.
 *
 * Each step goes against the part g of q - q0 that the constraints allow, and back onto them by
 * Newton's method. The factor of g is <s, y>/<y, y> of the last changes s of q and y of g. Rates
 * lose their part across the constraints, v = v0 - M^-1 J^T (J M^-1 J^T)^-1 (J v0 + j0).
 *
 * Reference: J. Barzilai, J. M. Borwein, IMA Journal of Numerical Analysis 8 (1988) 141-148. */
#include <string.h>

#include "../core/project.h"

enum { CORRECTIONS = 50, SHORTER = 20, STEPS = 500 };
#define ROUND (64 * PK_EPS)        /* a relative residual up to this is rounding */
#define CLOSE (1024 * PK_EPS)      /* a g up to this, relative to q and q0, is rounding */
#define LONGER (1 + PK_C(1e-6))    /* a step may lengthen the squared distance by this factor */

/* Returns (a - b)^T M (c - d); b and d may be NULL. */
static pk_real product(const struct pk_projection *w, const pk_real *a, const pk_real *b,
                       const pk_real *c, const pk_real *d)
{
    const size_t m = w->m, n = w->rotation;
    pk_real sum = 0;
    for (size_t j = 0; j < n; j++) {
        pk_real x = a[j] - (b ? b[j] : 0), y = c[j] - (d ? d[j] : 0);
        for (size_t i = j + 1; i < n; i++) {
            x += w->M[i * m + j] * (a[i] - (b ? b[i] : 0));
            y += w->M[i * m + j] * (c[i] - (d ? d[i] : 0));
        }
        sum += w->M[j * m + j] * x * y;
    }
    return sum;
}

/* Moves q onto phi = 0. Returns 0, or 1 + the index of a row that is left broken. */
static size_t onto(struct pk_projection *w, pk_real *q, const pk_real *v)
{
    pk_real before = 0;
    for (int count = 0;; count++) {
        size_t row;
        pk_project_rows(w, q, v);
        pk_project_terms(w, q, v);
        const pk_real ratio = pk_project_worst(w->phi, w->phi_size, w->h, &row);
        if (ratio <= ROUND || (count && ratio >= before / 2 && ratio <= PK_WRITTEN))
            return 0;
        if (!pk_finite(ratio) || count == CORRECTIONS || pk_project_factor(w, w->h, q, v))
            return 1 + row;
        pk_project_solve(w, w->h, w->phi);
        for (size_t k = 0; k < w->rotation; k++)
            q[k] -= w->d[k];
        before = ratio;
    }
}

/* Computes the part of q - q0 that the constraints allow. Returns as pk_project_factor(). */
static size_t allowed(struct pk_projection *w, const pk_real *q, const pk_real *q0,
                      const pk_real *v, pk_real *g)
{
    pk_project_rows(w, q, v);
    const size_t row = pk_project_factor(w, w->h, q, v);
    if (row)
        return row;
    for (size_t i = 0; i < w->h; i++) {
        w->rate[i] = 0;
        for (size_t k = 0; k < w->rotation; k++)
            w->rate[i] += w->J[i * w->n + k] * (q[k] - q0[k]);
    }
    pk_project_solve(w, w->h, w->rate);
    for (size_t k = 0; k < w->rotation; k++)
        g[k] = q[k] - q0[k] - w->d[k];
    return 0;
}

/* Finds the positions from q0 = room, which has 4 n numbers. Returns as onto(). */
static size_t positions(struct pk_projection *w, pk_real *q, const pk_real *v, pk_real *room)
{
    const size_t n = w->rotation;
    pk_real *const q0 = room, *const old = q0 + n, *g = old + n, *last = g + n;
    pk_real factor = 1, distance = 0;
    size_t row = onto(w, q, v);
    for (int count = 0; !row && count < STEPS; count++) {
        if ((row = allowed(w, q, q0, v, g)) != 0)
            break;
        const pk_real far = product(w, q, NULL, q, NULL) + product(w, q0, NULL, q0, NULL);
        if (product(w, g, NULL, g, NULL) <= CLOSE * CLOSE * far)
            return 0;
        if (count) {
            const pk_real y = product(w, g, last, g, last), s = product(w, q, old, g, last);
            factor = s > 0 ? s / y : 1;
        }
        memcpy(old, q, n * sizeof *q);
        distance = product(w, q, q0, q, q0);
        for (int tries = 0; tries < SHORTER; tries++, factor /= 4) {
            for (size_t k = 0; k < n; k++)
                q[k] = old[k] - factor * g[k];
            row = onto(w, q, v);
            if (!row && product(w, q, q0, q, q0) <= LONGER * distance)
                break;
        }
        pk_real *const swap = last;
        last = g, g = swap;
    }
    return row ? row : 1;
}

size_t pk_project_nearest(struct pk_projection *w, pk_real *q, pk_real *v, pk_real *room)
{
    if (pk_project_inertia(w, q, v))
        return 1;
    memcpy(room, q, w->rotation * sizeof *q);
    size_t row = w->h ? positions(w, q, v, room) : 0;
    if (!row && pk_project_inertia(w, q, v))
        row = 1;
    for (int twice = 0; twice < 2 && !row; twice++) {
        pk_project_rows(w, q, v);
        row = pk_project_factor(w, w->c, q, v);
        if (row)
            break;
        pk_project_solve(w, w->c, w->rate);
        for (size_t k = 0; k < w->m; k++)
            v[k] -= w->d[k];
    }
    if (row)
        memcpy(q, room, w->rotation * sizeof *q);
    return row;
}

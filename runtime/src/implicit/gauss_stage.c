/* The stages of a step that an implicit method in (q, p) has just made, for quadratures: as one
 * more coordinate z would be, with the weights b of q's table. /
 */
#include "gauss.h"
#include "../core/generic.h"

#include <pk/step/gauss_stages.h>

int pk_gauss_stage(struct pk_integrator *it, int k, struct pk_stage *stage, pk_real *room)
{
    const struct pk_gauss_work w = pk_gauss_parts(it);
    const size_t n = it->n, i = (size_t)k;
    if (i >= w.s)
        return 0;
    const pk_real h = w.kept->h, t = it->t + w.c[i] * h;
    if (pk_gauss_by_lanes(it, &w, h)) {
        const struct pk_gauss_lanes lanes = pk_gauss_lanes(it, n, w.rest);
        pk_gauss_lane(&lanes, n, k, t, w.hb[i], stage, room);
        return 1;
    }
    /* V are what the iteration ended with, Q may be one older. */
    for (size_t c = 0; c < n; c++) {
        pk_real dq = 0;
        for (size_t j = 0; j < w.s; j++)
            dq += w.hA[i * w.s + j] * w.V[j * n + c];
        room[c] = it->q[c] + dq;
    }
    *stage = (struct pk_stage){t, w.hb[i], room, w.V + i * n, {0, 0}};
    return 1;
}

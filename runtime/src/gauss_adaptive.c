/* The adaptive Gauss method over function pointers; see pk/step/gauss.h. */
#include "gauss_dense.h"
#include "generic.h"
#include "tableau.h"

#include <pk/step/gauss.h>

static size_t size(const struct pk_method *method, size_t n)
{
    (void)method;
    return 5 * n * PK_GAUSS_S + 4 * n + 3 + pk_gauss_dense_size(n);
}

static enum pk_status init(struct pk_integrator *it)
{
    (void)it;
    return PK_DONE;
}

static enum pk_status step(struct pk_integrator *it, pk_real limit)
{
    return generic_gauss(it, limit);
}

/* From the accelerations that the step was made of: those that it iterated on are one older. */
static int stage(struct pk_integrator *it, int k, struct pk_stage *stage, pk_real *room)
{
    const size_t n = it->n;
    const struct pk_gauss_lanes w = pk_gauss_lanes(it, n, it->work);
    struct pk_gauss_trial y;
    if (k >= PK_GAUSS_S)
        return 0;
    y.h = *w.h;
    for (int l = 0; l < PK_GAUSS_S; l++)
        y.hc[l] = y.h * pk_gauss8_c[l];
    if (k == 0)
        generic_gauss_stages(it, &w, &y, 1);
    pk_gauss_lane(&w, n, k, it->t + y.hc[k], y.h * pk_gauss8_b[k], stage, room);
    return 1;
}

const struct pk_method pk_gauss_adaptive = {
    .name = "gauss",
    .doc = "adaptive Gauss-Legendre, 8 stages, in (q, q'), symmetric where M varies, symplectic "
           "where not; after Antonana, Makazaga, Murua (2017) and Rein, Spiegel (2015)",
    .order = 16,
    .stages = 8,
    .dense_order = 16,
    .traits = PK_SYMMETRIC | PK_ADAPTIVE | PK_IMPLICIT | PK_DENSE | PK_QUADRATURE,
    .needs = PK_SMOOTH,
    .formula = &pk_gauss8,
    .size = size,
    .init = init,
    .step = step,
    .dense = pk_gauss_dense,
    .stage = stage,
};

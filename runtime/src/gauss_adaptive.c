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

const struct pk_method pk_gauss_adaptive = {
    .name = "gauss",
    .doc = "adaptive Gauss-Legendre, 8 stages, in (q, q'), symmetric where M varies, symplectic "
           "where not; after Antonana, Makazaga, Murua (2017) and Rein, Spiegel (2015)",
    .order = 16,
    .stages = 8,
    .dense_order = 16,
    .traits = PK_SYMMETRIC | PK_ADAPTIVE | PK_IMPLICIT | PK_DENSE,
    .needs = PK_SMOOTH,
    .formula = &pk_gauss8,
    .size = size,
    .init = init,
    .step = step,
    .dense = pk_gauss_dense,
};

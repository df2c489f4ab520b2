/* The adaptive Gauss method over function pointers; see pk/step/gauss.h. */
#include "generic.h"
#include "tableau.h"

#include <pk/step/gauss.h>

static size_t size(const struct pk_method *method, size_t n)
{
    (void)method;
    return 5 * n * PK_GAUSS_S + 3 * n + 3;
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
    .doc = "adaptive Gauss-Legendre, 8 stages, in (q, q'); after Rein, Spiegel (2015) and "
           "Antonana, Makazaga, Murua (2017)",
    .order = 16,
    .stages = 8,
    .traits = PK_SYMMETRIC | PK_ADAPTIVE | PK_IMPLICIT,
    .needs = PK_SMOOTH,
    .size = size,
    .init = init,
    .step = step,
};

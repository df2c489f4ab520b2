/* Parts of the Taylor method that run rarely, and dense output; the step is in pk/step/taylor.h. */
#include "../core/generic.h"

#include <pk/step/taylor.h>

enum { LEAST_ORDER = 4 };

static int order_of(pk_real tolerance)
{
    const int order = (int)(PK_C(1.999) - PK_F(log)(pk_max(tolerance, PK_EPS)) / 2);
    return order < LEAST_ORDER ? LEAST_ORDER : order > PK_JET_ORDER ? PK_JET_ORDER : order;
}

static enum pk_status init(struct pk_integrator *it)
{
    it->own->work[0] = (pk_real)order_of(it->options.rtol);
    return PK_DONE;
}

static size_t size(const struct pk_method *method, const struct pk_problem *problem, size_t n)
{
    (void)method;
    return (PK_JET_ORDER + 1) * (pk_coordinates_of(problem) + n) + 1;
}

static enum pk_status step(struct pk_integrator *it, pk_real limit)
{
    return generic_taylor_step(it, limit);
}

static enum pk_status dense(struct pk_integrator *it, pk_real t, pk_real *q, pk_real *v)
{
    const pk_real s = t - it->last_t, *c = pk_taylor_c(it);
    const size_t m = it->n_q + it->n;
    for (size_t i = 0; i < m; i++) {
        pk_real y = 0;
        for (int k = pk_taylor_order(it); k >= 0; k--)
            y = c[(size_t)k * m + i] + s * y;
        *(i < it->n_q ? q + i : v + (i - it->n_q)) = y;
    }
    return PK_DONE;
}

#define TAYLOR(of) \
    .needs = PK_NEEDS_TAYLOR, .size = size, .init = init, .step = step, .dense = dense
PK_METHODS_TAYLOR(PK_DEFINE_METHOD, TAYLOR)

/* Parts of the Taylor method that run rarely, and dense output; the step is in pk/step/taylor.h. */
#include "../core/generic.h"

#include <pk/step/taylor.h>

#define MORE PK_C(1.5)
enum { LEAST_ORDER = 4 };

/* Returns the order: that of least work where the work of a step grows as its square; and up to
 * MORE times that where higher orders are cheap, for then longer steps cost less. */
static int order_of(pk_real tolerance, int fast)
{
    const pk_real e = -PK_F(log)(pk_max(tolerance, PK_EPS)) / 2;
    const int least = (int)(PK_C(1.999) + e), more = (int)(PK_C(1.999) + MORE * e);
    const int order = fast < least ? least : fast < more ? fast : more;
    return order < LEAST_ORDER ? LEAST_ORDER : order > PK_JET_ORDER ? PK_JET_ORDER : order;
}

static enum pk_status init(struct pk_integrator *it)
{
    const int order = order_of(it->options.rtol, it->problem.system->jet_fast);
    it->own->work[0] = (pk_real)order;
    it->own->work[1] = PK_F(log2)(pk_max(it->options.rtol, PK_EPS)) / (pk_real)order;
    return PK_DONE;
}

static size_t size(const struct pk_method *method, const struct pk_problem *problem, size_t n)
{
    (void)method;
    return (PK_JET_ORDER + 1) * (pk_coordinates_of(problem) + n) + 2;
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

/* The adaptive Gauss method over function pointers; see pk/step/gauss.h. */
#include <string.h>

#include "gauss_dense.h"
#include "../core/generic.h"
#include "../core/tableau.h"

#include <pk/step/gauss.h>

static size_t size(const struct pk_method *method, size_t n)
{
    (void)method;
    return pk_gauss_lanes_size(n) + pk_gauss_dense_size(n);
}

static enum pk_status init(struct pk_integrator *it)
{
    const struct pk_gauss_lanes w = pk_gauss_lanes(it, it->n, it->own->work);
    if (!it->own->made) {
        pk_gauss_make_matrices(w.M);
        pk_gauss_dense_init(it);
        it->own->made = 1;
    }
    /* Where nothing depends on rates those of stages are not made, and kernels get them yet. */
    memset(w.v, 0, it->n * PK_GAUSS_S * sizeof *w.v);
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
    const struct pk_gauss_lanes w = pk_gauss_lanes(it, n, it->own->work);
    struct pk_gauss_trial y;
    if (k >= PK_GAUSS_S)
        return 0;
    y.h = *w.h;
    for (int l = 0; l < PK_GAUSS_S; l++)
        y.hc[l] = y.h * pk_gauss8_c[l];
    if (k == 0)
        generic_gauss_stages(it, &w, &y, 1);
    pk_gauss_lane(&w, n, k, it->t + y.hc[k], y.h * pk_gauss8_b[k], stage, room);
    stage->error[0] = y.h * w.M->legendre6[k];
    stage->error[1] = y.h * w.M->legendre7[k];
    return 1;
}

/* As of the accelerations: |h g| theta^16, where the last two Legendre coefficients tell theta. */
static pk_real stage_error(const struct pk_integrator *it, pk_real size, const pk_real sums[2])
{
    const pk_real six = pk_abs(sums[0]) / (size + PK_TINY),
                  seven = pk_abs(sums[1]) / (size + PK_TINY);
    const pk_real theta =
        PK_SAME(pk_max(PK_F(pow)(six, PK_C(1.0) / 6), PK_F(pow)(seven, PK_C(1.0) / 7)));
    const pk_real theta2 = theta * theta, theta4 = theta2 * theta2, theta8 = theta4 * theta4;
    (void)it;
    return size * theta8 * theta8 / (PK_GAUSS_SHARE * PK_F(exp)(PK_GAUSS_ACCEPT_LOG));
}

#define GAUSS(of)                                                                                  \
    .needs = PK_NEEDS_GAUSS, .formula = &pk_method_##of, .size = size, .init = init, .step = step, \
    .dense = pk_gauss_dense, .stage = stage, .stage_error = stage_error
PK_METHODS_GAUSS(PK_DEFINE_METHOD, GAUSS)

/* The adaptive Gauss method with kernels called by pointers; see pk/step/gauss.h. */

#include "gauss.h"
#include "gauss_dense.h"
#include "../core/generic.h"
#include "../core/tableau.h"

#include <pk/step/gauss.h>

static size_t size(const struct pk_method *method, const struct pk_problem *problem, size_t n)
{
    const size_t n_q = pk_coordinates_of(problem);
    (void)method;
    return pk_gauss_lanes_size(n_q, n) + pk_gauss_dense_size(n_q, n);
}

static enum pk_status init(struct pk_integrator *it)
{
    const struct pk_gauss_lanes w = pk_gauss_lanes(it, it->n_q, it->n, it->own->work);
    if (!it->own->made) {
        pk_gauss_make_matrices(w.M);
        pk_gauss_dense_init(it);
        it->own->made = 1;
    }
    /* Kernels get stage rates as an argument; if no kernel depends on them, they stay 0. */
    pk_zero(w.v, it->n * PK_GAUSS_S);
    return PK_DONE;
}

static void last(struct pk_integrator *it, struct pk_stages *to)
{
    const struct pk_gauss_lanes w = pk_gauss_lanes(it, it->n_q, it->n, it->own->work);
    pk_gauss_lanes_last(it, &w, to);
    pk_copy(to->c, pk_gauss8_c, PK_GAUSS_S);
    for (int j = 0; j < PK_GAUSS_S; j++) {
        for (int i = 0; i < PK_GAUSS_S; i++)
            to->A[i * PK_GAUSS_S + j] = *w.h * w.M->A[j * PK_GAUSS_S + i];
        to->A[PK_GAUSS_S * PK_GAUSS_S + j] = *w.h * pk_gauss8_b[j];
    }
    pk_copy(to->A_p, to->A, (PK_GAUSS_S + 1) * PK_GAUSS_S);
}

#define GAUSS(of)                                                                    \
    .needs = PK_NEEDS_GAUSS, .formula = &pk_method_##of, .size = size, .init = init, \
    .step = generic_gauss, .dense = pk_gauss_dense, .last = last
PK_METHODS_GAUSS(PK_DEFINE_METHOD, GAUSS)

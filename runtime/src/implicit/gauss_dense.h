/* Dense output of the adaptive Gauss method (gauss_dense.c), for gauss_adaptive.c. */
#ifndef PK_GAUSS_DENSE_H
#define PK_GAUSS_DENSE_H

#include "../core/internal.h"

size_t pk_gauss_dense_size(size_t n_q, size_t n);
/* Computes the tables, which are the same for all steps. */
void pk_gauss_dense_init(struct pk_integrator *it);
enum pk_status pk_gauss_dense(struct pk_integrator *it, pk_real t, pk_real *q, pk_real *v);

#endif

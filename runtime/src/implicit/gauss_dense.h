/* What gauss_adaptive.c and gauss_dense.c share. */
#ifndef PK_GAUSS_DENSE_H
#define PK_GAUSS_DENSE_H

#include "../core/internal.h"

size_t pk_gauss_dense_size(size_t n_q, size_t n);
/* Its tables, which no step changes. */
void pk_gauss_dense_init(struct pk_integrator *it);
enum pk_status pk_gauss_dense(struct pk_integrator *it, pk_real t, pk_real *q, pk_real *v);

#endif

/* What gauss_adaptive.c and gauss_dense.c share. */
#ifndef PK_GAUSS_DENSE_H
#define PK_GAUSS_DENSE_H

#include "../core/internal.h"

/* Of Gauss's formula with 16 nodes on [0, 1], j = 0 to 15. */
struct pk_node {
    pk_real x, weight;
};
struct pk_node pk_gauss_node(int j);

size_t pk_gauss_dense_size(size_t n);
/* Its tables, which no step changes. */
void pk_gauss_dense_init(struct pk_integrator *it);
enum pk_status pk_gauss_dense(struct pk_integrator *it, pk_real t, pk_real *q, pk_real *v);

#endif

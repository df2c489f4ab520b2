/* The common code of families of explicit methods. A method with other coefficients needs only a
 * table and an X-macro row, in the registry (pk/methods.h) or in the C of a model:
 *
 *     static const struct pk_tableau pk_mine_table = {...};
 *     PK_DEFINE_METHOD(PK_FAMILY_ERK, mine, 3, 3, 0, 0, mine, "mine"); */
#ifndef PK_FAMILIES_H
#define PK_FAMILIES_H

#include <pk/methods.h>

PK_BEGIN

/* Returns the number of pk_real of work memory, which stores the slopes of all stages. */
size_t pk_erk_size(const struct pk_method *method, const struct pk_problem *problem, size_t n);
enum pk_status pk_erk_step(struct pk_integrator *it, pk_real limit);

enum pk_status pk_splitting_init(struct pk_integrator *it);
enum pk_status pk_splitting_step(struct pk_integrator *it, pk_real limit);

size_t pk_embedded_size(const struct pk_method *method, const struct pk_problem *problem, size_t n);
enum pk_status pk_embedded_init(struct pk_integrator *it);
enum pk_status pk_embedded_step(struct pk_integrator *it, pk_real limit);
enum pk_status pk_embedded_dense(struct pk_integrator *it, pk_real t, pk_real *q, pk_real *v);

PK_END

#define PK_FAMILY_ERK(of) \
    .needs = PK_NEEDS_ERK, .table = &pk_##of##_table, .size = pk_erk_size, .step = pk_erk_step
#define PK_FAMILY_SPLITTING(of)                                                        \
    .needs = PK_NEEDS_SPLITTING, .table = &pk_##of##_table, .init = pk_splitting_init, \
    .step = pk_splitting_step
#define PK_FAMILY_EMBEDDED(of)                                                       \
    .needs = PK_NEEDS_EMBEDDED, .table = &pk_##of##_table, .size = pk_embedded_size, \
    .init = pk_embedded_init, .step = pk_embedded_step, .dense = pk_embedded_dense

#endif

/* What the explicit methods of a family have in common: a method of other coefficients is a table
 * and a row. Of the registry (pk/methods.h) and of a model's own methods alike:
 *
 *     static const struct pk_tableau pk_mine_table = {...};
 *     PK_DEFINE_METHOD(PK_FAMILY_ERK, mine, 3, 3, 0, PK_QUADRATURE, mine, "mine");
 */
#ifndef PK_FAMILIES_H
#define PK_FAMILIES_H

#include <pk/methods.h>

PK_BEGIN

size_t pk_erk_size(const struct pk_method *method, size_t n); /* the slopes of all stages */
enum pk_status pk_erk_step(struct pk_integrator *it, pk_real limit);
int pk_erk_stage(struct pk_integrator *it, int k, struct pk_stage *stage, pk_real *room);

enum pk_status pk_splitting_init(struct pk_integrator *it);
enum pk_status pk_splitting_step(struct pk_integrator *it, pk_real limit);

size_t pk_embedded_size(const struct pk_method *method, size_t n);
enum pk_status pk_embedded_init(struct pk_integrator *it);
enum pk_status pk_embedded_step(struct pk_integrator *it, pk_real limit);
enum pk_status pk_embedded_dense(struct pk_integrator *it, pk_real t, pk_real *q, pk_real *v);
int pk_embedded_stage(struct pk_integrator *it, int k, struct pk_stage *stage, pk_real *room);
pk_real pk_embedded_stage_error(const struct pk_integrator *it, pk_real size,
                                const pk_real sums[2]);

PK_END

#define PK_FAMILY_ERK(of)                                                                       \
    .needs = PK_NEEDS_ERK, .table = &pk_##of##_table, .size = pk_erk_size, .step = pk_erk_step, \
    .stage = pk_erk_stage
#define PK_FAMILY_SPLITTING(of)                                                        \
    .needs = PK_NEEDS_SPLITTING, .table = &pk_##of##_table, .init = pk_splitting_init, \
    .step = pk_splitting_step
#define PK_FAMILY_EMBEDDED(of)                                                       \
    .needs = PK_NEEDS_EMBEDDED, .table = &pk_##of##_table, .size = pk_embedded_size, \
    .init = pk_embedded_init, .step = pk_embedded_step, .dense = pk_embedded_dense,  \
    .stage = pk_embedded_stage, .stage_error = pk_embedded_stage_error

#endif

/* Splitting methods; the step and its tables are in pk/step/splitting.h. */
#include "../core/generic.h"
#include "../core/tableau.h"

#include <pk/step/splitting.h>

static size_t splitting_size(const struct pk_method *method, size_t n)
{
    (void)method;
    (void)n;
    return 0;
}

static enum pk_status splitting_init(struct pk_integrator *it)
{
    (void)it;
    return PK_DONE;
}

static enum pk_status splitting_step(struct pk_integrator *it, pk_real limit)
{
    (void)limit;
    return generic_splitting(it, (const struct pk_splitting *)it->method->table);
}

const struct pk_splitting *pk_splitting_table(const struct pk_method *method)
{
    return method->step == splitting_step ? (const struct pk_splitting *)method->table : NULL;
}

#define SPLITTING(of)                                                               \
    .needs = PK_NEEDS_SPLITTING, .table = &pk_##of##_table, .size = splitting_size, \
    .init = splitting_init, .step = splitting_step
PK_METHODS_SPLITTING(PK_DEFINE_METHOD, SPLITTING)

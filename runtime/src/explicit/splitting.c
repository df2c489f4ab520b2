/* Splitting methods; the step and its tables are in pk/step/splitting.h. */
#include "../core/generic.h"
#include "../core/tableau.h"

#include <pk/step/splitting.h>

static enum pk_status splitting_step(struct pk_integrator *it, pk_real limit)
{
    (void)limit;
    return generic_splitting(it, (const struct pk_splitting *)it->method->table);
}

const struct pk_splitting *pk_splitting_table(const struct pk_method *method)
{
    return method->step == splitting_step ? (const struct pk_splitting *)method->table : NULL;
}

#define SPLITTING(of) .needs = PK_NEEDS_SPLITTING, .table = &pk_##of##_table, .step = splitting_step
PK_METHODS_SPLITTING(PK_DEFINE_METHOD, SPLITTING)

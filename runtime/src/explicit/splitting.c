/* Splitting methods; the step and its tables are in pk/step/splitting.h. */
#include "../core/generic.h"
#include "../core/tableau.h"

#include <pk/families.h>
#include <pk/step/splitting.h>

enum pk_status pk_splitting_step(struct pk_integrator *it, pk_real limit)
{
    (void)limit;
    return generic_splitting(it, (const struct pk_splitting *)it->method->table);
}

const struct pk_splitting *pk_splitting_table(const struct pk_method *method)
{
    return method->step == pk_splitting_step ? (const struct pk_splitting *)method->table : NULL;
}

PK_METHODS_SPLITTING(PK_DEFINE_METHOD, PK_FAMILY_SPLITTING)

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

enum pk_status pk_splitting_init(struct pk_integrator *it)
{
    if (it->problem.system->facts & PK_SEPARABLE)
        return PK_DONE;
    return pk_linear_drag_init(it, (const struct pk_splitting *)it->method->table);
}

const struct pk_splitting *pk_splitting_table(const struct pk_method *method)
{
    return method->step == pk_splitting_step ? (const struct pk_splitting *)method->table : NULL;
}

size_t pk_splitting_size(const struct pk_method *method, const struct pk_problem *problem, size_t n)
{
    const struct pk_splitting *table = pk_splitting_table(method);
    return table && !(problem->system->facts & PK_SEPARABLE) ? pk_linear_drag_size(table, n) : 0;
}

PK_METHODS_SPLITTING(PK_DEFINE_METHOD, PK_FAMILY_SPLITTING)

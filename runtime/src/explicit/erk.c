/* Explicit Runge-Kutta methods at a fixed step; the step and its tables are in pk/step/erk.h. */
#include "../core/generic.h"
#include "../core/tableau.h"

#include <pk/families.h>
#include <pk/step/erk.h>

size_t pk_erk_size(const struct pk_method *method, const struct pk_problem *problem, size_t n)
{
    const struct pk_tableau *table = (const struct pk_tableau *)method->table;
    return (size_t)table->stages * (pk_coordinates_of(problem) + n);
}

enum pk_status pk_erk_step(struct pk_integrator *it, pk_real limit)
{
    (void)limit;
    return generic_erk(it, (const struct pk_tableau *)it->method->table);
}

const struct pk_tableau *pk_erk_table(const struct pk_method *method)
{
    return method->step == pk_erk_step ? (const struct pk_tableau *)method->table : NULL;
}

PK_METHODS_ERK(PK_DEFINE_METHOD, PK_FAMILY_ERK)

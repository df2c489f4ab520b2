/* Explicit Runge-Kutta methods at a fixed step; the step and its tables are in pk/step/erk.h. */
#include "generic.h"
#include "tableau.h"

#include <pk/step/erk.h>

static size_t erk_size(const struct pk_method *method, size_t n)
{
    const struct pk_tableau *table = (const struct pk_tableau *)method->table;
    return (size_t)table->stages * 2 * n;
}

static enum pk_status erk_init(struct pk_integrator *it)
{
    (void)it;
    return PK_DONE;
}

static enum pk_status erk_step(struct pk_integrator *it, pk_real limit)
{
    (void)limit;
    return generic_erk(it, (const struct pk_tableau *)it->method->table);
}

const struct pk_method pk_euler = {.name = "euler",
                                   .doc = "explicit Euler; HNW I.7",
                                   .order = 1,
                                   .stages = 1,
                                   .table = &pk_euler_table,
                                   .size = erk_size,
                                   .init = erk_init,
                                   .step = erk_step};
const struct pk_method pk_rk4 = {.name = "rk4",
                                 .doc = "the classical Runge-Kutta method; W. Kutta (1901), "
                                        "HNW II.1 Table 1.2",
                                 .order = 4,
                                 .stages = 4,
                                 .table = &pk_rk4_table,
                                 .size = erk_size,
                                 .init = erk_init,
                                 .step = erk_step};

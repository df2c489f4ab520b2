/* Explicit Runge-Kutta methods at a fixed step; the step and its tables are in pk/step/erk.h. */
#include "../core/generic.h"
#include "../core/tableau.h"

#include <pk/families.h>
#include <pk/step/erk.h>

size_t pk_erk_size(const struct pk_method *method, size_t n)
{
    const struct pk_tableau *table = (const struct pk_tableau *)method->table;
    return (size_t)table->stages * 2 * n;
}

enum pk_status pk_erk_step(struct pk_integrator *it, pk_real limit)
{
    (void)limit;
    return generic_erk(it, (const struct pk_tableau *)it->method->table);
}

int pk_explicit_stage(const struct pk_integrator *it, const struct pk_tableau *table, pk_real h,
                      const pk_real *k, int i, struct pk_stage *stage, pk_real *room)
{
    const int ends = table->e && !table->e3; /* the end has a part in the estimate */
    if (i >= table->stages + ends)
        return 0;
    const pk_real e = table->e ? h * table->e[i] : 0, e3 = table->e3 ? h * table->e3[i] : 0;
    if (i == table->stages) {
        *stage =
            (struct pk_stage){it->own->next_t, 0, it->own->next, it->own->next + it->n, {e, 0}};
        return 1;
    }
    if (i > 0)
        pk_erk_combine(room, it->own->state, h, table->a + i * (i - 1) / 2, i, k, 2 * it->n);
    const pk_real *y = i > 0 ? room : it->own->state;
    *stage = (struct pk_stage){it->t + table->c[i] * h, h * table->b[i], y, y + it->n, {e, e3}};
    return 1;
}

int pk_erk_stage(struct pk_integrator *it, int i, struct pk_stage *stage, pk_real *room)
{
    return pk_explicit_stage(it, (const struct pk_tableau *)it->method->table, it->own->h,
                             it->own->work, i, stage, room);
}

const struct pk_tableau *pk_erk_table(const struct pk_method *method)
{
    return method->step == pk_erk_step ? (const struct pk_tableau *)method->table : NULL;
}

PK_METHODS_ERK(PK_DEFINE_METHOD, PK_FAMILY_ERK)

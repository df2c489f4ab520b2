/* The registry: one line a method. */
#include <string.h>

#include "core/tableau.h"

static const struct pk_method *const methods[] = {
    &pk_euler, &pk_rk2, &pk_rk3, &pk_rk4,
    &pk_symplectic_euler, &pk_verlet, &pk_adaptive_verlet,
    &pk_yoshida4, &pk_suzuki4, &pk_mclachlan4, &pk_blanes_moan4,
    &pk_yoshida6, &pk_kahan_li6, &pk_blanes_moan6,
    &pk_yoshida8, &pk_kahan_li8,
    &pk_gauss1, &pk_gauss2, &pk_gauss3, &pk_gauss4,
    &pk_gauss5, &pk_gauss6, &pk_gauss7, &pk_gauss8,
    &pk_lobatto2, &pk_lobatto3, &pk_lobatto4, &pk_radau5, &pk_radau9,
    &pk_dopri5, &pk_dop853, &pk_gauss_adaptive, &pk_radau_adaptive,
    &pk_exponential,
    &pk_lie_midpoint, &pk_lie_midpoint4, &pk_lie_midpoint6,
    &pk_rattle, &pk_rattle4, &pk_rattle6, &pk_rkmk4, &pk_rkmk8,
};

const struct pk_method *pk_method_at(size_t index)
{
    return index < sizeof methods / sizeof *methods ? methods[index] : NULL;
}

const struct pk_method *pk_method_find(const char *name)
{
    for (size_t i = 0; i < sizeof methods / sizeof *methods; i++)
        if (strcmp(methods[i]->name, name) == 0)
            return methods[i];
    return NULL;
}

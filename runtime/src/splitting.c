/* Splitting methods; the step and its tables are in pk/step/splitting.h. */
#include "generic.h"
#include "tableau.h"

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

#define SPLITTING(symbol, text, p, s, more)                                                   \
    const struct pk_method pk_##symbol = {.name = #symbol,                                    \
                                          .doc = text,                                        \
                                          .order = p,                                         \
                                          .stages = s,                                        \
                                          .traits = PK_SYMPLECTIC | (more),                   \
                                          .needs = PK_MASS_CONSTANT | PK_SEPARABLE,           \
                                          .table = &pk_##symbol##_table,                      \
                                          .size = splitting_size,                             \
                                          .init = splitting_init,                             \
                                          .step = splitting_step}

SPLITTING(symplectic_euler, "symplectic Euler, kick first; R. de Vogelaere (1956), GNI I.1.9", 1, 1,
          0);
SPLITTING(verlet, "velocity Verlet (Stormer, leapfrog); Phys. Rev. 159 (1967) 98", 2, 1,
          PK_SYMMETRIC);
SPLITTING(yoshida4, "triple jump of Verlet; H. Yoshida, Phys. Lett. A 150 (1990) 262", 4, 3,
          PK_SYMMETRIC);

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
SPLITTING(suzuki4, "five Verlet steps; M. Suzuki, Phys. Lett. A 146 (1990) 319", 4, 5,
          PK_SYMMETRIC);
SPLITTING(mclachlan4,
          "5 stages of least error; R. I. McLachlan, SIAM J. Sci. Comput. 16 (1995) 151",
          4, 5, PK_SYMMETRIC);
SPLITTING(blanes_moan4,
          "SRKN_6^b; S. Blanes, P. C. Moan, J. Comput. Appl. Math. 142 (2002) 313", 4, 6,
          PK_SYMMETRIC);
SPLITTING(yoshida6,
          "seven Verlet steps, solution A; H. Yoshida, Phys. Lett. A 150 (1990) 262", 6, 7,
          PK_SYMMETRIC);
SPLITTING(kahan_li6,
          "nine Verlet steps, s9odr6a; W. Kahan, R.-C. Li, Math. Comp. 66 (1997) 1089", 6, 9,
          PK_SYMMETRIC);
SPLITTING(blanes_moan6,
          "SRKN_11^b; S. Blanes, P. C. Moan, J. Comput. Appl. Math. 142 (2002) 313", 6, 11,
          PK_SYMMETRIC);
SPLITTING(yoshida8,
          "fifteen Verlet steps, solution D; H. Yoshida, Phys. Lett. A 150 (1990) 262", 8, 15,
          PK_SYMMETRIC);
SPLITTING(kahan_li8,
          "seventeen Verlet steps, s17odr8a; W. Kahan, R.-C. Li, Math. Comp. 66 (1997) 1089", 8, 17,
          PK_SYMMETRIC);

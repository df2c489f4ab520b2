/* Systems of systems.h that fail on purpose: no number after t = limit, no mass at q = limit. */
#include "systems_make.h"

POINT_MASS(broken, 0, PK_F(sqrt)(LIMIT(params) - t), 0, -PK_C(0.5) / PK_F(sqrt)(LIMIT(params) - t))
SIZES(broken, 1, 0)
#undef PK_MODEL
#define PK_MODEL(x) broken_##x
#include <pk/inlined.h>
SYSTEM(broken, 1, DRIVEN, PK_C(1.0), PK_C(1.25), none_cyclic, LIST(PK_C(0.7)), LIST(PK_C(0.2)),
       .linear = broken_linear);

/* L = (limit - q) v^2/2: p = (limit - q) v, pdot = -v^2/2, M a = v^2/2. */
static void folded_mass(ARGS, pk_real *M)
{
    UNUSED;
    M[0] = LIMIT(params) - q[0];
}
static void folded_force(ARGS, pk_real *f)
{
    UNUSED;
    f[0] = v[0] * v[0] / 2;
}
static int folded_acceleration(ARGS, pk_real *a)
{
    const pk_real M = LIMIT(params) - q[0];
    UNUSED;
    if (!(M > 0))
        return 1;
    a[0] = v[0] * v[0] / 2 / M;
    return 0;
}
static void folded_gradient(ARGS, pk_real *d)
{
    UNUSED;
    d[0] = -v[0] * v[0] / 2;
}
static void folded_canonical(ARGS, pk_real *p, pk_real *pdot)
{
    UNUSED;
    p[0] = (LIMIT(params) - q[0]) * v[0];
    pdot[0] = -v[0] * v[0] / 2;
}
static void folded_jacobian(ARGS, pk_real *p_q, pk_real *pdot_q, pk_real *pdot_v)
{
    UNUSED;
    p_q[0] = -v[0];
    pdot_q[0] = 0;
    pdot_v[0] = -v[0];
}
static pk_real folded_energy(ARGS)
{
    UNUSED;
    return (LIMIT(params) - q[0]) * v[0] * v[0] / 2;
}
SIZES(folded, 1, 0)
#undef PK_MODEL
#define PK_MODEL(x) folded_##x
#include <pk/inlined.h>
SYSTEM(folded, 1, GENERAL, PK_C(1.0), PK_C(1.25), none_cyclic, LIST(PK_C(0.7)), LIST(PK_C(0.2)), );

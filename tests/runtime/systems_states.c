/* Systems with states of systems.h: v has the state, and q, its integral, is in no kernel. */
#include "systems_make.h"

#define FIRST_ORDER (PK_MASS_CONSTANT | PK_MASS_DIAGONAL | PK_QUADRATIC | PK_AUTONOMOUS | PK_SMOOTH)

/* x' = 1 + x^2 y - 4 x, y' = 3 x - x^2 y */
static void brusselator_force(ARGS, pk_real *f)
{
    UNUSED;
    f[0] = 1 + v[0] * v[0] * v[1] - 4 * v[0];
    f[1] = 3 * v[0] - v[0] * v[0] * v[1];
}
UNIT_MASS(brusselator, 2)
static void brusselator_gradient(ARGS, pk_real *d)
{
    UNUSED;
    d[0] = d[1] = 0;
}
static void brusselator_jacobian(ARGS, pk_real *p_q, pk_real *pdot_q, pk_real *pdot_v)
{
    UNUSED;
    for (int i = 0; i < 4; i++)
        p_q[i] = pdot_q[i] = 0;
    pdot_v[0] = 2 * v[0] * v[1] - 4;
    pdot_v[1] = v[0] * v[0];
    pdot_v[2] = 3 - 2 * v[0] * v[1];
    pdot_v[3] = -v[0] * v[0];
}
LINEAR(brusselator, 2)
#define brusselator_energy NULL
SIZES(brusselator, 2, 0)
#undef PK_MODEL
#define PK_MODEL(x) brusselator_##x
#undef PK_MODEL_FIRST_ORDER
#define PK_MODEL_FIRST_ORDER 2
#include <pk/inlined.h>
SYSTEM(brusselator, 2, FIRST_ORDER, PK_C(1.0), PK_C(0.0), none_cyclic, LIST(PK_C(0.0), PK_C(0.0)),
       LIST(PK_C(1.5), PK_C(3.0)), .linear = brusselator_linear, .n_first_order = 2, );

/* A pendulum that a Maxwell element holds back: q'' = -g sin q - s, s' = q' - s. */
static void maxwell_force(ARGS, pk_real *f)
{
    UNUSED;
    f[0] = -G(params) * PK_F(sin)(q[0]) - v[1];
    f[1] = v[0] - v[1];
}
UNIT_MASS(maxwell, 2)
static void maxwell_gradient(ARGS, pk_real *d)
{
    UNUSED;
    d[0] = -G(params) * PK_F(sin)(q[0]);
    d[1] = 0;
}
static void maxwell_jacobian(ARGS, pk_real *p_q, pk_real *pdot_q, pk_real *pdot_v)
{
    UNUSED;
    for (int i = 0; i < 4; i++)
        p_q[i] = pdot_q[i] = pdot_v[i] = 0;
    pdot_q[0] = -G(params) * PK_F(cos)(q[0]);
    pdot_v[1] = pdot_v[3] = -1;
    pdot_v[2] = 1;
}
LINEAR(maxwell, 2)
static pk_real maxwell_energy(ARGS)
{
    UNUSED;
    return v[0] * v[0] / 2 - G(params) * PK_F(cos)(q[0]);
}
SIZES(maxwell, 2, 0)
#undef PK_MODEL
#define PK_MODEL(x) maxwell_##x
#undef PK_MODEL_FIRST_ORDER
#define PK_MODEL_FIRST_ORDER 1
#include <pk/inlined.h>
SYSTEM(maxwell, 2, FIRST_ORDER, PK_C(9.81), PK_C(0.0), none_cyclic, LIST(PK_C(1.0), PK_C(0.0)),
       LIST(PK_C(0.0), PK_C(0.2)), .linear = maxwell_linear, .n_first_order = 1, );

/* r'' = g/r^3 - 1/r^2, phi' = sqrt(g)/r^2. */
static void turning_force(ARGS, pk_real *f)
{
    UNUSED;
    f[0] = G(params) / (q[0] * q[0] * q[0]) - 1 / (q[0] * q[0]);
    f[1] = PK_F(sqrt)(G(params)) / (q[0] * q[0]);
}
UNIT_MASS(turning, 2)
static void turning_gradient(ARGS, pk_real *d)
{
    turning_force(params, t, q, v, u, d);
    d[1] = 0;
}
static void turning_jacobian(ARGS, pk_real *p_q, pk_real *pdot_q, pk_real *pdot_v)
{
    UNUSED;
    for (int i = 0; i < 4; i++)
        p_q[i] = pdot_q[i] = pdot_v[i] = 0;
    pdot_q[0] = 2 / (q[0] * q[0] * q[0]) - 3 * G(params) / (q[0] * q[0] * q[0] * q[0]);
    pdot_q[2] = -2 * PK_F(sqrt)(G(params)) / (q[0] * q[0] * q[0]);
}
LINEAR(turning, 2)
static pk_real turning_energy(ARGS)
{
    UNUSED;
    return v[0] * v[0] / 2 + G(params) / (2 * q[0] * q[0]) - 1 / q[0];
}
SIZES(turning, 2, 0)
#undef PK_MODEL
#define PK_MODEL(x) turning_##x
#include <pk/inlined.h>
SYSTEM(turning, 2, FIRST_ORDER | PK_SEPARABLE | PK_CONSERVATIVE | PK_VARIATIONAL, PK_C(0.75), 0,
       none_cyclic, LIST(PK_C(0.5), PK_C(0.0)), LIST(PK_C(0.0), PK_C(0.25)),
       .linear = turning_linear, .n_first_order = 1, );

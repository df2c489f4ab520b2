/* Systems of systems.h with one degree of freedom whose mass varies: with v, or with q and t. */
#include "systems_make.h"

/* Relativistic oscillator: p = v g, g = (1 - v^2)^(-1/2); M = g^3. */
static pk_real lorentz(const pk_real *v) { return 1 / PK_F(sqrt)(1 - v[0] * v[0]); }
static void relativistic_mass(ARGS, pk_real *M)
{
    const pk_real g = lorentz(v);
    UNUSED;
    M[0] = g * g * g;
}
static void relativistic_gradient(ARGS, pk_real *d)
{
    UNUSED;
    d[0] = -G(params) * q[0];
}
#define relativistic_force relativistic_gradient
static int relativistic_acceleration(ARGS, pk_real *a)
{
    pk_real M;
    relativistic_mass(params, t, q, v, u, &M);
    if (!(M > 0))
        return 1;
    a[0] = -G(params) * q[0] / M;
    return 0;
}
static void relativistic_canonical(ARGS, pk_real *p, pk_real *pdot)
{
    UNUSED;
    p[0] = v[0] * lorentz(v);
    pdot[0] = -G(params) * q[0];
}
static void relativistic_jacobian(ARGS, pk_real *p_q, pk_real *pdot_q, pk_real *pdot_v)
{
    UNUSED;
    p_q[0] = pdot_v[0] = 0;
    pdot_q[0] = -G(params);
}
static void relativistic_linear(ARGS, const pk_real *a, pk_real *r_q, pk_real *r_v, pk_real *r_t)
{
    const pk_real g = lorentz(v);
    UNUSED;
    r_q[0] = -G(params);
    r_v[0] = -3 * g * g * g * g * g * v[0] * a[0];
    r_t[0] = 0;
}
static pk_real relativistic_energy(ARGS)
{
    UNUSED;
    return lorentz(v) + G(params) * q[0] * q[0] / 2;
}
SIZES(relativistic, 1, 0)
#undef PK_MODEL
#define PK_MODEL(x) relativistic_##x
#include <pk/inlined.h>
SYSTEM(relativistic, 1, NATURAL & ~(unsigned)(PK_MASS_CONSTANT | PK_QUADRATIC | PK_SEPARABLE),
       PK_C(1.0), 0, none_cyclic, LIST(PK_C(1.7)), LIST(PK_C(0.2)), .linear = relativistic_linear);

/* p = E (1 + q^2) v with E = exp(t/2), see systems.h. */
#define E_OF_T PK_F(exp)(t / 2)
#define DRAG (PK_C(0.3) * (2 + PK_F(cos)(t)))
static void forced_mass(ARGS, pk_real *M)
{
    UNUSED;
    M[0] = E_OF_T * (1 + q[0] * q[0]);
}
static void forced_gradient(ARGS, pk_real *d)
{
    UNUSED;
    d[0] = E_OF_T * q[0] * v[0] * v[0] - G(params) * PK_F(cos)(t) * q[0];
}
static void forced_canonical(ARGS, pk_real *p, pk_real *pdot)
{
    p[0] = E_OF_T * (1 + q[0] * q[0]) * v[0];
    forced_gradient(params, t, q, v, u, pdot);
    pdot[0] += PK_C(0.2) * PK_F(sin)(3 * t) - v[0] * v[0] * v[0] / 9 - DRAG * v[0];
}
static void forced_force(ARGS, pk_real *f)
{
    pk_real p, pdot;
    forced_canonical(params, t, q, v, u, &p, &pdot);
    f[0] = pdot - 2 * E_OF_T * q[0] * v[0] * v[0] - p / 2;
}
static int forced_acceleration(ARGS, pk_real *a)
{
    forced_force(params, t, q, v, u, a);
    a[0] /= E_OF_T * (1 + q[0] * q[0]);
    return 0;
}
static void forced_jacobian(ARGS, pk_real *p_q, pk_real *pdot_q, pk_real *pdot_v)
{
    UNUSED;
    p_q[0] = 2 * E_OF_T * q[0] * v[0];
    pdot_q[0] = E_OF_T * v[0] * v[0] - G(params) * PK_F(cos)(t);
    pdot_v[0] = p_q[0] - v[0] * v[0] / 3 - DRAG;
}
static pk_real forced_energy(ARGS)
{
    UNUSED;
    return E_OF_T * (1 + q[0] * q[0]) * v[0] * v[0] / 2 +
           G(params) * PK_F(cos)(t) * q[0] * q[0] / 2;
}
SIZES(forced, 1, 0)
#undef PK_MODEL
#define PK_MODEL(x) forced_##x
#include <pk/inlined.h>
SYSTEM(forced, 1, PK_QUADRATIC | PK_SMOOTH, PK_C(1.7), 0, none_cyclic, LIST(PK_C(0.7)),
       LIST(PK_C(0.9)), );

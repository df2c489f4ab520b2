/* Systems of systems.h that are stiff and dissipate, and one whose mass dips below zero in
 * passing. */
#include "systems_make.h"

#define DISSIPATIVE (PK_MASS_CONSTANT | PK_MASS_DIAGONAL | PK_QUADRATIC | PK_AUTONOMOUS | PK_SMOOTH)

/* Van der Pol: a force g (1 - q^2) v beside -q. */
static void van_der_pol_force(ARGS, pk_real *f)
{
    UNUSED;
    f[0] = G(params) * (1 - q[0] * q[0]) * v[0] - q[0];
}
UNIT_MASS(van_der_pol, 1)
static void van_der_pol_gradient(ARGS, pk_real *d)
{
    UNUSED;
    d[0] = -q[0];
}
static void van_der_pol_jacobian(ARGS, pk_real *p_q, pk_real *pdot_q, pk_real *pdot_v)
{
    UNUSED;
    p_q[0] = 0;
    pdot_q[0] = -2 * G(params) * q[0] * v[0] - 1;
    pdot_v[0] = G(params) * (1 - q[0] * q[0]);
}
static pk_real van_der_pol_energy(ARGS)
{
    UNUSED;
    return (v[0] * v[0] + q[0] * q[0]) / 2;
}
SIZES(van_der_pol, 1, 0)
#undef PK_MODEL
#define PK_MODEL(x) van_der_pol_##x
#include <pk/inlined.h>
SYSTEM(van_der_pol, 1, DISSIPATIVE, PK_C(300.0), 0, none_cyclic, LIST(PK_C(2.0)),
       LIST(PK_C(0.0)), );

/* Two unit masses, a spring g and a damper `limit` between them, the first a pendulum. */
static void damped_force(ARGS, pk_real *f)
{
    const pk_real pull = G(params) * (q[1] - q[0]) + LIMIT(params) * (v[1] - v[0]);
    UNUSED;
    f[0] = pull - PK_F(sin)(q[0]);
    f[1] = -pull;
}
UNIT_MASS(damped, 2)
static void damped_gradient(ARGS, pk_real *d)
{
    UNUSED;
    d[0] = G(params) * (q[1] - q[0]) - PK_F(sin)(q[0]);
    d[1] = G(params) * (q[0] - q[1]);
}
static void damped_jacobian(ARGS, pk_real *p_q, pk_real *pdot_q, pk_real *pdot_v)
{
    UNUSED;
    for (int i = 0; i < 4; i++) {
        const pk_real sign = i / 2 == i % 2 ? -1 : 1;
        p_q[i] = 0;
        pdot_q[i] = sign * G(params);
        pdot_v[i] = sign * LIMIT(params);
    }
    pdot_q[0] -= PK_F(cos)(q[0]);
}
static pk_real damped_energy(ARGS)
{
    UNUSED;
    return (v[0] * v[0] + v[1] * v[1] + G(params) * (q[1] - q[0]) * (q[1] - q[0])) / 2 -
           PK_F(cos)(q[0]);
}
SIZES(damped, 2, 0)
#undef PK_MODEL
#define PK_MODEL(x) damped_##x
#include <pk/inlined.h>
SYSTEM(damped, 2, DISSIPATIVE, PK_C(1e6), PK_C(1e4), none_cyclic, LIST(PK_C(1.0), PK_C(1.01)),
       LIST(PK_C(0.0), PK_C(0.3)), );

/* M(t) = 1 - 1.5 exp(-((t - limit) / .01)^2): indefinite about t = limit alone. */
static void dipping_mass(ARGS, pk_real *M)
{
    const pk_real x = (t - LIMIT(params)) * 100;
    UNUSED;
    M[0] = 1 - PK_C(1.5) * PK_F(exp)(-x * x);
}
static void dipping_force(ARGS, pk_real *f)
{
    const pk_real x = (t - LIMIT(params)) * 100;
    UNUSED;
    f[0] = -300 * x * PK_F(exp)(-x * x) * v[0];
}
static int dipping_acceleration(ARGS, pk_real *a)
{
    pk_real M;
    dipping_mass(params, t, q, v, u, &M);
    dipping_force(params, t, q, v, u, a);
    a[0] /= M;
    return !(M > 0);
}
static void dipping_gradient(ARGS, pk_real *d)
{
    UNUSED;
    d[0] = 0;
}
static void dipping_canonical(ARGS, pk_real *p, pk_real *pdot)
{
    dipping_mass(params, t, q, v, u, p);
    p[0] *= v[0];
    pdot[0] = 0;
}
static void dipping_jacobian(ARGS, pk_real *p_q, pk_real *pdot_q, pk_real *pdot_v)
{
    UNUSED;
    p_q[0] = pdot_q[0] = pdot_v[0] = 0;
}
static pk_real dipping_energy(ARGS)
{
    pk_real M;
    dipping_mass(params, t, q, v, u, &M);
    return M * v[0] * v[0] / 2;
}
SIZES(dipping, 1, 0)
#undef PK_MODEL
#define PK_MODEL(x) dipping_##x
#include <pk/inlined.h>
SYSTEM(dipping, 1, PK_QUADRATIC | PK_VARIATIONAL | PK_SMOOTH, PK_C(1.0), PK_C(0.5), none_cyclic,
       LIST(PK_C(0.7)), LIST(PK_C(0.2)), );

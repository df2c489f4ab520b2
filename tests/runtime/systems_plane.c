/* Systems of systems.h with two degrees of freedom that keep their energy. References:
 * H. Goldstein, Classical Mechanics, 3rd ed., 1.6, 3.2, 7.9; for the double pendulum any text:
 * M = [[2, c], [c, 1]], c = cos(q1 - q2).
 */
#include "systems_make.h"

static const struct pk_quantity angular[] = {{"angular momentum", "", ""}};

/* Double pendulum, m = l = 1: L = v1^2 + v2^2/2 + c v1 v2 + g (2 cos q1 + cos q2). */
static void double_pendulum_mass(ARGS, pk_real *M)
{
    UNUSED;
    M[0] = 2;
    M[1] = M[2] = PK_F(cos)(q[0] - q[1]);
    M[3] = 1;
}
static void double_pendulum_force(ARGS, pk_real *f)
{
    const pk_real s = PK_F(sin)(q[0] - q[1]);
    UNUSED;
    f[0] = -s * v[1] * v[1] - 2 * G(params) * PK_F(sin)(q[0]);
    f[1] = s * v[0] * v[0] - G(params) * PK_F(sin)(q[1]);
}
static int double_pendulum_acceleration(ARGS, pk_real *a)
{
    const pk_real c = PK_F(cos)(q[0] - q[1]), det = 2 - c * c;
    pk_real f[2];
    double_pendulum_force(params, t, q, v, u, f);
    if (!(det > 0))
        return PK_FAILED(PK_FAILURE_MASS, 1);
    a[0] = (f[0] - c * f[1]) / det;
    a[1] = (2 * f[1] - c * f[0]) / det;
    return 0;
}
static void double_pendulum_gradient(ARGS, pk_real *d)
{
    const pk_real s = PK_F(sin)(q[0] - q[1]);
    UNUSED;
    d[0] = -s * v[0] * v[1] - 2 * G(params) * PK_F(sin)(q[0]);
    d[1] = s * v[0] * v[1] - G(params) * PK_F(sin)(q[1]);
}
static void double_pendulum_canonical(ARGS, pk_real *p, pk_real *pdot)
{
    const pk_real c = PK_F(cos)(q[0] - q[1]);
    p[0] = 2 * v[0] + c * v[1];
    p[1] = v[1] + c * v[0];
    double_pendulum_gradient(params, t, q, v, u, pdot);
}
static void double_pendulum_jacobian(ARGS, pk_real *p_q, pk_real *pdot_q, pk_real *pdot_v)
{
    const pk_real s = PK_F(sin)(q[0] - q[1]), c = PK_F(cos)(q[0] - q[1]);
    UNUSED;
    p_q[0] = -s * v[1], p_q[1] = s * v[1];
    p_q[2] = -s * v[0], p_q[3] = s * v[0];
    pdot_q[0] = -c * v[0] * v[1] - 2 * G(params) * PK_F(cos)(q[0]);
    pdot_q[1] = pdot_q[2] = c * v[0] * v[1];
    pdot_q[3] = -c * v[0] * v[1] - G(params) * PK_F(cos)(q[1]);
    pdot_v[0] = -s * v[1], pdot_v[1] = -s * v[0];
    pdot_v[2] = s * v[1], pdot_v[3] = s * v[0];
}
static void double_pendulum_linear(ARGS, const pk_real *a, pk_real *r_q, pk_real *r_v, pk_real *r_t)
{
    const pk_real s = PK_F(sin)(q[0] - q[1]), c = PK_F(cos)(q[0] - q[1]);
    UNUSED;
    r_q[1] = c * v[1] * v[1] - s * a[1];
    r_q[0] = -r_q[1] - 2 * G(params) * PK_F(cos)(q[0]);
    r_q[2] = c * v[0] * v[0] + s * a[0];
    r_q[3] = -r_q[2] - G(params) * PK_F(cos)(q[1]);
    r_v[0] = r_v[3] = r_t[0] = r_t[1] = 0;
    r_v[1] = -2 * s * v[1];
    r_v[2] = 2 * s * v[0];
}
static pk_real double_pendulum_energy(ARGS)
{
    UNUSED;
    return v[0] * v[0] + v[1] * v[1] / 2 + PK_F(cos)(q[0] - q[1]) * v[0] * v[1] -
           G(params) * (2 * PK_F(cos)(q[0]) + PK_F(cos)(q[1]));
}
SIZES(double_pendulum, 2, 0)
#undef PK_MODEL
#define PK_MODEL(x) double_pendulum_##x
#include <pk/inlined.h>
SYSTEM(double_pendulum, 2, GENERAL, PK_C(9.81), 0, none_cyclic, LIST(PK_C(1.3), PK_C(-0.9)),
       LIST(PK_C(0.2), PK_C(0.4)), .linear = double_pendulum_linear);

/* Kepler, L = v^2/2 + mu/r. */
static void kepler_gradient(ARGS, pk_real *d)
{
    const pk_real r2 = q[0] * q[0] + q[1] * q[1], k = G(params) / (r2 * PK_F(sqrt)(r2));
    UNUSED;
    d[0] = -k * q[0];
    d[1] = -k * q[1];
}
#define kepler_force kepler_gradient
UNIT_MASS(kepler, 2)
static void kepler_jacobian(ARGS, pk_real *p_q, pk_real *pdot_q, pk_real *pdot_v)
{
    const pk_real r2 = q[0] * q[0] + q[1] * q[1], k = G(params) / (r2 * PK_F(sqrt)(r2));
    UNUSED;
    for (int i = 0; i < 4; i++) {
        p_q[i] = pdot_v[i] = 0;
        pdot_q[i] = k * (3 * q[i / 2] * q[i % 2] / r2 - (i / 2 == i % 2 ? 1 : 0));
    }
}
LINEAR(kepler, 2)
static pk_real kepler_energy(ARGS)
{
    UNUSED;
    return (v[0] * v[0] + v[1] * v[1]) / 2 - G(params) / PK_F(sqrt)(q[0] * q[0] + q[1] * q[1]);
}
static void kepler_conserve(ARGS, pk_real *out)
{
    UNUSED;
    out[0] = q[0] * v[1] - q[1] * v[0];
}
SIZES(kepler, 2, 0)
#undef PK_MODEL
#define PK_MODEL(x) kepler_##x
#include <pk/inlined.h>
SYSTEM(kepler, 2, NATURAL, PK_C(1.0), 0, none_cyclic, LIST(PK_C(0.4), PK_C(0.0)),
       LIST(PK_C(0.0), PK_C(2.0)), .n_conserved = 1, .conserved = angular,
       .conserve = kepler_conserve, .linear = kepler_linear);

/* Restricted three bodies, mu = .012277471. */
static int arenstorf_acceleration(ARGS, pk_real *a)
{
    const pk_real mu = PK_C(0.012277471), nu = 1 - mu;
    const pk_real d1 = PK_F(pow)((q[0] + mu) * (q[0] + mu) + q[1] * q[1], PK_C(1.5));
    const pk_real d2 = PK_F(pow)((q[0] - nu) * (q[0] - nu) + q[1] * q[1], PK_C(1.5));
    UNUSED;
    a[0] = q[0] + 2 * v[1] - nu * (q[0] + mu) / d1 - mu * (q[0] - nu) / d2;
    a[1] = q[1] - 2 * v[0] - nu * q[1] / d1 - mu * q[1] / d2;
    return 0;
}
#define arenstorf_mass kepler_mass
#define arenstorf_force kepler_force
#define arenstorf_canonical kepler_canonical
#define arenstorf_gradient kepler_gradient
#define arenstorf_jacobian kepler_jacobian
#define arenstorf_energy kepler_energy
SIZES(arenstorf, 2, 0)
#undef PK_MODEL
#define PK_MODEL(x) arenstorf_##x
#include <pk/inlined.h>
SYSTEM(arenstorf, 2, PK_QUADRATIC | PK_SMOOTH, PK_C(1.0), 0, none_cyclic,
       LIST(PK_C(0.994), PK_C(0.0)), LIST(PK_C(0.0), PK_C(-2.00158510637908252240537862224)), );

/* The systems of systems.h. Kernels are written out for each; facts and tables come from one
 * macro. References: H. Goldstein, Classical Mechanics, 3rd ed., 1.6, 3.2, 7.9; for the double
 * pendulum any text: M = [[2, c], [c, 1]], c = cos(q1 - q2).
 */
#include "systems.h"

#include <stddef.h>
#include <string.h>

#define G(params) (((const struct test_params *)(params))->g)
#define LIMIT(params) (((const struct test_params *)(params))->limit)
#define ARGS const void *params, pk_real t, const pk_real *q, const pk_real *v, const pk_real *u
#define UNUSED (void)params, (void)t, (void)q, (void)v, (void)u

static void derive(void *params, const unsigned char *given) { (void)params, (void)given; }
static int prepare(void *params)
{
    return G(params) - G(params) == 0 && G(params) > 0 ? 0 : 1;
}
static void bounds(const void *params, pk_real *lo, pk_real *hi)
{
    (void)params;
    lo[0] = 0, lo[1] = -(pk_real)INFINITY;
    hi[0] = hi[1] = (pk_real)INFINITY;
}

static const struct pk_parameter parameters[] = {
    {{"g", "", ""}, offsetof(struct test_params, g), 0, 1, 0},
    {{"limit", "", ""}, offsetof(struct test_params, limit), 0, 0, 0}};
static const struct pk_quantity coordinates[] = {{"x", "", ""}, {"y,1", "", ""}};
static const struct pk_quantity rates[] = {{"x'", "", ""}, {"y,1'", "", ""}};
static const struct pk_quantity momenta[] = {{"p_x", "", ""}, {"p_y", "", ""}};
static const struct pk_quantity inputs[] = {{"u", "", ""}};
static const struct pk_quantity angular[] = {{"angular momentum", "", ""}};
static const unsigned char none_cyclic[] = {0, 0};

#define SYSTEM(NAME, N, FACTS, GRAVITY, LIMIT0, CYCLIC, START_Q, START_V, ...)               \
    static void NAME##_defaults(void *params)                                               \
    {                                                                                       \
        struct test_params *p = (struct test_params *)params;                               \
        p->g = GRAVITY;                                                                     \
        p->limit = LIMIT0;                                                                  \
    }                                                                                       \
    static void NAME##_start(const void *params, pk_real *q, pk_real *v)                    \
    {                                                                                       \
        static const pk_real q0[] = START_Q, v0[] = START_V;                                \
        (void)params;                                                                       \
        memcpy(q, q0, sizeof q0);                                                           \
        memcpy(v, v0, sizeof v0);                                                           \
    }                                                                                       \
    const struct pk_system NAME##_system = {.abi = PK_ABI,                                  \
                                            .name = #NAME,                                  \
                                            .source_hash = "by hand",                       \
                                            .facts = FACTS,                                 \
                                            .n = N,                                         \
                                            .n_parameters = 2,                              \
                                            .params_size = sizeof(struct test_params),      \
                                            .coordinates = coordinates,                     \
                                            .rates = rates,                                 \
                                            .momenta = momenta,                             \
                                            .parameters = parameters,                       \
                                            .cyclic = CYCLIC,                               \
                                            .defaults = NAME##_defaults,                    \
                                            .derive = derive,                               \
                                            .prepare = prepare,                             \
                                            .bounds = bounds,                               \
                                            .start = NAME##_start,                          \
                                            .acceleration = NAME##_acceleration,            \
                                            .mass = NAME##_mass,                            \
                                            .force = NAME##_force,                          \
                                            .canonical = NAME##_canonical,                  \
                                            .gradient = NAME##_gradient,                    \
                                            .jacobian = NAME##_jacobian,                    \
                                            .energy = NAME##_energy,                        \
                                            __VA_ARGS__}

#define LIST(...) {__VA_ARGS__}
#define NATURAL \
    (PK_MASS_CONSTANT | PK_MASS_DIAGONAL | PK_QUADRATIC | PK_SEPARABLE | PK_AUTONOMOUS | \
     PK_CONSERVATIVE | PK_VARIATIONAL | PK_SMOOTH)

/* One degree of freedom and M = 1: all kernels from V(q, t), its derivatives, and nothing else. */
#define POINT_MASS(NAME, V, FORCE, DFORCE)                                                   \
    static int NAME##_acceleration(ARGS, pk_real *a)                                        \
    {                                                                                       \
        UNUSED;                                                                             \
        a[0] = FORCE;                                                                       \
        return 0;                                                                           \
    }                                                                                       \
    static void NAME##_mass(ARGS, pk_real *M)                                               \
    {                                                                                       \
        UNUSED;                                                                             \
        M[0] = 1;                                                                           \
    }                                                                                       \
    static void NAME##_force(ARGS, pk_real *f)                                              \
    {                                                                                       \
        UNUSED;                                                                             \
        f[0] = FORCE;                                                                       \
    }                                                                                       \
    static void NAME##_canonical(ARGS, pk_real *p, pk_real *pdot)                           \
    {                                                                                       \
        UNUSED;                                                                             \
        p[0] = v[0];                                                                        \
        pdot[0] = FORCE;                                                                    \
    }                                                                                       \
    static void NAME##_gradient(ARGS, pk_real *d)                                           \
    {                                                                                       \
        UNUSED;                                                                             \
        d[0] = FORCE;                                                                       \
    }                                                                                       \
    static void NAME##_jacobian(ARGS, pk_real *p_q, pk_real *pdot_q, pk_real *pdot_v)       \
    {                                                                                       \
        UNUSED;                                                                             \
        p_q[0] = 0;                                                                         \
        pdot_q[0] = DFORCE;                                                                 \
        pdot_v[0] = 0;                                                                      \
    }                                                                                       \
    static pk_real NAME##_energy(ARGS)                                                      \
    {                                                                                       \
        UNUSED;                                                                             \
        return v[0] * v[0] / 2 + (V);                                                       \
    }

POINT_MASS(pendulum, -G(params) * PK_F(cos)(q[0]), -G(params) * PK_F(sin)(q[0]),
           -G(params) * PK_F(cos)(q[0]))
SYSTEM(pendulum, 1, NATURAL, PK_C(1.0), 0, none_cyclic, LIST(PK_C(2.385)), LIST(PK_C(0.13)), );

POINT_MASS(oscillator, G(params) * q[0] * q[0] / 2, -G(params) * q[0], -G(params))
SYSTEM(oscillator, 1, NATURAL, PK_C(1.0), 0, none_cyclic, LIST(PK_C(0.7)), LIST(PK_C(0.2)), );

#define DRIVEN (NATURAL & ~(unsigned)(PK_AUTONOMOUS | PK_CONSERVATIVE))
POINT_MASS(driven, G(params) * q[0] * q[0] / 2 - q[0] * PK_F(cos)(3 * t),
           -G(params) * q[0] + PK_F(cos)(3 * t), -G(params))
SYSTEM(driven, 1, DRIVEN, PK_C(2.0), 0, none_cyclic, LIST(PK_C(0.7)), LIST(PK_C(0.2)), );

void driven_exact(pk_real t, pk_real *q, pk_real *v)
{
    const pk_real w = PK_F(sqrt)(PK_C(2.0)), A = 1 / (PK_C(2.0) - 9);
    const pk_real a = PK_C(0.7) - A, b = PK_C(0.2) / w;
    *q = A * PK_F(cos)(3 * t) + a * PK_F(cos)(w * t) + b * PK_F(sin)(w * t);
    *v = -3 * A * PK_F(sin)(3 * t) - a * w * PK_F(sin)(w * t) + b * w * PK_F(cos)(w * t);
}

POINT_MASS(broken, 0, PK_F(sqrt)(LIMIT(params) - t), 0)
SYSTEM(broken, 1, DRIVEN, PK_C(1.0), PK_C(1.25), none_cyclic, LIST(PK_C(0.7)),
       LIST(PK_C(0.2)), );

POINT_MASS(pushed, 0, u[0], 0)
SYSTEM(pushed, 1, DRIVEN, PK_C(1.0), 0, none_cyclic, LIST(PK_C(0.7)), LIST(PK_C(0.2)),
       .n_inputs = 1, .inputs = inputs);

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
        return 2;
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
static pk_real double_pendulum_energy(ARGS)
{
    UNUSED;
    return v[0] * v[0] + v[1] * v[1] / 2 + PK_F(cos)(q[0] - q[1]) * v[0] * v[1] -
           G(params) * (2 * PK_F(cos)(q[0]) + PK_F(cos)(q[1]));
}
#define GENERAL (NATURAL & ~(unsigned)(PK_MASS_CONSTANT | PK_MASS_DIAGONAL | PK_SEPARABLE))
SYSTEM(double_pendulum, 2, GENERAL, PK_C(9.81), 0, none_cyclic, LIST(PK_C(1.3), PK_C(-0.9)),
       LIST(PK_C(0.2), PK_C(0.4)), );

/* Kepler, L = v^2/2 + mu/r. */
static void kepler_gradient(ARGS, pk_real *d)
{
    const pk_real r2 = q[0] * q[0] + q[1] * q[1], k = G(params) / (r2 * PK_F(sqrt)(r2));
    UNUSED;
    d[0] = -k * q[0];
    d[1] = -k * q[1];
}
static int kepler_acceleration(ARGS, pk_real *a)
{
    kepler_gradient(params, t, q, v, u, a);
    return 0;
}
#define kepler_force kepler_gradient
static void kepler_mass(ARGS, pk_real *M)
{
    UNUSED;
    M[0] = M[3] = 1;
    M[1] = M[2] = 0;
}
static void kepler_canonical(ARGS, pk_real *p, pk_real *pdot)
{
    p[0] = v[0];
    p[1] = v[1];
    kepler_gradient(params, t, q, v, u, pdot);
}
static void kepler_jacobian(ARGS, pk_real *p_q, pk_real *pdot_q, pk_real *pdot_v)
{
    const pk_real r2 = q[0] * q[0] + q[1] * q[1], k = G(params) / (r2 * PK_F(sqrt)(r2));
    UNUSED;
    for (int i = 0; i < 4; i++) {
        p_q[i] = pdot_v[i] = 0;
        pdot_q[i] = k * (3 * q[i / 2] * q[i % 2] / r2 - (i / 2 == i % 2 ? 1 : 0));
    }
}
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
SYSTEM(kepler, 2, NATURAL, PK_C(1.0), 0, none_cyclic, LIST(PK_C(0.4), PK_C(0.0)),
       LIST(PK_C(0.0), PK_C(2.0)), .n_conserved = 1, .conserved = angular,
       .conserve = kepler_conserve);

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
static pk_real relativistic_energy(ARGS)
{
    UNUSED;
    return lorentz(v) + G(params) * q[0] * q[0] / 2;
}
SYSTEM(relativistic, 1,
       NATURAL & ~(unsigned)(PK_MASS_CONSTANT | PK_QUADRATIC | PK_SEPARABLE), PK_C(1.0), 0,
       none_cyclic, LIST(PK_C(1.7)), LIST(PK_C(0.2)), );

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
SYSTEM(folded, 1, GENERAL, PK_C(1.0), PK_C(1.25), none_cyclic, LIST(PK_C(0.7)),
       LIST(PK_C(0.2)), );

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
SYSTEM(forced, 1, PK_QUADRATIC | PK_SMOOTH, PK_C(1.7), 0, none_cyclic, LIST(PK_C(0.7)),
       LIST(PK_C(0.9)), );

/* Derivatives of r = f - M a with a held, of systems.h's; see there for f and M. */
#include <math.h>
#include <string.h>

#include "linear_systems.h"

#define ARGS                                                                          \
    const void *params, pk_real t, const pk_real *q, const pk_real *v, const pk_real *u, \
        const pk_real *a, pk_real *r_q, pk_real *r_v, pk_real *r_t
#define UNUSED (void)params, (void)t, (void)q, (void)v, (void)u, (void)a
#define G(params) (((const struct test_params *)(params))->g)

/* r0 = -s v1^2 - 2 g sin q0 - 2 a0 - c a1, r1 = s v0^2 - g sin q1 - c a0 - a1. */
static void double_pendulum(ARGS)
{
    const double s = sin(q[0] - q[1]), c = cos(q[0] - q[1]);
    UNUSED;
    r_q[1] = c * v[1] * v[1] - s * a[1];
    r_q[0] = -r_q[1] - 2 * G(params) * cos(q[0]);
    r_q[2] = c * v[0] * v[0] + s * a[0];
    r_q[3] = -r_q[2] - G(params) * cos(q[1]);
    r_v[0] = r_v[3] = 0;
    r_v[1] = -2 * s * v[1];
    r_v[2] = 2 * s * v[0];
    r_t[0] = r_t[1] = 0;
}

static void pendulum(ARGS)
{
    UNUSED;
    r_q[0] = -G(params) * cos(q[0]);
    r_v[0] = r_t[0] = 0;
}

static void oscillator(ARGS)
{
    UNUSED;
    r_q[0] = -G(params);
    r_v[0] = r_t[0] = 0;
}

/* M = (1 - v^2)^(-3/2). */
static void relativistic(ARGS)
{
    UNUSED;
    r_q[0] = -G(params);
    r_v[0] = -3 * v[0] * pow(1 - v[0] * v[0], -2.5) * a[0];
    r_t[0] = 0;
}

#define WITH_LINEAR(name)                            \
    struct pk_system linear_##name(void)             \
    {                                                \
        struct pk_system system = name##_system;     \
        system.linear = name;                        \
        return system;                               \
    }

WITH_LINEAR(double_pendulum)
WITH_LINEAR(pendulum)
WITH_LINEAR(oscillator)
WITH_LINEAR(relativistic)

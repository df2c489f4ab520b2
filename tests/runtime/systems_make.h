/* What the hand-written systems are made of. Kernels are written out for each; facts and tables
 * come from one macro, SYSTEM, and all kernels of a point mass from another, POINT_MASS. Compiled
 * with -DPK_INLINE_ERK and so on, they bring their own steps as generated C does.
 */
#ifndef TEST_SYSTEMS_MAKE_H
#define TEST_SYSTEMS_MAKE_H

#include <stddef.h>
#include <string.h>

#include "systems.h"

#define G(params) (((const struct test_params *)(params))->g)
#define LIMIT(params) (((const struct test_params *)(params))->limit)

static void derive(void *params, const unsigned char *given) { (void)params, (void)given; }
static int prepare(void *params) { return G(params) - G(params) == 0 && G(params) > 0 ? 0 : 1; }
static void bounds(const void *params, pk_real *lo, pk_real *hi)
{
    (void)params;
    lo[0] = 0, lo[1] = -(pk_real)INFINITY;
    hi[0] = hi[1] = (pk_real)INFINITY;
}

/* A part of the acceleration, which may be any. */
static inline void fast_1(ARGS, pk_real *a)
{
    UNUSED;
    a[0] = -q[0] / 3;
}
static inline void fast_2(ARGS, pk_real *a)
{
    fast_1(params, t, q, v, u, a);
    fast_1(params, t, q + 1, v, u, a + 1);
}

static const struct pk_parameter parameters[] = {
    {{"g", "", ""}, offsetof(struct test_params, g), 0, 1, 0},
    {{"limit", "", ""}, offsetof(struct test_params, limit), 0, 0, 0}};
static const struct pk_quantity coordinates[] = {{"x", "", ""}, {"y,1", "", ""}};
static const struct pk_quantity rates[] = {{"x'", "", ""}, {"y,1'", "", ""}};
static const struct pk_quantity momenta[] = {{"p_x", "", ""}, {"p_y", "", ""}};
static const unsigned char none_cyclic[] = {0, 0};

/* What pk/inlined.h wants: constants, and lane kernels, here lane by lane. */
#define SIZES(NAME, N, INPUTS)                                                                     \
    enum { NAME##_N = N, NAME##_INPUTS = INPUTS };                                                 \
    PK_INLINE                                                                                      \
    static unsigned long long NAME##_lanes_inline(size_t W, const void *params, const pk_real *t,  \
                                                  const pk_real *q, const pk_real *v,              \
                                                  const pk_real *u, pk_real *a)                    \
    {                                                                                              \
        unsigned long long failed = 0;                                                             \
        for (size_t l = 0; l < W; l++) {                                                           \
            pk_real q1[N], v1[N], a1[N], u1[INPUTS + 1];                                           \
            for (size_t i = 0; i < N; i++)                                                         \
                q1[i] = q[i * W + l], v1[i] = v[i * W + l], a1[i] = 0;                             \
            for (size_t i = 0; i + 1 < sizeof u1 / sizeof *u1; i++)                                \
                u1[i] = u[i * W + l];                                                              \
            if (NAME##_acceleration(params, t[l], q1, v1, u1, a1))                                 \
                failed |= 1ull << l;                                                               \
            for (size_t i = 0; i < N; i++)                                                         \
                a[i * W + l] = a1[i];                                                              \
        }                                                                                          \
        return failed;                                                                             \
    }                                                                                              \
    PK_INLINE                                                                                      \
    static unsigned long long NAME##_members_inline(size_t W, const pk_real *P, const pk_real *t,  \
                                                    const pk_real *q, const pk_real *v,            \
                                                    const pk_real *u, pk_real *a)                  \
    {                                                                                              \
        unsigned long long failed = 0;                                                             \
        for (size_t l = 0; l < W; l++) {                                                           \
            const struct test_params params = {P[l], P[W + l], {0}};                               \
            pk_real q1[N], v1[N], a1[N], u1[INPUTS + 1] = {0};                                     \
            for (size_t i = 0; i < N; i++)                                                         \
                q1[i] = q[i * W + l], v1[i] = v[i * W + l];                                        \
            for (int i = 0; i < INPUTS; i++)                                                       \
                u1[i] = u[(size_t)i * W + l];                                                      \
            if (NAME##_acceleration(&params, t[l], q1, v1, u1, a1))                                \
                failed |= 1ull << l;                                                               \
            else                                                                                   \
                for (size_t i = 0; i < N; i++)                                                     \
                    a[i * W + l] = a1[i];                                                          \
        }                                                                                          \
        return failed;                                                                             \
    }                                                                                              \
    static unsigned long long NAME##_members(const pk_real *P, const pk_real *t, const pk_real *q, \
                                             const pk_real *v, const pk_real *u, pk_real *a)       \
    {                                                                                              \
        return NAME##_members_inline(PK_LANES, P, t, q, v, u, a);                                  \
    }

#define SYSTEM(NAME, N, FACTS, GRAVITY, LIMIT0, CYCLIC, START_Q, START_V, ...)          \
    static void NAME##_defaults(void *params)                                           \
    {                                                                                   \
        struct test_params *p = (struct test_params *)params;                           \
        p->g = GRAVITY;                                                                 \
        p->limit = LIMIT0;                                                              \
    }                                                                                   \
    static void NAME##_start(const void *params, pk_real *q, pk_real *v)                \
    {                                                                                   \
        static const pk_real q0[] = START_Q, v0[] = START_V;                            \
        (void)params;                                                                   \
        memcpy(q, q0, sizeof q0);                                                       \
        memcpy(v, v0, sizeof v0);                                                       \
    }                                                                                   \
    const struct pk_system NAME##_system = {.abi = PK_ABI,                              \
                                            .size = sizeof(struct pk_system),           \
                                            .name = #NAME,                              \
                                            .source_hash = "by hand",                   \
                                            .facts = FACTS,                             \
                                            .n = N,                                     \
                                            .n_parameters = 2,                          \
                                            .params_size = sizeof(struct test_params),  \
                                            .coordinates = coordinates,                 \
                                            .rates = rates,                             \
                                            .momenta = momenta,                         \
                                            .parameters = parameters,                   \
                                            .cyclic = CYCLIC,                           \
                                            .defaults = NAME##_defaults,                \
                                            .derive = derive,                           \
                                            .prepare = prepare,                         \
                                            .bounds = bounds,                           \
                                            .start = NAME##_start,                      \
                                            .acceleration = NAME##_acceleration,        \
                                            .mass = NAME##_mass,                        \
                                            .force = NAME##_force,                      \
                                            .canonical = NAME##_canonical,              \
                                            .gradient = NAME##_gradient,                \
                                            .jacobian = NAME##_jacobian,                \
                                            .energy = NAME##_energy,                    \
                                            .fast = fast_##N,                           \
                                            .members = NAME##_members,                  \
                                            .steppers = PK_INLINE_STEPPERS,             \
                                            .block_steppers = PK_INLINE_BLOCK_STEPPERS, \
                                            __VA_ARGS__}

#define LIST(...) {__VA_ARGS__}
#define NATURAL                                                                          \
    (PK_MASS_CONSTANT | PK_MASS_DIAGONAL | PK_QUADRATIC | PK_SEPARABLE | PK_AUTONOMOUS | \
     PK_CONSERVATIVE | PK_VARIATIONAL | PK_SMOOTH | PK_FAST)
#define GENERAL (NATURAL & ~(unsigned)(PK_MASS_CONSTANT | PK_MASS_DIAGONAL | PK_SEPARABLE))
#define DRIVEN (NATURAL & ~(unsigned)(PK_AUTONOMOUS | PK_CONSERVATIVE))

/* M = 1 of N degrees of freedom: what follows from the force; and what from the jacobian, where
 * nothing depends on the time. */
#define UNIT_MASS(NAME, N)                                        \
    static int NAME##_acceleration(ARGS, pk_real *a)              \
    {                                                             \
        NAME##_force(params, t, q, v, u, a);                      \
        return 0;                                                 \
    }                                                             \
    static void NAME##_mass(ARGS, pk_real *M)                     \
    {                                                             \
        UNUSED;                                                   \
        for (size_t i = 0; i < (N) * (N); i++)                    \
            M[i] = i % ((N) + 1) == 0;                            \
    }                                                             \
    static void NAME##_canonical(ARGS, pk_real *p, pk_real *pdot) \
    {                                                             \
        memcpy(p, v, (N) * sizeof *p);                            \
        NAME##_force(params, t, q, v, u, pdot);                   \
    }
#define LINEAR(NAME, N)                                                                         \
    static void NAME##_linear(ARGS, const pk_real *a, pk_real *r_q, pk_real *r_v, pk_real *r_t) \
    {                                                                                           \
        pk_real p_q[(N) * (N)];                                                                 \
        (void)a;                                                                                \
        NAME##_jacobian(params, t, q, v, u, p_q, r_q, r_v);                                     \
        memset(r_t, 0, (N) * sizeof *r_t);                                                      \
    }

/* One degree of freedom and M = 1: all kernels from V(q, t), the force, and its derivatives by q
 * and t. */
#define POINT_MASS(NAME, V, FORCE, DFORCE, TFORCE)                                              \
    static int NAME##_acceleration(ARGS, pk_real *a)                                            \
    {                                                                                           \
        UNUSED;                                                                                 \
        a[0] = FORCE;                                                                           \
        return 0;                                                                               \
    }                                                                                           \
    static void NAME##_mass(ARGS, pk_real *M)                                                   \
    {                                                                                           \
        UNUSED;                                                                                 \
        M[0] = 1;                                                                               \
    }                                                                                           \
    static void NAME##_force(ARGS, pk_real *f)                                                  \
    {                                                                                           \
        UNUSED;                                                                                 \
        f[0] = FORCE;                                                                           \
    }                                                                                           \
    static void NAME##_canonical(ARGS, pk_real *p, pk_real *pdot)                               \
    {                                                                                           \
        UNUSED;                                                                                 \
        p[0] = v[0];                                                                            \
        pdot[0] = FORCE;                                                                        \
    }                                                                                           \
    static void NAME##_gradient(ARGS, pk_real *d)                                               \
    {                                                                                           \
        UNUSED;                                                                                 \
        d[0] = FORCE;                                                                           \
    }                                                                                           \
    static void NAME##_jacobian(ARGS, pk_real *p_q, pk_real *pdot_q, pk_real *pdot_v)           \
    {                                                                                           \
        UNUSED;                                                                                 \
        p_q[0] = 0;                                                                             \
        pdot_q[0] = DFORCE;                                                                     \
        pdot_v[0] = 0;                                                                          \
    }                                                                                           \
    static void NAME##_linear(ARGS, const pk_real *a, pk_real *r_q, pk_real *r_v, pk_real *r_t) \
    {                                                                                           \
        UNUSED;                                                                                 \
        (void)a;                                                                                \
        r_q[0] = DFORCE;                                                                        \
        r_v[0] = 0;                                                                             \
        r_t[0] = TFORCE;                                                                        \
    }                                                                                           \
    static pk_real NAME##_energy(ARGS)                                                          \
    {                                                                                           \
        UNUSED;                                                                                 \
        return v[0] * v[0] / 2 + (V);                                                           \
    }

#endif

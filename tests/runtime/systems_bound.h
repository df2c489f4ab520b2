/* What systems with rotations and constraints have in common: their kernels by linear algebra from
 * what each says of itself,
 *
 *     p, pdot of L alone;  M;  f of M a = f + J^T lambda;  phi, J, J v + j0;  d(J v + j0)/dt at a =
 * 0
 *
 * Derivatives that only Newton's method takes are differences. As in generated C, M a = f is solved
 * first, so that canonical() and mass() have the rates for momenta and the unit matrix.
 */
#ifndef TEST_SYSTEMS_BOUND_H
#define TEST_SYSTEMS_BOUND_H

#include <stddef.h>
#include <string.h>

#include "systems.h"

#define G(params) (((const struct test_params *)(params))->g)
#define LIMIT(params) (((const struct test_params *)(params))->limit)

enum { MOST_N = 20, MOST_C = 4, MOST_ALL = MOST_N + MOST_C };

typedef void kernel(ARGS, pk_real *out);
struct bound {
    size_t n, coordinates, rotations, c; /* n without quaternions is coordinates + 3 rotations */
    kernel *inertia, *force, *bias;
    void (*rows)(ARGS, pk_real *J, pk_real *residual);
};

/* The rotation matrix's column or row products: R x and R^T x. */
static inline void turn(const pk_real *Q, int back, const pk_real *x, pk_real *out)
{
    const pk_real w = back ? -Q[0] : Q[0], *e = Q + 1;
    const pk_real a = e[1] * x[2] - e[2] * x[1], b = e[2] * x[0] - e[0] * x[2];
    const pk_real c = e[0] * x[1] - e[1] * x[0];
    out[0] = x[0] + 2 * (w * a + (e[1] * c - e[2] * b));
    out[1] = x[1] + 2 * (w * b + (e[2] * a - e[0] * c));
    out[2] = x[2] + 2 * (w * c + (e[0] * b - e[1] * a));
}

static inline void cross(const pk_real *a, const pk_real *b, pk_real *out)
{
    const pk_real x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
    out[0] = x, out[1] = y;
}

/* Q' = Q (0, omega)/2. */
static inline void spin(const pk_real *Q, const pk_real *o, pk_real *out)
{
    out[0] = -(Q[1] * o[0] + Q[2] * o[1] + Q[3] * o[2]) / 2;
    out[1] = (Q[0] * o[0] + Q[2] * o[2] - Q[3] * o[1]) / 2;
    out[2] = (Q[0] * o[1] + Q[3] * o[0] - Q[1] * o[2]) / 2;
    out[3] = (Q[0] * o[2] + Q[1] * o[1] - Q[2] * o[0]) / 2;
}

/* [M -J^T; J 0] (a, lambda) = (f, -bias), by elimination with pivots. */
static inline int bound_solve(const struct bound *b, ARGS, pk_real *a, pk_real *lambda)
{
    const size_t n = b->n, c = b->c, m = b->coordinates + 3 * b->rotations, all = m + c;
    pk_real M[MOST_N * MOST_N], J[MOST_C * MOST_N], f[MOST_N], K[MOST_ALL][MOST_ALL + 1] = {{0}};
    pk_real residual[MOST_C], bias[MOST_C];
    b->inertia(params, t, q, v, u, M);
    b->force(params, t, q, v, u, f);
    if (c) {
        b->rows(params, t, q, v, u, J, residual);
        b->bias(params, t, q, v, u, bias);
    }
    for (size_t i = 0; i < m; i++) {
        memcpy(K[i], M + i * n, m * sizeof *M);
        K[i][all] = f[i];
        for (size_t k = 0; k < c; k++)
            K[i][m + k] = -J[k * n + i], K[m + k][i] = J[k * n + i];
    }
    for (size_t k = 0; k < c; k++)
        K[m + k][all] = -bias[k];
    for (size_t k = 0; k < all; k++) {
        size_t best = k;
        for (size_t i = k + 1; i < all; i++)
            if (PK_F(fabs)(K[i][k]) > PK_F(fabs)(K[best][k]))
                best = i;
        if (!(PK_F(fabs)(K[best][k]) > PK_C(1e-14)))
            return c ? PK_FAILED(PK_FAILURE_CONSTRAINT, 0) : PK_FAILED(PK_FAILURE_MASS, k);
        for (size_t j = 0; j <= all; j++) {
            const pk_real swap = K[k][j];
            K[k][j] = K[best][j], K[best][j] = swap;
        }
        for (size_t i = k + 1; i < all; i++)
            for (size_t j = all + 1; j-- > k;)
                K[i][j] -= K[i][k] / K[k][k] * K[k][j];
    }
    for (size_t k = all; k-- > 0;) {
        for (size_t j = k + 1; j < all; j++)
            K[k][all] -= K[k][j] * K[j][all];
        K[k][all] /= K[k][k];
    }
    for (size_t i = 0; i < m; i++)
        a[i] = K[i][all];
    for (size_t r = 0; r < b->rotations; r++)
        spin(v + m + 4 * r, v + b->coordinates + 3 * r, a + m + 4 * r);
    for (size_t k = m + 4 * b->rotations; k < n; k++)
        a[k] = f[k]; /* a state */
    for (size_t k = 0; lambda && k < c; k++)
        lambda[k] = K[m + k][all];
    return 0;
}

/* Differences of the acceleration, by q (of_v 0) or by v, n by n. */
static inline void bound_derivative(const struct bound *b, ARGS, int of_v, pk_real *out)
{
    const pk_real e = PK_F(pow)(PK_EPSILON, PK_C(1.0) / 3);
    for (size_t k = 0; k < b->n; k++) {
        pk_real x[2][MOST_N], a[2][MOST_N] = {{0}};
        for (int s = 0; s < 2; s++) {
            memcpy(x[s], of_v ? v : q, b->n * sizeof *v);
            x[s][k] += s ? e : -e;
            bound_solve(b, params, t, of_v ? q : x[s], of_v ? x[s] : v, u, a[s], NULL);
        }
        for (size_t i = 0; i < b->n; i++)
            out[i * b->n + k] = (a[1][i] - a[0][i]) / (2 * e);
    }
}

/* Of rows whose terms are about |J_k q_k|, with attitudes 1 for q_k, and |J_k v_k|. */
static inline void bound_terms(const struct bound *b, ARGS, pk_real *phi_size, pk_real *rate_size)
{
    pk_real J[MOST_C * MOST_N], residual[MOST_C];
    if (!b->c)
        return;
    b->rows(params, t, q, v, u, J, residual);
    for (size_t i = 0; i < b->c; i++) {
        pk_real j0 = residual[i];
        phi_size[i] = rate_size[i] = 0;
        for (size_t k = 0; k < b->coordinates + 3 * b->rotations; k++) {
            const pk_real row = J[i * b->n + k];
            phi_size[i] += PK_F(fabs)(k < b->coordinates ? row * q[k] : row);
            rate_size[i] += PK_F(fabs)(row * v[k]);
            j0 -= row * v[k];
        }
        rate_size[i] += PK_F(fabs)(j0);
    }
}

/* x^2 + y^2 = 1, for a system of these two coordinates first. */
#define UNIT_ROD(NAME)                                           \
    static void NAME##_constraint(ARGS, pk_real *phi)            \
    {                                                            \
        UNUSED;                                                  \
        phi[0] = q[0] * q[0] + q[1] * q[1] - 1;                  \
    }                                                            \
    static void NAME##_rows(ARGS, pk_real *J, pk_real *residual) \
    {                                                            \
        UNUSED;                                                  \
        J[0] = 2 * q[0];                                         \
        J[1] = 2 * q[1];                                         \
        residual[0] = J[0] * v[0] + J[1] * v[1];                 \
    }                                                            \
    static void NAME##_bias(ARGS, pk_real *b)                    \
    {                                                            \
        UNUSED;                                                  \
        b[0] = 2 * (v[0] * v[0] + v[1] * v[1]);                  \
    }

/* A diagonal M: these masses, and 1 for what has no momenta. */
static inline void constant_inertia(size_t n, const pk_real *masses, size_t count, pk_real *M)
{
    memset(M, 0, n * n * sizeof *M);
    for (size_t i = 0; i < n; i++)
        M[i * n + i] = i < count ? masses[i] : 1;
}

/* Unit masses at N coordinates. */
#define UNIT_MASSES(NAME, N)                                          \
    static void NAME##_inertia(ARGS, pk_real *M)                      \
    {                                                                 \
        UNUSED;                                                       \
        constant_inertia(N, NULL, 0, M);                              \
    }                                                                 \
    static void NAME##_unconstrained(ARGS, pk_real *p, pk_real *pdot) \
    {                                                                 \
        memcpy(p, v, (N) * sizeof *p);                                \
        NAME##_drift(params, t, q, v, u, pdot);                       \
    }

#define NAMED(x) {x, "", ""}

static const struct pk_parameter bound_parameters[] = {
    {{"g", "", ""}, offsetof(struct test_params, g), 0, 1, 0},
    {{"limit", "", ""}, offsetof(struct test_params, limit), 0, 0, 0}};
static inline void bound_derive(void *params, const unsigned char *given)
{
    (void)params, (void)given;
}
static inline int bound_prepare(void *params)
{
    return G(params) > 0 ? 0 : PK_FAILED(PK_FAILURE_PARAMETER, 0);
}
static inline void bound_bounds(const void *params, pk_real *lo, pk_real *hi)
{
    (void)params;
    lo[0] = 0, lo[1] = -(pk_real)INFINITY;
    hi[0] = hi[1] = (pk_real)INFINITY;
}

#define LIST(...) {__VA_ARGS__}
#define BOUND_FACTS                                                                   \
    (PK_MASS_CONSTANT | PK_MASS_DIAGONAL | PK_QUADRATIC | PK_AUTONOMOUS | PK_SMOOTH | \
     PK_CONSERVATIVE | PK_VARIATIONAL)
#define BOUND_OUTSIDE (PK_MASS_CONSTANT | PK_MASS_DIAGONAL | PK_QUADRATIC | PK_SMOOTH)

/* A system of these names: NAME_inertia, _drift, _unconstrained, _energy, and with constraints
 * _rows, _bias. n counts quaternions. The rest: further members of struct pk_system, of which
 * `terms` is NAME_terms or its own. */
#define BOUND(NAME, N, COORDINATES, ROTATIONS, C, FACTS, GRAVITY, LIMIT0, START_Q, START_V, ...) \
    static const struct bound NAME##_bound = {                                                   \
        N, COORDINATES, ROTATIONS, C, NAME##_inertia, NAME##_drift, NAME##_bias, NAME##_rows};   \
    static int NAME##_acceleration(ARGS, pk_real *a)                                             \
    {                                                                                            \
        return bound_solve(&NAME##_bound, params, t, q, v, u, a, NULL);                          \
    }                                                                                            \
    static void NAME##_multipliers(ARGS, pk_real *lambda)                                        \
    {                                                                                            \
        pk_real a[N];                                                                            \
        bound_solve(&NAME##_bound, params, t, q, v, u, a, lambda);                               \
    }                                                                                            \
    static inline void NAME##_terms(ARGS, pk_real *phi_size, pk_real *rate_size)                 \
    {                                                                                            \
        bound_terms(&NAME##_bound, params, t, q, v, u, phi_size, rate_size);                     \
    }                                                                                            \
    static void NAME##_mass(ARGS, pk_real *M)                                                    \
    {                                                                                            \
        UNUSED;                                                                                  \
        memset(M, 0, (size_t)(N) * (N) * sizeof *M);                                             \
        for (size_t i = 0; i < (N); i++)                                                         \
            M[i * (N) + i] = 1;                                                                  \
    }                                                                                            \
    static void NAME##_force(ARGS, pk_real *f) { NAME##_acceleration(params, t, q, v, u, f); }   \
    static void NAME##_canonical(ARGS, pk_real *p, pk_real *pdot)                                \
    {                                                                                            \
        memcpy(p, v, (N) * sizeof *p);                                                           \
        NAME##_acceleration(params, t, q, v, u, pdot);                                           \
    }                                                                                            \
    static void NAME##_jacobian(ARGS, pk_real *p_q, pk_real *pdot_q, pk_real *pdot_v)            \
    {                                                                                            \
        memset(p_q, 0, (size_t)(N) * (N) * sizeof *p_q);                                         \
        bound_derivative(&NAME##_bound, params, t, q, v, u, 0, pdot_q);                          \
        bound_derivative(&NAME##_bound, params, t, q, v, u, 1, pdot_v);                          \
    }                                                                                            \
    static void NAME##_defaults(void *params)                                                    \
    {                                                                                            \
        ((struct test_params *)params)->g = GRAVITY;                                             \
        ((struct test_params *)params)->limit = LIMIT0;                                          \
    }                                                                                            \
    static void NAME##_start(const void *params, pk_real *q, pk_real *v)                         \
    {                                                                                            \
        static const pk_real q0[] = START_Q, v0[N] = START_V;                                    \
        (void)params;                                                                            \
        memset(q, 0, (N) * sizeof *q);                                                           \
        memcpy(q, q0, sizeof q0 < (N) * sizeof *q ? sizeof q0 : (N) * sizeof *q);                \
        memcpy(v, v0, sizeof v0);                                                                \
    }                                                                                            \
    const struct pk_system NAME##_system = {.abi = PK_ABI,                                       \
                                            .name = #NAME,                                       \
                                            .source_hash = "by hand",                            \
                                            .facts = FACTS,                                      \
                                            .n = N,                                              \
                                            .n_first_order = (N) - (COORDINATES),                \
                                            .n_rotations = ROTATIONS,                            \
                                            .constraints.n = C,                                  \
                                            .n_parameters = 2,                                   \
                                            .params_size = sizeof(struct test_params),           \
                                            .parameters = bound_parameters,                      \
                                            .coordinates = NAME##_names,                         \
                                            .rates = NAME##_names,                               \
                                            .momenta = NAME##_names,                             \
                                            .defaults = NAME##_defaults,                         \
                                            .derive = bound_derive,                              \
                                            .prepare = bound_prepare,                            \
                                            .bounds = bound_bounds,                              \
                                            .start = NAME##_start,                               \
                                            .acceleration = NAME##_acceleration,                 \
                                            .mass = NAME##_mass,                                 \
                                            .force = NAME##_force,                               \
                                            .canonical = NAME##_canonical,                       \
                                            .jacobian = NAME##_jacobian,                         \
                                            .energy = NAME##_energy,                             \
                                            .constraints.multipliers = (C) ? NAME##_multipliers  \
                                                                           : NULL,               \
                                            .constraints.jacobian = NAME##_rows,                 \
                                            .unconstrained = NAME##_unconstrained,               \
                                            .inertia = NAME##_inertia,                           \
                                            __VA_ARGS__}

#endif

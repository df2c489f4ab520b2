/* The map of one step on linear equations: from the table, or read off the step itself, run on a
 * system of one coordinate from two starts. See pk/limits.h.
 */
#include <pk/limits.h>

#include "internal.h"
#include "tableau.h"

enum { MOST_WORK = 4096 };

#define ARGS                                                                            \
    const void *params, pk_real t, const pk_real *q, const pk_real *v, const pk_real *u
#define UNUSED ((void)params, (void)t, (void)q, (void)v, (void)u)

/* q'' = -K q - C q'. */
#define LINEAR_SYSTEM(NAME, K, C, FACTS)                                                     \
    static int NAME##_acceleration(ARGS, pk_real *a)                                        \
    {                                                                                       \
        UNUSED;                                                                             \
        a[0] = -(K)*q[0] - (C)*v[0];                                                        \
        return 0;                                                                           \
    }                                                                                       \
    static void NAME##_force(ARGS, pk_real *f) { NAME##_acceleration(params, t, q, v, u, f); } \
    static void NAME##_mass(ARGS, pk_real *M)                                               \
    {                                                                                       \
        UNUSED;                                                                             \
        M[0] = 1;                                                                           \
    }                                                                                       \
    static void NAME##_canonical(ARGS, pk_real *p, pk_real *pdot)                           \
    {                                                                                       \
        p[0] = v[0];                                                                        \
        NAME##_acceleration(params, t, q, v, u, pdot);                                      \
    }                                                                                       \
    static void NAME##_gradient(ARGS, pk_real *d)                                           \
    {                                                                                       \
        UNUSED;                                                                             \
        d[0] = -(K)*q[0];                                                                   \
    }                                                                                       \
    static void NAME##_jacobian(ARGS, pk_real *p_q, pk_real *pdot_q, pk_real *pdot_v)       \
    {                                                                                       \
        UNUSED;                                                                             \
        p_q[0] = 0;                                                                         \
        pdot_q[0] = -(K);                                                                   \
        pdot_v[0] = -(C);                                                                   \
    }                                                                                       \
    static void NAME##_linear(ARGS, const pk_real *a, pk_real *r_q, pk_real *r_v,           \
                              pk_real *r_t)                                                 \
    {                                                                                       \
        UNUSED;                                                                             \
        (void)a;                                                                            \
        r_q[0] = -(K);                                                                      \
        r_v[0] = -(C);                                                                      \
        r_t[0] = 0;                                                                         \
    }                                                                                       \
    static pk_real NAME##_energy(ARGS)                                                      \
    {                                                                                       \
        UNUSED;                                                                             \
        return (v[0] * v[0] + (K)*q[0] * q[0]) / 2;                                         \
    }                                                                                       \
    static const struct pk_system NAME = {.abi = PK_ABI,                                    \
                                          .name = #NAME,                                    \
                                          .source_hash = "",                                \
                                          .facts = FACTS,                                   \
                                          .n = 1,                                           \
                                          .acceleration = NAME##_acceleration,              \
                                          .mass = NAME##_mass,                              \
                                          .force = NAME##_force,                            \
                                          .canonical = NAME##_canonical,                    \
                                          .gradient = NAME##_gradient,                      \
                                          .jacobian = NAME##_jacobian,                      \
                                          .energy = NAME##_energy,                          \
                                          .linear = NAME##_linear}

#define OF_DRAG                                                                       \
    (PK_MASS_CONSTANT | PK_MASS_DIAGONAL | PK_QUADRATIC | PK_AUTONOMOUS | PK_SMOOTH)
LINEAR_SYSTEM(spring, PK_C(1.0), PK_C(0.0),
              OF_DRAG | PK_SEPARABLE | PK_CONSERVATIVE | PK_VARIATIONAL);
LINEAR_SYSTEM(drag, PK_C(0.0), PK_C(1.0), OF_DRAG);

/* One step of h from (q, v), by the integrator; q and v become its end. */
static enum pk_status run(const struct pk_method *method, const struct pk_system *system, pk_real h,
                          pk_real *q, pk_real *v)
{
    pk_real block[MOST_WORK];
    struct pk_integrator it;
    const struct pk_problem problem = {.system = system};
    struct pk_options options = pk_options_default();
    if (pk_integrator_size(&problem, method) > sizeof block)
        return PK_BLOCK_TOO_SMALL;
    options.h = options.h_max = h; /* an adaptive method makes just this one */
    options.rtol = options.atol = PK_C(1e10);
    enum pk_status status =
        pk_integrator_init(&it, &problem, method, &options, 0, q, v, block, sizeof block);
    if (status >= 0)
        status = pk_integrator_step(&it, h);
    if (status >= 0 && !(it.t >= h))
        status = PK_REFUSED; /* its iteration took a shorter one */
    *q = it.state ? it.q[0] : 0;
    *v = it.state ? it.v[0] : 0;
    return status;
}

static const struct pk_method *formula(const struct pk_method *method)
{
    return method->formula ? method->formula : method;
}

int pk_tableau_polynomial(const struct pk_tableau *table, pk_real *coefficient)
{
    pk_real power[PK_MOST_STAGES], next[PK_MOST_STAGES]; /* A^k applied to ones */
    const int s = table->stages;
    for (int i = 0; i < s; i++)
        power[i] = 1;
    coefficient[0] = 1;
    for (int k = 1; k <= s; k++) {
        const pk_real *a = table->a;
        coefficient[k] = 0;
        for (int i = 0; i < s; i++) {
            coefficient[k] += table->b[i] * power[i];
            next[i] = 0;
            for (int j = 0; j < i; j++)
                next[i] += *a++ * power[j];
        }
        for (int i = 0; i < s; i++)
            power[i] = next[i];
    }
    return s;
}

static void turn(const struct pk_splitting *table, pk_real y, pk_real map[4])
{
    map[0] = map[3] = 1;
    map[1] = map[2] = 0;
    for (int i = 0; i <= table->stages; i++)
        for (int column = 0; column < 2; column++) {
            map[2 + column] -= table->kick[i] * y * map[column];
            if (i < table->stages)
                map[column] += table->drift[i] * y * map[2 + column];
        }
}

enum pk_status pk_method_oscillator(const struct pk_method *method, pk_real y, pk_real map[4])
{
    const struct pk_method *f = formula(method);
    const struct pk_splitting *splitting = pk_splitting_table(f);
    const struct pk_tableau *tableau = pk_explicit_table(f);
    if (!(y > 0) || !pk_finite(y))
        return PK_BAD_ARGUMENT;
    if (splitting) {
        turn(splitting, y, map);
        return PK_DONE;
    }
    if (tableau) { /* R(iy) = x + i w turns by the angle of the eigenvector (1, i) */
        pk_real c[PK_MOST_STAGES + 1], part[2] = {0, 0}, power = 1;
        const int s = pk_tableau_polynomial(tableau, c);
        for (int k = 0; k <= s; k++, power *= y)
            part[k % 2] += k % 4 < 2 ? c[k] * power : -c[k] * power;
        map[0] = map[3] = part[0];
        map[1] = part[1];
        map[2] = -part[1];
        return PK_DONE;
    }
    if (f->release || f->order == 0)
        return PK_REFUSED;
    for (int column = 0; column < 2; column++) {
        pk_real q = column == 0, v = column == 1;
        const enum pk_status status = run(f, &spring, y, &q, &v);
        if (status < 0)
            return status;
        map[column] = q;
        map[2 + column] = v;
    }
    return PK_DONE;
}

enum pk_status pk_method_decay(const struct pk_method *method, pk_real z, pk_real *factor)
{
    const struct pk_method *f = formula(method);
    const struct pk_tableau *tableau = pk_explicit_table(f);
    if (!(z > 0) || !pk_finite(z))
        return PK_BAD_ARGUMENT;
    if (tableau) {
        pk_real c[PK_MOST_STAGES + 1], sum = 0;
        for (int k = pk_tableau_polynomial(tableau, c); k >= 0; k--)
            sum = c[k] - z * sum;
        *factor = sum;
        return PK_DONE;
    }
    if (f->release || f->order == 0)
        return PK_REFUSED;
    pk_real q = 0, v = 1;
    const enum pk_status status = run(f, &drag, z, &q, &v);
    *factor = v;
    return status;
}

pk_real pk_map_growth(const pk_real map[4])
{
    const pk_real half = (map[0] + map[3]) / 2;
    const pk_real part = half * half - (map[0] * map[3] - map[1] * map[2]);
    if (part > 0)
        return pk_abs(half) + PK_F(sqrt)(part);
    return PK_F(sqrt)(half * half - part);
}

pk_real pk_map_angle(const pk_real map[4])
{
    const pk_real half = (map[0] + map[3]) / 2;
    const pk_real part = map[0] * map[3] - map[1] * map[2] - half * half;
    return PK_F(atan2)(PK_F(sqrt)(pk_max(part, 0)), half);
}

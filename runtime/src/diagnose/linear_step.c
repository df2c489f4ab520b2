/* The map of one step on linear equations. It comes from the method's table, or from one step of a
 * system with one coordinate for each of two initial states. See pk/limits.h. */
#include <pk/limits.h>

#include "../core/internal.h"
#include "../core/tableau.h"

enum { MOST_WORK = 4096 };

/* q'' = -stiffness q - damping q' */
struct spring {
    pk_real stiffness, damping;
};

static const struct spring *spring(const void *params) { return (const struct spring *)params; }

static int acceleration(ARGS, pk_real *a)
{
    UNUSED;
    a[0] = -spring(params)->stiffness * q[0] - spring(params)->damping * v[0];
    return 0;
}

static void mass(ARGS, pk_real *M)
{
    UNUSED;
    M[0] = 1;
}

static void canonical(ARGS, pk_real *p, pk_real *pdot)
{
    p[0] = v[0];
    acceleration(params, t, q, v, u, pdot);
}

static void jacobian(ARGS, pk_real *p_q, pk_real *pdot_q, pk_real *pdot_v)
{
    UNUSED;
    p_q[0] = 0;
    pdot_q[0] = -spring(params)->stiffness;
    pdot_v[0] = -spring(params)->damping;
}

static void linear(ARGS, const pk_real *a, pk_real *r_q, pk_real *r_v, pk_real *r_t)
{
    (void)a;
    jacobian(params, t, q, v, u, r_t, r_q, r_v); /* r = pdot: M is 1 and nothing depends on t */
}

static void fast(ARGS, pk_real *a)
{
    UNUSED;
    a[0] = 0;
}

enum {
    DAMPED = PK_MASS_CONSTANT | PK_MASS_DIAGONAL | PK_QUADRATIC | PK_AUTONOMOUS | PK_SMOOTH |
        PK_AFFINE | PK_LINEAR_DRAG,
    FREE = DAMPED | PK_SEPARABLE | PK_CONSERVATIVE | PK_VARIATIONAL | PK_FAST
};

static const struct pk_system linear_system = {.abi = PK_ABI,
                                               .name = "linear",
                                               .facts = FREE,
                                               .n = 1,
                                               .acceleration = acceleration,
                                               .mass = mass,
                                               .canonical = canonical,
                                               .jacobian = jacobian,
                                               .linear = linear,
                                               .fast = fast};

/* Makes one step of length h from (q, v), and sets q and v to its end. */
static enum pk_status run(const struct pk_method *method, struct spring params, pk_real h,
                          pk_real *q, pk_real *v)
{
    pk_real block[MOST_WORK];
    struct pk_integrator it;
    struct pk_system system = linear_system;
    const struct pk_problem problem = {.system = &system, .params = &params};
    struct pk_options options = pk_options_default();
    if (pk_integrator_size(&problem, method) > sizeof block)
        return PK_BLOCK_TOO_SMALL;
    if (params.damping > 0 || params.damping < 0)
        system.facts = DAMPED;
    options.h = options.h_max = h; /* lets any method reach h in one step */
    options.rtol = options.atol = PK_C(1e10);
    enum pk_status status =
        pk_integrator_init(&it, &problem, method, &options, 0, q, v, block, sizeof block);
    if (status >= 0)
        status = pk_integrator_step(&it, h);
    if (status >= 0 && !(it.t >= h))
        status = PK_REFUSED; /* the method has made a shorter step */
    *q = it.q ? it.q[0] : 0;
    *v = it.q ? it.v[0] : 0;
    return status;
}

static const struct pk_method *formula(const struct pk_method *method)
{
    return method->formula ? method->formula : method;
}

/* Returns whether the steps of method f are not all the same linear map. */
static int varies(const struct pk_method *f)
{
    return f->release || (f->order == 0 && !(f->traits & PK_EXACT));
}

int pk_tableau_polynomial(const struct pk_tableau *table, pk_real *coefficient)
{
    /* A^k times a vector of ones, where A is the table's matrix */
    pk_real power[PK_MOST_STAGES], next[PK_MOST_STAGES];
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

enum pk_status pk_method_spring(const struct pk_method *method, pk_real stiffness, pk_real damping,
                                pk_real h, pk_real map[4])
{
    const struct pk_method *f = formula(method);
    const struct spring params = {stiffness, damping};
    if (!(h > 0) || !pk_finite(h))
        return PK_BAD_ARGUMENT;
    if (varies(f) || (method->needs & PK_SEPARABLE && (damping > 0 || damping < 0)))
        return PK_REFUSED;
    for (int column = 0; column < 2; column++) {
        pk_real q = column == 0, v = column == 1;
        PK_TRY(run(f, params, h, &q, &v));
        map[column] = q;
        map[2 + column] = v;
    }
    return PK_DONE;
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
    if (tableau) { /* multiplies q - i v by the stability function R(iy), a rotation with scaling */
        pk_real c[PK_MOST_STAGES + 1], part[2] = {0, 0}, power = 1;
        const int s = pk_tableau_polynomial(tableau, c);
        for (int k = 0; k <= s; k++, power *= y)
            part[k % 2] += k % 4 < 2 ? c[k] * power : -c[k] * power;
        map[0] = map[3] = part[0];
        map[1] = part[1];
        map[2] = -part[1];
        return PK_DONE;
    }
    return pk_method_spring(f, 1, 0, y, map);
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
    if (varies(f) || method->needs & PK_SEPARABLE)
        return PK_REFUSED;
    if (pk_splitting_table(f)) { /* a substep of negative length may overflow */
        *factor = PK_F(exp)(-z);
        return PK_DONE;
    }
    pk_real q = 0, v = 1;
    const struct spring drag = {0, 1};
    const enum pk_status status = run(f, drag, z, &q, &v);
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

/* Quadratures, z' = g(t, q, v), beside the motion: a step adds h sum b_i g at its stages, which is
 * what the method would make of z as one more coordinate, since nothing depends on it. So z has
 * the method's order, and costs nothing but g. Sums are compensated, and z is exchanged as states
 * are: a step that fails leaves no trace. /
 */
#include <string.h>

#include <pk/step/gauss_tables.h>

#include "internal.h"

enum { NOW, LOW, NEXT, NEXT_LOW, RATE, DENSE_LOW, PARTS };

static pk_real *part(const struct pk_integrator *it, int k)
{
    return it->quadratures + (size_t)k * it->problem.system->n_quadratures;
}

/* Where what is now is; the other half is what was before the step, or comes after it. */
static int half(const struct pk_integrator *it) { return it->z == part(it, NOW) ? NOW : NEXT; }

size_t pk_quadrature_size(const struct pk_system *system, size_t n)
{
    return system->n_quadratures ? PARTS * system->n_quadratures + 2 * n : 0;
}

enum pk_status pk_quadrature_start(struct pk_integrator *it)
{
    const struct pk_system *system = it->problem.system;
    pk_real *z = part(it, NOW);
    it->z = z;
    if (system->quadrature_start)
        system->quadrature_start(it->problem.params, z);
    it->where = BAD_STATE;
    return pk_all_finite(z, system->n_quadratures) ? PK_DONE : PK_BAD_ARGUMENT;
}

enum pk_status pk_integrator_set_quadratures(struct pk_integrator *it, const pk_real *z)
{
    const size_t m = it->z ? it->problem.system->n_quadratures : 0;
    it->where = z && m ? BAD_STATE : BAD_POINTER;
    if (!z || !m || !pk_all_finite(z, m))
        return it->status = PK_BAD_ARGUMENT;
    const int now = half(it);
    memmove(part(it, now), z, m * sizeof *z);
    memset(part(it, now + 1), 0, m * sizeof *z);
    return PK_DONE;
}

static void add(struct pk_integrator *it, const struct pk_stage *stage, pk_real *z, pk_real *low)
{
    const struct pk_system *system = it->problem.system;
    pk_real *rate = part(it, RATE);
    if (!(stage->weight > 0) && !(stage->weight < 0))
        return;
    system->quadrature(it->problem.params, stage->t, stage->q, stage->v,
                       pk_eval_input(it, stage->t), rate);
    for (size_t i = 0; i < system->n_quadratures; i++)
        z[i] = pk_sum(z[i], stage->weight * rate[i], &low[i]);
}

enum pk_status pk_quadrature_step(struct pk_integrator *it)
{
    const size_t bytes = 2 * it->problem.system->n_quadratures * sizeof *it->z;
    const int now = half(it), next = NEXT - now;
    pk_real *z = part(it, next);
    struct pk_stage stage;
    memcpy(z, part(it, now), bytes); /* with the low parts behind it */
    for (int k = 0; it->method->stage(it, k, &stage, part(it, PARTS)); k++)
        add(it, &stage, z, part(it, next + 1));
    return pk_all_finite(z, it->problem.system->n_quadratures) ? PK_DONE : PK_NOT_FINITE;
}

void pk_quadrature_accept(struct pk_integrator *it) { it->z = part(it, NEXT - half(it)); }

enum pk_status pk_integrator_dense_quadratures(struct pk_integrator *it, pk_real t, pk_real *z)
{
    const size_t m = it->z ? it->problem.system->n_quadratures : 0, n = it->n;
    if (!z || !m) {
        it->where = BAD_POINTER;
        return it->status = it->status < 0 ? it->status : PK_BAD_ARGUMENT;
    }
    const int before = NEXT - half(it);
    pk_real *q = part(it, PARTS), *v = q + n, *low = part(it, DENSE_LOW);
    if (!(t < it->t) && !(t > it->t)) {
        memcpy(z, it->z, m * sizeof *z);
        return it->status = PK_DONE;
    }
    memcpy(z, part(it, before), m * sizeof *z);
    memcpy(low, part(it, before + 1), m * sizeof *z);
    for (int k = 0; k < 8; k++) {
        const pk_real h = t - it->last_t;
        const struct pk_stage stage = {it->last_t + h * pk_gauss8_c[k], h * pk_gauss8_b[k], q, v};
        if (pk_integrator_dense(it, stage.t, q, v) < 0)
            return it->status;
        add(it, &stage, z, low);
    }
    return it->status = pk_all_finite(z, m) ? PK_DONE : PK_NOT_FINITE;
}

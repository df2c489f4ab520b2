/* Quadratures, z' = g(t, q, v), beside the motion: a step adds h sum b_i g at its stages, which is
 * what the method would make of z as one more coordinate, since nothing depends on it. So z has
 * the method's order, and costs nothing but g. Sums are compensated, and z is exchanged as states
 * are: a step that fails leaves no trace.
 *
 * Nor is its error left to the motion's: g may vary faster than q and v do. An adaptive method
 * judges it from the same stages by its own estimate, and a step that errs by more than the
 * tolerance is made again, shorter.
 */
#include <string.h>

#include "../core/project.h"
#include "../core/tableau.h"

enum { NOW, LOW, NEXT, NEXT_LOW, RATE, SIZE, SUM, SUM_2, TRAVEL, PARTS, TERMS = 2 * PK_LANES };

#define SAFETY PK_C(0.9)
#define SHRINK PK_C(0.2)

static pk_real *part(const struct pk_integrator *it, int k)
{
    return it->own->quadratures + (size_t)k * it->problem.system->quadratures.n;
}

/* The half with the current values; the other has those before or after the step. */
static int half(const struct pk_integrator *it) { return it->z == part(it, NOW) ? NOW : NEXT; }

size_t pk_quadrature_size(const struct pk_system *system, size_t n)
{
    const size_t m = system->quadratures.n;
    return m ? PARTS * m + 2 * n + TERMS * m + 2 * TERMS : 0;
}

/* Its terms: of the last step, where it->own->flags has PK_HAVE_SERIES. */
static pk_real *series(const struct pk_integrator *it) { return part(it, PARTS) + 2 * it->n; }

/* Behind them Gauss's nodes, and his weights. */
static pk_real *nodes(const struct pk_integrator *it)
{
    return series(it) + TERMS * it->problem.system->quadratures.n;
}

enum pk_status pk_quadrature_start(struct pk_integrator *it)
{
    const struct pk_system *system = it->problem.system;
    pk_real *z = part(it, NOW);
    it->z = z;
    pk_gauss_nodes(TERMS, nodes(it), nodes(it) + TERMS);
    memset(part(it, TRAVEL), 0, system->quadratures.n * sizeof *z);
    memset(z, 0, 2 * system->quadratures.n * sizeof *z); /* the low parts too */
    if (system->quadratures.start)
        system->quadratures.start(it->problem.params, z);
    it->where = BAD_STATE;
    return pk_all_finite(z, system->quadratures.n) ? PK_DONE : PK_BAD_ARGUMENT;
}

enum pk_status pk_integrator_set_quadratures(struct pk_integrator *it, const pk_real *z)
{
    const size_t m = it->z ? it->problem.system->quadratures.n : 0;
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
    if (!(pk_abs(stage->weight) + pk_abs(stage->error[0]) + pk_abs(stage->error[1]) > 0))
        return;
    system->quadratures.rates(it->problem.params, stage->t, stage->q, stage->v,
                              pk_eval_input(it, stage->t), rate);
    for (size_t i = 0; i < system->quadratures.n; i++) {
        const pk_real added = stage->weight * rate[i];
        z[i] = pk_sum(z[i], added, &low[i]);
        part(it, SIZE)[i] += pk_abs(added);
        part(it, SUM)[i] += stage->error[0] * rate[i];
        part(it, SUM_2)[i] += stage->error[1] * rate[i];
    }
}

enum pk_status pk_quadrature_step(struct pk_integrator *it)
{
    const size_t bytes = 2 * it->problem.system->quadratures.n * sizeof *it->z;
    const int now = half(it), next = NEXT - now;
    pk_real *z = part(it, next);
    struct pk_stage stage = {0};
    memcpy(z, part(it, now), bytes); /* with the low parts behind it */
    memset(part(it, SIZE), 0, (TRAVEL - SIZE) * bytes / 2);
    for (int k = 0; it->own->crossed ? pk_passage_stage(it, k, &stage)
                                     : it->method->stage(it, k, &stage, part(it, PARTS));
         k++)
        add(it, &stage, z, part(it, next + 1));
    return pk_all_finite(z, it->problem.system->quadratures.n) ? PK_DONE : PK_NOT_FINITE;
}

/* Of the worst one, in tolerances. */
static pk_real error_of(struct pk_integrator *it)
{
    const pk_real *before = part(it, half(it)), *z = part(it, NEXT - half(it));
    pk_real worst = 0;
    for (size_t i = 0; i < it->problem.system->quadratures.n; i++) {
        const pk_real sums[] = {part(it, SUM)[i], part(it, SUM_2)[i]};
        const pk_real larger = pk_max(pk_abs(before[i]), pk_abs(z[i]));
        const pk_real rtol = pk_max(it->options.rtol, 2 * PK_EPS);
        const pk_real error = it->method->stage_error(it, part(it, SIZE)[i], sums);
        const pk_real atol = it->options.atol < 0 ? rtol * (part(it, TRAVEL)[i] + part(it, SIZE)[i])
                                                  : it->options.atol;
        worst = pk_max(worst, error / (atol + rtol * larger + PK_TINY));
    }
    return worst;
}

int pk_quadrature_rejects(struct pk_integrator *it)
{
    if (!it->method->stage_error)
        return 0;
    const pk_real error = error_of(it), h = it->own->next_t - it->t;
    const pk_real factor =
        SAFETY * PK_SAME(PK_F(pow)(error + PK_TINY, PK_C(-1.0) / (pk_real)it->method->order));
    if (error <= 1) {
        if (pk_abs(h) * factor < pk_abs(it->own->h))
            it->own->h = h * factor;
        return 0;
    }
    it->own->h = h * pk_max(SHRINK, factor);
    /* What the method keeps of its last step is of this one. */
    it->own->flags &= ~(PK_HAVE_A | PK_HAVE_STEP | PK_HAVE_DENSE);
    it->count.rejections++;
    return 1;
}

void pk_quadrature_accept(struct pk_integrator *it)
{
    it->z = part(it, NEXT - half(it));
    for (size_t i = 0; i < it->problem.system->quadratures.n; i++)
        part(it, TRAVEL)[i] += part(it, SIZE)[i];
    it->own->flags &= ~PK_HAVE_SERIES;
}

void pk_quadrature_aside(const struct pk_integrator *it, struct pk_integrator *side)
{
    if (it->z && side->z)
        memcpy(part(side, half(side)), part(it, NEXT - half(it)),
               2 * it->problem.system->quadratures.n * sizeof *it->z);
}

/* Of g over the last step, at the nodes: (2 k + 1) sum_j w_j P_k(2 x_j - 1) g_j. */
static enum pk_status make_series(struct pk_integrator *it)
{
    const struct pk_system *system = it->problem.system;
    const size_t m = system->quadratures.n;
    const pk_real h = it->t - it->last_t;
    pk_real *q = part(it, PARTS), *v = q + it->n, *rate = part(it, RATE), *terms = series(it);
    memset(terms, 0, TERMS * m * sizeof *terms);
    for (int j = 0; j < TERMS; j++) {
        const pk_real x = nodes(it)[j], weight = nodes(it)[TERMS + j], t = it->last_t + h * x;
        pk_real P[TERMS];
        pk_legendre(x, 1 - x, TERMS, P, NULL);
        PK_TRY(pk_integrator_dense(it, t, q, v));
        system->quadratures.rates(it->problem.params, t, q, v, pk_eval_input(it, t), rate);
        for (int k = 0; k < TERMS; k++)
            for (size_t i = 0; i < m; i++)
                terms[(size_t)k * m + i] += (pk_real)(2 * k + 1) * weight * P[k] * rate[i];
    }
    it->own->flags |= PK_HAVE_SERIES;
    return PK_DONE;
}

/* From the step's start. */
enum pk_status pk_integrator_dense_quadratures(struct pk_integrator *it, pk_real t, pk_real *z)
{
    const size_t m = it->z ? it->problem.system->quadratures.n : 0;
    if (!z || !m) {
        it->where = BAD_POINTER;
        return it->status = it->status < 0 ? it->status : PK_BAD_ARGUMENT;
    }
    if (!(t < it->t) && !(t > it->t)) {
        memcpy(z, it->z, m * sizeof *z);
        return it->status = PK_DONE;
    }
    const pk_real h = it->t - it->last_t, x = (t - it->last_t) / h;
    pk_real *q = part(it, PARTS), *v = q + it->n;
    if ((!(x >= 0 && x <= 1) && pk_integrator_dense(it, t, q, v) < 0) || /* which says why not */
        (!(it->own->flags & PK_HAVE_SERIES) && make_series(it) < 0))
        return it->status;
    const pk_real *terms = series(it), *from = part(it, NEXT - half(it)), *low = from + m;
    pk_real P[TERMS], integral[TERMS];
    pk_legendre(x, 1 - x, TERMS, P, integral);
    memcpy(z, low, m * sizeof *z);
    for (int k = 0; k < TERMS; k++)
        for (size_t i = 0; i < m; i++)
            z[i] += h * terms[(size_t)k * m + i] * integral[k];
    for (size_t i = 0; i < m; i++)
        z[i] += from[i];
    return it->status = pk_all_finite(z, m) ? PK_DONE : PK_NOT_FINITE;
}

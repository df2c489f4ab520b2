/* The derivative S of a step map and its effect on the symplectic form; see pk/stepmap.h. For each
 * column of S, a unit displacement in (Q, P), which metric.h defines, is converted to (dq, dv),
 * advanced by one step, and converted back. */
#include <string.h>

#include <pk/stepmap.h>

#include "metric.h"

struct parts {
    struct pk_variation variation;
    struct pk_metric metric;
    struct pk_integrator it;
    pk_real *S, *Q, *V, *J, *dp, *u, *LU, *pivot, *block, *variation_block, *metric_block;
    size_t block_size, n;
};

static size_t lay_out(struct parts *w, const struct pk_problem *problem,
                      const struct pk_method *method, pk_real *base)
{
    const size_t n = pk_system_count(problem->system, problem->params), m = 2 * n;
    w->n = n;
    w->block_size = pk_variation_integrator_size(problem, 1, method);
    /* clang-format off */
    const struct pk_slot slots[] = {
        {&w->variation_block, pk_variation_size(problem, 1) / sizeof *base},
        {&w->metric_block, pk_metric_reals(n)}, {&w->S, m * m}, {&w->LU, m * m}, {&w->Q, m},
        {&w->V, m}, {&w->J, 3 * n * n}, {&w->dp, n}, {&w->pivot, m},
        {&w->u, problem->system->n_inputs}, {&w->block, 0}};
    /* clang-format on */
    return PK_LAY_OUT(base, slots) * sizeof *base + w->block_size;
}

size_t pk_stepmap_size(const struct pk_problem *problem, const struct pk_method *method)
{
    if (!problem || !method || !pk_variation_size(problem, 1))
        return 0;
    struct parts w;
    return lay_out(&w, problem, method, NULL);
}

static const pk_real *inputs(struct parts *w, pk_real t)
{
    pk_input(&w->variation.of, t, w->u);
    return w->u;
}

/* Evaluates dp/dq at a state, into w->J. */
static void momentum_slope(struct parts *w, pk_real t, const pk_real *q, const pk_real *v)
{
    const struct pk_problem *of = &w->variation.of;
    const size_t nn = w->n * w->n;
    of->system->jacobian(of->params, t, q, v, inputs(w, t), w->J, w->J + nn, w->J + 2 * nn);
}

/* Sets the displacement in w->Q, w->V, which follows the initial state in each: the unit vector j
 * of (Q, P), converted to (dq, dv). */
static void displace(struct parts *w, pk_real t, size_t j)
{
    const size_t n = w->n;
    pk_real *dq = w->Q + n, *dv = w->V + n;
    memset(dq, 0, n * sizeof *dq);
    memset(dv, 0, n * sizeof *dv);
    (j < n ? dq : dv)[j % n] = 1;
    pk_metric_dq(&w->metric, dq);
    pk_metric_dp(&w->metric, dv); /* at this point dv holds dp */
    momentum_slope(w, t, w->Q, w->V);
    memset(w->dp, 0, n * sizeof *w->dp);
    pk_add_product(w->dp, w->J, dq, n);
    for (size_t i = 0; i < n; i++)
        dv[i] -= w->dp[i];
    pk_ldl_solve(w->metric.L, n, dv);
}

/* Sets column j of S from the state of the integrator. */
static void take_column(struct parts *w, size_t j)
{
    const struct pk_problem *of = &w->variation.of;
    const size_t n = w->n, m = 2 * n;
    const pk_real *q = w->it.q, *v = w->it.v, *dq = q + n, *dv = v + n;
    momentum_slope(w, w->it.t, q, v);
    memset(w->dp, 0, n * sizeof *w->dp);
    pk_add_product(w->dp, w->J, dq, n);
    of->system->mass(of->params, w->it.t, q, v, inputs(w, w->it.t), w->J);
    pk_add_product(w->dp, w->J, dv, n);
    memcpy(w->Q + n, dq, n * sizeof *dq); /* w->Q is used as scratch memory */
    pk_metric_Q(&w->metric, w->Q + n);
    pk_metric_P(&w->metric, w->dp);
    for (size_t i = 0; i < n; i++) {
        w->S[i * m + j] = w->Q[n + i];
        w->S[(n + i) * m + j] = w->dp[i];
    }
}

static void measure(struct parts *w, struct pk_stepmap *map)
{
    const size_t n = w->n, m = 2 * n;
    pk_real size = 1;
    int sign;
    map->defect = 0;
    for (size_t i = 0; i < m; i++)
        for (size_t j = 0; j < m; j++) {
            pk_real form = (j == i + n) ? -PK_C(1.0) : (i == j + n) ? PK_C(1.0) : 0, sum = 0;
            for (size_t k = 0; k < n; k++) {
                const pk_real a = w->S[k * m + i] * w->S[(n + k) * m + j];
                const pk_real b = w->S[(n + k) * m + i] * w->S[k * m + j];
                form += a - b;
                sum += pk_abs(a) + pk_abs(b);
            }
            if (!(pk_abs(form) <= map->defect)) /* the condition is true for NaN */
                map->defect = pk_abs(form);
            size = pk_max(size, sum);
        }
    memcpy(w->LU, w->S, m * m * sizeof *w->S);
    map->volume = -1;
    if (pk_lu_factor(w->LU, w->pivot, m))
        map->volume += pk_lu_determinant(w->LU, w->pivot, m, &sign);
    map->rounding = 16 * PK_EPSILON * size * (pk_real)m;
}

static enum pk_status column(struct parts *w, const struct pk_method *method,
                             const struct pk_options *options, pk_real t0, const pk_real *q0,
                             const pk_real *v0, size_t j)
{
    const size_t n = w->n;
    memcpy(w->Q, q0, n * sizeof *q0);
    memcpy(w->V, v0, n * sizeof *v0);
    displace(w, t0, j);
    enum pk_status status = pk_integrator_init(&w->it, &w->variation.problem, method, options, t0,
                                               w->Q, w->V, w->block, w->block_size);
    if (status >= 0)
        status = pk_integrator_to(&w->it, t0 + options->h);
    if (status >= 0 && w->it.count.steps != 1)
        status = PK_REFUSED;
    if (status >= 0)
        take_column(w, j);
    pk_integrator_free(&w->it);
    return status;
}

enum pk_status pk_stepmap_find(struct pk_stepmap *map, const struct pk_problem *problem,
                               const struct pk_method *method, const struct pk_options *options,
                               pk_real h, pk_real t0, const pk_real *q0, const pk_real *v0,
                               pk_real *S, void *block, size_t block_size)
{
    const size_t size = pk_stepmap_size(problem, method);
    if (map && method && method->traits & PK_ADAPTIVE && method->traits & PK_LINEAR &&
        !(method->traits & PK_IMPLICIT))
        return PK_REFUSED; /* step sizes depend on the state */
    if (map && problem && problem->system &&
        (problem->system->n_first_order || problem->system->constraints.n))
        return PK_REFUSED; /* first-order variables have no momenta; rows make q and p dependent */
    if (!map || !options || !q0 || !v0 || !size || !(h > 0))
        return PK_BAD_ARGUMENT;
    if (!block || block_size < size || (size_t)block % _Alignof(pk_real))
        return PK_BLOCK_TOO_SMALL;
    struct parts w;
    lay_out(&w, problem, method, (pk_real *)block);
    memset(map, 0, sizeof *map);
    map->h = h;

    struct pk_options one = *options;
    one.h = h;
    if (method->traits & PK_ADAPTIVE) {
        one.h_max = h;
        one.rtol = one.atol = PK_C(1e10);
        one.newton_tol = 8 * PK_EPSILON;
    }
    PK_TRY(pk_variation_init(&w.variation, problem, 1, w.variation_block,
                             pk_variation_size(problem, 1)));
    PK_TRY(pk_metric_init(&w.metric, &w.variation, t0, q0, v0, inputs(&w, t0), h, w.metric_block));
    for (size_t j = 0; j < 2 * w.n; j++)
        PK_TRY(column(&w, method, &one, t0, q0, v0, j));
    measure(&w, map);
    if (S)
        memcpy(S, w.S, 4 * w.n * w.n * sizeof *S);
    return pk_finite(map->defect) ? PK_DONE : PK_NOT_FINITE;
}

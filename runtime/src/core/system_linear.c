/* The linearised equations of motion; see pk/linear.h. M is factored once for all. */
#include <pk/linear.h>

#include "internal.h"

size_t pk_system_linear_size(const struct pk_problem *problem)
{
    const size_t n = pk_count_of(problem);
    return n * n + n + problem->system->n_inputs;
}

/* Solves M X = B for an n by n matrix B, in place. */
static void solve_columns(const pk_real *L, size_t n, pk_real *matrix, pk_real *column)
{
    for (size_t j = 0; j < n; j++) {
        for (size_t i = 0; i < n; i++)
            column[i] = matrix[i * n + j];
        pk_ldl_solve(L, n, column);
        for (size_t i = 0; i < n; i++)
            matrix[i * n + j] = column[i];
    }
}

/* With PK_SINGULAR_MASS, *failed is the failure as acceleration() would return it. */
static enum pk_status linear(const struct pk_problem *problem, pk_real t, const pk_real *q,
                             const pk_real *v, pk_real *a, pk_real *a_q, pk_real *a_v, pk_real *a_t,
                             pk_real *work, int *failed)
{
    const struct pk_system *system = problem->system;
    const void *params = problem->params;
    if (!system->linear || !system->mass)
        return PK_REFUSED;
    const size_t n = pk_system_count(system, params);
    pk_real *L = work, *column = L + n * n, *u = column + n;
    pk_input(problem, t, u);
    *failed = system->acceleration(params, t, q, v, u, a);
    if (!*failed) {
        system->mass(params, t, q, v, u, L);
        const size_t pivot = pk_ldl_factor(L, n);
        *failed = pivot ? PK_FAILED(PK_FAILURE_MASS, pivot - 1) : 0;
    }
    if (*failed)
        return PK_SINGULAR_MASS;
    system->linear(params, t, q, v, u, a, a_q, a_v, a_t);
    solve_columns(L, n, a_q, column);
    solve_columns(L, n, a_v, column);
    pk_ldl_solve(L, n, a_t);
    return pk_all_finite(a, n) && pk_all_finite(a_q, n * n) && pk_all_finite(a_v, n * n) &&
                   pk_all_finite(a_t, n)
               ? PK_DONE
               : PK_NOT_FINITE;
}

enum pk_status pk_system_linear(const struct pk_problem *problem, pk_real t, const pk_real *q,
                                const pk_real *v, pk_real *a, pk_real *a_q, pk_real *a_v,
                                pk_real *a_t, pk_real *work)
{
    int failed;
    return linear(problem, t, q, v, a, a_q, a_v, a_t, work, &failed);
}

enum pk_status pk_eval_linear(struct pk_integrator *it, pk_real t, const pk_real *q,
                              const pk_real *v, pk_real *a, pk_real *a_q, pk_real *a_v,
                              pk_real *a_t, pk_real *work)
{
    int failed;
    const enum pk_status status = linear(&it->problem, t, q, v, a, a_q, a_v, a_t, work, &failed);
    it->count.jacobians++;
    return status == PK_SINGULAR_MASS ? pk_eval_failed(it, t, q, v, failed) : status;
}

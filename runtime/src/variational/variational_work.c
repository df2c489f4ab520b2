/* Shared by the files of a variational step (variational.c): memory, momenta and forces, and M. */

#include "variational.h"

static size_t lay_out(struct pk_variational_work *w, const struct pk_system *system, pk_real *base)
{
    const size_t n = w->n;
    w->whole = !system->families.diagonal;
    const size_t nn = w->whole ? n * n : 0;
    pk_real *M = NULL;
    /* clang-format off */
    const struct pk_slot slots[] = {
        {&w->V, n}, {&w->dV, n}, {&w->scale, n}, {&w->p, n}, {&w->f, n}, {&w->p_end, n},
        {&w->f_end, n}, {&w->f_start, n}, {&w->q_at, w->rotation}, {&w->v_at, n},
        {&w->q_end, w->rotation}, {&w->v_end, n}, {&w->low_q, w->rotation}, {&w->low_v, n},
        {&w->kick, n}, {&w->pull, n}, {&w->root, n}, {&w->spare, n}, {&w->last_V, n},
        {&w->last_h, 1}, {&w->kept, n}, {&w->slope, n}, {&w->pivot, n}, {&w->kept_kick, n},
        {&w->A_pivot, n}, {&w->J, nn}, {&w->lu, nn}, {&M, w->whole ? nn : n}};
    /* clang-format on */
    const size_t size = PK_LAY_OUT(base, slots);
    w->at.M = w->whole || !system->constraints.factor ? M : w->at.M;
    return size;
}

size_t pk_variational_size(const struct pk_method *method, const struct pk_problem *problem,
                           size_t n)
{
    struct pk_variational_work w = {.table = (const struct pk_variational *)method->table,
                                    .rotation = pk_coordinates_of(problem),
                                    .n = n};
    return lay_out(&w, problem->system, NULL);
}

struct pk_variational_work pk_variational_parts(const struct pk_integrator *it)
{
    const struct pk_problem *problem = &it->problem;
    struct pk_variational_work w = {.table = (const struct pk_variational *)it->method->table};
    w.n = it->n;
    w.turned = pk_system_rotations(problem->system, problem->params);
    /* Without constraints, `at` is in the work memory, and only its M is used. */
    w.at = pk_project_parts(problem, it->n, it->own->project ? it->own->project : it->own->work);
    w.c = w.at.c;
    w.m = w.at.m;
    w.rotation = w.at.rotation;
    w.states = w.m + 4 * w.turned;
    lay_out(&w, problem->system, it->own->work);
    return w;
}

void pk_variational_momenta(struct pk_integrator *it, pk_real t, const pk_real *q, const pk_real *v,
                            pk_real *p, pk_real *pdot)
{
    const struct pk_system *system = it->problem.system;
    const pk_real *u = pk_eval_input(it, t);
    it->count.evaluations++;
    (system->unconstrained ? system->unconstrained : system->canonical)(it->problem.params, t, q, v,
                                                                        u, p, pdot);
}

enum pk_status pk_variational_mass(struct pk_integrator *it, struct pk_variational_work *w,
                                   pk_real t, const pk_real *q, const pk_real *v)
{
    const struct pk_part_families *families = &it->problem.system->families;
    const pk_real *u = w->at.u = pk_eval_input(it, t);
    w->at.t = t;
    it->count.factorisations++;
    int failed = w->whole || w->c   ? pk_project_inertia(&w->at, q, v)
                 : families->factor ? families->factor(it->problem.params, t, q, v, u)
                                    : 0;
    if (!w->whole && !w->c)
        families->diagonal(it->problem.params, t, q, v, u, w->at.M);
    for (size_t k = 0; k < w->m && !failed; k++) {
        const pk_real mass = w->whole ? pk_ldl_diagonal(w->at.M, w->m, k) : w->at.M[k];
        w->root[k] = PK_F(sqrt)(mass);
        if (!(mass > 0))
            failed = PK_FAILED(PK_FAILURE_MASS, k);
    }
    if (failed)
        return pk_eval_failed(it, t, q, v, failed);
    return w->c && !w->whole ? pk_variational_rows(it, w, q, v) : PK_DONE;
}

enum pk_status pk_variational_rows(struct pk_integrator *it, struct pk_variational_work *w,
                                   const pk_real *q, const pk_real *v)
{
    pk_project_rows(&w->at, q, v);
    const size_t singular = pk_project_factor(&w->at, w->c, q, v);
    if (singular && w->at.inertia)
        return pk_eval_failed(it, w->at.t, q, v, w->at.inertia);
    return singular ? pk_fail_with(it, PK_NO_PROJECTION, PK_WHY(.index = singular - 1)) : PK_DONE;
}

void pk_variational_by_mass(const struct pk_variational_work *w, pk_real *x)
{
    if (w->whole) {
        pk_ldl_solve(w->at.M, w->m, x);
    } else if (w->c) {
        pk_zero(w->at.mu, w->c);
        w->at.system->constraints.solve(w->at.params, x, w->at.mu, x, w->at.mu);
    } else if (w->at.system->families.solve) {
        w->at.system->families.solve(w->at.params, x, x);
    } else {
        for (size_t k = 0; k < w->m; k++)
            x[k] /= w->at.M[k];
    }
}

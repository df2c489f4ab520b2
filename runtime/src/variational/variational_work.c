/* What all of a variational step shares (variational.c): its memory, momenta and forces, and M. */
#include "variational.h"

static size_t lay_out(struct pk_variational_work *w, pk_real *base)
{
    const size_t n = w->n;
    const struct pk_slot slots[] = {
        {&w->V, n},      {&w->dV, n},      {&w->scale, n},     {&w->p, n},       {&w->f, n},
        {&w->p_end, n},  {&w->f_end, n},   {&w->f_start, n},   {&w->q_at, n},    {&w->v_at, n},
        {&w->q_end, n},  {&w->v_end, n},   {&w->low_q, n},     {&w->low_v, n},   {&w->kick, n},
        {&w->root, n},   {&w->spare, n},   {&w->last_V, n},    {&w->last_h, 1},  {&w->kept, n},
        {&w->slope, n},  {&w->pivot, n},   {&w->kept_kick, n}, {&w->A_pivot, n}, {&w->J, n * n},
        {&w->lu, n * n}, {&w->at.M, n * n}};
    return PK_LAY_OUT(base, slots);
}

size_t pk_variational_size(const struct pk_method *method, size_t n)
{
    struct pk_variational_work w = {.table = (const struct pk_variational *)method->table, .n = n};
    return lay_out(&w, NULL);
}

struct pk_variational_work pk_variational_parts(const struct pk_integrator *it)
{
    const struct pk_system *system = it->problem.system;
    struct pk_variational_work w = {.table = (const struct pk_variational *)it->method->table};
    w.n = it->n;
    w.turned = system->n_rotations;
    /* Of what is free M alone is used. */
    w.at =
        pk_project_parts(&it->problem, it->n, it->own->project ? it->own->project : it->own->work);
    w.c = w.at.c;
    w.m = w.at.m;
    w.rotation = w.at.rotation;
    w.states = w.m + 4 * w.turned;
    lay_out(&w, it->own->work);
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
    w->at.t = t;
    w->at.u = pk_eval_input(it, t);
    it->count.factorisations++;
    const int failed = pk_project_inertia(&w->at, q, v);
    if (failed)
        return pk_eval_failed(it, t, q, v, failed);
    for (size_t k = 0; k < w->m; k++)
        w->root[k] = PK_F(sqrt)(pk_ldl_diagonal(w->at.M, w->m, k));
    return PK_DONE;
}

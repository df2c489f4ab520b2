/* The memory of the implicit methods in (q, p), and the tableau multiplied by the step size. */
#include <string.h>

#include "gauss.h"
#include "../core/generic.h"

#include <pk/step/gauss_stages.h>

/* Assigns the memory of w, whose table, n_q, n and pattern are set. Returns its size. */
static size_t lay_out(struct pk_gauss_work *w, pk_real *base)
{
    const size_t n = w->n, s = (size_t)w->table->stages, m = s * n;
    const size_t rows = w->pattern.rows, border = w->pattern.border, banded = !w->pattern.dense;
    const size_t places = rows + border, by_places = s * places;
    const size_t kept = PK_REALS_OF(struct pk_gauss_kept), room = by_places > n ? by_places : n;
    const size_t across = banded ? border : n;
    const size_t nn = banded ? pk_pattern_numbers(&w->pattern) : n * n;
    pk_real *memory = NULL, *lu = NULL, *other = NULL;
    w->s = s;
    w->places = places;
    w->nn = nn;
    w->across = across;
    w->lu = w->other = (struct pk_band){.rows = s * rows,
                                        .below = s * w->pattern.width + s - 1,
                                        .above = s * w->pattern.width + s - 1,
                                        .border = s * border};
    w->lu.pivoting = 1;
    /* clang-format off */
    const struct pk_slot slots[] = {
        {&memory, kept},      {&w->V, m},           {&w->Q, s * w->n_q},         {&w->P, m},
        {&w->F, m},           {&w->G, m},           {&w->last_V, m},
        {&w->jacobian, 4 * s * nn},                 {&w->mass, nn},
        {&lu, pk_band_lay_out(&w->lu, NULL)},       {&other, pk_band_lay_out(&w->other, NULL)},
        {&w->mean_q, w->n_q},      {&w->mean_v, n},      {&w->scale, n},       {&w->mu, s * s},
        {&w->mu_p, s * s},    {&w->hA, s * s},      {&w->hA_p, s * s},    {&w->predict, s * (s + 1)},
        {&w->hb, s},          {&w->norms, 3},       {&w->hh, s * s * s},  {&w->mu_columns, s * s},
        {&w->start_J, 4 * nn},                      {&w->before_J, 4 * s * nn},
        {&w->old_J, 4 * s * nn},                    {&w->old_V, m},       {&w->older_V, m},
        {&w->c, s},           {&w->b, s},           {&w->x, room},        {&w->y, room},
        {&w->M, banded ? s * nn : nn},              {&w->place, banded * places},
        {&w->z, by_places + places},
        {&w->rest, s == PK_LANES ? pk_gauss_lanes_size(w->n_q, n) : 0}};
    /* clang-format on */
    const size_t size = PK_LAY_OUT(base, slots);
    w->kept = (struct pk_gauss_kept *)(void *)memory;
    if (base) {
        pk_band_lay_out(&w->lu, lu);
        pk_band_lay_out(&w->other, other);
    }
    return size;
}

size_t pk_gauss_size(const struct pk_method *method, const struct pk_problem *problem, size_t n)
{
    struct pk_gauss_work w = {.table = (const struct pk_gauss *)method->table,
                              .n_q = pk_coordinates_of(problem),
                              .n = n,
                              .pattern = pk_system_pattern(problem->system, problem->params)};
    return lay_out(&w, NULL);
}

struct pk_gauss_work pk_gauss_parts(struct pk_integrator *it)
{
    struct pk_gauss_work w = {.table = (const struct pk_gauss *)it->method->table,
                              .n_q = it->n_q,
                              .n = it->n,
                              .closed = it->problem.system->families.closed != NULL,
                              .pattern = pk_system_pattern(it->problem.system, it->problem.params)};
    lay_out(&w, it->own->work);
    return w;
}

static void make_tables(struct pk_integrator *it, const struct pk_gauss_work *w)
{
    const size_t s = w->s;
    pk_collocation(w->table, w->c, w->b, w->mu);
    for (size_t i = 0; i < s; i++)
        for (size_t j = 0; j < s; j++) {
            pk_real *mu = &w->mu[i * s + j], *conjugate = &w->mu_p[j * s + i];
            if (!w->table->conjugate)
                w->mu_p[i * s + j] = *mu;
            else if (*mu >= PK_C(0.5))
                *conjugate = 1 - *mu; /* 1 - x is exact for .5 <= x <= 1 */
            else
                *conjugate = 1 - *mu, *mu = 1 - *conjugate;
            w->mu_columns[j * s + i] = *mu;
        }
    if (s == PK_LANES)
        pk_gauss_make_matrices(pk_gauss_lanes(it, it->n_q, it->n, w->rest).M);
    for (size_t k = 0; k < w->places && !w->pattern.dense; k++)
        w->place[k] = (pk_real)it->problem.system->families.place(it->problem.params, k);
    it->own->made = 1;
}

enum pk_status pk_gauss_init(struct pk_integrator *it)
{
    const struct pk_gauss_work w = pk_gauss_parts(it);
    pk_real *p = pk_state(it, PK_P);
    if (!it->own->made)
        make_tables(it, &w);
    memset(w.kept, 0, sizeof *w.kept);
    w.kept->contraction = w.kept->last_contraction = PK_INFINITY;
    pk_eval_canonical(it, it->t, it->q, it->v, p, w.F);
    it->p = p;
    return pk_all_finite(p, it->n) ? PK_DONE : PK_NOT_FINITE;
}

/* Computes h b_i, then h a_ij = mu_ij h b_j. The first and last h b_i (for methods that are not
 * symmetric, only the last) are adjusted so that all h b_i sum to h. */
void pk_gauss_set_step(struct pk_integrator *it, struct pk_gauss_work *w, pk_real h)
{
    const size_t s = w->s;
    pk_real inner = 0;
    for (size_t i = 0; i < s; i++)
        w->hb[i] = h * w->b[i];
    for (size_t i = 1; i + 1 < s; i++)
        inner += w->hb[i];
    if (!(it->method->traits & PK_SYMMETRIC))
        w->hb[s - 1] = h - (w->hb[0] + inner);
    else if (s > 1)
        w->hb[0] = w->hb[s - 1] = (h - inner) / 2;
    for (size_t i = 0; i < s * s; i++) {
        w->hA[i] = w->mu[i] * w->hb[i % s];
        w->hA_p[i] = w->mu_p[i] * w->hb[i % s];
    }
    pk_zero(w->norms, 3);
    for (size_t i = 0; i < s; i++) {
        pk_real sums[3] = {0, 0, 0};
        for (size_t j = 0; j < s; j++) {
            for (size_t r = 0; r < s; r++) {
                const pk_real both = w->hA_p[i * s + r] * w->hA[r * s + j];
                w->hh[(i * s + j) * s + r] = both;
                sums[2] += pk_abs(both);
            }
            sums[0] += pk_abs(w->hA[i * s + j]);
            sums[1] += pk_abs(w->hA_p[i * s + j]);
        }
        for (int k = 0; k < 3; k++)
            w->norms[k] = pk_max(w->norms[k], sums[k]);
    }
    w->kept->h = h;
}

void pk_gauss_lanes_last(const struct pk_integrator *it, const struct pk_gauss_lanes *w,
                         struct pk_stages *to)
{
    for (size_t i = 0; i < PK_GAUSS_S; i++)
        for (size_t k = 0; k < it->n; k++) {
            to->Q[i * it->n + k] = k < it->n_q ? w->q[k * PK_GAUSS_S + i] : 0;
            to->V[i * it->n + k] = w->v[k * PK_GAUSS_S + i];
        }
}

void pk_gauss_last(struct pk_integrator *it, struct pk_stages *to)
{
    const struct pk_gauss_work w = pk_gauss_parts(it);
    const size_t n = it->n, s = w.s;
    pk_copy(to->c, w.c, s);
    pk_copy(to->A, w.hA, s * s);
    pk_copy(to->A + s * s, w.hb, s);
    pk_copy(to->A_p, w.hA_p, s * s);
    pk_copy(to->A_p + s * s, w.hb, s);
    if (pk_gauss_by_lanes(it, &w, w.kept->h)) {
        const struct pk_gauss_lanes lanes = pk_gauss_lanes(it, it->n_q, n, w.rest);
        pk_gauss_lanes_last(it, &lanes, to);
        return;
    }
    for (size_t i = 0; i < s; i++)
        pk_copy(to->Q + i * n, w.Q + i * w.n_q, w.n_q);
    pk_copy(to->V, w.V, s * n);
}

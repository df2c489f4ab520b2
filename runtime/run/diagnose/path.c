/* Hamilton's principle along a computed path; see motion.h. The path is integrated between the
 * nodes of a composite Gauss rule, together with n displacements whose initial rates are unit
 * vectors. Where the determinant of the n displacements changes sign is a conjugate point. */
#include "../../src/core/internal.h"
#include <pk/root.h>
#include "motion.h"

#include <pk/step/gauss_tables.h>

enum { NODES = 8 };

static void modes_at(const struct least_action *found, pk_real t)
{
    const struct node *x = &found->node;
    for (size_t k = 0; k < found->modes; k++) {
        const pk_real w = (pk_real)(k + 1) * PK_PI / found->time;
        x->sine[k] = PK_F(sin)(w * (t - found->t0));
        x->rate[k] = w * PK_F(cos)(w * (t - found->t0));
    }
}

/* Returns the Lagrangian L = p.v - h, where h is the energy; *size is |p.v| + |h|. */
static pk_real lagrangian(const struct least_action *found, pk_real t, const pk_real *q,
                          const pk_real *v, pk_real *size)
{
    const struct pk_problem *of = &found->variation.of;
    const struct node *x = &found->node;
    const pk_real *u = variation_inputs(&found->variation, t);
    of->system->canonical(of->params, t, q, v, u, x->p, x->g); /* pdot is dL/dq without forces */
    const pk_real h = of->system->energy(of->params, t, q, v, u);
    const pk_real work = pk_dot(x->p, v, found->n);
    *size = pk_abs(work) + pk_abs(h);
    return work - h;
}

/* Adds the contribution of a node to the action S, to the derivatives of S by the mode amplitudes,
 * to the second derivatives C of S, and to their kinetic part B. `slopes` holds the sums of first
 * derivatives, then the sums of their absolute values. */
static void add(struct least_action *found, pk_real weight, pk_real t, const pk_real *q,
                const pk_real *v)
{
    const struct pk_problem *of = &found->variation.of;
    const struct node *x = &found->node;
    const pk_real *u = found->variation.u;
    const size_t n = found->n, modes = found->modes, m = n * modes;
    pk_real both;
    found->action += weight * lagrangian(found, t, q, v, &both);
    found->size += weight * both;
    of->system->mass(of->params, t, q, v, u, x->M);
    of->system->jacobian(of->params, t, q, v, u, x->p_q, x->g_q, x->g_v);
    modes_at(found, t);
    for (size_t i = 0; i < n; i++)
        for (size_t k = 0; k < modes; k++) {
            const size_t row = i * modes + k;
            const pk_real by_rate = weight * x->p[i] * x->rate[k];
            const pk_real by_place = weight * x->g[i] * x->sine[k];
            found->slopes[row] += by_rate + by_place;
            found->slopes[m + row] += pk_abs(by_rate) + pk_abs(by_place);
            for (size_t j = 0; j < n; j++)
                for (size_t l = 0; l < modes; l++) {
                    const size_t at = row * m + j * modes + l;
                    const pk_real kinetic = weight * x->M[i * n + j] * x->rate[k] * x->rate[l];
                    found->B[at] += kinetic;
                    found->C[at] += kinetic +
                                    weight * (x->rate[k] * x->p_q[i * n + j] * x->sine[l] +
                                              x->sine[k] * x->p_q[j * n + i] * x->rate[l] +
                                              x->sine[k] * x->g_q[i * n + j] * x->sine[l]);
                }
        }
}

/* Returns det dq/dv0 of the displacements, by elimination with partial pivoting. */
static pk_real determinant(const struct least_action *found)
{
    const size_t n = found->n;
    int sign;
    memcpy(found->J, found->variation.motion.it.q + n, n * n * sizeof *found->J);
    return pk_lu_factor(found->J, found->pivot, n)
               ? pk_lu_determinant(found->J, found->pivot, n, &sign)
               : 0;
}

/* Q and V of the variation are the state at the time `from`. */
struct search {
    struct least_action *found;
    pk_real from;
};

static enum pk_status reach(const struct search *s, pk_real t)
{
    struct variation *of = &s->found->variation;
    enum pk_status status = pk_integrator_reset(&of->motion.it, s->from, of->Q, of->V);
    return status < 0 || !(t > s->from) ? status : pk_integrator_to(&of->motion.it, t);
}

static enum pk_status determinant_at(void *context, pk_real t, pk_real *y)
{
    const struct search *s = (const struct search *)context;
    const enum pk_status status = reach(s, t);
    *y = determinant(s->found);
    return status;
}

/* Finds the conjugate point between the time s->from and now, then restores the state of now. */
static enum pk_status conjugate(struct search *s, pk_real before, pk_real det)
{
    struct least_action *found = s->found;
    const pk_real now = found->variation.motion.it.t;
    pk_real a = s->from, b = now;
    PK_TRY(
        pk_root(determinant_at, s, &a, before, &b, det, 4 * PK_EPS * (pk_abs(now) + found->time)));
    if (found->n_conjugate < CONJUGATE_MOST)
        found->conjugate[found->n_conjugate] = b;
    found->n_conjugate++;
    return reach(s, now);
}

/* Returns the time of a node, and sets its weight; the node behind the last one is the end. */
static pk_real node_at(const struct least_action *found, size_t k, pk_real *weight)
{
    const pk_real width = found->time / (pk_real)(found->nodes / NODES);
    *weight = width * pk_gauss8_b[k % NODES];
    return k == found->nodes ? found->t0 + found->time
                             : found->t0 + width * ((pk_real)(k / NODES) + pk_gauss8_c[k % NODES]);
}

static enum pk_status along(struct least_action *found)
{
    struct variation *of = &found->variation;
    struct pk_integrator *it = &of->motion.it;
    const size_t n = found->n, m = n * found->modes, wide = n * (1 + n);
    struct search search = {found, found->t0};
    pk_real before = 0, weight;
    for (size_t k = 0; k <= found->nodes; k++) {
        const pk_real t = node_at(found, k, &weight);
        search.from = it->t;
        memcpy(of->Q, it->q, wide * sizeof *of->Q);
        memcpy(of->V, it->v, wide * sizeof *of->V);
        PK_TRY(pk_integrator_to(it, t));
        const pk_real det = determinant(found);
        if (before * det < 0)
            PK_TRY(conjugate(&search, before, det));
        before = det;
        if (k == found->nodes)
            break;
        memcpy(found->path + k * 2 * n, it->q, n * sizeof *it->q);
        memcpy(found->path + k * 2 * n + n, it->v, n * sizeof *it->v);
        add(found, weight, t, it->q, it->v);
    }
    for (size_t i = 0; i < m; i++)
        if (found->slopes[m + i] > 0)
            found->slope = pk_max(found->slope, pk_abs(found->slopes[i]) / found->slopes[m + i]);
    return PK_DONE;
}

enum pk_status least_action_find(struct least_action *found, const struct motion *motion,
                                 size_t panels, size_t modes)
{
    struct variation *of = &found->variation;
    struct node *x = &found->node;
    memset(found, 0, sizeof *found);
    PK_TRY(variation_init(of, motion, pk_count_of(motion->problem)));
    const size_t n = of->n, nn = n * n, m = n * modes;
    found->n = n;
    found->modes = modes;
    found->nodes = panels * NODES;
    found->t0 = motion->t;
    found->time = motion->end - motion->t;
    /* clang-format off */
    const struct pk_slot slots[] = {
        {&found->path, found->nodes * 2 * n}, {&found->B, m * m}, {&found->C, m * m},
        {&found->slopes, 2 * m}, {&found->J, nn}, {&found->pivot, n}, {&x->p, n}, {&x->g, n},
        {&x->q, n}, {&x->v, n}, {&x->M, nn}, {&x->p_q, nn}, {&x->g_q, nn}, {&x->g_v, nn},
        {&x->sine, modes}, {&x->rate, modes}};
    /* clang-format on */
    PK_LAY_OUT(memory_take(motion->memory, PK_LAY_OUT(NULL, slots), sizeof(pk_real)), slots);
    for (size_t i = 0; i < n; i++)
        of->V[n + i * n + i] = 1;
    PK_TRY(motion_begin(&of->motion));
    return along(found);
}

pk_real least_action_at(const struct least_action *found, const pk_real *a)
{
    const size_t n = found->n, modes = found->modes;
    const struct node *x = &found->node;
    pk_real sum = 0, size, weight;
    for (size_t k = 0; k < found->nodes; k++) {
        const pk_real t = node_at(found, k, &weight);
        const pk_real *at = found->path + k * 2 * n;
        modes_at(found, t);
        for (size_t i = 0; i < n; i++) {
            x->q[i] = at[i];
            x->v[i] = at[n + i];
            for (size_t l = 0; l < modes; l++) {
                x->q[i] += a[i * modes + l] * x->sine[l];
                x->v[i] += a[i * modes + l] * x->rate[l];
            }
        }
        sum += weight * lagrangian(found, t, x->q, x->v, &size);
    }
    return sum;
}

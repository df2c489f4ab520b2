/* Hamilton's principle along a computed path; see pk/least_action.h. The path is integrated between
 * the nodes of a composite Gauss rule, together with n displacements whose initial rates are unit
 * vectors. A point where the determinant of the n displacements changes sign is conjugate to the
 * start. */
#include <string.h>

#include <pk/least_action.h>

#include "../core/internal.h"
#include "../core/root.h"

#include <pk/step/gauss_tables.h>

#define PI PK_C(3.141592653589793238462643383279502884)
enum { NODES = 8 };

struct layout {
    size_t variation, integrator, path, matrix, scratch; /* sizes of memory, in pk_real */
};

static struct layout layout_of(const struct pk_problem *problem, const struct pk_method *method,
                               size_t panels, size_t modes)
{
    const size_t n = pk_system_count(problem->system, problem->params), m = n * modes;
    return (struct layout){
        .variation = pk_variation_size(problem, n) / sizeof(pk_real),
        .integrator = (pk_variation_integrator_size(problem, n, method) + sizeof(pk_real) - 1) /
                      sizeof(pk_real),
        .path = panels * NODES * 2 * n,
        .matrix = m * m,
        .scratch = 5 * n * n + 6 * n + 2 * m + 2 * modes + 4 * n * (1 + n) +
                   problem->system->n_inputs,
    };
}

size_t pk_least_action_size(const struct pk_problem *problem, const struct pk_method *method,
                            size_t panels, size_t modes)
{
    if (!problem || !method || !panels || !modes || !pk_variation_size(problem, 1))
        return 0;
    const struct layout x = layout_of(problem, method, panels, modes);
    return (x.variation + x.integrator + x.path + 2 * x.matrix + x.scratch) * sizeof(pk_real);
}

/* Values of the kernels and of the modes, which are sines of t, at one node of the rule. */
struct node {
    pk_real *p, *g, *M, *p_q, *g_q, *g_v; /* g: dL/dq at the node */
    pk_real *sine, *rate;                 /* value and time derivative of each mode */
    pk_real *u, *q, *v;
};

static struct node node_of(pk_real *at, size_t n, size_t modes)
{
    struct node x;
    x.p = at, at += n;
    x.g = at, at += n;
    x.q = at, at += n;
    x.v = at, at += n;
    x.M = at, at += n * n;
    x.p_q = at, at += n * n;
    x.g_q = at, at += n * n;
    x.g_v = at, at += n * n;
    x.sine = at, at += modes;
    x.rate = at, at += modes;
    x.u = at;
    return x;
}

static void modes_at(const struct pk_least_action *found, pk_real t, struct node *x)
{
    for (size_t k = 0; k < found->modes; k++) {
        const pk_real w = (pk_real)(k + 1) * PI / found->time;
        x->sine[k] = PK_F(sin)(w * (t - found->t0));
        x->rate[k] = w * PK_F(cos)(w * (t - found->t0));
    }
}

/* Returns the Lagrangian L = p.v - h, where h is the energy; *size is |p.v| + |h|. */
static pk_real lagrangian(const struct pk_problem *of, struct node *x, pk_real t, const pk_real *q,
                          const pk_real *v, size_t n, pk_real *size)
{
    pk_input(of, t, x->u);
    of->system->canonical(of->params, t, q, v, x->u, x->p, x->g); /* pdot is dL/dq without forces */
    const pk_real h = of->system->energy(of->params, t, q, v, x->u);
    pk_real work = 0;
    for (size_t i = 0; i < n; i++)
        work += x->p[i] * v[i];
    *size = pk_abs(work) + pk_abs(h);
    return work - h;
}

/* Adds the contribution of a node to the action S, to the derivatives of S by the mode amplitudes,
 * to the second derivatives C of S, and to their kinetic part B. `slope` holds the sums of first
 * derivatives, then the sums of their absolute values. */
static void add(struct pk_least_action *found, struct node *x, pk_real weight, pk_real t,
                const pk_real *q, const pk_real *v, pk_real *slope, pk_real *B, pk_real *C)
{
    const struct pk_problem *of = &found->variation.of;
    const size_t n = found->n, modes = found->modes, m = n * modes;
    pk_real both;
    found->action += weight * lagrangian(of, x, t, q, v, n, &both);
    found->size += weight * both;
    of->system->mass(of->params, t, q, v, x->u, x->M);
    of->system->jacobian(of->params, t, q, v, x->u, x->p_q, x->g_q, x->g_v);
    modes_at(found, t, x);
    for (size_t i = 0; i < n; i++)
        for (size_t k = 0; k < modes; k++) {
            const size_t row = i * modes + k;
            const pk_real by_rate = weight * x->p[i] * x->rate[k];
            const pk_real by_place = weight * x->g[i] * x->sine[k];
            slope[row] += by_rate + by_place;
            slope[m + row] += pk_abs(by_rate) + pk_abs(by_place);
            for (size_t j = 0; j < n; j++)
                for (size_t l = 0; l < modes; l++) {
                    const pk_real kinetic = weight * x->M[i * n + j] * x->rate[k] * x->rate[l];
                    B[row * m + j * modes + l] += kinetic;
                    C[row * m + j * modes + l] +=
                        kinetic + weight * (x->rate[k] * x->p_q[i * n + j] * x->sine[l] +
                                            x->sine[k] * x->p_q[j * n + i] * x->rate[l] +
                                            x->sine[k] * x->g_q[i * n + j] * x->sine[l]);
                }
        }
}

/* Returns det dq/dv0 of the displacements, by elimination with partial pivoting. */
static pk_real determinant(const struct pk_least_action *found, pk_real *J, pk_real *pivot)
{
    const size_t n = found->n;
    memcpy(J, found->it.q + n, n * n * sizeof *J);
    int sign;
    return pk_lu_factor(J, pivot, n) ? pk_lu_determinant(J, pivot, n, &sign) : 0;
}

struct search {
    struct pk_least_action *found;
    pk_real from; /* time at which the search starts; q and v are the state at this time */
    const pk_real *q, *v;
    pk_real *J, *pivot;
};

static enum pk_status reach(const struct search *s, pk_real t)
{
    struct pk_integrator *it = &s->found->it;
    enum pk_status status = pk_integrator_reset(it, s->from, s->q, s->v);
    return status < 0 || !(t > s->from) ? status : pk_integrator_to(it, t);
}

static enum pk_status determinant_at(void *context, pk_real t, pk_real *y)
{
    const struct search *s = (const struct search *)context;
    const enum pk_status status = reach(s, t);
    *y = determinant(s->found, s->J, s->pivot);
    return status;
}

/* Finds the conjugate point between the time s->from and the current time, then restores the state
 * at the current time. */
static enum pk_status conjugate(struct search *s, pk_real before, pk_real det)
{
    struct pk_least_action *found = s->found;
    const pk_real now = found->it.t;
    pk_real a = s->from, b = now;
    PK_TRY(
        pk_root(determinant_at, s, &a, before, &b, det, 4 * PK_EPS * (pk_abs(now) + found->time)));
    if (found->n_conjugate < PK_CONJUGATE_MOST)
        found->conjugate[found->n_conjugate] = b;
    found->n_conjugate++;
    return reach(s, now);
}

static enum pk_status along(struct pk_least_action *found, pk_real *path, pk_real *B, pk_real *C)
{
    const size_t n = found->n, m = n * found->modes, wide = n * (1 + n);
    const size_t panels = found->nodes / NODES;
    struct pk_integrator *it = &found->it;
    pk_real *slope = found->scratch, *J = slope + 2 * m, *pivot = J + n * n;
    pk_real *q = pivot + n, *v = q + wide;
    struct node x = node_of(v + wide, n, found->modes);
    struct search search = {found, found->t0, q, v, J, pivot};
    const pk_real width = found->time / (pk_real)panels;
    pk_real before = 0;
    for (size_t k = 0; k <= found->nodes; k++) { /* the last node is the end */
        const int end = k == found->nodes;
        const pk_real t = end ? found->t0 + found->time
                              : found->t0 + width * ((pk_real)(k / NODES) + pk_gauss8_c[k % NODES]);
        search.from = it->t;
        memcpy(q, it->q, wide * sizeof *q);
        memcpy(v, it->v, wide * sizeof *v);
        PK_TRY(pk_integrator_to(it, t));
        const pk_real det = determinant(found, J, pivot);
        if (before * det < 0)
            PK_TRY(conjugate(&search, before, det));
        before = det;
        if (end)
            break;
        memcpy(path + k * 2 * n, it->q, n * sizeof *q);
        memcpy(path + k * 2 * n + n, it->v, n * sizeof *v);
        add(found, &x, width * pk_gauss8_b[k % NODES], t, it->q, it->v, slope, B, C);
    }
    for (size_t i = 0; i < m; i++)
        if (slope[m + i] > 0)
            found->slope = pk_max(found->slope, pk_abs(slope[i]) / slope[m + i]);
    return PK_DONE;
}

enum pk_status pk_least_action_find(struct pk_least_action *found, const struct pk_problem *problem,
                                    const struct pk_method *method,
                                    const struct pk_options *options, pk_real t0, const pk_real *q0,
                                    const pk_real *v0, pk_real time, size_t panels, size_t modes,
                                    void *block, size_t size)
{
    if (found)
        memset(found, 0, sizeof *found);
    const size_t least = pk_least_action_size(problem, method, panels, modes);
    if (!found || !least || !options || !q0 || !v0 || !(time > 0) || !pk_finite(time))
        return PK_BAD_ARGUMENT;
    if (!block || size < least || (size_t)block % _Alignof(pk_real))
        return PK_BLOCK_TOO_SMALL;
    if (!(problem->system->facts & PK_VARIATIONAL))
        return PK_REFUSED;
    const struct layout x = layout_of(problem, method, panels, modes);
    pk_real *at = (pk_real *)block;
    memset(at, 0, least);
    found->n = pk_system_count(problem->system, problem->params);
    found->modes = modes;
    found->nodes = panels * NODES;
    found->t0 = t0;
    found->time = time;
    PK_TRY(pk_variation_init(&found->variation, problem, found->n, at, x.variation * sizeof *at));
    pk_real *integrator = at + x.variation, *path = integrator + x.integrator;
    pk_real *B = path + x.path, *C = B + x.matrix;
    found->path = path, found->B = B, found->C = C;
    found->scratch = C + x.matrix;
    const size_t n = found->n;
    pk_real *q = found->scratch, *v = q + n * (1 + n);
    memcpy(q, q0, n * sizeof *q);
    memcpy(v, v0, n * sizeof *v);
    for (size_t i = 0; i < n; i++)
        v[n + i * n + i] = 1;
    const enum pk_status status = pk_integrator_init(&found->it, &found->variation.problem, method,
                                                     options, t0, q, v, integrator,
                                                     x.integrator * sizeof *at);
    memset(found->scratch, 0, x.scratch * sizeof *at);
    return status < 0 ? status : along(found, path, B, C);
}

pk_real pk_least_action_at(const struct pk_least_action *found, const pk_real *a)
{
    const size_t n = found->n, modes = found->modes;
    const pk_real width = found->time / (pk_real)(found->nodes / NODES);
    struct node x = node_of(found->scratch, n, modes);
    pk_real sum = 0, size;
    for (size_t k = 0; k < found->nodes; k++) {
        const pk_real t = found->t0 + width * ((pk_real)(k / NODES) + pk_gauss8_c[k % NODES]);
        const pk_real *at = found->path + k * 2 * n;
        modes_at(found, t, &x);
        for (size_t i = 0; i < n; i++) {
            x.q[i] = at[i];
            x.v[i] = at[n + i];
            for (size_t l = 0; l < modes; l++) {
                x.q[i] += a[i * modes + l] * x.sine[l];
                x.v[i] += a[i * modes + l] * x.rate[l];
            }
        }
        sum += width * pk_gauss8_b[k % NODES] *
               lagrangian(&found->variation.of, &x, t, x.q, x.v, n, &size);
    }
    return sum;
}

void pk_least_action_free(struct pk_least_action *found) { pk_integrator_free(&found->it); }

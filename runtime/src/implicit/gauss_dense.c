/* Dense output of the adaptive Gauss method, as accurate as the step. The polynomial through its 8
 * stages is less accurate (1e-9 within a step with an error of 1e-13 at its end), but a good first
 * guess. At the first use it is refined, over the same step, to collocation at 16 nodes,
 *
 *     a(x) = sum_k<16 alpha_k P_k(2 x - 1),   v = v0 + h int a,   q = q0 + h int v,
 *
 * by Picard iteration: q and v at the nodes, two calls of the lane kernel, then new alpha. Each
 * output is then a sum of Legendre polynomials. Their integrals: int P_k = (P_k+1 - P_k-1) / (2 (2
 * k + 1)) on [0, 1].
 *
 * The iteration contracts while h times the fastest frequency is below about 15, even if that
 * frequency is not excited. Steps of a long chain may be longer, since the iteration of the step
 * ends before the round-off that it amplifies reaches the tolerance. Such a step is divided into
 * pieces with a collocation each, which starts at the end of the last one; pieces are halved until
 * the iteration contracts.
 *
 * Reference: E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, II.7,
 * for collocation. */

#include "gauss_dense.h"
#include "../core/generic.h"
#include "../core/tableau.h"

#include <pk/step/gauss_stages.h>

enum { NODES = PK_GAUSS_NODES, TERMS = NODES + 2 };

/* length of the shortest piece of a step, relative to the step */
#define LEAST PK_C(0x1p-10)

/* Work arrays of dense output, which follow those of the step. */
struct parts {
    pk_real *node, *weight;
    pk_real *P, *to_alpha; /* row k: P_k at the nodes; matrix from a at the nodes to alpha */
    /* values at 16 nodes, in two halves of n by 8 (q: n_q by 8); b: previous a */
    pk_real *q, *v, *a, *b;
    pk_real *series;     /* n by 3 TERMS coefficients: TERMS each for a, v and q */
    pk_real *from;       /* q and v at the start of the piece */
    pk_real *at, *width; /* start and length of the piece relative to the step */
};

static size_t lay_out(struct parts *d, size_t n_q, size_t n, pk_real *base)
{
    /* clang-format off */
    const struct pk_slot slots[] = {
        {&d->node, NODES}, {&d->weight, NODES}, {&d->P, TERMS * NODES},
        {&d->to_alpha, NODES * NODES}, {&d->q, NODES * n_q}, {&d->v, NODES * n}, {&d->a, NODES * n},
        {&d->b, NODES * n}, {&d->series, 3 * TERMS * n}, {&d->from, n_q + n}, {&d->at, 1},
        {&d->width, 1}};
    /* clang-format on */
    return PK_LAY_OUT(base, slots);
}

size_t pk_gauss_dense_size(size_t n_q, size_t n)
{
    struct parts d;
    return lay_out(&d, n_q, n, NULL);
}

static struct parts parts_of(struct pk_integrator *it)
{
    struct parts d;
    lay_out(&d, it->n_q, it->n, pk_gauss_lanes(it, it->n_q, it->n, it->own->work).dense);
    return d;
}

/* Returns where node l of the current piece of dense output lies in the step, from 0 to 1. */
static pk_real place_of(const struct parts *d, int l) { return *d->at + *d->width * d->node[l]; }

void pk_gauss_dense_init(struct pk_integrator *it)
{
    const struct parts at = parts_of(it), *d = &at;
    pk_real P[TERMS];
    pk_gauss_nodes(NODES, d->node, d->weight);
    for (int l = 0; l < NODES; l++) {
        pk_legendre(d->node[l], d->node[NODES - 1 - l], TERMS, P, NULL);
        for (int k = 0; k < TERMS; k++)
            d->P[k * NODES + l] = P[k];
        for (int k = 0; k < NODES; k++)
            d->to_alpha[k * NODES + l] = (pk_real)(2 * k + 1) * d->weight[l] * P[k];
    }
}

/* Integrates a Legendre series of `count` terms: at0 + h times the integral from 0. */
static void integrate(const pk_real *from, int count, pk_real h, pk_real at0, pk_real *to)
{
    pk_real start = 0;
    for (int k = 1; k <= count; k++) {
        const pk_real above = k + 1 < count ? from[k + 1] / (pk_real)(2 * k + 3) : 0;
        to[k] = h * (from[k - 1] / (pk_real)(2 * k - 1) - above) / 2;
        start += k % 2 ? -to[k] : to[k];
    }
    to[0] = at0 - start;
}

static void place(const pk_real *series, int count, const pk_real *P, pk_real *x0, pk_real *x1)
{
    for (int l = 0; l < NODES; l++) {
        pk_real sum = 0;
        for (int k = count - 1; k >= 0; k--)
            sum += series[k] * P[k * NODES + l];
        *(l < PK_GAUSS_S ? x0 + l : x1 + l - PK_GAUSS_S) = sum;
    }
}

/* Evaluates a at one half of the nodes. */
static enum pk_status evaluate(struct pk_integrator *it, const struct pk_gauss_lanes *w,
                               const struct parts *d, int half)
{
    const size_t of_q = (size_t)half * PK_GAUSS_S * it->n_q;
    const size_t first = (size_t)half * PK_GAUSS_S * it->n;
    pk_real t[PK_GAUSS_S];
    for (int l = 0; l < PK_GAUSS_S; l++)
        t[l] = it->last_t + *w->h * place_of(d, half * PK_GAUSS_S + l);
    return generic_gauss_evaluate(it, t, d->q + of_q, d->v + first, w->u, d->a + first);
}

/* Sets a at the nodes from the Taylor polynomial through the stages. */
static void begin(struct pk_integrator *it, const struct pk_gauss_lanes *w, const struct parts *d)
{
    for (size_t i = 0; i < it->n; i++)
        for (size_t l = 0; l < NODES; l++) {
            const pk_real *c = w->poly + i * PK_GAUSS_S;
            pk_real sum = 0;
            for (int k = PK_GAUSS_S - 1; k >= 0; k--)
                sum = sum * (place_of(d, (int)l) - 1) + c[k];
            d->a[l / PK_GAUSS_S * PK_GAUSS_S * it->n + i * PK_GAUSS_S + l % PK_GAUSS_S] = sum;
        }
}

/* Computes alpha from a at the nodes, then the series of v and q and their values at the nodes. */
static void collocate(struct pk_integrator *it, const struct pk_gauss_lanes *w,
                      const struct parts *d)
{
    const size_t n_q = it->n_q, n = it->n, half = PK_GAUSS_S * n, half_q = PK_GAUSS_S * n_q;
    const pk_real h = *w->h * *d->width;
    for (size_t i = 0; i < n; i++) {
        pk_real *a = d->series + i * 3 * TERMS, *v = a + TERMS, *q = v + TERMS;
        const pk_real *a0 = d->a + i * PK_GAUSS_S, *a1 = a0 + half;
        for (int k = 0; k < NODES; k++) {
            const pk_real *row = d->to_alpha + k * NODES;
            a[k] = pk_gauss_dot(row, a0) + pk_gauss_dot(row + PK_GAUSS_S, a1);
        }
        integrate(a, NODES, h, d->from[n_q + i], v);
        place(v, NODES + 1, d->P, d->v + i * PK_GAUSS_S, d->v + half + i * PK_GAUSS_S);
        if (i >= n_q)
            continue;
        integrate(v, NODES + 1, h, d->from[i], q);
        place(q, NODES + 2, d->P, d->q + i * PK_GAUSS_S, d->q + half_q + i * PK_GAUSS_S);
    }
}

/* Refines one piece. Returns PK_NO_CONVERGENCE as soon as corrections do not decrease. */
static enum pk_status refine(struct pk_integrator *it, const struct pk_gauss_lanes *w,
                             const struct parts *d)
{
    const size_t n = it->n, half = PK_GAUSS_S * n;
    pk_real before = 0;
    begin(it, w, d);
    collocate(it, w, d);
    for (int count = 0; count < 30; count++) {
        pk_copy(d->b, d->a, NODES * n);
        PK_TRY(evaluate(it, w, d, 0));
        PK_TRY(evaluate(it, w, d, 1));
        pk_real change2 = 0, size2 = 0;
        for (size_t i = 0; i < n; i++)
            for (size_t l = 0; l < NODES; l++) {
                const size_t at = l / PK_GAUSS_S * half + i * PK_GAUSS_S + l % PK_GAUSS_S;
                const pk_real weight_i = w->last_weight[i] * *d->width;
                const pk_real x = weight_i * d->a[at], y = weight_i * (d->a[at] - d->b[at]);
                size2 += x * x / (pk_real)(NODES * n);
                change2 += y * y / (pk_real)(NODES * n);
            }
        if (!pk_finite(change2) || !pk_finite(size2))
            return PK_NOT_FINITE;
        collocate(it, w, d);
        const pk_real rate2 = count ? change2 / before : PK_C(0.25);
        if (rate2 * change2 <= PK_C(0.01) * (1 - rate2) ||
            change2 <= PK_C(1e4) * PK_EPS * PK_EPS * size2)
            return PK_DONE;
        it->reason = PK_WHY(.value = PK_F(sqrt)(change2 / (size2 + PK_TINY)));
        if (count > 1 && rate2 > PK_C(0.5))
            break;
        before = change2;
    }
    return PK_NO_CONVERGENCE;
}

/* Evaluates the series of the piece at x, 0 <= x <= 1. */
static void values(const struct parts *d, size_t n_q, size_t n, pk_real x, pk_real *q, pk_real *v)
{
    pk_real P[TERMS];
    pk_legendre(x, 1 - x, TERMS, P, NULL);
    for (size_t i = 0; i < n; i++) {
        const pk_real *of_v = d->series + i * 3 * TERMS + TERMS, *of_q = of_v + TERMS;
        v[i] = 0;
        for (int k = TERMS - 2; k >= 0; k--)
            v[i] += of_v[k] * P[k];
        if (i < n_q)
            q[i] = 0;
        for (int k = TERMS - 1; k >= 0 && i < n_q; k--)
            q[i] += of_q[k] * P[k];
    }
}

/* Advances to the piece that contains x (relative to the step); restarts at the first piece if x is
 * before the current one. */
static enum pk_status reach(struct pk_integrator *it, const struct pk_gauss_lanes *w,
                            const struct parts *d, pk_real x)
{
    const size_t n_q = it->n_q, n = it->n;
    if (!(it->own->flags & PK_HAVE_DENSE) || x < *d->at) {
        pk_copy(d->from, w->start, n_q + n);
        *d->at = 0;
        *d->width = 1;
        it->own->flags &= ~PK_HAVE_DENSE;
    }
    for (;;) {
        const pk_real end = *d->at + *d->width;
        if (it->own->flags & PK_HAVE_DENSE) {
            if (x <= end || end >= 1)
                return PK_DONE;
            values(d, n_q, n, 1, d->from, d->from + n_q);
            *d->at = end;
            it->own->flags &= ~PK_HAVE_DENSE;
        }
        const enum pk_status status = refine(it, w, d);
        if (status >= 0)
            it->own->flags |= PK_HAVE_DENSE;
        else if (*d->width > LEAST)
            *d->width /= 2;
        else
            return status;
    }
}

enum pk_status pk_gauss_dense(struct pk_integrator *it, pk_real t, pk_real *q, pk_real *v)
{
    const size_t n_q = it->n_q, n = it->n;
    const struct pk_gauss_lanes w = pk_gauss_lanes(it, n_q, n, it->own->work);
    const struct parts d = parts_of(it);
    const pk_real x = (t - it->last_t) / *w.h;
    /* Returns exactly the state at the start of the step. */
    if (!(t > it->last_t) && !(t < it->last_t)) {
        pk_copy(q, w.start, n_q);
        pk_copy(v, w.start + n_q, n);
        return PK_DONE;
    }
    PK_TRY(reach(it, &w, &d, x));
    values(&d, n_q, n, (x - *d.at) / *d.width, q, v);
    return PK_DONE;
}

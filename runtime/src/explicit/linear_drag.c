/* Splitting methods for systems that are separable except for drag and gyroscopic forces C v with a
 * constant C, M a = g(q, t) + C v. The drift is the exact flow without g,
 *
 *     q += Phi v,   v += D v,       D = exp(delta h B) - 1,  B D^-1 Phi = 1,  B = M^-1 C,
 *
 * so a kick depends only on g(q, t). Without g a step of any length is exact. If C is antisymmetric
 * (a uniform magnetic field, a rotating frame) the drift is the flow of T, which is quadratic in p,
 * so steps are symplectic, and methods for such T (Blanes and Moan's) keep their order. If C is a
 * multiple of M (a drag), the symplectic form decreases at the exact rate.
 *
 * D and Phi are computed once for each step size, in twice the precision, since their error is the
 * same in each step. References: GNI II.5; R. I. McLachlan, G. R. W. Quispel, Acta Numerica 11
 * (2002) 341, 3. */

#include "../core/double_double.h"
#include "../core/tableau.h"

/* number of step sizes whose matrices are stored: the usual one, and that of shorter last steps */
enum { KEPT = 2 };

struct work {
    size_t n;
    /* h: the stored step sizes; last: index of the one used last; zero: n rates, which are 0
     * except while B is computed; norm: largest absolute row sum of B */
    pk_real *h, *last, *zero, *B, *norm;
    /* drifts[k]: matrices for step size h[k]: for each stage Phi, D and their low parts */
    pk_real *drifts[KEPT];
    struct pk_pairs L, E;
    pk_real *room;
};

static size_t lay_out(struct work *w, size_t n, int stages, pk_real *base)
{
    const size_t m = 2 * n, mm = m * m, one = (size_t)stages * mm;
    const struct pk_slot slots[] = {
        {&w->h, KEPT},  {&w->last, 1},        {&w->norm, 1},        {&w->zero, n},
        {&w->B, n * n}, {&w->L.hi, mm},       {&w->L.lo, mm},       {&w->E.hi, mm},
        {&w->E.lo, mm}, {&w->drifts[0], one}, {&w->drifts[1], one}, {&w->room, pk_expm_room(m)}};
    w->n = n;
    return PK_LAY_OUT(base, slots);
}

size_t pk_linear_drag_size(const struct pk_splitting *table, size_t n)
{
    struct work w;
    return n > PK_EXPONENTIAL_MOST ? 0 : lay_out(&w, n, table->stages, NULL);
}

static struct work work_of(const struct pk_integrator *it, const struct pk_splitting *table)
{
    struct work w;
    lay_out(&w, it->n, table->stages, it->own->work);
    return w;
}

/* Computes B from accelerations at rates so large that g vanishes in the rounding of B v. */
enum pk_status pk_drag_matrix(struct pk_integrator *it, pk_real *zero, pk_real *g, pk_real *a,
                              pk_real *B)
{
    const size_t n = it->n;
    const pk_real length = 1 / (PK_EPS * PK_EPS);
    PK_TRY(pk_eval_acceleration(it, it->t, it->q, zero, g));
    for (size_t j = 0; j < n; j++) {
        zero[j] = length;
        const enum pk_status status = pk_eval_acceleration(it, it->t, it->q, zero, a);
        zero[j] = 0;
        if (status < 0)
            return status;
        for (size_t i = 0; i < n; i++)
            B[i * n + j] = (a[i] - g[i]) / length;
    }
    return pk_all_finite(B, n * n) ? PK_DONE : PK_NOT_FINITE;
}

enum pk_status pk_linear_drag_init(struct pk_integrator *it, const struct pk_splitting *table)
{
    if (it->n > PK_EXPONENTIAL_MOST)
        return PK_REFUSED;
    const struct work w = work_of(it, table);
    const size_t n = w.n;
    pk_zero(w.h, KEPT);
    pk_zero(w.zero, n);
    *w.last = *w.norm = 0;
    PK_TRY(pk_drag_matrix(it, w.zero, w.room, w.room + n, w.B));
    for (size_t i = 0; i < n; i++) {
        pk_real row = 0;
        for (size_t j = 0; j < n; j++)
            row += pk_abs(w.B[i * n + j]);
        *w.norm = pk_max(*w.norm, row);
    }
    return PK_DONE;
}

/* Computes Phi and D of a drift of length h from exp(h L) - 1 = (0 s Phi; 0 D), L = (0 s; 0 B). s
 * is a power of two similar to the norm of B, so that s in L adds no squarings. */
static enum pk_status drift(const struct work *w, pk_real h, pk_real *to)
{
    const size_t n = w->n, m = 2 * n, nn = n * n;
    pk_real s = 1;
    for (; s < *w->norm; s *= 2)
        ;
    for (; *w->norm > 0 && s > 2 * *w->norm; s /= 2)
        ;
    pk_zero(w->L.hi, m * m);
    pk_zero(w->L.lo, m * m);
    for (size_t i = 0; i < n; i++) {
        w->L.hi[i * m + n + i] = s;
        pk_copy(w->L.hi + (n + i) * m + n, w->B + i * n, n);
    }
    PK_TRY(pk_expm(w->E, w->L, s, h, m, w->room));
    pk_pairs_settle(w->E, m * m);
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < n; j++)
            for (int low = 0; low < 2; low++) {
                const pk_real *E = low ? w->E.lo : w->E.hi;
                pk_real *out = to + (size_t)(2 * low) * nn + i * n + j;
                out[0] = E[i * m + n + j] / s;
                out[nn] = E[(n + i) * m + n + j];
            }
    return PK_DONE;
}

/* Returns Phi and D of all stages of a step of size h; computes them unless they are stored. */
static enum pk_status drifts(struct pk_integrator *it, const struct work *w,
                             const struct pk_splitting *table, pk_real h, const pk_real **found)
{
    const size_t one = 4 * w->n * w->n;
    int k = 0;
    while (k < KEPT && (w->h[k] < h || w->h[k] > h))
        k++;
    if (k == KEPT) {
        k = (int)(pk_index(*w->last, KEPT) + 1) % KEPT;
        w->h[k] = 0;
        it->count.factorisations++;
        for (int i = 0; i < table->stages; i++) {
            int same = 0; /* index of the first stage whose drift has the same length */
            while (table->drift[same] < table->drift[i] || table->drift[same] > table->drift[i])
                same++;
            pk_real *to = w->drifts[k] + (size_t)i * one;
            if (same < i)
                pk_copy(to, w->drifts[k] + (size_t)same * one, one);
            else
                PK_TRY(drift(w, table->drift[i] * h, to));
        }
        w->h[k] = h;
    }
    *w->last = (pk_real)k;
    *found = w->drifts[k];
    return PK_DONE;
}

static void kick_drift(const struct work *w, pk_real kappa, const pk_real *a, const pk_real *of,
                       const pk_real *from, pk_real *to)
{
    const size_t n = w->n, nn = n * n;
    pk_real *v = w->room, *dv = v + n;
    pk_kick_drift(n, n, kappa, a, 0, from, to);
    pk_copy(v, to + n, n);
    for (int row = 0; row < 2; row++) { /* row 0 updates q by Phi, row 1 updates v by D */
        pk_zero(dv, n);
        pk_add_product(dv, of + (size_t)(2 + row) * nn, v, n);
        pk_add_product(dv, of + (size_t)row * nn, v, n);
        for (size_t i = 0; i < n; i++)
            to[(size_t)row * n + i] = pk_sum(to[(size_t)row * n + i], dv[i],
                                             &pk_part(to, n, n, row ? PK_LOW_X : PK_LOW_Q)[i]);
    }
}

enum pk_status pk_linear_drag_step(struct pk_integrator *it, const struct pk_splitting *table)
{
    struct pk_integrator_private *const own = it->own;
    const struct work w = work_of(it, table);
    const size_t n = w.n;
    const pk_real h = own->h, *from = own->state, *a = pk_state(it, PK_A), *of;
    pk_real *to = own->next, *a1 = pk_next(it, PK_A), done = 0;
    const int s = table->stages, ends = table->kick[s] > 0 || table->kick[s] < 0;
    PK_TRY(drifts(it, &w, table, h, &of));
    for (int i = 0; i < s; i++) {
        if (i > 0 || !(own->flags & PK_HAVE_A)) {
            PK_TRY(pk_eval_acceleration(it, it->t + done * h, from, w.zero, a1));
            a = a1;
        }
        kick_drift(&w, table->kick[i] * h, a, of + (size_t)i * 4 * n * n, from, to);
        done += table->drift[i];
        from = to;
    }
    if (ends) {
        PK_TRY(pk_eval_acceleration(it, own->next_t, to, w.zero, a1));
        pk_kick(n, n, table->kick[s] * h, a1, to);
    }
    if (pk_all_finite(to, 2 * n))
        own->flags = ends ? own->flags | PK_HAVE_A : own->flags & ~PK_HAVE_A;
    return PK_DONE;
}

/* Adaptive explicit Runge-Kutta methods on y = (q, v): error by an embedded formula, PI control
 *
 *     h_new = h * clamp(safety * err^(-alpha) * err_old^beta),  alpha = 1/k - 3/4 beta
 *
 * first step by a guess of y'', dense output by the nested interpolant
 * y(s) = r0 + s (r1 + (1-s) (r2 + s (r3 + (1-s) (r4 + ...)))), made only when asked for.
 *
 * References: E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I,
 * II.4 (4.13)-(4.14), II.5, II.6, II.10; E. Hairer, G. Wanner, ... II, IV.2; K. Gustafsson,
 * ACM TOMS 17 (1991) 533.
 */
#include <string.h>

#include "internal.h"
#include "tableau.h"

/* The work: stages, an argument, the step's start, the interpolant, and two numbers. */
struct parts {
    const struct pk_tableau *table;
    size_t m;
    pk_real *k, *last, *y, *old, *dense, *err_old, *h_made;
};

static int dense_rows(const struct pk_tableau *table) { return 4 + table->rows; }

size_t pk_embedded_size(const struct pk_method *method, size_t n)
{
    const struct pk_tableau *table = (const struct pk_tableau *)method->table;
    const int rows = table->stages + 1 + table->extra + 2 + dense_rows(table);
    return (size_t)rows * 2 * n + 2;
}

static struct parts parts_of(struct pk_integrator *it)
{
    struct parts w;
    w.table = (const struct pk_tableau *)it->method->table;
    w.m = 2 * it->n;
    w.k = it->work;
    w.last = w.k + (size_t)w.table->stages * w.m;
    w.y = w.last + (size_t)(1 + w.table->extra) * w.m;
    w.old = w.y + w.m;
    w.dense = w.old + w.m;
    w.err_old = w.dense + (size_t)dense_rows(w.table) * w.m;
    w.h_made = w.err_old + 1;
    return w;
}

enum pk_status pk_embedded_init(struct pk_integrator *it)
{
    *parts_of(it).err_old = PK_C(1e-4);
    return PK_DONE;
}

/* k = (v, a) at y. */
static enum pk_status slope(struct pk_integrator *it, pk_real t, const pk_real *y, pk_real *k)
{
    memcpy(k, y + it->n, it->n * sizeof *k);
    return pk_eval_acceleration(it, t, y, y + it->n, k + it->n);
}

static pk_real tolerance(const struct pk_integrator *it, pk_real a, pk_real b)
{
    return it->options.atol + it->options.rtol * pk_max(pk_abs(a), pk_abs(b)) + PK_TINY;
}

/* HNW II.4: a step whose explicit Euler half-way error is about 1%, checked against y''. */
static pk_real first_step(struct pk_integrator *it, const struct parts *w, pk_real limit)
{
    const pk_real *y0 = it->state, span = pk_abs(limit - it->t);
    pk_real d0 = 0, d1 = 0, d2 = 0;
    if (it->options.h > 0)
        return it->options.h;
    for (size_t i = 0; i < w->m; i++) {
        const pk_real scale = tolerance(it, y0[i], y0[i]);
        d0 += (y0[i] / scale) * (y0[i] / scale);
        d1 += (w->k[i] / scale) * (w->k[i] / scale);
    }
    pk_real h = d0 > PK_C(1e-10) && d1 > PK_C(1e-10) ? PK_C(0.01) * PK_F(sqrt)(d0 / d1)
                                                     : PK_C(1e-6) * span;
    if (!(h > 0) || !pk_finite(h)) /* atol = 0 at a start from rest: y'/scale is infinite */
        h = PK_C(1e-6) * span;
    h = pk_min(h, span);
    for (size_t i = 0; i < w->m; i++)
        w->y[i] = y0[i] + (pk_real)it->direction * h * w->k[i];
    if (slope(it, it->t + (pk_real)it->direction * h, w->y, w->last) < 0)
        return h;
    for (size_t i = 0; i < w->m; i++) {
        const pk_real x = (w->last[i] - w->k[i]) / tolerance(it, y0[i], y0[i]);
        d2 += x * x;
    }
    const pk_real most = pk_max(PK_F(sqrt)(d1), PK_F(sqrt)(d2) / h);
    if (!pk_finite(most))
        return h;
    const pk_real h1 = most > PK_C(1e-15) * PK_F(sqrt)((pk_real)w->m)
                           ? PK_F(pow)(PK_C(0.01) * PK_F(sqrt)((pk_real)w->m) / most,
                                       PK_C(1.0) / (pk_real)w->table->error_order)
                           : pk_max(PK_C(1e-6) * span, h * PK_C(1e-3));
    return pk_min(pk_min(PK_C(100.0) * h, h1), span);
}

/* The error of the step in units of the tolerance, root mean square. */
static pk_real error_norm(struct pk_integrator *it, const struct parts *w, pk_real h)
{
    const struct pk_tableau *table = w->table;
    const pk_real *y0 = it->state, *y1 = it->next;
    const int count = table->stages + (table->e3 ? 0 : 1);
    pk_real e = 0, e3 = 0;
    for (size_t i = 0; i < w->m; i++) {
        const pk_real scale = tolerance(it, y0[i], y1[i]);
        pk_real x = 0, x3 = 0;
        for (int j = 0; j < count; j++) {
            const pk_real k = w->k[(size_t)j * w->m + i];
            x += table->e[j] * k;
            if (table->e3)
                x3 += table->e3[j] * k;
        }
        e += (x / scale) * (x / scale);
        e3 += (x3 / scale) * (x3 / scale);
    }
    if (!table->e3)
        return pk_abs(h) * PK_F(sqrt)(e / (pk_real)w->m);
    const pk_real blend = e + PK_C(0.01) * e3;
    return blend > 0 || !pk_finite(blend)
               ? pk_abs(h) * e / PK_F(sqrt)(blend * (pk_real)w->m)
               : 0;
}

/* One trial of size h to it->next_t: the new state, its derivative, its error. */
static enum pk_status attempt(struct pk_integrator *it, const struct parts *w, pk_real h)
{
    const struct pk_tableau *table = w->table;
    const pk_real *a = table->a;
    enum pk_status status;
    for (int i = 1; i < table->stages; i++) {
        pk_erk_combine(w->y, it->state, h, a, i, w->k, w->m);
        a += i;
        status = slope(it, it->t + table->c[i] * h, w->y, w->k + (size_t)i * w->m);
        if (status < 0)
            return status;
    }
    memset(it->next, 0, PK_PARTS * it->n * sizeof *w->y);
    pk_erk_combine(it->next, it->state, h, table->b, table->stages, w->k, w->m);
    if (!pk_all_finite(it->next, w->m))
        return PK_NOT_FINITE;
    if (!table->e3) {
        status = slope(it, it->next_t, it->next, w->last);
        if (status < 0)
            return status;
    }
    it->error = error_norm(it, w, h);
    if (!pk_finite(it->error)) /* the state is finite: its tolerance is all but zero */
        it->error = PK_C(1e30);
    if (table->e3 && it->error <= PK_C(1.0)) {
        status = slope(it, it->next_t, it->next, w->last);
        if (status < 0)
            return status;
        if (!pk_all_finite(w->last, w->m))
            return PK_NOT_FINITE;
    }
    return PK_DONE;
}

/* Takes over the derivative at the last step's end, or evaluates it. */
static enum pk_status begin(struct pk_integrator *it, const struct parts *w, pk_real limit)
{
    if (it->flags & PK_HAVE_STEP)
        memcpy(w->k, w->last, w->m * sizeof *w->k);
    else if (!(it->flags & PK_HAVE_A)) {
        const enum pk_status status = slope(it, it->t, it->state, w->k);
        if (status < 0)
            return status;
        if (!pk_all_finite(w->k, w->m))
            return PK_NOT_FINITE;
    }
    it->flags = PK_HAVE_A; /* and the last step's stages are gone, its dense output too */
    if (!(it->h > 0) && !(it->h < 0)) {
        it->h = (pk_real)it->direction * first_step(it, w, limit);
        *w->err_old = PK_C(1e-4);
    }
    return PK_DONE;
}

enum pk_status pk_embedded_step(struct pk_integrator *it, pk_real limit)
{
    const struct parts w = parts_of(it);
    const struct pk_tableau *table = w.table;
    const pk_real sign = (pk_real)it->direction, left = pk_abs(limit - it->t);
    const pk_real least =
        pk_max(it->options.h_min, PK_C(10.0) * PK_EPS * pk_abs(it->t) + PK_TINY);
    const pk_real alpha =
        PK_C(1.0) / (pk_real)table->error_order - PK_C(0.75) * table->beta;
    const pk_real safety = PK_C(0.9);
    enum pk_status status = begin(it, &w, limit);
    if (status < 0)
        return status;

    pk_real planned = pk_abs(it->h);
    int rejected = 0;
    for (;;) {
        if (it->options.h_max > 0)
            planned = pk_min(planned, it->options.h_max);
        if (!(planned > least) && (left > least || rejected))
            return pk_underflow(it, planned); /* also a step that shrank while being accepted */
        /* What is left below round-off is one step: a smaller one would not move t. */
        const int lands = planned * PK_C(1.01) >= left || !(left > least);
        const pk_real h = lands ? left : planned;
        it->next_t = lands ? limit : it->t + sign * h;
        status = attempt(it, &w, sign * h);
        if (status < 0) {
            it->trouble = status;
            it->trouble_t = it->next_t;
            planned = h * PK_C(0.2);
        } else {
            const pk_real raw = PK_F(pow)(it->error, alpha) / safety;
            if (it->error <= PK_C(1.0)) {
                const pk_real fac = raw / PK_F(pow)(*w.err_old, table->beta);
                const int at_most = fac <= PK_C(1.0) / table->grow;
                pk_real next = h / pk_min(PK_C(1.0) / table->shrink,
                                          pk_max(PK_C(1.0) / table->grow, fac));
                if (rejected)
                    next = pk_min(next, h);
                else if (lands && at_most)
                    next = pk_max(next, planned); /* a step cut short says nothing of the next */
                *w.err_old = pk_max(it->error, PK_C(1e-4));
                *w.h_made = sign * h;
                /* After a step below round-off, the next is guessed like a first one. */
                it->h = planned > least || left > least ? sign * next : 0;
                break;
            }
            planned = h / pk_min(PK_C(1.0) / table->shrink, raw);
        }
        rejected = 1;
        it->count.rejections++;
        if (!(planned < h)) /* whatever happens, a rejected step shrinks */
            planned = h * PK_C(0.5);
        it->h = sign * planned;
    }
    memcpy(w.old, it->state, w.m * sizeof *w.old);
    it->flags = PK_HAVE_STEP;
    return PK_DONE;
}

static enum pk_status prepare_dense(struct pk_integrator *it, const struct parts *w)
{
    const struct pk_tableau *table = w->table;
    const pk_real h = *w->h_made, *a = table->extra_a;
    const int all = table->stages + 1 + table->extra;
    pk_real *r = w->dense;
    for (int i = 0; i < table->extra; i++) {
        pk_real *k = w->last + (size_t)(i + 1) * w->m;
        pk_erk_combine(w->y, w->old, h, a, table->stages + 1 + i, w->k, w->m);
        a += table->stages + 1 + i;
        const enum pk_status status =
            slope(it, it->last_t + table->c[table->stages + i] * h, w->y, k);
        if (status < 0)
            return status;
    }
    for (size_t i = 0; i < w->m; i++) {
        const pk_real rise = it->state[i] - w->old[i], bend = h * w->k[i] - rise;
        r[i] = w->old[i];
        r[w->m + i] = rise;
        r[2 * w->m + i] = bend;
        r[3 * w->m + i] = rise - h * w->last[i] - bend;
    }
    memset(w->y, 0, w->m * sizeof *w->y);
    for (int j = 0; j < table->rows; j++)
        pk_erk_combine(r + (size_t)(4 + j) * w->m, w->y, h, table->d + j * all, all, w->k, w->m);
    it->flags |= PK_HAVE_DENSE;
    return PK_DONE;
}

enum pk_status pk_embedded_dense(struct pk_integrator *it, pk_real t, pk_real *q, pk_real *v)
{
    const struct parts w = parts_of(it);
    if (!(it->flags & PK_HAVE_DENSE)) {
        const enum pk_status status = prepare_dense(it, &w);
        if (status < 0)
            return status;
    }
    const pk_real s = (t - it->last_t) / *w.h_made;
    for (size_t i = 0; i < w.m; i++) {
        pk_real y = 0;
        for (int j = dense_rows(w.table) - 1; j >= 0; j--)
            y = w.dense[(size_t)j * w.m + i] + (j % 2 ? PK_C(1.0) - s : s) * y;
        (i < it->n ? q : v)[i < it->n ? i : i - it->n] = y;
    }
    return pk_all_finite(q, it->n) && pk_all_finite(v, it->n) ? PK_DONE : PK_NOT_FINITE;
}

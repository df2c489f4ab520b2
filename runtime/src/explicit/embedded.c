/* Parts of adaptive explicit Runge-Kutta methods that run rarely: the first step size, from an
 * estimate of y'', and dense output, by the nested interpolant
 *
 *     y(s) = r0 + s (r1 + (1-s) (r2 + s (r3 + (1-s) (r4 + ...)))),
 *
 * computed only on request. The step itself is in pk/step/embedded.h.
 *
 * Reference: E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, II.4
 * and II.6. */
#include "../core/generic.h"
#include "../core/tableau.h"

#include <pk/families.h>
#include <pk/step/embedded.h>

static const struct pk_tableau *table_of(const struct pk_method *method)
{
    return (const struct pk_tableau *)method->table;
}

static struct pk_embedded_work parts_of(struct pk_integrator *it)
{
    return pk_embedded_parts(it, table_of(it->method), it->n_q, it->n);
}

size_t pk_embedded_size(const struct pk_method *method, const struct pk_problem *problem, size_t n)
{
    const struct pk_tableau *table = table_of(method);
    const int rows = table->stages + 1 + table->extra + 1 + pk_embedded_dense_rows(table);
    return (size_t)rows * (pk_coordinates_of(problem) + n) + 2;
}

enum pk_status pk_embedded_init(struct pk_integrator *it)
{
    *parts_of(it).err_old = PK_C(1e-4);
    return PK_DONE;
}

/* Returns the first step size as in HNW II.4, from y, y' and y'' estimated by an Euler step. */
static pk_real first_step(struct pk_integrator *it, const struct pk_embedded_work *w, pk_real limit)
{
    const pk_real *y0 = it->own->state, span = pk_abs(limit - it->t);
    const pk_real rms = PK_F(sqrt)((pk_real)w->m);
    const pk_real h = pk_first_step(it, w->k + w->n_q, PK_C(0.01), limit);
    pk_real d1 = 0, d2 = 0;
    if (it->options.h > 0)
        return h;
    for (size_t i = 0; i < w->m; i++)
        w->y[i] = y0[i] + pk_direction(it) * h * w->k[i];
    if (generic_slope(it, it->t + pk_direction(it) * h, w->y, w->last) < 0)
        return h;
    for (size_t i = 0; i < w->m; i++) {
        const pk_real scale = pk_scale_known(pk_tolerance(it, i, y0[i], y0[i]));
        const pk_real x = (w->last[i] - w->k[i]) / scale;
        d1 += w->k[i] / scale * (w->k[i] / scale);
        d2 += x * x;
    }
    const pk_real most = pk_max(PK_F(sqrt)(d1), PK_F(sqrt)(d2) / h);
    if (!pk_finite(most))
        return h;
    const pk_real order = (pk_real)table_of(it->method)->error_order;
    const pk_real h1 = most > PK_C(1e-15) * rms
                           ? PK_SAME(PK_F(pow)(PK_C(0.01) * rms / most, 1 / order))
                           : pk_max(PK_C(1e-6) * span, h * PK_C(1e-3));
    return pk_min(pk_min(100 * h, h1), span);
}

enum pk_status pk_embedded_begin(struct pk_integrator *it, pk_real limit)
{
    const struct pk_embedded_work w = parts_of(it);
    if (!(it->own->flags & (PK_HAVE_STEP | PK_HAVE_A))) {
        PK_TRY(generic_slope(it, it->t, it->own->state, w.k));
        if (!pk_all_finite(w.k, w.m))
            return PK_NOT_FINITE;
    }
    if (!(pk_abs(it->own->h) > 0)) {
        it->own->h = pk_direction(it) * first_step(it, &w, limit);
        *w.err_old = PK_C(1e-4);
    }
    return PK_DONE;
}

enum pk_status pk_embedded_step(struct pk_integrator *it, pk_real limit)
{
    return generic_embedded(it, table_of(it->method), limit);
}

const struct pk_tableau *pk_explicit_table(const struct pk_method *method)
{
    return method->step == pk_embedded_step ? table_of(method) : pk_erk_table(method);
}

const pk_real *pk_embedded_acceleration(struct pk_integrator *it, int end)
{
    if (it->method->step != pk_embedded_step || !(it->own->flags & PK_HAVE_STEP))
        return NULL;
    const struct pk_embedded_work w = parts_of(it);
    return (end ? w.last : w.k) + w.n_q;
}

static enum pk_status prepare_dense(struct pk_integrator *it, const struct pk_embedded_work *w)
{
    const struct pk_tableau *table = table_of(it->method);
    const pk_real h = *w->h_made, *a = table->extra_a, *old = it->own->next;
    const int all = table->stages + 1 + table->extra;
    pk_real *r = w->dense;
    for (int i = 0; i < table->extra; i++) {
        pk_real *k = w->last + (size_t)(i + 1) * w->m;
        pk_erk_combine(w->y, old, h, a, table->stages + 1 + i, w->k, w->m);
        a += table->stages + 1 + i;
        PK_TRY(generic_slope(it, it->last_t + table->c[table->stages + i] * h, w->y, k));
    }
    for (size_t i = 0; i < w->m; i++) {
        const pk_real rise = it->own->state[i] - old[i], bend = h * w->k[i] - rise;
        r[i] = old[i];
        r[w->m + i] = rise;
        r[2 * w->m + i] = bend;
        r[3 * w->m + i] = rise - h * w->last[i] - bend;
        for (int j = 0; j < table->rows; j++)
            r[(size_t)(4 + j) * w->m + i] = h * pk_row_sum(table->d + j * all, all, w->k, w->m, i);
    }
    it->own->flags |= PK_HAVE_DENSE;
    return PK_DONE;
}

enum pk_status pk_embedded_dense(struct pk_integrator *it, pk_real t, pk_real *q, pk_real *v)
{
    const struct pk_embedded_work w = parts_of(it);
    if (!(it->own->flags & PK_HAVE_DENSE))
        PK_TRY(prepare_dense(it, &w));
    const pk_real s = (t - it->last_t) / *w.h_made;
    for (size_t i = 0; i < w.m; i++) {
        pk_real y = 0;
        for (int j = pk_embedded_dense_rows(table_of(it->method)) - 1; j >= 0; j--)
            y = w.dense[(size_t)j * w.m + i] + (j % 2 ? 1 - s : s) * y;
        (i < w.n_q ? q : v)[i < w.n_q ? i : i - w.n_q] = y;
    }
    return PK_DONE;
}

PK_METHODS_EMBEDDED(PK_DEFINE_METHOD, PK_FAMILY_EMBEDDED)

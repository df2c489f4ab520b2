/* Adaptive explicit Runge-Kutta methods on y = (q, v): error by an embedded formula, PI control
 *
 *     h_new = h * clamp(safety * err^(-alpha) * err_old^beta),  alpha = 1/k - 3/4 beta
 *
 * alpha and beta depend on the table; k is the order of the error estimate. This file has the code
 * that each step runs, with the macros of pk/inlined.h; first step size and dense output are in the
 * library.
 *
 * References: E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, II.4
 * (4.13)-(4.14), II.5, II.10; E. Hairer, G. Wanner, ... II, IV.2; K. Gustafsson, ACM TOMS 17 (1991)
 * 533. */
#ifndef PK_STEP_EMBEDDED_H
#define PK_STEP_EMBEDDED_H

#include <pk/step/tables.h>

/* The work memory. k: derivatives of the stages; last: the derivative at the end of the step, then
 * those of the extra stages; y: the state of a stage; dense: the interpolant; err_old: error of the
 * last step; h_made: its size. After the step, it->own->next holds the start of the step. */
struct pk_embedded_work {
    size_t m, n_q; /* length of y = (q, v), length of q */
    pk_real *k, *last, *y, *dense, *err_old, *h_made;
};

static inline int pk_embedded_dense_rows(const struct pk_tableau *table) { return 4 + table->rows; }

static PK_INLINE struct pk_embedded_work
pk_embedded_parts(struct pk_integrator *it, const struct pk_tableau *table, size_t n_q, size_t n)
{
    struct pk_embedded_work w;
    w.m = n_q + n;
    w.n_q = n_q;
    w.k = it->own->work;
    w.last = w.k + (size_t)table->stages * w.m;
    w.y = w.last + (size_t)(1 + table->extra) * w.m;
    w.dense = w.y + w.m;
    w.err_old = w.dense + (size_t)pk_embedded_dense_rows(table) * w.m;
    w.h_made = w.err_old + 1;
    return w;
}

PK_BEGIN
/* Computes the derivative at the start of the step if the last step did not, and guesses the first
 * step size, at the start of a run or after a failure. */
enum pk_status pk_embedded_begin(struct pk_integrator *it, pk_real limit);
PK_END

/* Returns the root mean square over (q, v) of the estimated error relative to the tolerance. */
static PK_INLINE pk_real pk_embedded_error(struct pk_integrator *it, const struct pk_tableau *table,
                                           const struct pk_embedded_work *w, pk_real h)
{
    const pk_real *y0 = it->own->state, *y1 = it->own->next;
    const int count = table->stages + (table->e3 ? 0 : 1);
    pk_real e = 0, e3 = 0;
    for (size_t i = 0; i < w->m; i++) {
        const pk_real scale = pk_tolerance(it, i, y0[i], y1[i]);
        const pk_real x = pk_row_sum(table->e, count, w->k, w->m, i) / scale;
        e += x * x;
        if (table->e3) {
            const pk_real x3 = pk_row_sum(table->e3, count, w->k, w->m, i) / scale;
            e3 += x3 * x3;
        }
    }
    if (!table->e3)
        return pk_abs(h) * PK_F(sqrt)(e / (pk_real)w->m);
    const pk_real blend = e + PK_C(0.01) * e3;
    return blend > 0 || !pk_finite(blend) ? pk_abs(h) * e / PK_F(sqrt)(blend * (pk_real)w->m) : 0;
}
#endif

/* Makes a trial step of size h to it->own->next_t: the new state, its derivative, its error. */
static PK_INLINE enum pk_status PK_STEPPER(attempt)(struct pk_integrator *it,
                                                    const struct pk_tableau *table,
                                                    const struct pk_embedded_work *w, pk_real h)
{
    pk_real *y = it->own->next;
#define PK_EMBEDDED_STAGE(i)                                                                  \
    if ((i) < table->stages) {                                                                \
        pk_erk_combine(y, it->own->state, h, table->a + (i) * ((i) - 1) / 2, i, w->k, w->m);  \
        PK_TRY(PK_STEPPER(slope)(it, it->t + table->c[i] * h, y, w->k + (size_t)(i) * w->m)); \
    }
    PK_EACH_STAGE(PK_EMBEDDED_STAGE)
#undef PK_EMBEDDED_STAGE
    pk_erk_combine(y, it->own->state, h, table->b, table->stages, w->k, w->m);
    if (!pk_all_finite(y, w->m))
        return PK_NOT_FINITE;
    if (!table->e3)
        PK_TRY(PK_STEPPER(slope)(it, it->own->next_t, y, w->last));
    it->own->error = pk_embedded_error(it, table, w, h);
    if (!pk_finite(it->own->error)) /* the error is infinite if a tolerance is nearly zero */
        it->own->error = PK_C(1e30);
    if (table->e3 && it->own->error <= 1) {
        PK_TRY(PK_STEPPER(slope)(it, it->own->next_t, y, w->last));
        if (!pk_all_finite(w->last, w->m))
            return PK_NOT_FINITE;
    }
    return PK_DONE;
}

/* Does the same as attempt() for a trial step that was computed in a lane. */
static PK_INLINE enum pk_status PK_STEPPER(taken)(struct pk_integrator *it,
                                                  const struct pk_tableau *table,
                                                  const struct pk_embedded_work *w, pk_real h)
{
    pk_ahead_take(it, PK_Q, 2);
    pk_ahead_slopes(it, w->k, table->stages + 1);
    it->own->error = pk_embedded_error(it, table, w, h);
    if (!pk_finite(it->own->error))
        it->own->error = PK_C(1e30);
    it->count.evaluations += (unsigned long)table->stages;
    it->count.evaluations -= table->e3 && it->own->error > 1;
    return PK_DONE;
}

static PK_INLINE enum pk_status PK_STEPPER(embedded)(struct pk_integrator *it,
                                                     const struct pk_tableau *table, pk_real limit)
{
    const struct pk_embedded_work w =
        pk_embedded_parts(it, table, PK_STEPPER_COORDINATES(it), PK_STEPPER_N(it));
    const pk_real alpha = 1 / (pk_real)table->error_order - PK_C(0.75) * table->beta;
    const pk_real safety = PK_C(0.9);
    if (it->own->flags & PK_HAVE_STEP)
        for (size_t i = 0; i < w.m; i++) /* copies the derivative at the end of the last step */
            w.k[i] = w.last[i];
    if (!(it->own->flags & (PK_HAVE_STEP | PK_HAVE_A)) || !(pk_abs(it->own->h) > 0))
        PK_TRY(pk_embedded_begin(it, limit));
    it->own->flags = PK_HAVE_A; /* the last step's dense output becomes invalid */

    struct pk_trial x = pk_trial(it, limit);
    if (it->own->ahead)
        it->own->ahead->waits = 0;
    for (;;) {
        if (!pk_trial_next(it, limit, &x))
            return pk_underflow(it, x.planned);
        const pk_real h = pk_abs(x.h);
        pk_real planned = h * PK_C(0.2);
        const int ahead = pk_is_ahead(it, x.h);
        const enum pk_status status = ahead ? PK_STEPPER(taken)(it, table, &w, x.h)
                                            : PK_STEPPER(attempt)(it, table, &w, x.h);
        if (status < 0) {
            pk_trouble(it, status, it->own->next_t);
        } else {
            const pk_real raw = PK_SAME(PK_F(pow)(it->own->error, alpha)) / safety;
            if (it->own->error <= 1) {
                const pk_real fac = raw / PK_SAME(PK_F(pow)(*w.err_old, table->beta));
                const pk_real next = h / pk_min(1 / table->shrink, pk_max(1 / table->grow, fac));
                *w.err_old = pk_max(it->own->error, PK_C(1e-4));
                *w.h_made = x.h;
                pk_trial_accept(it, &x, x.rejected ? pk_min(next, h) : next,
                                fac <= 1 / table->grow);
                it->own->flags = PK_HAVE_STEP;
                return PK_DONE;
            }
            planned = h / pk_min(1 / table->shrink, raw);
        }
        /* A rejected step is always shortened. */
        pk_trial_reject(it, &x, planned < h ? planned : h * PK_C(0.5));
        if (ahead && pk_waits_for(it, &x))
            return PK_DONE;
    }
}

/* Samples the event functions over a step at the 9 or 17 Chebyshev-Lobatto points of a window,
 * first of the whole step: on an interpolant, which costs no step, or, if that is too inaccurate,
 * at states from shorter steps. The last coefficients of the polynomials through the samples show
 * whether they resolve the functions; if one does not, the window is halved. See events.c.
 *
 * Reference: L. N. Trefethen, Approximation Theory and Approximation Practice, SIAM 2013, chapters
 * 3 and 8. */

#include "../core/tableau.h"
#include "events.h"

enum { SAMPLES = PK_MOST_SAMPLES, FEW = 8, TAIL = 4 };
/* limit of the number of windows; lower limit if g is not finite */
enum { MOST_PARTS = 1 << 12, MOST_BEYOND = 1 << 6 };
enum { NOISE = 8 }; /* g is noise after so many narrowest windows that do not resolve it */

/* Evaluates the quintic Hermite interpolant through q, v and accelerations at the ends, and its
 * derivative; for first-order variables the quartic through values and rates at the ends and the
 * rate at a quarter of the step. */
static PK_INLINE void hermite(const struct pk_events *e, const struct pk_integrator *it, pk_real x)
{
    const struct pk_knot from = {e->q0, e->v0, e->a0}, to = {it->q, it->v, e->a1};
    const size_t n_q = e->n_q, n = e->n;
    const pk_real h = it->t - e->from, y = 1 - x;
    const pk_real *bend0 = e->bend, *bend1 = bend0 + n_q;
    pk_real *q = e->trial, *v = e->trial_v;
    pk_hermite(it, h, from, to, x, q, v);
    for (size_t i = 0; i < n_q; i++) {
        const pk_real bend = (bend0[i] * y + bend1[i] * x) / 2;
        q[i] += x * x * y * y * bend;
        v[i] += (2 * x * y * (y - x) * bend + x * x * y * y * (bend1[i] - bend0[i]) / 2) / h;
    }
    for (size_t i = n_q; i < n; i++)
        v[i] += x * x * y * y * bend1[i];
}

/* Sets the quartic terms of first-order variables from their rates at a quarter of the step.
 * Returns whether a cubic without these terms may be off half-way by 1/32 of the change. */
static int states_bend(struct pk_events *e, struct pk_integrator *it)
{
    const pk_real h = it->t - e->from, x = PK_C(0.25), y = 1 - x;
    pk_real *bend = e->bend + e->n_q;
    int worthless = 0;
    if (e->n == e->n_q)
        return 0;
    hermite(e, it, x);
    if (pk_eval_acceleration(&e->scout, e->from + x * h, e->trial, e->trial_v, e->a_between) < 0)
        return 0;
    for (size_t i = e->n_q; i < e->n; i++) {
        const pk_real rise = it->v[i] - e->v0[i], w0 = h * e->a0[i], w1 = h * e->a1[i];
        const pk_real slope = 6 * x * y * rise + y * (1 - 3 * x) * w0 + x * (3 * x - 2) * w1;
        const pk_real size = pk_max(pk_abs(rise), pk_max(pk_abs(w0), pk_abs(w1)) / 4);
        bend[i] = (h * e->a_between[i] - slope) / (2 * x * y * (y - x));
        worthless |= pk_abs(bend[i]) > size / 2 + 8 * PK_EPS * pk_abs(it->v[i]);
    }
    return worthless;
}

/* Sets e->bend, the differences of h^2 q'' between the motion and its cubic Hermite interpolant at
 * both ends of the step. Returns whether this cubic may be off half-way by 1/32 of the change. */
static int is_worthless(struct pk_events *e, struct pk_integrator *it)
{
    const pk_real h = it->t - e->from;
    int worthless = 0;
    pk_zero(e->bend, e->n_q + e->n);
    for (int end = 0; end < 2; end++) {
        const pk_real *q = end ? it->q : e->q0, *v = end ? it->v : e->v0;
        const pk_real *known = pk_embedded_acceleration(it, end);
        pk_real *bends = e->bend + (end ? e->n_q : 0), *a = end ? e->a1 : e->a0;
        if (known) {
            pk_copy(a, known, e->n);
        } else if (pk_eval_acceleration(&e->scout, end ? it->t : e->from, q, v, a) < 0) {
            pk_zero(e->bend, e->n_q + e->n);
            for (size_t i = e->n_q; i < e->n; i++) /* interpolates first-order variables linearly */
                e->a0[i] = e->a1[i] = (it->v[i] - e->v0[i]) / h;
            return 0;
        }
        for (size_t i = 0; i < e->n_q; i++) {
            const pk_real rise = it->q[i] - e->q0[i], v0 = h * e->v0[i], v1 = h * it->v[i];
            const pk_real bend = end ? 2 * v0 + 4 * v1 - 6 * rise : 6 * rise - 4 * v0 - 2 * v1;
            const pk_real size = pk_max(pk_abs(rise), pk_max(pk_abs(v0), pk_abs(v1)) / 4);
            bends[i] = h * h * a[i] - bend;
            worthless |= pk_abs(bends[i]) > size + PK_EPS * pk_abs(q[i]);
        }
    }
    return worthless | states_bend(e, it);
}

/* Computes the state at a sample by the method itself. Returns 0 if that step fails. */
static int reach_sample(struct pk_events *e, struct pk_integrator *it, pk_real t)
{
    const struct pk_reason reason = it->reason;
    if (pk_events_reach(e, it, t) >= 0)
        return 1;
    it->reason = reason;
    it->status = PK_DONE;
    return 0;
}

/* Evaluates all g at sample j; at the ends of the step it copies the exact values. */
static enum pk_status sample(struct pk_events *e, struct pk_integrator *it, int j)
{
    const pk_real h = it->t - e->from, length = pk_abs(h), x = pk_events_node(e, j);
    const pk_real t = pk_events_time(e, it, x);
    if (!(x > 0) || !(x < length)) {
        pk_copy(pk_events_sample(e, j), pk_events_end(e, x > 0), pk_events_count(e));
        return PK_DONE;
    }
    if (e->proposes && !e->by_ends) {
        PK_TRY(pk_integrator_dense(it, t, e->trial, e->trial_v));
    } else if (!(e->by_steps && reach_sample(e, it, t))) {
        hermite(e, it, x / length);
    }
    pk_events_functions(e, it, t, e->trial, e->trial_v, pk_events_sample(e, j));
    return PK_DONE;
}

/* Fits the polynomial through every `stride`th sample of function k and sets its flags. */
static void fit(struct pk_events *e, size_t k, int stride, int narrow)
{
    const int N = SAMPLES / stride;
    struct pk_shape *shape = &e->shapes[k];
    pk_real least = pk_events_sample(e, 0)[k], most = least, others = 0, tail = 0, back = 0;
    int finite = 1;
    for (int j = 0; j <= SAMPLES; j += stride) {
        const pk_real g = pk_events_sample(e, j)[k];
        least = pk_min(least, g);
        most = pk_max(most, g);
        finite &= pk_finite(g);
    }
    const int far = pk_max(least, -most) > 4 * (most - least); /* all samples are far from zero */
    shape->order = N;
    shape->range = most - least;
    shape->clear = far;
    shape->lost = 0;
    shape->crosses = !far;
    shape->others = 0;
    shape->c[0] = far ? 1 : 0; /* if far, the only term, so that no root is sought */
    if (far || !finite || !pk_finite(shape->range))
        return;
    for (int i = 0; i <= N; i++) {
        pk_real sum = 0;
        for (int j = 0; j <= N; j++) {
            const int at = i * j * stride % (2 * SAMPLES);
            const pk_real g = pk_events_sample(e, j * stride)[k];
            const pk_real c = pk_events_cosines[at <= SAMPLES ? at : 2 * SAMPLES - at];
            sum += (j == 0 || j == N ? g / 2 : g) * c;
        }
        shape->c[i] = 2 * sum / (pk_real)N / (i == 0 || i == N ? 2 : 1);
        others += i ? pk_abs(shape->c[i]) : 0;
        tail += i > N - TAIL ? pk_abs(shape->c[i]) : 0;
    }
    shape->crosses = !(pk_abs(shape->c[0]) > others + tail) && shape->range > 0;
    shape->clear = !shape->crosses || tail <= shape->range / 40;
    shape->tail = tail;
    shape->others = others + tail;
    shape->lost = shape->crosses && tail > shape->range / 16;
    /* A function unresolved even in the narrowest window, with monotone samples, jumps. */
    for (int j = 0; j < SAMPLES; j += stride) {
        const pk_real step = pk_events_sample(e, j + stride)[k] - pk_events_sample(e, j)[k];
        back += pk_abs(step);
    }
    if (narrow && !shape->clear && back < shape->range * PK_C(1.1))
        shape->jumps = 1;
}

/* Returns whether every event function, on the quintic interpolant, is farther from zero than it
 * varies. This test costs nothing in an adaptive Runge-Kutta method; if it succeeds, dense output,
 * which has more stages, is not needed. */
static int is_far(struct pk_events *e, struct pk_integrator *it)
{
    int far = 1;
    if (!pk_embedded_acceleration(it, 1) || is_worthless(e, it))
        return 0;
    e->at = 0;
    e->width = pk_abs(it->t - e->from);
    e->by_ends = 1;
    for (int j = 0; j <= SAMPLES && far; j += SAMPLES / FEW)
        far = sample(e, it, j) >= 0;
    e->by_ends = 0;
    for (size_t k = 0; k < pk_events_count(e) && far; k++) {
        const struct pk_shape *shape = &e->shapes[k];
        fit(e, k, SAMPLES / FEW, 0);
        far = !shape->crosses && pk_abs(shape->c[0]) > PK_CLEAR_OF * shape->others;
    }
    return far;
}

/* Returns whether all functions are resolved in the window. */
static int look(struct pk_events *e, struct pk_integrator *it, unsigned long parts)
{
    int clear = 0;
    for (int stride = SAMPLES / FEW; !clear && stride >= 1; stride /= 2) {
        const int first = stride == SAMPLES / FEW;
        for (int j = first ? 0 : stride; j <= SAMPLES; j += first ? stride : 2 * stride)
            if (sample(e, it, j) < 0)
                return 0;
        clear = 1;
        for (size_t k = 0; k < pk_events_count(e); k++) {
            e->shapes[k].jumps = 0;
            fit(e, k, stride, parts >= MOST_PARTS);
            if (e->shapes[k].clear && e->shapes[k].in_a_row < NOISE)
                e->shapes[k].in_a_row = 0;
            clear &= e->shapes[k].clear || e->shapes[k].in_a_row >= NOISE ||
                     (!pk_finite(e->shapes[k].range) && parts >= MOST_BEYOND);
        }
    }
    return clear;
}

static void doubt(struct pk_events *e, const struct pk_integrator *it)
{
    for (size_t k = 0; k < pk_events_count(e); k++) {
        struct pk_shape *shape = &e->shapes[k];
        if (!shape->lost || shape->jumps || !pk_finite(shape->range))
            continue;
        shape->in_a_row++;
        e->which = k;
        e->t = pk_events_time(e, it, e->at);
        e->doubts++;
        if (e->doubtful)
            e->doubtful(e->context, e);
    }
}

/* Returns the switch that seems to cross first in the window; later ones are not sought. */
static size_t foremost(const struct pk_events *e)
{
    size_t first = pk_events_count(e);
    pk_real least = PK_INFINITY;
    for (size_t k = e->n_events; k < pk_events_count(e); k++) {
        const int stride = SAMPLES / (e->shapes[k].order ? e->shapes[k].order : 1);
        for (int j = 0; e->shapes[k].crosses && j < SAMPLES; j += stride) {
            const pk_real l = pk_events_sample(e, j)[k], r = pk_events_sample(e, j + stride)[k];
            const pk_real from = pk_events_node(e, j), to = pk_events_node(e, j + stride);
            if (!(from < least))
                break;
            if (!(l < 0 && r >= 0) && !(l > 0 && r <= 0))
                continue;
            const pk_real x = from + (to - from) * (l / (l - r));
            if (x < least) {
                least = x;
                first = k;
            }
            break;
        }
    }
    return first;
}

/* Puts all crossings in the window into the list. */
static enum pk_status seek(struct pk_events *e, struct pk_integrator *it)
{
    const size_t first = foremost(e), m = pk_events_count(e);
    e->listed = 0;
    e->near = PK_INFINITY;
    e->near_known = e->last = -1;
    for (size_t k = 0; k < e->n_events; k++)
        PK_TRY(pk_events_seek(e, it, k));
    if (first < m)
        PK_TRY(pk_events_seek(e, it, first));
    for (size_t k = e->n_events; k < m; k++)
        if (k != first)
            PK_TRY(pk_events_seek(e, it, k));
    return PK_DONE;
}

/* The function of a contact is positive from the start of a motion on, whatever rounding says. If it
 * was given room (pk/act.h) and is positive at the first sample, it is looked at from there. If it
 * was found closed a little late, it is looked at from the first sample where it is positive. */
static enum pk_status begin_late(struct pk_events *e, struct pk_integrator *it)
{
    const pk_real h = pk_abs(it->t - e->from), *begin = pk_events_end(e, 0);
    pk_real *g = pk_events_sample(e, PK_MOST_SAMPLES + 1);
    for (int j = 1, most = 1; j <= most; j++) {
        const pk_real x = h * (1 - pk_events_cosines[j]) / 2, t = pk_events_time(e, it, x);
        int known = 0;
        for (size_t k = 0; k < e->n_events; k++) {
            const int late = !(begin[k] < 0) && begin[k] <= PK_TINY;
            if (!(late || (j == 1 && e->off[k] < 0)) || !(e->held[k] > 0) ||
                pk_finite(e->held[k]) || e->shapes[k].last_x > 0)
                continue;
            if (!known) {
                PK_TRY(pk_events_reach(e, it, t));
                pk_events_functions(e, it, t, e->trial, e->trial_v, g);
                known = 1;
            }
            if (j == PK_MOST_SAMPLES && h <= 64 * PK_EPS * pk_abs(it->t))
                g[k] = pk_max(g[k], PK_TINY); /* a step of rounding is too short to open it */
            if (g[k] > 0)
                e->shapes[k].last_x = x, e->shapes[k].last_g = g[k];
            else if (late)
                most = PK_MOST_SAMPLES;
        }
    }
    return PK_DONE;
}

enum pk_status pk_events_look(struct pk_events *e, struct pk_integrator *it)
{
    const pk_real h = pk_abs(it->t - e->from);
    unsigned long part = 0, parts = 1;
    if (!e->cut && is_far(e, it)) {
        e->at_switch = 0;
        pk_zero(e->held, e->n_events);
        return it->status = PK_DONE;
    }
    e->by_steps = !e->proposes && is_worthless(e, it);
    e->cut = 0;
    for (size_t k = 0; k < pk_events_count(e); k++) {
        e->shapes[k].in_a_row = 0;
        e->shapes[k].last_x = 0;
        e->shapes[k].last_g = pk_events_end(e, 0)[k];
    }
    PK_TRY(begin_late(e, it));
    while (part < parts) {
        e->at = h * (pk_real)part / (pk_real)parts;
        e->width = (part + 1 == parts ? h : h * (pk_real)(part + 1) / (pk_real)parts) - e->at;
        const int clear = look(e, it, parts);
        if (it->status < 0)
            return it->status;
        if (!clear && parts < MOST_PARTS) {
            part *= 2, parts *= 2;
            continue;
        }
        if (!clear)
            doubt(e, it);
        PK_TRY(seek(e, it));
        if (pk_events_report(e, it) != PK_DONE || e->again || e->cut)
            return it->status;
        part++;
        if (parts > 1 && part % 2 == 0)
            part /= 2, parts /= 2;
    }
    e->at_switch = 0;
    pk_zero(e->held, e->n_events);
    return it->status = PK_DONE;
}

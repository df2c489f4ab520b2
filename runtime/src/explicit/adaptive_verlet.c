/* Position Verlet at a variable, time-symmetric step size: the step size follows a density rho of
 * steps that is part of the state, not an estimate of the error.
 *
 *     q_1/2 = q + eps/(2 rho) v                    rho' = 2 w(q_1/2) - rho
 *     v'    = v + eps/2 (1/rho + 1/rho') a(q_1/2)  q'   = q_1/2 + eps/(2 rho') v'
 *
 * w is a local frequency, w^4 = ||da/dq||_F^2 + w_0^4, by the kernel `linear`: for Kepler's problem
 * 6^(1/4) r^(-3/2). So a step has about the size eps/w. eps is h ||da/dq||^(1/2) at the start if a
 * first step size h is given, else sqrt(24 rtol), with which the local frequency is accurate to
 * rtol; w_0 is eps/h_max, or 0. The same formulas with -eps lead from (q', v', rho') back to (q, v,
 * rho), so energy errors do not drift. If rho would change by a factor of 4 or more, or become
 * negative, as where da/dq passes zero without an h_max, the scheme fails with a status.
 *
 * The sequence of steps must not depend on limits and dense output. So if a limit requires a
 * shorter step, this step starts from the last point of the sequence (the base), and so does the
 * step after it, which again has the planned length.
 *
 * Reference: W. Huang, B. Leimkuhler, SIAM J. Sci. Comput. 18 (1997) 239; Hairer, Lubich, Wanner,
 * Geometric Numerical Integration, VIII.3. */
#include <string.h>

#include <pk/linear.h>

#include "../core/generic.h"
#include "../core/tableau.h"

/* Data stored from one step to the next. */
struct kept {
    pk_real eps, floor, given, direction;
    /* values at the base: density of steps, time, and low part of the time */
    pk_real rho, t, t_low;
    /* flags. planned: the length of the step from the base is known; whole: that step was made */
    int planned, whole;
    pk_real length, rho_next, end, end_low;
};

struct work {
    struct kept *kept;
    pk_real *base; /* the state at the base, from which steps start: q, v and their low parts */
    pk_real *a, *a_q, *a_v, *a_t, *linear; /* a: acceleration of the planned step */
};

static size_t lay_out(struct work *w, size_t n_q, size_t n, pk_real *base)
{
    pk_real *kept;
    /* clang-format off */
    const struct pk_slot slots[] = {
        {&kept, PK_REALS_OF(struct kept)}, {&w->base, 2 * (n_q + n)}, {&w->a, n}, {&w->a_q, n * n},
        {&w->a_v, n * n}, {&w->a_t, n}, {&w->linear, n * n + n}};
    /* clang-format on */
    const size_t size = PK_LAY_OUT(base, slots);
    w->kept = (struct kept *)(void *)kept;
    return size;
}

static struct work parts(const struct pk_integrator *it)
{
    struct work w;
    lay_out(&w, it->n_q, it->n, it->own->work);
    return w;
}

static size_t size(const struct pk_method *method, const struct pk_problem *problem, size_t n)
{
    struct work w;
    (void)method;
    return lay_out(&w, pk_coordinates_of(problem), n, NULL);
}

/* Computes the square root of ||da/dq||; leaves the acceleration in w->a. */
static enum pk_status frequency(struct pk_integrator *it, const struct work *w, const pk_real *q,
                                const pk_real *v, pk_real *omega)
{
    const enum pk_status status =
        pk_eval_linear(it, it->t, q, v, w->a, w->a_q, w->a_v, w->a_t, w->linear);
    pk_real sum = 0;
    it->count.evaluations++;
    if (status < 0)
        return status;
    for (size_t i = 0; i < it->n * it->n; i++)
        sum += w->a_q[i] * w->a_q[i];
    *omega = PK_F(sqrt)(PK_F(sqrt)(sum));
    return PK_DONE;
}

static pk_real raised(const struct work *w, pk_real omega)
{
    const pk_real a = omega * omega, b = w->kept->floor * w->kept->floor;
    return PK_F(sqrt)(PK_F(sqrt)(a * a + b * b));
}

/* Makes the current state the base. */
static void take_base(struct pk_integrator *it, const struct work *w)
{
    const size_t m = it->n_q + it->n;
    pk_copy(w->base, it->own->state, m);
    pk_copy(w->base + m, pk_state(it, PK_LOW_Q), m);
    w->kept->planned = w->kept->whole = 0;
}

/* Starts a new sequence of steps at the current state. */
static enum pk_status begin(struct pk_integrator *it, const struct work *w)
{
    const struct pk_options *o = &it->options;
    pk_real omega;
    PK_TRY(frequency(it, w, it->q, it->v, &omega));
    if (!(omega > 0) && (o->h > 0 || !(o->h_max > 0)))
        return pk_fail(it, PK_BAD_ARGUMENT, BAD_SCALE);
    const pk_real tolerance = o->rtol > 0 ? o->rtol : o->atol;
    w->kept->eps = o->h > 0 ? o->h * omega : PK_F(sqrt)(24 * tolerance);
    w->kept->floor = o->h_max > 0 ? w->kept->eps / o->h_max : 0;
    w->kept->rho = raised(w, omega);
    w->kept->t = it->t;
    w->kept->t_low = 0;
    w->kept->given = o->h;
    take_base(it, w);
    return PK_DONE;
}

static enum pk_status init(struct pk_integrator *it)
{
    const struct work w = parts(it);
    memset(w.kept, 0, sizeof *w.kept);
    return begin(it, &w);
}

/* A step from the base consists of drift() to mid-step, and kick_drift(): the kicks of both halves
 * of the step at once, then the second drift. */
static void drift(const struct pk_integrator *it, const struct work *w, pk_real first, pk_real *to)
{
    const size_t n_q = it->n_q;
    const pk_real *low = w->base + n_q + it->n;
    pk_real *low_q = pk_part(to, n_q, it->n, PK_LOW_Q);
    for (size_t i = 0; i < n_q; i++) {
        low_q[i] = low[i];
        to[i] = pk_sum(w->base[i], first * w->base[n_q + i], &low_q[i]);
    }
}

static void kick_drift(const struct pk_integrator *it, const struct work *w, pk_real both,
                       pk_real second, const pk_real *a, pk_real *to)
{
    const size_t n_q = it->n_q, n = it->n;
    const pk_real *low = w->base + 2 * n_q + n;
    pk_real *v = to + n_q, *low_q = pk_part(to, n_q, n, PK_LOW_Q);
    pk_real *low_v = pk_part(to, n_q, n, PK_LOW_X);
    for (size_t i = 0; i < n; i++) {
        low_v[i] = low[i];
        v[i] = pk_sum(w->base[n_q + i], both * a[i], &low_v[i]);
    }
    for (size_t i = 0; i < n_q; i++)
        to[i] = pk_sum(to[i], second * v[i], &low_q[i]);
}

/* Computes the next density of the sequence and the length of its next step. */
static enum pk_status plan(struct pk_integrator *it, const struct work *w)
{
    struct kept *kept = w->kept;
    pk_real omega;
    const pk_real half = kept->eps / 2;
    drift(it, w, pk_direction(it) * half / kept->rho, it->own->next);
    PK_TRY(frequency(it, w, it->own->next, w->base + it->n_q, &omega));
    const pk_real next = 2 * raised(w, omega) - kept->rho;
    if (!(next > kept->rho / 4 && next < 4 * kept->rho))
        return pk_fail(it, PK_STEP_UNDERFLOW, PK_REASON_TIME_SCALE);
    kept->rho_next = next;
    kept->length = half / kept->rho + half / next;
    kept->planned = 1;
    return PK_DONE;
}

/* Makes a step of any length from the base and writes the state to `to`. Only a step of the planned
 * length, kept->length, continues the sequence of steps. */
static enum pk_status aside(struct pk_integrator *it, const struct work *w, pk_real length,
                            pk_real *to)
{
    const struct kept *kept = w->kept;
    const pk_real first = length * (kept->eps / 2 / kept->rho) / kept->length;
    drift(it, w, first, to);
    const enum pk_status status = pk_eval_acceleration(it, it->t, to, w->base + it->n_q, w->a_t);
    kick_drift(it, w, length, length - first, w->a_t, to);
    return status;
}

static enum pk_status step(struct pk_integrator *it, pk_real limit)
{
    struct pk_integrator_private *const own = it->own;
    const struct work w = parts(it);
    struct kept *kept = w.kept;
    const pk_real sign = (pk_real)own->direction;
    /* the step of planned length was made, but the integrator rejected it */
    if (kept->whole && !(own->flags & PK_HAVE_STEP)) {
        kept->whole = kept->planned = 0;
    } else if (kept->whole) { /* the integrator accepted the step: its end becomes the base */
        take_base(it, &w);
        kept->rho = kept->rho_next;
        kept->t = kept->end;
        kept->t_low = kept->end_low;
    }
    const int there = !(it->t < kept->t || it->t > kept->t), turned = sign * kept->direction < 0;
    if ((turned && !there) || kept->given < it->options.h || kept->given > it->options.h)
        PK_TRY(begin(it, &w));
    if (turned)
        kept->planned = 0;
    kept->direction = sign;
    own->flags = 0;
    if (!kept->planned)
        PK_TRY(plan(it, &w));

    const pk_real least = pk_max(it->options.h_min, 10 * PK_EPS * pk_abs(it->t) + PK_TINY);
    const pk_real close = 4 * PK_EPS * pk_max(pk_abs(it->t), pk_abs(limit));
    pk_real low = kept->t_low;
    const pk_real end = pk_sum(kept->t, sign * kept->length, &low);
    if (!(kept->length > least))
        return pk_underflow(it, kept->length);
    if (sign * (end - limit) > close) {
        own->next_t = limit;
        PK_TRY(aside(it, &w, limit - kept->t, own->next));
    } else {
        const pk_real half = sign * kept->eps / 2;
        own->next_t = pk_abs(end - limit) <= close ? limit : end;
        drift(it, &w, half / kept->rho, own->next);
        kick_drift(it, &w, sign * kept->length, half / kept->rho_next, w.a, own->next);
        if (!pk_all_finite(own->next, it->n_q + it->n))
            return PK_NOT_FINITE;
        kept->end = own->next_t;
        kept->end_low = own->next_t < end || own->next_t > end ? 0 : low;
        kept->whole = 1;
    }
    own->h = sign * kept->length;
    own->flags = PK_HAVE_STEP;
    return PK_DONE;
}

static enum pk_status dense(struct pk_integrator *it, pk_real t, pk_real *q, pk_real *v)
{
    const struct work w = parts(it);
    const enum pk_status status = aside(it, &w, t - w.kept->t, it->own->next);
    pk_copy(q, pk_next(it, PK_Q), it->n_q);
    pk_copy(v, pk_next(it, PK_V), it->n);
    return status;
}

#define ADAPTIVE_VERLET(of)                                                                      \
    .needs = PK_NEEDS_ADAPTIVE_VERLET, .formula = &pk_method_verlet, .size = size, .init = init, \
    .step = step, .dense = dense
PK_METHODS_ADAPTIVE_VERLET(PK_DEFINE_METHOD, ADAPTIVE_VERLET)

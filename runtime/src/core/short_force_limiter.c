/* Detects forces shorter than a step. Marks are the arguments u of exp(u), tanh(u) and similar
 * functions, which change only for |u| < ALIVE. Perhaps no stage of a step has u in this range, so
 * that the step misses the force. But u is smooth along the step, often a polynomial in time, so it
 * is sampled finely enough to find where it enters the range.
 *
 * If u, clipped to +-ALIVE, varies by more than MOST in a step, the stages may miss the change: the
 * step is repeated up to a time where u varies less, and the next steps are limited to that length
 * until the error estimate keeps them shorter. Fixed steps are not shortened, but counted. The
 * motion within the step is approximated by a cubic; if that is inaccurate, the check of the
 * shorter step corrects it. */

#include "internal.h"

#define ALIVE PK_C(36.0) /* exp(-36) = 2e-16 is round-off */
/* if the clipped u varies by more than this in a step, the step is repeated as a shorter one */
#define MOST PK_C(12.0)
/* shift of sample times, since equidistant samples would miss a u that is periodic in the step */
#define WARP PK_C(0.11)
#define GROW PK_C(4.0)
/* after a fixed step in which u changes less than this, SKIPPED steps are not checked */
#define SLOW (MOST / 128)
enum { FEW = 4, MOST_WINDOWS = 4096, SKIPPED = 7 };

/* Work memory, which follows four arrays that have one number for each mark. */
struct between {
    pk_real *q, *v, *u, *a0, *a1; /* a0, a1: accelerations at the ends of the step */
};

static size_t lay_out(struct between *b, const struct pk_system *system, size_t n_q, size_t n,
                      pk_real *base)
{
    const struct pk_slot slots[] = {
        {&b->q, n_q}, {&b->v, n}, {&b->u, system->n_inputs}, {&b->a0, n}, {&b->a1, n}};
    return PK_LAY_OUT(base, slots);
}

size_t pk_short_force_size(const struct pk_system *system, size_t n_q, size_t n)
{
    struct between b;
    return system->marks.n ? 4 * system->marks.n + lay_out(&b, system, n_q, n, NULL) : 0;
}

static struct between between(const struct pk_integrator *it)
{
    const struct pk_system *system = it->problem.system;
    struct between b;
    lay_out(&b, system, it->n_q, it->n, it->own->marks + 4 * system->marks.n);
    return b;
}

/* Computes accelerations at the ends of the step; if that fails, uses the mean (v1 - v0)/h. */
static void look_at_ends(struct pk_integrator *it)
{
    const struct between b = between(it);
    const struct pk_reason reason = it->reason;
    const pk_real h = it->own->next_t - it->t;
    const pk_real *q = pk_next(it, PK_Q), *v = pk_next(it, PK_V);
    if (it->n == it->n_q || (pk_eval_acceleration(it, it->t, it->q, it->v, b.a0) >= 0 &&
                             pk_eval_acceleration(it, it->own->next_t, q, v, b.a1) >= 0))
        return;
    for (size_t i = 0; i < it->n; i++)
        b.a0[i] = b.a1[i] = (v[i] - it->v[i]) / h;
    it->reason = reason;
}

void pk_hermite(const struct pk_integrator *it, pk_real h, struct pk_knot from, struct pk_knot to,
                pk_real x, pk_real *q, pk_real *v)
{
    const pk_real *q0 = from.q, *v0 = from.v, *q1 = to.q, *v1 = to.v;
    const pk_real y = 1 - x, h01 = x * x * (3 - 2 * x), h10 = x * y * y * h, h11 = -x * x * y * h;
    const pk_real slope = 6 * x * y / h, d10 = y * (1 - 3 * x), d11 = x * (3 * x - 2);
    const size_t n_q = it->n_q, n = it->n;
    for (size_t i = 0; i < n_q; i++) {
        const pk_real rise = q1[i] - q0[i];
        q[i] = q0[i] + h01 * rise + h10 * v0[i] + h11 * v1[i];
        v[i] = slope * rise + d10 * v0[i] + d11 * v1[i];
    }
    for (size_t i = n_q; i < n; i++)
        v[i] = v0[i] + h01 * (v1[i] - v0[i]) + h10 * from.a[i] + h11 * to.a[i];
}

/* Evaluates the arguments u at x in 0 .. 1 of the trial step. */
static void values(const struct pk_integrator *it, pk_real x, pk_real *u)
{
    const struct pk_system *system = it->problem.system;
    const struct between b = between(it);
    const struct pk_knot from = {it->q, it->v, b.a0};
    const struct pk_knot to = {pk_next(it, PK_Q), pk_next(it, PK_V), b.a1};
    const pk_real h = it->own->next_t - it->t, t = x < 1 ? it->t + x * h : it->own->next_t;
    const struct pk_knot at = {x > 0 && x < 1 ? b.q
                               : x > 0        ? to.q
                                              : from.q,
                               x > 0 && x < 1 ? b.v
                               : x > 0        ? to.v
                                              : from.v,
                               NULL};
    if (x > 0 && x < 1)
        pk_hermite(it, h, from, to, x, b.q, b.v);
    pk_input(&it->problem, t, b.u);
    system->marks.values(it->problem.params, t, at.q, at.v, b.u, u);
}

static pk_real at(const struct pk_integrator *it, size_t k, pk_real x)
{
    pk_real *u = it->own->marks + 3 * it->problem.system->marks.n;
    values(it, x, u);
    return u[k];
}

static pk_real alive(pk_real u) { return pk_max(-ALIVE, pk_min(u, ALIVE)); }

/* Data of a time interval, from u at both ends and in the middle. varies: variation of the clipped
 * u; range: largest less smallest u; bend: second difference of u; dead: u is outside +-ALIVE. */
struct window {
    pk_real varies, range, bend;
    int dead;
};

static struct window window(pk_real a, pk_real m, pk_real b)
{
    const pk_real lo = pk_min(a, pk_min(m, b)), hi = pk_max(a, pk_max(m, b));
    struct window w = {pk_abs(alive(m) - alive(a)) + pk_abs(alive(b) - alive(m)), hi - lo,
                       pk_abs(a - 2 * m + b), 0};
    const pk_real margin = w.bend + w.range / 4;
    w.dead = !pk_finite(margin) || lo - margin > ALIVE || hi + margin < -ALIVE;
    return w;
}

static pk_real warped(pk_real x) { return x + WARP * x * (1 - x); }

/* Returns the fraction x of the trial step up to which mark k (a short force's argument u; see the
 * head of this file) varies little enough; 1 is the whole step. *rise is the part of x after which u
 * enters -ALIVE..ALIVE, outside of which the force does not vary. */
static pk_real follow(struct pk_integrator *it, size_t k, pk_real *rise)
{
    const pk_real h = pk_abs(it->own->next_t - it->t),
                  round = 8 * PK_EPS * pk_abs(it->own->next_t) / h;
    pk_real total = 0, begins = -1, width = PK_C(1.0) / FEW, from = 0, u = it->own->marks[k];
    for (int count = 0; from < 1; count++) {
        const pk_real to = pk_min(from + width, 1), a = warped(from), b = warped(to);
        const pk_real middle = at(it, k, warped((from + to) / 2)), end = at(it, k, b);
        const struct window w = window(u, middle, end);
        const int fine = w.range + w.bend <= MOST / 2;
        if (!w.dead && !fine && b - a > round && count < MOST_WINDOWS) {
            width /= 2;
            continue;
        }
        if (!w.dead && w.varies > 0) {
            begins = begins < 0 ? a : begins;
            if (total + w.varies > MOST || (!fine && count >= MOST_WINDOWS)) {
                *rise = a - begins;
                return a;
            }
            total += w.varies;
        }
        it->own->short_force.varied = pk_max(it->own->short_force.varied, total);
        u = end;
        from = to;
        /* After both halves of an interval the next one is twice as wide. */
        if (width < PK_C(1.0) / FEW && !(PK_F(fmod)(from, 2 * width) > 0))
            width *= 2;
    }
    return 1;
}

pk_real pk_short_force_limit(const struct pk_integrator *it, pk_real limit)
{
    const struct pk_short_force *of = &it->own->short_force;
    const int restrained = of->reach > 0 && of->reach < pk_abs(limit - it->t);
    return restrained ? it->t + pk_direction(it) * of->reach : limit;
}

int pk_short_force_reject(struct pk_integrator *it)
{
    struct pk_short_force *of = &it->own->short_force;
    if (!it->own->marks)
        return 0;
    const int fixed = pk_is_fixed(it->method);
    if (fixed && of->unlooked > 0)
        return 0;
    const size_t m = it->problem.system->marks.n;
    const pk_real h = pk_abs(it->own->next_t - it->t);
    pk_real *begin = it->own->marks, *end = begin + m, *middle = end + m, first = 1, rise = 0;
    size_t which = 0;
    if (!of->known)
        values(it, 0, begin);
    of->known = 1;
    values(it, 1, end);
    of->range = of->varied = 0;
    for (size_t k = 0; k < m; k++)
        of->range = pk_max(of->range, pk_abs(end[k] - begin[k]));
    if (of->range <= MOST / 4 && h <= 3 * of->calm) /* usually true if there are no short forces */
        return 0;
    look_at_ends(it);
    values(it, warped(PK_C(0.5)), middle);
    for (size_t k = 0; k < m; k++) {
        const struct window w = window(begin[k], middle[k], end[k]);
        of->range = pk_max(of->range, w.range);
        if (w.range <= MOST / 2) {
            of->varied = pk_max(of->varied, w.varies);
            continue;
        }
        pk_real active = 0;
        const pk_real part = follow(it, k, &active);
        if (part < first)
            first = part, which = k, rise = active;
    }
    if (!(first < 1))
        return 0;
    if (!fixed && first * h > 64 * PK_EPS * pk_abs(it->t)) {
        of->reach = first * h;
        of->rise = rise * h;
        it->count.rejections++;
        return 1;
    }
    of->varied = MOST;
    if (it->passed_over.count++ == 0) {
        it->passed_over.which = which;
        it->passed_over.t = it->t + pk_direction(it) * first * h;
    }
    return 0;
}

void pk_short_force_accept(struct pk_integrator *it)
{
    struct pk_short_force *of = &it->own->short_force;
    if (!it->own->marks)
        return;
    const size_t m = it->problem.system->marks.n;
    const pk_real h = pk_abs(it->own->next_t - it->t);
    if (of->unlooked > 0) {
        of->unlooked--;
        of->known = 0;
        return;
    }
    of->unlooked = of->range < SLOW && pk_is_fixed(it->method) ? SKIPPED : 0;
    of->calm = of->range <= MOST / 4 ? h : 0; /* a step of this length met no short force */
    pk_copy(it->own->marks, it->own->marks + m, m);
    if (!(of->reach > 0))
        return;
    if (h < of->reach * (1 - PK_C(1e-6)) || of->varied < MOST / 8)
        /* the error estimate keeps the step shorter, or u hardly changes: no limit is needed */
        of->reach = 0;
    else
        of->reach = of->rise > 0 ? of->rise : h * pk_min(GROW, PK_C(0.9) * MOST / of->varied);
    of->rise = 0;
}

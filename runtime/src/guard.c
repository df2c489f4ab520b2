/* Guards: where the equations end, watched from step to step; see struct pk_guard.
 *
 * A guard that changes its sign in a step has vanished in it. One that never does, such as the
 * distance in a collision, has not for all that two ends of a step tell; nor has one that changes
 * it twice, and a step may step over a singularity without a sign of it. So where the tangent at
 * either end says that a guard may vanish within the step, or cannot account for its change, the
 * step is gone through again by short ones, none of which lets a guard fall below .7 of its value:
 * towards a zero they shrink geometrically, past it they get on. Adaptive steps are no exception:
 * at a tight tolerance they shrink before a singularity until they underflow, and then the same
 * search tells its cause; at a loose one they step over it as fixed ones do.
 *
 * Reference for the geometric approach to a singular time: E. Hairer, S. P. Norsett, G. Wanner,
 * Solving Ordinary Differential Equations I, II.4 and I.6.
 */
#include <string.h>

#include "internal.h"

#define FALL PK_C(0.7)     /* of a guard in one short step, at most */
#define DEEP PK_C(1e-12)   /* of its value at the start of the search: it vanishes, */
#define SHALLOW PK_C(1e-3) /* or where steps underflow already, and it is small already */
#define SEARCH_STEPS 2000  /* then it is undecided, and nothing is claimed */
#define CALM PK_C(0.0625)  /* a change in two steps running that is no cause for any doubt */
#define FAR PK_C(1.5)      /* tangents are trusted to tell of a zero up to so many steps away */

/* Parts of it->guards: values and slopes at the state, then at the end of a trial step; a state
 * and a slope for the search, n numbers each. */
enum { NOW, SLOPE, NEXT, NEXT_SLOPE, GUARD_PARTS };
enum { Y, TRIAL = 2, SUM = 4, STAGE = 6, K = 8, SEARCH_PARTS = 10 };

enum { KNOWN = 1, QUIET = 2 }; /* it->slopes: those at the state; the last step changed little */

static pk_real *part(const struct pk_integrator *it, int which)
{
    return it->guards + (size_t)which * it->n_guards;
}

static pk_real *search_part(const struct pk_integrator *it, int which)
{
    return part(it, GUARD_PARTS) + (size_t)which * it->n;
}

size_t pk_guard_size(size_t n_guards, size_t n)
{
    return n_guards ? GUARD_PARTS * n_guards + SEARCH_PARTS * n : 0;
}

static void evaluate(struct pk_integrator *it, pk_real t, const pk_real *q, const pk_real *v,
                     pk_real *out)
{
    const pk_real *u = pk_eval_input(it, t);
    it->problem.system->guard(it->problem.params, t, q, v, u, out);
}

/* The guards at d along the tangent. */
static void along(struct pk_integrator *it, pk_real t, const pk_real *q, const pk_real *v,
                  pk_real d, pk_real *out)
{
    pk_real *moved = search_part(it, STAGE);
    for (size_t i = 0; i < it->n; i++)
        moved[i] = q[i] + d * v[i];
    evaluate(it, t + d, moved, v, out);
}

static void slopes(struct pk_integrator *it, pk_real t, const pk_real *q, const pk_real *v,
                   const pk_real *value, pk_real *slope)
{
    const pk_real d = (it->next_t - it->t) / 1024;
    along(it, t, q, v, d, slope);
    for (size_t k = 0; k < it->n_guards; k++)
        slope[k] = (slope[k] - value[k]) / d;
}

void pk_guard_start(struct pk_integrator *it)
{
    if (it->guards)
        evaluate(it, it->t, it->q, it->v, part(it, NOW));
    it->slopes = 0;
}

/* y + d k: q, v and their slopes are 2n numbers in a row each. */
static void shift(size_t m, const pk_real *y, pk_real d, const pk_real *k, pk_real *out)
{
    for (size_t i = 0; i < m; i++)
        out[i] = y[i] + d * k[i];
}

/* One step of the classical Runge-Kutta method from y into the trial state. */
static int short_step(struct pk_integrator *it, pk_real t, pk_real s)
{
    static const int weight[4] = {1, 2, 2, 1};
    const size_t n = it->n, m = 2 * n;
    pk_real *y = search_part(it, Y), *trial = search_part(it, TRIAL), *sum = search_part(it, SUM);
    pk_real *stage = search_part(it, STAGE), *k = search_part(it, K);
    memcpy(sum, y, m * sizeof *y);
    memcpy(stage, y, m * sizeof *y);
    for (int i = 0; i < 4; i++) {
        const pk_real c = i == 0 ? 0 : i == 3 ? s : s / 2;
        memcpy(k, stage + n, n * sizeof *k);
        if (pk_eval_acceleration(it, t + c, stage, stage + n, k + n) < 0)
            return 0;
        shift(m, sum, s * (pk_real)weight[i] / 6, k, sum);
        if (i < 3)
            shift(m, y, i == 2 ? s : s / 2, k, stage);
    }
    memcpy(trial, sum, m * sizeof *y);
    return pk_all_finite(trial, m);
}

/* Whether no guard has changed by much; how much the one has that changed most. */
static int near(size_t m, const pk_real *g, const pk_real *g1, pk_real *least, pk_real *most)
{
    for (size_t k = 0; k < m; k++) {
        const pk_real ratio = g1[k] / g[k];
        if (!(ratio >= FALL && ratio <= 1 / FALL)) /* true for a NaN */
            return 0;
        *least = pk_min(*least, ratio);
        *most = pk_max(*most, ratio);
    }
    return 1;
}

/* The first guard that has fallen to `depth` of its value at the state; else their number. */
static size_t fallen(const struct pk_integrator *it, const pk_real *g, pk_real depth)
{
    const pk_real *first = part(it, NOW);
    size_t k = 0;
    while (k < it->n_guards && !(pk_abs(g[k]) <= depth * pk_abs(first[k])))
        k++;
    return k;
}

/* A time from a tangent that is no more than round-off may be anything: then the first of two. */
static pk_real within(pk_real t, pk_real first, pk_real last)
{
    return t >= pk_min(first, last) && t <= pk_max(first, last) ? t : first;
}

/* Whether a guard falls to `depth` of its value on the way from the state to t_end; which one, and
 * when it vanishes. */
static int vanishes(struct pk_integrator *it, pk_real t_end, pk_real depth, size_t *which,
                    pk_real *when)
{
    const size_t n = it->n, m = it->n_guards;
    const pk_real whole = t_end - it->t;
    pk_real *g = part(it, NEXT), *g1 = part(it, NEXT_SLOPE);
    pk_real *y = search_part(it, Y), *trial = search_part(it, TRIAL);
    pk_real at = 0, made = 0, s = whole / 16;
    int stuck = 0; /* M is singular to round-off before the guard is quite zero */
    memcpy(y, it->q, n * sizeof *y);
    memcpy(y + n, it->v, n * sizeof *y);
    memcpy(g, part(it, NOW), m * sizeof *g);
    for (int count = 0; count < SEARCH_STEPS && pk_abs(s) > 0 && !stuck; count++) {
        const int last = pk_abs(at + s) >= pk_abs(whole);
        pk_real least = PK_C(1.0), most = PK_C(1.0);
        if (last)
            s = whole - at;
        int good = 1; /* half-way too, for a step through a centre may end as far behind it */
        for (int half = 1; good && half <= 2; half++) {
            along(it, it->t + at, y, y + n, s * (pk_real)half / 2, g1);
            good = near(m, g, g1, &least, &most);
        }
        good = good && short_step(it, it->t + at, s);
        if (good) {
            evaluate(it, it->t + at + s, trial, trial + n, g1);
            good = near(m, g, g1, &least, &most);
        }
        if (!good) {
            s /= 2;
            stuck = pk_abs(s) <= PK_EPS * pk_abs(at);
            continue;
        }
        at += s;
        made = s;
        memcpy(y, trial, 2 * n * sizeof *y);
        memcpy(g, g1, m * sizeof *g);
        if (fallen(it, g, depth) < m || last)
            break;
        if (least > PK_C(0.9) && most < PK_C(1.1))
            s *= PK_C(1.5);
    }
    *which = fallen(it, g, stuck ? SHALLOW : depth);
    if (*which == m)
        return 0;
    along(it, it->t + at, y, y + n, made / 16, g1);
    *when = it->t + at + made / 16 * g[*which] / (g[*which] - g1[*which]);
    *when = within(*when, it->t + at, t_end);
    return 1;
}

/* The search leaves counters and the reason of a failure as they were. */
static int search(struct pk_integrator *it, pk_real t_end, pk_real depth, size_t *which,
                  pk_real *when)
{
    const struct pk_counters count = it->count;
    const size_t where = it->where;
    const pk_real detail = it->detail, condition = it->condition;
    const int found = vanishes(it, t_end, depth, which, when);
    it->count = count;
    it->where = where;
    it->detail = detail;
    it->condition = condition;
    return found;
}

static enum pk_status ended(struct pk_integrator *it, size_t which, pk_real when)
{
    const struct pk_system *system = it->problem.system;
    const size_t guard = pk_system_guard(system, it->problem.params, which).guard;
    it->where = which;
    it->detail = when;
    return system->guards[guard].kind == PK_GUARD_COORDINATES
               ? PK_SINGULAR_COORDINATES
               : PK_SINGULAR_TIME;
}

enum pk_status pk_guard_here(struct pk_integrator *it)
{
    if (!it->guards)
        return PK_DONE;
    const pk_real *g = part(it, NOW);
    for (size_t k = 0; k < it->n_guards; k++)
        if (!(g[k] > 0) && !(g[k] < 0))
            return ended(it, k, it->t);
    return PK_DONE;
}

/* +1, -1, or 0 for zero and what is no number; products of two guards may underflow. */
static int sign(pk_real x)
{
    return (x > 0) - (x < 0);
}

/* Whether the tangents say that guard k may vanish in the step just tried, or say too little. */
static int doubtful(const struct pk_integrator *it, size_t k)
{
    const pk_real g0 = part(it, NOW)[k], g1 = part(it, NEXT)[k], h = it->next_t - it->t;
    const pk_real d0 = h * part(it, SLOPE)[k], d1 = h * part(it, NEXT_SLOPE)[k];
    if (sign(g0) * sign(d0) < 0 && pk_abs(g0) <= FAR * pk_abs(d0))
        return 1;
    if (sign(g1) * sign(d1) > 0 && pk_abs(g1) <= FAR * pk_abs(d1))
        return 1;
    return !(pk_abs(g1 - g0 - (d0 + d1) / 2) <= pk_min(pk_abs(g0), pk_abs(g1)) / 2);
}

static int calm(const struct pk_integrator *it)
{
    const pk_real *g0 = part(it, NOW), *g1 = part(it, NEXT);
    for (size_t k = 0; k < it->n_guards; k++)
        if (!(pk_abs(g1[k] - g0[k]) <= CALM * pk_abs(g0[k])))
            return 0;
    return 1;
}

enum pk_status pk_guard_step(struct pk_integrator *it)
{
    const size_t m = it->n_guards, n = it->n;
    if (!it->guards)
        return PK_DONE;
    const pk_real *q = pk_part(it->next, n, PK_Q), *v = pk_part(it->next, n, PK_V);
    pk_real *g0 = part(it, NOW), *g1 = part(it, NEXT);
    size_t crossed = m, which = m;
    int doubt = 0;
    pk_real when = it->next_t;
    evaluate(it, it->next_t, q, v, g1);
    const int quiet = calm(it) ? QUIET : 0;
    if (quiet & it->slopes) {
        memcpy(g0, g1, m * sizeof *g0);
        it->slopes = QUIET;
        return PK_DONE;
    }
    if (!(it->slopes & KNOWN))
        slopes(it, it->t, it->q, it->v, g0, part(it, SLOPE));
    slopes(it, it->next_t, q, v, g1, part(it, NEXT_SLOPE));
    for (size_t k = 0; k < m; k++) {
        if (sign(g0[k]) * sign(g1[k]) <= 0 && crossed == m) {
            crossed = k;
            when = within(it->t + (it->next_t - it->t) * (g0[k] / (g0[k] - g1[k])), it->next_t,
                          it->t);
        }
        doubt |= doubtful(it, k);
    }
    if (crossed < m || doubt) {
        if (search(it, it->next_t, DEEP, &which, &when))
            return ended(it, which, when);
        if (crossed < m)
            return ended(it, crossed, when);
        evaluate(it, it->next_t, q, v, g1); /* the search has used its place */
        slopes(it, it->next_t, q, v, g1, part(it, NEXT_SLOPE));
    }
    memcpy(g0, g1, 2 * m * sizeof *g0);
    it->slopes = KNOWN | quiet;
    return PK_DONE;
}

enum pk_status pk_guard_cause(struct pk_integrator *it, enum pk_status status, int fixed)
{
    size_t which = 0;
    pk_real when = 0, ahead = 2 * (it->next_t - it->t), depth = DEEP;
    if (!it->guards || (status != PK_SINGULAR_MASS && status != PK_NOT_FINITE &&
                        status != PK_STEP_UNDERFLOW && status != PK_NO_CONVERGENCE &&
                        status != PK_AMBIGUOUS_STEP))
        return status;
    if (!fixed) { /* that close ahead steps underflow: pk_underflow() */
        depth = SHALLOW;
        ahead = (pk_real)it->direction * (PK_C(64.0) * PK_F(sqrt)(PK_EPS) * pk_abs(it->t) +
                                          PK_C(10.0) * pk_abs(it->h));
    }
    return search(it, it->t + ahead, depth, &which, &when) ? ended(it, which, when) : status;
}

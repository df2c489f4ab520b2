/* A singularity is a function of the state, such as a distance, at whose root the equations fail.
 * The search for such a root makes short steps of the classical Runge-Kutta method. In each step no
 * singularity may fall below 0.7 of its value, so step sizes decrease geometrically towards a root,
 * and increase after it. singularity.c calls it.
 *
 * Reference for the geometric approach to a singular time: E. Hairer, S. P. Norsett, G. Wanner,
 * Solving Ordinary Differential Equations I, II.4 and I.6. */

#include "singularity.h"

#define FALL PK_C(0.7)    /* least ratio of a singularity's value to the one a short step before */
#define SEARCH_STEPS 2000 /* largest number of steps of a search */

enum { Y, TRIAL, SUM, STAGE, K }; /* indices of parts of the work memory */

static pk_real *search_part(const struct pk_integrator *it, int which)
{
    return pk_singularity_part(it, PK_SINGULARITY_PARTS) + (size_t)which * (it->n_q + it->n);
}

void pk_singularity_evaluate(struct pk_integrator *it, pk_real t, const pk_real *q,
                             const pk_real *v, pk_real *out)
{
    const pk_real *u = pk_eval_input(it, t);
    it->problem.system->singularities.values(it->problem.params, t, q, v, u, out);
}

void pk_singularity_along(struct pk_integrator *it, pk_real t, const pk_real *q, const pk_real *v,
                          pk_real d, pk_real *out)
{
    pk_real *moved = search_part(it, STAGE);
    for (size_t i = 0; i < it->n_q; i++)
        moved[i] = q[i] + d * v[i];
    pk_singularity_evaluate(it, t + d, moved, v, out);
}

pk_real pk_singularity_within(pk_real t, pk_real first, pk_real last)
{
    return t >= pk_min(first, last) && t <= pk_max(first, last) ? t : first;
}

/* Computes y + d k, where y is q and v, k their derivatives, m numbers. */
static void shift(size_t m, const pk_real *y, pk_real d, const pk_real *k, pk_real *out)
{
    for (size_t i = 0; i < m; i++)
        out[i] = y[i] + d * k[i];
}

/* Makes one step of the classical Runge-Kutta method from y to the trial state. */
static int short_step(struct pk_integrator *it, pk_real t, pk_real s)
{
    static const int weight[4] = {1, 2, 2, 1};
    const size_t n_q = it->n_q, m = n_q + it->n;
    pk_real *y = search_part(it, Y), *trial = search_part(it, TRIAL), *sum = search_part(it, SUM);
    pk_real *stage = search_part(it, STAGE), *k = search_part(it, K);
    pk_copy(sum, y, m);
    pk_copy(stage, y, m);
    for (int i = 0; i < 4; i++) {
        const pk_real c = i == 0 ? 0 : i == 3 ? s : s / 2;
        pk_copy(k, stage + n_q, n_q);
        if (pk_eval_acceleration(it, t + c, stage, stage + n_q, k + n_q) < 0)
            return 0;
        shift(m, sum, s * (pk_real)weight[i] / 6, k, sum);
        if (i < 3)
            shift(m, y, i == 2 ? s : s / 2, k, stage);
    }
    pk_copy(trial, sum, m);
    return pk_all_finite(trial, m);
}

/* Returns whether no singularity has changed much, from g to g1; updates the extreme g1/g. */
static int near(size_t m, const pk_real *g, const pk_real *g1, pk_real *least, pk_real *most)
{
    for (size_t k = 0; k < m; k++) {
        const pk_real ratio = g1[k] / g[k];
        if (!(ratio >= FALL && ratio <= 1 / FALL)) /* negated, so that NaN is included */
            return 0;
        *least = pk_min(*least, ratio);
        *most = pk_max(*most, ratio);
    }
    return 1;
}

/* Returns the index of the first singularity that fell to `depth` times its value at the state, or,
 * if steps became too short to advance (`halted`), to the round-off of its largest value so far. If
 * there is none, returns the number of singularities. */
static size_t fallen(const struct pk_integrator *it, const pk_real *g, pk_real depth, int halted)
{
    const pk_real *first = pk_singularity_part(it, PK_SINGULARITY_NOW);
    const pk_real *most = pk_singularity_part(it, PK_SINGULARITY_MOST);
    const pk_real round = halted ? 64 * PK_EPS : 0;
    size_t k = 0;
    while (k < it->own->n_singularities &&
           !(pk_abs(g[k]) <= pk_max(depth * pk_abs(first[k]), round * most[k])))
        k++;
    return k;
}

/* The largest acceleration when the singularity g is down to 1e-2 and to 1e-4 of its value. An
 * acceleration like g^-k grows by a factor 100^k from the first to the second; an acceleration
 * whose quotient has a finite limit, such as sin(g)/g, does not grow. */
struct growth {
    int levels;
    pk_real a[2];
};

static void note_growth(const struct pk_integrator *it, struct growth *growth, const pk_real *g)
{
    static const pk_real depth[2] = {PK_C(1e-2), PK_C(1e-4)};
    const pk_real *a = search_part(it, K) + it->n_q;
    while (growth->levels < 2 && fallen(it, g, depth[growth->levels], 0) < it->own->n_singularities)
        growth->a[growth->levels++] = pk_largest(a, it->n);
}

static struct pk_singularity_search search(struct pk_integrator *it, pk_real t_end, pk_real depth)
{
    const size_t n_q = it->n_q, n = it->n, m = it->own->n_singularities;
    const pk_real whole = t_end - it->t;
    pk_real *g = pk_singularity_part(it, PK_SINGULARITY_NEXT),
            *g1 = pk_singularity_part(it, PK_SINGULARITY_NEXT_SLOPE);
    pk_real *y = search_part(it, Y), *trial = search_part(it, TRIAL);
    pk_real at = 0, made = 0, s = whole / 16;
    struct pk_singularity_search found = {PK_SINGULARITY_UNDECIDED, m, it->t, 0};
    struct growth growth = {0};
    int stuck = 0, arrived = 0; /* 1: M is singular to round-off already */
    pk_copy(y, it->q, n_q);
    pk_copy(y + n_q, it->v, n);
    pk_copy(g, pk_singularity_part(it, PK_SINGULARITY_NOW), m);
    for (int count = 0; count < SEARCH_STEPS && pk_abs(s) > 0 && !stuck && !arrived; count++) {
        const int last = pk_abs(at + s) >= pk_abs(whole);
        pk_real least = 1, most = 1;
        if (last)
            s = whole - at;
        /* values are also checked at mid-step: through a centre both ends have like values */
        int good = 1;
        for (int half = 1; good && half <= 2; half++) {
            pk_singularity_along(it, it->t + at, y, y + n_q, s * (pk_real)half / 2, g1);
            good = near(m, g, g1, &least, &most);
        }
        good = good && short_step(it, it->t + at, s);
        if (good) {
            pk_singularity_evaluate(it, it->t + at + s, trial, trial + n_q, g1);
            good = near(m, g, g1, &least, &most);
        }
        if (!good) {
            s /= 2;
            stuck = pk_abs(s) <= PK_EPS * pk_abs(at);
            continue;
        }
        at += s;
        made = s;
        pk_copy(y, trial, n_q + n);
        pk_copy(g, g1, m);
        note_growth(it, &growth, g);
        arrived = last;
        if (fallen(it, g, depth, 0) < m)
            break;
        if (least > PK_C(0.9) && most < PK_C(1.1))
            s *= PK_C(1.5);
    }
    found.which = fallen(it, g, stuck ? PK_SINGULARITY_SHALLOW : depth, !arrived);
    if (found.which < m) {
        pk_singularity_along(it, it->t + at, y, y + n_q, made / 16, g1);
        found.when = it->t + at + made / 16 * g[found.which] / (g[found.which] - g1[found.which]);
        found.when = pk_singularity_within(found.when, it->t + at, t_end);
        found.found = PK_SINGULARITY_VANISHES;
        /* near zero (growth.levels = 2) round-off may have reflected the motion: undecided */
    } else if (arrived && growth.levels < 2) {
        found.found = PK_SINGULARITY_STAYS;
    }
    found.bounded = growth.levels == 2 && growth.a[1] <= 4 * growth.a[0];
    return found;
}

struct pk_singularity_search pk_singularity_search(struct pk_integrator *it, pk_real t_end,
                                                   pk_real depth)
{
    const struct pk_counters count = it->count;
    const struct pk_reason reason = it->reason;
    const struct pk_singularity_search found = search(it, t_end, depth);
    it->count = count;
    it->reason = reason;
    return found;
}

/* Singularities, where the equations are undefined, looked for at each step; see struct
 * pk_singularity.
 *
 * An expression that changes sign in a step has a root in it. But an expression has the same sign
 * at both ends of the step if it only touches zero, such as the distance in a collision, or if it
 * has two roots in the step. Then the step may pass over the roots. So if the tangent at either end
 * of the step predicts a root within it, or the change of the expression differs from both
 * tangents, the motion is recomputed by short steps (singularity_search.c). Adaptive steps are
 * treated likewise: at a tight tolerance their sizes decrease before a singularity until they
 * underflow, and the search finds the cause; at a loose one they pass over it like fixed steps.
 *
 * If there is a sign change, but the motion by short steps does not reach the root, the step is
 * inaccurate: PK_STEP_TOO_LONG. */

#include "singularity.h"

/* if no value changes by a larger fraction in two successive steps, the step needs no check */
#define CALM PK_C(0.0625)
/* a tangent predicts a root in the step if it reaches zero within FAR step sizes */
#define FAR PK_C(1.5)
#define ROUNDING (64 * PK_EPS)

enum {
    KNOWN = 1,
    QUIET = 2
    /* flags. KNOWN: the slopes at the state are known; QUIET: values changed little in the last
     * step */
};

size_t pk_singularity_size(size_t n_singularities, size_t n_q, size_t n)
{
    return n_singularities
               ? PK_SINGULARITY_PARTS * n_singularities + PK_SINGULARITY_SEARCH_PARTS * (n_q + n)
               : 0;
}

static void slopes(struct pk_integrator *it, pk_real t, const pk_real *q, const pk_real *v,
                   const pk_real *value, pk_real *slope)
{
    const pk_real d = (it->own->next_t - it->t) / 1024;
    pk_singularity_along(it, t, q, v, d, slope);
    for (size_t k = 0; k < it->own->n_singularities; k++)
        slope[k] = (slope[k] - value[k]) / d;
}

/* Sets a value to 0 if it is only rounding of the start state, such as cos(pi/2) in gimbal lock. */
static void clear_rounding(struct pk_integrator *it)
{
    const size_t count = it->n_q + it->n;
    pk_real *now = pk_singularity_part(it, PK_SINGULARITY_NOW),
            *then = pk_singularity_part(it, PK_SINGULARITY_NEXT), *near = it->own->next;
    for (int which = 0; which < 2; which++) {
        for (size_t i = 0; i < count; i++)
            near[i] = it->own->state[i] * (1 + (i >> which & 1 ? ROUNDING : -ROUNDING));
        pk_singularity_evaluate(it, it->t, near, near + it->n_q, then);
        for (size_t k = 0; k < it->own->n_singularities; k++)
            if (pk_abs(now[k]) <= pk_abs(then[k] - now[k]))
                now[k] = 0;
    }
}

void pk_singularity_start(struct pk_integrator *it)
{
    it->own->slopes = 0;
    if (!it->own->singularities)
        return;
    pk_singularity_evaluate(it, it->t, it->q, it->v, pk_singularity_part(it, PK_SINGULARITY_NOW));
    clear_rounding(it);
    pk_zero(pk_singularity_part(it, PK_SINGULARITY_MOST), it->own->n_singularities);
}

/* Accepts the trial step: its end becomes the state. */
static enum pk_status go_on(struct pk_integrator *it, int known)
{
    const size_t m = it->own->n_singularities;
    pk_real *now = pk_singularity_part(it, PK_SINGULARITY_NOW),
            *most = pk_singularity_part(it, PK_SINGULARITY_MOST);
    for (size_t k = 0; k < m; k++)
        most[k] = pk_max(most[k], pk_abs(now[k]));
    pk_copy(now, pk_singularity_part(it, PK_SINGULARITY_NEXT), 2 * m);
    it->own->slopes = known;
    return PK_DONE;
}

static enum pk_status ended(struct pk_integrator *it, size_t which, pk_real when, int bounded)
{
    const struct pk_system *system = it->problem.system;
    const size_t singularity = pk_system_singularity(system, it->problem.params, which).which;
    it->reason =
        PK_WHY(.kind = bounded ? PK_REASON_BOUNDED : PK_REASON_GROWS, .index = which, .time = when);
    return system->singularities.table[singularity].kind == PK_SINGULARITY_COORDINATES
               ? PK_SINGULAR_COORDINATES
               : PK_SINGULAR_TIME;
}

/* Handles a sign change in a step: short steps search for the root, from the start of the step over
 * twice its length, since an inaccurate step may reach the singularity too early. */
static enum pk_status crossed(struct pk_integrator *it, size_t k, pk_real when)
{
    const pk_real h = it->own->next_t - it->t;
    const struct pk_singularity_search s =
        pk_singularity_search(it, it->t + 2 * h, PK_SINGULARITY_DEEP);
    if (s.found == PK_SINGULARITY_VANISHES)
        return ended(it, s.which, s.when, s.bounded);
    const int least = pk_abs(h) <= 64 * PK_EPS * pk_abs(it->t); /* no shorter step */
    if (s.found == PK_SINGULARITY_UNDECIDED || least)
        return ended(it, k, when, s.bounded);
    return pk_fail_with(it, PK_STEP_TOO_LONG, PK_WHY(.index = k, .time = it->own->next_t));
}

enum pk_status pk_singularity_here(struct pk_integrator *it)
{
    if (!it->own->singularities)
        return PK_DONE;
    const pk_real *g = pk_singularity_part(it, PK_SINGULARITY_NOW);
    for (size_t k = 0; k < it->own->n_singularities; k++)
        if (!(g[k] > 0) && !(g[k] < 0))
            return ended(it, k, it->t, 0);
    return PK_DONE;
}

/* Returns the sign of x, and 0 if x is zero or NaN. Signs are multiplied instead of numbers, since
 * products of two small numbers may underflow. */
static int sign(pk_real x) { return (x > 0) - (x < 0); }

/* Returns whether singularity k may have a root in the trial step: a tangent at either end predicts
 * one, or the change of the value differs too much from both tangents. */
static int doubtful(const struct pk_integrator *it, size_t k)
{
    const pk_real g0 = pk_singularity_part(it, PK_SINGULARITY_NOW)[k],
                  g1 = pk_singularity_part(it, PK_SINGULARITY_NEXT)[k];
    const pk_real h = it->own->next_t - it->t,
                  d0 = h * pk_singularity_part(it, PK_SINGULARITY_SLOPE)[k];
    const pk_real d1 = h * pk_singularity_part(it, PK_SINGULARITY_NEXT_SLOPE)[k];
    if (sign(g0) * sign(d0) < 0 && pk_abs(g0) <= FAR * pk_abs(d0))
        return 1;
    if (sign(g1) * sign(d1) > 0 && pk_abs(g1) <= FAR * pk_abs(d1))
        return 1;
    return !(pk_abs(g1 - g0 - (d0 + d1) / 2) <= pk_min(pk_abs(g0), pk_abs(g1)) / 2);
}

static int calm(const struct pk_integrator *it)
{
    const pk_real *g0 = pk_singularity_part(it, PK_SINGULARITY_NOW),
                  *g1 = pk_singularity_part(it, PK_SINGULARITY_NEXT);
    for (size_t k = 0; k < it->own->n_singularities; k++)
        if (!(pk_abs(g1[k] - g0[k]) <= CALM * pk_abs(g0[k])))
            return 0;
    return 1;
}

enum pk_status pk_singularity_step(struct pk_integrator *it)
{
    struct pk_integrator_private *const own = it->own;
    const size_t m = own->n_singularities;
    if (!own->singularities)
        return PK_DONE;
    const pk_real *q = pk_next(it, PK_Q), *v = pk_next(it, PK_V);
    const pk_real *g0 = pk_singularity_part(it, PK_SINGULARITY_NOW);
    pk_real *g1 = pk_singularity_part(it, PK_SINGULARITY_NEXT);
    int doubt = 0;
    pk_singularity_evaluate(it, own->next_t, q, v, g1);
    const int quiet = calm(it) ? QUIET : 0;
    if (quiet & own->slopes)
        return go_on(it, QUIET);
    if (!(own->slopes & KNOWN))
        slopes(it, it->t, it->q, it->v, g0, pk_singularity_part(it, PK_SINGULARITY_SLOPE));
    slopes(it, own->next_t, q, v, g1, pk_singularity_part(it, PK_SINGULARITY_NEXT_SLOPE));
    for (size_t k = 0; k < m; k++) {
        const pk_real secant = it->t + (own->next_t - it->t) * (g0[k] / (g0[k] - g1[k]));
        if (sign(g0[k]) * sign(g1[k]) <= 0)
            return crossed(it, k, pk_singularity_within(secant, own->next_t, it->t));
        doubt |= doubtful(it, k);
    }
    if (doubt) {
        const struct pk_singularity_search s =
            pk_singularity_search(it, own->next_t, PK_SINGULARITY_DEEP);
        if (s.found == PK_SINGULARITY_VANISHES)
            return ended(it, s.which, s.when, s.bounded);
        pk_singularity_evaluate(it, own->next_t, q, v, g1); /* since the search overwrote the
                                                                   values */
        slopes(it, own->next_t, q, v, g1, pk_singularity_part(it, PK_SINGULARITY_NEXT_SLOPE));
    }
    return go_on(it, KNOWN | quiet);
}

enum pk_status pk_singularity_cause(struct pk_integrator *it, enum pk_status status, int fixed)
{
    pk_real ahead = 2 * (it->own->next_t - it->t), depth = PK_SINGULARITY_DEEP;
    if (!it->own->singularities ||
        (status != PK_SINGULAR_MASS && status != PK_NOT_FINITE && status != PK_STEP_UNDERFLOW &&
         status != PK_NO_CONVERGENCE && status != PK_AMBIGUOUS_STEP))
        return status;
    if (!fixed) { /* the distance `ahead` is similar to that in pk_underflow() */
        depth = PK_SINGULARITY_SHALLOW;
        ahead = pk_direction(it) *
                (64 * PK_F(sqrt)(PK_EPS) * pk_abs(it->t) + 10 * pk_abs(it->own->h));
    }
    const struct pk_singularity_search s = pk_singularity_search(it, it->t + ahead, depth);
    return s.found == PK_SINGULARITY_VANISHES ? ended(it, s.which, s.when, s.bounded) : status;
}

/* Action and period of an orbit; see motion.h. */
#include "../../src/core/internal.h"
#include "motion.h"
#include "well.h"

enum { LEAST = 32, MOST = 1 << 18, SAMPLES = 1024, TIMES = 3 };
#define SETTLED (32 * PK_EPSILON)  /* a relative change of J and T up to this is rounding */
#define NOISE (16384 * PK_EPSILON) /* a change up to this may be the rounding of many terms */
#define PASSABLE PK_C(1e-6)        /* results that still change by up to this are reported */
/* a larger relative rounding error of the period T shows a separatrix */
#define LOST PK_C(1e-3)

/* Returns the relative error of the period T due to rounding of the energy at one end of the orbit.
 * T depends on the logarithm of the force F at this end; rounding shifts it by epsilon/F of the
 * largest h - W. */
static pk_real doubt(const struct well *w, pk_real q, pk_real amplitude)
{
    const pk_real d = amplitude * PK_F(sqrt)(PK_F(sqrt)(PK_EPSILON)), F = force_at(w, q);
    const pk_real slope = (force_at(w, q + d) - force_at(w, q - d)) / (2 * d);
    return PK_EPSILON * w->most * pk_abs(slope) / (F * F);
}

/* Adds one half of a libration to J and T, from its end at q inwards; `nodes` counts the nodes of
 * both halves. Returns 0 if h - W (energy minus potential) or M is not positive at a node. */
static int half(const struct well *w, pk_real q, pk_real inwards, pk_real amplitude, size_t nodes,
                pk_real *J, pk_real *T)
{
    pk_real U = 0, last = 0;
    for (size_t j = 0; j < nodes / 2; j++) {
        const pk_real s = ((pk_real)j + PK_C(0.5)) * (PK_PI / (pk_real)nodes);
        const pk_real x = PK_F(sin)(s / 2), y = inwards * 2 * amplitude * x * x;
        U += well_work(w, q, last, y);
        last = y;
        const pk_real M = mass_at(w, q + y), dq = amplitude * PK_F(sin)(s);
        if (!(U > 0 && M > 0))
            return 0;
        *J += PK_F(sqrt)(2 * M * U) * dq;
        *T += PK_F(sqrt)(M / (2 * U)) * dq;
    }
    return 1;
}

/* Adds a full turn to J and T. It begins at q, where the kinetic energy h - W is U. Returns 0 if h
 * - W or M is not positive at a node. */
static int round_once(const struct well *w, pk_real q, pk_real U, pk_real direction, size_t nodes,
                      pk_real *J, pk_real *T)
{
    const pk_real dq = direction * (TURN / (pk_real)nodes);
    for (size_t j = 0; j < nodes; j++) {
        const pk_real y = (pk_real)j * dq, M = mass_at(w, q + y);
        if (!(U > 0 && M > 0))
            return 0;
        *J += PK_F(sqrt)(2 * M * U) + direction * linear_at(w, q + y);
        *T += PK_F(sqrt)(M / (2 * U));
        U += well_work(w, q, y, y + dq);
    }
    return 1;
}

static pk_real change(pk_real x, pk_real y) { return pk_abs(x - y) / pk_abs(x); }

static void sums(struct action *a, const struct well *w, pk_real q, pk_real U, pk_real direction)
{
    const int turns = a->orbit == ROTATION;
    const pk_real amplitude = (a->hi - a->lo) / 2, lost = a->error;
    pk_real before = PK_INFINITY, now = PK_INFINITY;
    for (size_t nodes = LEAST; nodes <= MOST; nodes *= 2) {
        pk_real J = 0, T = 0;
        const int whole = turns ? round_once(w, q, U, direction, nodes, &J, &T)
                                : half(w, q + a->lo, 1, amplitude, nodes, &J, &T) &&
                                      half(w, q + a->hi, -1, amplitude, nodes, &J, &T);
        if (!whole) /* too few nodes */
            continue;
        J /= (pk_real)nodes;
        T *= TURN / (pk_real)nodes;
        now = PK_F(fmax)(change(J, a->action), change(T, a->period));
        a->action = J;
        a->period = T;
        a->nodes = nodes;
        a->error = PK_F(fmax)(now, lost);
        if (a->nodes > LEAST && (now <= SETTLED || (now <= NOISE && now > before / 2)))
            break;
        before = now;
    }
    if (!(now <= PASSABLE))
        a->orbit = UNSETTLED;
}

/* Finds the ends of the orbit, or finds that it is a rotation. */
static enum orbit orbit_of(struct action *a, struct well *w, pk_real q, pk_real U,
                           pk_real direction)
{
    const pk_real F = force_at(w, q);
    struct end ahead, behind = {0, 0, 1};
    if (!(U > 0)) { /* at rest: the start is a turning point */
        const pk_real d = 2 * PK_EPSILON * q;
        if (!(pk_abs(F) > 2 * pk_abs(force_at(w, q + d) - force_at(w, q - d))))
            return pk_finite(F) ? EQUILIBRIUM : UNBOUNDED;
        direction = F > 0 ? 1 : -1;
    }
    ahead = well_march(w, q, U, direction);
    if (ahead.turns) {
        a->error = PK_EPSILON * w->most / w->least; /* relative error of T, as in doubt() */
        return U > 0 && a->error <= LOST ? ROTATION : SEPARATRIX;
    }
    if (U > 0 && ahead.found)
        behind = well_march(w, q, U, -direction);
    if (!ahead.found || !behind.found || behind.turns)
        return UNBOUNDED;
    a->lo = direction > 0 ? behind.y : ahead.y;
    a->hi = direction > 0 ? ahead.y : behind.y;
    const pk_real amplitude = (a->hi - a->lo) / 2;
    a->error = doubt(w, q + ahead.y, amplitude);
    if (U > 0)
        a->error = PK_F(fmax)(a->error, doubt(w, q + behind.y, amplitude));
    return a->error <= LOST ? LIBRATION : SEPARATRIX;
}

/* Returns whether, by the energy kernel, the potential W equals the energy h at the ends of the
 * orbit and is at most h between them: well_march() may miss a hump of W between its samples. */
static int is_followed(const struct action *a, const struct well *w, pk_real q, pk_real h)
{
    const struct pk_system *s = w->system;
    if (!s->energy || a->orbit != LIBRATION)
        return 1;
    const pk_real rest = 0, shown = PK_F(sqrt)(PK_EPSILON) * w->most / 256;
    for (int k = 0; k <= SAMPLES; k++) {
        const pk_real x = q + a->lo + (a->hi - a->lo) * ((pk_real)k / SAMPLES);
        const pk_real left = h - s->energy(w->params, w->t, &x, &rest, w->u);
        const pk_real rounding = pk_abs(h) + pk_abs(x * force_at(w, x));
        const pk_real slack = shown + 256 * PK_EPSILON * rounding;
        if (!(left >= -slack) || ((k == 0 || k == SAMPLES) && !(left <= slack)))
            return 0;
    }
    return 1;
}

enum pk_status action_find(struct action *found, const struct pk_problem *problem, pk_real t,
                           const pk_real *q, const pk_real *v, const pk_real *u)
{
    const struct pk_system *s = problem->system;
    struct well w = {s, problem->params, t, u, PK_INFINITY, 0, PK_INFINITY};
    *found = (struct action){SEVERAL, 0, 0, 0, 0, 0, 0};
    if (pk_system_count(s, problem->params) != 1)
        return PK_REFUSED;
    found->orbit = NO_KERNELS;
    if (!s->gradient || !s->mass || !s->canonical || s->switches.impulses)
        return PK_REFUSED;
    found->orbit = NOT_QUADRATIC;
    if (!(s->facts & PK_QUADRATIC))
        return PK_REFUSED;
    const pk_real direction = *v < 0 ? -1 : 1;
    w.most = mass_at(&w, *q) * *v * *v / 2;
    const pk_real U = w.most, h = s->energy ? s->energy(w.params, t, q, v, u) : 0;
    int followed = 0;
    for (int n = 0; n < TIMES && !followed; n++) {
        w.most = U;
        w.least = PK_INFINITY;
        found->lo = found->hi = 0;
        found->orbit = orbit_of(found, &w, *q, U, direction);
        followed = is_followed(found, &w, *q, h);
        w.longest = (found->hi - found->lo) / (n == 0 ? SAMPLES : 4 * SAMPLES);
    }
    if (!followed)
        found->orbit = UNSETTLED;
    if (found->orbit == LIBRATION || found->orbit == ROTATION)
        sums(found, &w, *q, U, direction);
    found->lo += *q;
    found->hi += *q;
    return found->orbit <= ROTATION ? PK_DONE : PK_REFUSED;
}

const char *orbit_text(enum orbit orbit)
{
    static const char *const text[] = {ORBITS(PK_EACH_TEXT)};
    return (unsigned)orbit < ORBIT_COUNT ? text[orbit] : "?";
}

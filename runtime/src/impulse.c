/* The impulse where the motion meets a switch across which L or a constraint jumps: the corner
 * condition of Weierstrass and Erdmann. Before it are p-, h-; behind it, with alpha along the
 * gradient of the switch s(q, t) and Lambda along the rows J v + j0 = 0 of that side,
 *
 *     p(v+) = p- + alpha s_q + J^T Lambda,   J v+ + j0 = 0,   E = h(v+) - h- + alpha s_t + Lambda.j0 = 0.
 *
 * Along v(alpha) dE/dalpha = s', the rate of s, and s' grows with alpha, M being definite: E is
 * convex, and of its two zeros one goes on and one goes back. Where there is none the surface is a
 * barrier: the same equations of the side before, whose other zero goes back. A surface s(t) has
 * alpha = 0 and keeps no energy; so has one across which a rolling's j0 jumps, for its force works
 * along its row alone.
 *
 * References: I. M. Gelfand, S. V. Fomin, Calculus of Variations, section 15; B. Brogliato,
 * Nonsmooth Mechanics, 3rd ed., chapters 1 and 3.
 */
#include <stdio.h>
#include <string.h>

#include <pk/constraint.h>

#include "events.h"
#include "project.h"

enum { MOST = 60 };                    /* corrections */
#define SAME (PK_C(64.0) * PK_EPS)     /* of its size: what is off by less has not jumped */
#define WHOLE PK_F(sqrt)(PK_EPS)       /* and what a position or a row is off by more by has */
#define ALONG (PK_C(1024.0) * PK_EPS)  /* of s_q: so little is left of it beside the rows, or none */
#define AGREE PK_C(1e-8)               /* of rates: two orders have the same result */

/* it->detail of PK_NO_IMPULSE; it->where is the switch, it->condition the row. */
enum { POSITION, ROLLING, BOTH_JUMP, TURNS, ORDER, NEITHER };

struct corner {
    struct pk_events *e;
    struct pk_integrator *it;
    struct pk_projection w;
    const pk_real *q, *slope; /* s_q */
    pk_real slope_t, h0;
    pk_real *p0, *p, *v, *start, *along, *lambda, *by; /* along = dv/dalpha, by = dLambda/dalpha */
    pk_real *slopes, *J, *phi, *before, *sides, *first;
};

size_t pk_impulse_size(const struct pk_system *system, size_t n)
{
    const size_t c = system->n_constraints, k = system->n_switches;
    return system->impulses ? pk_project_room(system, n) + 7 * n + (n + 3) * c + (n + 5) * k : 0;
}

static struct corner corner_of(struct pk_events *e, struct pk_integrator *it)
{
    struct corner x = {.e = e, .it = it, .q = e->trial, .start = e->trial + e->n};
    const size_t n = e->n, c = it->problem.system->n_constraints, k = e->n_switches;
    pk_real *at = e->room;
    x.w = pk_project_layout(&it->problem, n, at), at += pk_project_room(it->problem.system, n);
    x.w.t = e->t;
    x.p0 = at, at += n;
    x.p = at, at += 2 * n; /* and pdot */
    x.v = at, at += n;
    x.along = at, at += n;
    x.first = at, at += 2 * n;
    x.lambda = at, at += c;
    x.by = at, at += c;
    x.phi = at, at += c;
    x.J = at, at += c * n;
    x.before = at, at += 2 * k;
    x.sides = at, at += 2 * k;
    x.slopes = at;
    return x;
}

static pk_real dot(const pk_real *a, const pk_real *b, size_t count)
{
    pk_real sum = 0;
    for (size_t i = 0; i < count; i++)
        sum += a[i] * b[i];
    return sum;
}

static void momenta(struct corner *x, const pk_real *v)
{
    x->w.system->unbound(x->w.params, x->w.t, x->q, v, x->w.u, x->p, x->p + x->w.n);
}

static pk_real energy(const struct corner *x, const pk_real *v)
{
    return x->w.system->energy(x->w.params, x->w.t, x->q, v, x->w.u);
}

static void rows(struct corner *x, const pk_real *v)
{
    if (x->w.c)
        pk_project_rows(&x->w, x->q, v);
}

/* d, which is a force, becomes M^-1 (d + J^T mu) with J d = -rate. M and J are those at v. */
static int solve(struct corner *x, const pk_real *v, pk_real *d, const pk_real *rate, pk_real *mu)
{
    struct pk_projection *w = &x->w;
    if (pk_project_inertia(w, x->q, v) || pk_project_factor(w, w->c))
        return -1;
    pk_ldl_solve(w->M, w->m, d);
    for (size_t j = 0; j < w->c; j++)
        mu[j] = -(rate ? rate[j] : 0) - dot(w->J + j * w->n, d, w->m);
    pk_ldl_solve(w->A, w->c, mu);
    for (size_t j = 0; j < w->c; j++)
        for (size_t i = 0; i < w->m; i++)
            d[i] += w->W[j * w->m + i] * mu[j];
    return 0;
}

/* v(alpha) on the side at hand by Newton's method, from what v and lambda are; and its derivative. */
static int rates(struct corner *x, pk_real alpha)
{
    struct pk_projection *w = &x->w;
    pk_real before = 0, part = 1, *d = x->along;
    for (int count = 0; count < MOST; count++) {
        pk_real change = 0, size = 0;
        momenta(x, x->v);
        if (count && !pk_all_finite(x->p, w->m)) { /* beyond what L has: half of the way back */
            part /= 2;
            for (size_t i = 0; i < w->m; i++)
                x->v[i] -= part * d[i];
            for (size_t j = 0; j < w->c; j++)
                x->lambda[j] -= part * x->by[j];
            continue;
        }
        part = 1;
        rows(x, x->v);
        for (size_t i = 0; i < w->m; i++) {
            d[i] = x->p0[i] - x->p[i] + alpha * x->slope[i];
            for (size_t j = 0; j < w->c; j++)
                d[i] += w->J[j * w->n + i] * x->lambda[j];
        }
        if (solve(x, x->v, d, w->rate, x->by) < 0)
            return -1;
        for (size_t j = 0; j < w->c; j++)
            x->lambda[j] += x->by[j];
        for (size_t i = 0; i < w->m; i++) {
            x->v[i] += d[i];
            change = pk_max(change, pk_abs(d[i]));
            size = pk_max(size, pk_abs(x->v[i]));
        }
        if (!pk_all_finite(x->v, w->m))
            return -1;
        if (change <= PK_EPS * size || (count > 1 && change >= before / 2 && change <= WHOLE * size)) {
            rows(x, x->v);
            memcpy(d, x->slope, w->m * sizeof *d);
            return solve(x, x->v, d, NULL, x->by);
        }
        before = change;
    }
    return -1;
}

static pk_real excess(const struct corner *x, pk_real alpha)
{
    const struct pk_projection *w = &x->w;
    pk_real sum = energy(x, x->v) - x->h0 + alpha * x->slope_t;
    for (size_t j = 0; j < w->c; j++)
        sum += x->lambda[j] * (w->rate[j] - dot(w->J + j * w->n, x->v, w->m));
    return sum;
}

static pk_real speed(const struct corner *x)
{
    return dot(x->slope, x->v, x->w.m) + x->slope_t;
}

/* To the zero of E where s' has a direction: 1, or 0 where there is none; -1: no rates are found. */
static int leave(struct corner *x, pk_real direction, int free)
{
    struct pk_projection *w = &x->w;
    pk_real alpha = 0, before = 0, first = 0;
    int lowest = 0;
    memcpy(x->v, x->start, w->n * sizeof *x->v);
    memset(x->lambda, 0, w->c * sizeof *x->lambda);
    for (int count = 0; count < MOST; count++) {
        if (rates(x, alpha) < 0)
            return -1;
        const pk_real s = speed(x), bend = dot(x->slope, x->along, w->m);
        if (!free)
            return 1;
        if (count == 0) { /* what rows leave of s_q */
            memcpy(w->d, x->slope, w->m * sizeof *w->d);
            pk_ldl_solve(w->M, w->m, w->d);
            first = pk_abs(s);
            if (!(bend > ALONG * dot(x->slope, w->d, w->m)))
                return 1;
        }
        const pk_real E = excess(x, alpha), root = s * s - 2 * bend * E;
        if (lowest && root < 0 && pk_abs(s) <= WHOLE * first)
            return 0;
        lowest = root < 0;
        const pk_real by = lowest ? 0 : direction * PK_F(sqrt)(root);
        const pk_real step = !lowest && by * s > 0 ? -2 * E / (s + by) : (by - s) / bend;
        if (!pk_finite(step))
            return -1;
        if (!lowest && count && by * s > 0 &&
            (pk_abs(step) <= PK_EPS * pk_abs(alpha) ||
             (count > 1 && pk_abs(step) >= before / 2 && pk_abs(step) <= WHOLE * pk_abs(alpha))))
            return 1;
        if (!lowest && !(pk_abs(step) > 0))
            return 1;
        alpha += step;
        before = pk_abs(step);
    }
    return -1;
}

/* To the other side of one, and of those in whose arguments it stands. */
static void turn(struct corner *x, size_t k, pk_real side)
{
    struct pk_events *e = x->e;
    pk_real *now = x->before + e->n_switches;
    pk_switches_values(e, x->it, e->t, x->q, x->start, x->before);
    e->sides[k] = side;
    for (size_t round = 0; round < e->n_switches; round++) {
        pk_switches_values(e, x->it, e->t, x->q, x->start, now);
        for (size_t j = 0; j < e->n_switches; j++)
            if (j != k && now[j] * x->before[j] < 0)
                e->sides[j] = now[j] < 0 ? PK_C(-1.0) : PK_C(1.0);
    }
}

static enum pk_status refuse(struct corner *x, size_t k, int why, size_t row)
{
    x->it->where = k;
    x->it->detail = (pk_real)why;
    x->it->condition = (pk_real)row;
    return PK_NO_IMPULSE;
}

/* What has jumped, in `found` the bits of enum pk_impulse, the state being that before. */
static enum pk_status compare(struct corner *x, size_t k, unsigned *found)
{
    struct pk_projection *w = &x->w;
    const struct pk_system *system = w->system;
    *found = 0;
    momenta(x, x->start);
    for (size_t i = 0; i < w->m; i++)
        if (pk_abs(x->p[i] - x->p0[i]) > SAME * (pk_abs(x->p[i]) + pk_abs(x->p0[i])))
            *found |= PK_IMPULSE_ENERGY;
    const pk_real h = energy(x, x->start), work = pk_abs(dot(x->p, x->start, w->m));
    if (pk_abs(h - x->h0) > SAME * (pk_abs(h) + pk_abs(x->h0) + work))
        *found |= PK_IMPULSE_ENERGY;
    if (!w->c)
        return PK_DONE;
    rows(x, x->start);
    pk_project_terms(w, x->q, x->start);
    for (size_t j = 0; j < w->c; j++) {
        const int holonomic = j < system->n_holonomic;
        if (holonomic && pk_abs(w->phi[j] - x->phi[j]) > WHOLE * w->phi_size[j])
            return refuse(x, k, POSITION, j);
        pk_real change = 0, size = 0;
        for (size_t i = 0; i < w->m; i++) {
            change = pk_max(change, pk_abs(w->J[j * w->n + i] - x->J[j * w->n + i]));
            size = pk_max(size, pk_abs(x->J[j * w->n + i]));
        }
        if (!holonomic && change > WHOLE * size)
            return refuse(x, k, ROLLING, j);
        if (pk_abs(w->rate[j]) > ALONG * w->rate_size[j] || change > WHOLE * size)
            *found |= holonomic ? PK_IMPULSE_ENERGY : PK_IMPULSE_ROLLING;
    }
    return PK_DONE;
}

/* One impulse of the rates x->start. */
static enum pk_status one(struct corner *x, size_t k, pk_real side)
{
    struct pk_events *e = x->e;
    struct pk_projection *w = &x->w;
    const pk_real direction = side * (pk_real)x->it->direction;
    pk_real *const given = x->sides + e->n_switches;
    unsigned found;
    memcpy(given, e->sides, e->n_switches * sizeof *given);
    w->system->corner(w->params, w->t, x->q, x->start, w->u, x->slopes,
                      x->slopes + e->n_switches * w->n);
    x->slope = x->slopes + k * w->n;
    x->slope_t = x->slopes[e->n_switches * w->n + k];
    int of_place = 0;
    for (size_t i = 0; i < w->m; i++)
        of_place |= pk_abs(x->slope[i]) > 0;
    memcpy(x->v, x->start, w->n * sizeof *x->v);
    if (of_place && !(speed(x) * direction > 0))
        return PK_DONE; /* another impulse has turned it back */
    momenta(x, x->start);
    memcpy(x->p0, x->p, w->m * sizeof *x->p0);
    x->h0 = energy(x, x->start);
    rows(x, x->start);
    if (w->c) {
        memcpy(x->J, w->J, w->c * w->n * sizeof *x->J);
        memcpy(x->phi, w->phi, w->h * sizeof *x->phi);
    }
    turn(x, k, side);
    const enum pk_status status = compare(x, k, &found);
    if (status < 0 || !found)
        return status;
    if (of_place && found == (PK_IMPULSE_ENERGY | PK_IMPULSE_ROLLING))
        return refuse(x, k, BOTH_JUMP, 0);
    const int free = of_place && found == PK_IMPULSE_ENERGY;
    int done = leave(x, direction, free);
    if (done == 0) {
        memcpy(e->sides, given, e->n_switches * sizeof *given);
        done = leave(x, -direction, 1);
        if (done == 1 && speed(x) * direction > 0)
            done = 0;
    } else if (done == 1 && of_place && !(speed(x) * direction > 0)) {
        return refuse(x, k, TURNS, 0);
    }
    if (done != 1)
        return refuse(x, k, NEITHER, 0);
    memcpy(x->start, x->v, w->n * sizeof *x->v);
    return PK_DONE;
}

enum pk_status pk_impulse(struct pk_events *e, struct pk_integrator *it, const size_t *which,
                          const pk_real *side, size_t count)
{
    struct corner x = corner_of(e, it);
    const size_t bytes = e->n * sizeof *x.first;
    enum pk_status status = PK_DONE;
    x.w.u = pk_eval_input(it, e->t);
    memcpy(x.first, x.start, bytes);
    memcpy(x.sides, e->sides, e->n_switches * sizeof *x.sides);
    for (size_t i = 0; i < count && count > 1 && status >= 0; i++)
        status = one(&x, which[count - 1 - i], side[count - 1 - i]);
    if (count > 1) { /* once more in the other order */
        memcpy(x.first + e->n, x.start, bytes);
        memcpy(x.start, x.first, bytes);
        memcpy(e->sides, x.sides, e->n_switches * sizeof *x.sides);
    }
    for (size_t i = 0; i < count && status >= 0; i++)
        status = one(&x, which[i], side[i]);
    pk_real apart = 0, size = 0;
    for (size_t i = 0; count > 1 && i < x.w.m; i++) {
        apart = pk_max(apart, pk_abs(x.start[i] - x.first[e->n + i]));
        size = pk_max(size, pk_abs(x.start[i]));
    }
    if (status >= 0 && apart > AGREE * size)
        status = refuse(&x, which[0], ORDER, which[1]);
    if (status < 0)
        memcpy(x.start, x.first, bytes);
    return status;
}

int pk_impulse_reason(const struct pk_integrator *it, char *text, size_t size)
{
    const struct pk_system *system = it->problem.system;
    const char *name = it->where < system->n_switches ? system->switches[it->where].name : "x";
    const size_t row = (size_t)it->condition;
    char other[128] = "";
    if (it->detail <= (pk_real)ROLLING)
        pk_constraint_name(system, row, other, sizeof other);
    else if (it->detail >= (pk_real)ORDER && it->detail <= (pk_real)ORDER)
        snprintf(other, sizeof other, "%s",
                 row < system->n_switches ? system->switches[row].name : "x");
    static const char *const why[] = {
        [POSITION] = "the constraint %s jumps where %s vanishes: no motion follows it",
        [ROLLING] = "what multiplies the rates in %s jumps where %s vanishes: what follows depends "
                    "on how",
        [BOTH_JUMP] = "%.0sa rolling and the energy both jump where %s vanishes: what follows "
                      "depends on how",
        [TURNS] = "%.0sthe impulse where %s vanishes turns the motion back, into the side that has "
                  "none: it would have to stay there",
        [ORDER] = "%s and %s vanish at once, and what follows depends on which does first",
        [NEITHER] = "%.0sno rates are found with which the motion leaves %s = 0",
    };
    const int used = snprintf(text, size, why[(int)it->detail], other, name);
    const size_t at = used > 0 && (size_t)used < size ? (size_t)used : size;
    return used + snprintf(at < size ? text + at : NULL, size - at, "; last valid time %.17g", (double)it->t);
}

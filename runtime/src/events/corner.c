/* The impulse at a switch s(q, t) = 0 across which L or a constraint jumps: the corner condition of
 * Weierstrass and Erdmann. Before the switch, momenta are p- and the energy is h-. After it, rates
 * are v+, with an impulse alpha along the gradient s_q, and impulses Lambda along the constraint
 * rows J v + j0 = 0 of the new side:
 *
 *     p(v+) = p- + alpha s_q + J^T Lambda,   J v+ + j0 = 0,
 *     E = h(v+) - h- + alpha s_t + Lambda.j0 = 0.
 *
 * For v(alpha), dE/dalpha is s', the rate of s, which grows with alpha, since M is definite. So E
 * is convex: at one of its two roots the motion goes on, at the other it goes back. Without roots
 * the switch is a barrier: the same equations on the old side have another root, at which the
 * motion goes back. A switch s(t) has alpha = 0 and does not conserve energy. Nor does one across
 * which j0 of a rolling row jumps, since its force acts along its row alone.
 *
 * References: I. M. Gelfand, S. V. Fomin, Calculus of Variations, section 15; B. Brogliato,
 * Nonsmooth Mechanics, 3rd ed., chapters 1 and 3. */

#include <pk/constraint.h>

#include "corner.h"

enum { MOST = 60 }; /* corrections */

static size_t lay_out(struct corner *x, const struct pk_system *system, size_t n, pk_real **w,
                      pk_real *base)
{
    const size_t c = system->constraints.n, k = system->switches.n;
    const struct pk_problem problem = {.system = system}; /* families have no impulses */
    /* clang-format off */
    const struct pk_slot slots[] = {
        {w, pk_project_room(&problem, n)}, {&x->p0, n}, {&x->p, 2 * n}, {&x->v, n}, {&x->along, n},
        {&x->first, 2 * n}, {&x->lambda, c}, {&x->by, c}, {&x->phi, c}, {&x->J, c * n},
        {&x->before, 2 * k}, {&x->sides, 2 * k}, {&x->slopes, (n + 1) * k}};
    /* clang-format on */
    return PK_LAY_OUT(base, slots);
}

size_t pk_impulse_size(const struct pk_system *system, size_t n)
{
    struct corner x;
    pk_real *w;
    return system->switches.impulses ? lay_out(&x, system, n, &w, NULL) : 0;
}

struct corner pk_corner_of(struct pk_events *e, struct pk_integrator *it)
{
    struct corner x = {.e = e, .it = it, .q = e->trial, .start = e->trial_v};
    pk_real *w;
    lay_out(&x, it->problem.system, e->n, &w, e->room);
    x.w = pk_project_parts(&it->problem, e->n, w);
    x.w.t = e->t;
    return x;
}

void pk_corner_momenta(struct corner *x, const pk_real *v)
{
    x->w.system->unconstrained(x->w.params, x->w.t, x->q, v, x->w.u, x->p, x->p + x->w.n);
}

pk_real pk_corner_energy(const struct corner *x, const pk_real *v)
{
    return x->w.system->energy(x->w.params, x->w.t, x->q, v, x->w.u);
}

void pk_corner_rows(struct corner *x, const pk_real *v)
{
    if (x->w.c)
        pk_project_rows(&x->w, x->q, v);
}

/* Replaces the force d by the change of rates M^-1 (d + J^T mu) that it causes; mu is such that J
 * times this change is -rate. M and J are taken at the rates v. Returns -1 if one is singular. */
static int solve(struct corner *x, const pk_real *v, pk_real *d, const pk_real *rate, pk_real *mu)
{
    struct pk_projection *w = &x->w;
    if (pk_project_inertia(w, x->q, v) || pk_project_factor(w, w->c, x->q, v))
        return -1;
    pk_ldl_solve(w->M, w->m, d);
    for (size_t j = 0; j < w->c; j++)
        mu[j] = -(rate ? rate[j] : 0) - pk_dot(w->J + j * w->n, d, w->m);
    pk_ldl_solve(w->A, w->c, mu);
    for (size_t j = 0; j < w->c; j++)
        pk_add(d, mu[j], w->W + j * w->m, w->m);
    return 0;
}

/* Solves for the rates v(alpha) on the current side of the switch by Newton's method, starting from
 * x->v and x->lambda, and for the derivative of v by alpha. */
static int rates(struct corner *x, pk_real alpha)
{
    struct pk_projection *w = &x->w;
    pk_real before = 0, part = 1, *d = x->along;
    for (int count = 0; count < MOST; count++) {
        pk_corner_momenta(x, x->v);
        /* the correction d has left the domain of L: undoes part of it */
        if (count && !pk_all_finite(x->p, w->m)) {
            part /= 2;
            pk_add(x->v, -part, d, w->m);
            pk_add(x->lambda, -part, x->by, w->c);
            continue;
        }
        part = 1;
        pk_corner_rows(x, x->v);
        for (size_t i = 0; i < w->m; i++)
            d[i] = x->p0[i] - x->p[i] + alpha * x->slope[i];
        for (size_t j = 0; j < w->c; j++)
            pk_add(d, x->lambda[j], w->J + j * w->n, w->m);
        if (solve(x, x->v, d, w->rate, x->by) < 0)
            return -1;
        pk_add(x->lambda, 1, x->by, w->c);
        pk_add(x->v, 1, d, w->m);
        const pk_real change = pk_largest(d, w->m), size = pk_largest(x->v, w->m);
        if (!pk_all_finite(x->v, w->m))
            return -1;
        if (change <= PK_EPS * size ||
            (count > 1 && change >= before / 2 && change <= PK_CORNER_WHOLE * size)) {
            pk_corner_rows(x, x->v);
            pk_copy(d, x->slope, w->m);
            return solve(x, x->v, d, NULL, x->by);
        }
        before = change;
    }
    return -1;
}

static pk_real excess(const struct corner *x, pk_real alpha)
{
    const struct pk_projection *w = &x->w;
    pk_real sum = pk_corner_energy(x, x->v) - x->h0 + alpha * x->slope_t;
    for (size_t j = 0; j < w->c; j++)
        sum += x->lambda[j] * (w->rate[j] - pk_dot(w->J + j * w->n, x->v, w->m));
    return sum;
}

pk_real pk_corner_speed(const struct corner *x)
{
    return pk_dot(x->slope, x->v, x->w.m) + x->slope_t;
}

int pk_corner_leave(struct corner *x, pk_real direction, int free)
{
    struct pk_projection *w = &x->w;
    pk_real alpha = 0, before = 0, first = 0;
    int lowest = 0;
    pk_copy(x->v, x->start, w->n);
    pk_zero(x->lambda, w->c);
    for (int count = 0; count < MOST; count++) {
        if (rates(x, alpha) < 0)
            return -1;
        const pk_real s = pk_corner_speed(x), bend = pk_dot(x->slope, x->along, w->m);
        if (!free)
            return 1;
        if (count == 0) { /* tests whether s_q is outside the span of the rows */
            pk_copy(w->d, x->slope, w->m);
            pk_ldl_solve(w->M, w->m, w->d);
            first = pk_abs(s);
            if (!(bend > PK_CORNER_ALONG * pk_dot(x->slope, w->d, w->m)))
                return 1;
        }
        const pk_real E = excess(x, alpha), root = s * s - 2 * bend * E;
        if (lowest && root < 0 && pk_abs(s) <= PK_CORNER_WHOLE * first)
            return 0;
        lowest = root < 0;
        const pk_real by = lowest ? 0 : direction * PK_F(sqrt)(root);
        const pk_real step = !lowest && by * s > 0 ? -2 * E / (s + by) : (by - s) / bend;
        if (!pk_finite(step))
            return -1;
        if (!lowest && count && by * s > 0 &&
            (pk_abs(step) <= PK_EPS * pk_abs(alpha) ||
             (count > 1 && pk_abs(step) >= before / 2 &&
              pk_abs(step) <= PK_CORNER_WHOLE * pk_abs(alpha))))
            return 1;
        if (!lowest && !(pk_abs(step) > 0))
            return 1;
        alpha += step;
        before = pk_abs(step);
    }
    return -1;
}

/* The absolute tolerance of each coordinate and rate. Given, it is one for all. Else it is rtol
 * times the scale that the motion has shown: the largest value so far, since a motion of picometres
 * is as much of one as that of metres. Of those of one unit none counts as smaller than a millionth
 * of the largest, so that what has hardly begun to move, as the far end of a chain, does not hold
 * up the rest.
 *
 * What is nothing but rounding has no scale: its digits are noise, and steps that followed them
 * would shrink for nothing. What rounding of the state does to the accelerations is measured, by a
 * change of each number by some units in its last place; errors as large as that over the step that
 * is tried are none.
 */
#include <string.h>

#include "project.h"

#define SHARE PK_C(1e-6)
#define ROUNDING (8 * PK_EPS)
#define ASIDE PK_F(sqrt)(PK_EPS)
#define LEAST (PK_C(1e4) * PK_EPS) /* of t: a first step */
#define LONGER PK_C(4.0)
enum {
    OFTEN = 64, /* steps between two looks at rounding, or fewer once they are so much longer */
    SAMPLES = 4 /* of it: of many coordinates one alone would find some that it hardly moves */
};

/* 2 n each: tolerances, these without rounding, largest values, whose unit is shared, a state; n
 * each: what rounding does to accelerations, an acceleration, what rounding of momenta does to
 * rates, accelerations beside, two and their noise; and a mass matrix. */
enum { ATOL = 0, OWN = 2, MOST = 4, GROUP = 6, MOVED = 8, NOISE = 10, A, BY_P, BESIDE, PARTS = 16 };

size_t pk_scale_size(const struct pk_method *method, size_t n)
{
    const size_t matrix = method->traits & PK_JACOBIANS ? n * n : 0;
    return method->traits & PK_ADAPTIVE ? PARTS * n + matrix : 0;
}

static pk_real *part(const struct pk_integrator *it, int which)
{
    return it->own->atol + (size_t)which * it->n;
}

/* The first of the same unit, of a table with an entry a declared name; what stands behind these
 * names, the columns of variational equations, is for itself. */
static void group(const struct pk_integrator *it, const struct pk_quantity *table, size_t base,
                  pk_real *to)
{
    const struct pk_system *system = it->problem.system;
    const size_t declared = system->families.n_coordinates ? system->families.n_coordinates
                                                           : system->n;
    for (size_t k = 0; !table && k < it->n; k++)
        to[k] = (pk_real)base;
    size_t first = 0, i = 0;
    for (size_t k = 0; table && k < declared && i < it->n; k++) {
        const size_t members =
            pk_system_range(system, it->problem.params, PK_OF_COORDINATE, k).count;
        first = 0;
        for (size_t j = 0; j < k && strcmp(table[j].unit, table[k].unit) != 0; j++)
            first += pk_system_range(system, it->problem.params, PK_OF_COORDINATE, j).count;
        for (size_t m = 0; m < members && i < it->n; m++)
            to[i++] = (pk_real)(base + first);
    }
    const size_t names = i;
    for (; table && i < it->n; i++)
        to[i] = to[i - names] + (pk_real)names;
}

static void note(const struct pk_integrator *it)
{
    pk_real *most = part(it, MOST);
    for (size_t i = 0; i < 2 * it->n; i++)
        most[i] = pk_max(most[i], pk_abs(it->own->state[i]));
}

static void follow(const struct pk_integrator *it)
{
    const size_t n = it->n;
    const pk_real *most = part(it, MOST), *of = part(it, GROUP);
    pk_real *own = part(it, OWN), *all = part(it, MOVED);
    memset(all, 0, 2 * n * sizeof *all);
    for (size_t i = 0; i < 2 * n; i++)
        all[(size_t)of[i]] = pk_max(all[(size_t)of[i]], most[i]);
    for (size_t i = 0; i < 2 * n; i++)
        own[i] = it->options.rtol * pk_max(most[i], SHARE * all[(size_t)of[i]]) +
                 PK_F(sqrt)(PK_TINY);
}

void pk_scale_attempt(const struct pk_integrator *it, pk_real h)
{
    const size_t n = it->n;
    if (!it->own->atol || it->options.atol >= 0)
        return;
    const pk_real *own = part(it, OWN), *noise = part(it, NOISE), *by_p = part(it, BY_P);
    h = pk_abs(h);
    for (size_t i = 0; i < n; i++) {
        const pk_real of_v = h * noise[i] + by_p[i];
        it->own->atol[i] = own[i] + h * of_v;
        it->own->atol[n + i] = own[n + i] + of_v;
    }
    /* As rates move coordinates, body rates turn quaternions. */
    const struct pk_system *system = it->problem.system;
    for (size_t r = 0; r < pk_system_rotations(system, it->problem.params); r++) {
        const struct pk_turning at = pk_system_turning(system, it->problem.params, r);
        pk_real of_rate = 0;
        for (size_t k = 0, i = at.rate; k < 3; k++, i += at.step)
            of_rate = pk_max(of_rate, h * noise[i] + by_p[i]);
        for (size_t k = 0, i = n + at.number; k < 4; k++, i += at.step)
            it->own->atol[i] += h * of_rate / 2;
    }
}

static int acceleration(struct pk_integrator *it, pk_real t, const pk_real *q, pk_real *a)
{
    const struct pk_system *system = it->problem.system;
    const pk_real *u = pk_eval_input(it, t);
    it->count.evaluations++;
    return !system->acceleration(it->problem.params, t, q, q + it->n, u, a) &&
           pk_all_finite(a, it->n);
}

/* Methods in p solve M_ii v_i = p_i - (other terms), so v_i has the rounding of these. What
 * constraints hold does not move by itself; its error there is rtol of the terms. */
static void look_at_momenta(struct pk_integrator *it)
{
    const struct pk_system *system = it->problem.system;
    const size_t n = it->n;
    const pk_real share = system->constraints.n ? it->options.rtol : ROUNDING;
    pk_real *M = part(it, PARTS), *by_p = part(it, BY_P);
    if (!(it->method->traits & PK_JACOBIANS) || !(system->inertia ? system->inertia : system->mass))
        return;
    memset(M, 0, n * n * sizeof *M);
    (system->inertia ? system->inertia : system->mass)(it->problem.params, it->t, it->q, it->v,
                                                       pk_eval_input(it, it->t), M);
    for (size_t i = 0; i < n; i++) {
        pk_real sum = 0;
        for (size_t j = 0; j < n; j++)
            sum += pk_abs(M[i * n + j] * it->v[j]);
        by_p[i] = M[i * n + i] > 0 && pk_finite(sum) ? share * sum / M[i * n + i] : 0;
    }
}

/* Each number of a state by its `share` up or down. */
static void shake(const struct pk_integrator *it, pk_real share, unsigned long random,
                  pk_real *state)
{
    for (size_t i = 0; i < 2 * it->n; i++) {
        random = (random * 1103515245ul + 12345ul) & 0x7ffffffful;
        state[i] *= 1 + (random & 0x40000000ul ? share : -share);
    }
}

/* The acceleration at a state `aside` of this one, and the most that rounding makes of it; 0 where
 * there is none. */
static int noise_at(struct pk_integrator *it, pk_real aside, pk_real *a, pk_real *noise)
{
    const size_t n = it->n;
    pk_real *moved = part(it, MOVED), *other = part(it, BESIDE);
    memset(noise, 0, n * sizeof *noise);
    for (int k = 0; k <= SAMPLES; k++) {
        memcpy(moved, it->own->state, 2 * n * sizeof *moved);
        shake(it, aside, 54321, moved);
        shake(it, k ? ROUNDING : 0, 12345ul * (unsigned long)k, moved);
        const pk_real t = it->t * (1 + aside) * (1 + (k ? ROUNDING : 0));
        if (!acceleration(it, t, moved, k ? other : a))
            return 0;
        for (size_t i = 0; i < n && k; i++)
            noise[i] = pk_max(noise[i], pk_abs(other[i] - a[i]));
    }
    return 1;
}

/* What constraints hold in place has forces that cancel, and may be exactly where shaking moves
 * nothing: a is no better than the terms (M^-1 J^T)_ki lambda_i. */
static void look_at_rows(struct pk_integrator *it)
{
    const struct pk_system *system = it->problem.system;
    if (!system->constraints.multipliers || !it->own->project)
        return;
    struct pk_projection w = pk_project_parts(&it->problem, it->n, it->own->project);
    pk_real *noise = part(it, NOISE), *lambda = part(it, BESIDE);
    w.t = it->t;
    w.u = pk_eval_input(it, it->t);
    if (!w.whole || pk_project_inertia(&w, it->q, it->v))
        return;
    pk_project_rows(&w, it->q, it->v);
    if (pk_project_factor(&w, w.c, it->q, it->v))
        return;
    system->constraints.multipliers(w.params, w.t, it->q, it->v, w.u, lambda);
    for (size_t k = 0; k < w.m; k++) {
        pk_real sum = 0;
        for (size_t i = 0; i < w.c; i++)
            sum += pk_abs(w.W[i * w.m + k] * lambda[i]);
        noise[k] = pk_finite(sum) ? pk_max(noise[k], ROUNDING * sum) : noise[k];
    }
}

/* Takes the smaller noise of two nearby states: where a force sets in like sqrt(x), rounding is
 * amplified, but only for much less than a step. */
static void look_at_rounding(struct pk_integrator *it)
{
    const size_t n = it->n;
    pk_real *noise = part(it, NOISE), *beside = part(it, BESIDE) + n, *other = beside + n;
    const int valid = noise_at(it, 0, part(it, A), noise) && noise_at(it, ASIDE, beside, other);
    for (size_t i = 0; i < n; i++)
        noise[i] = valid ? pk_min(noise[i], other[i]) : 0;
    look_at_rows(it);
    look_at_momenta(it);
}

/* The shortest time in which a coordinate moves by its own scale; 0: unknown. */
static pk_real while_it_falls(const struct pk_integrator *it)
{
    const pk_real *most = part(it, MOST), *noise = part(it, NOISE), *a = part(it, A);
    pk_real h = 0;
    for (size_t i = 0; i < it->n; i++) {
        const pk_real v = most[it->n + i], size = pk_abs(a[i]);
        const pk_real x = v > 0 ? v / size : PK_F(sqrt)(most[i] / size);
        if (size > noise[i] && x > 0 && pk_finite(x) && !(h > 0 && h < x))
            h = x;
    }
    return h;
}

/* A coordinate at zero gets as its scale the way it goes in the least first step. A rate at rest
 * gets the speed of a fall through the coordinate's scale. */
void pk_scale_start(struct pk_integrator *it)
{
    const size_t n = it->n;
    if (!it->own->atol)
        return;
    if (it->options.atol >= 0) {
        for (size_t i = 0; i < 2 * n; i++)
            it->own->atol[i] = it->options.atol;
        return;
    }
    if (!(*part(it, GROUP + 1) > 0)) {
        group(it, it->problem.system->coordinates, 0, part(it, GROUP));
        group(it, it->problem.system->rates, n, part(it, GROUP + 1));
    }
    note(it);
    look_at_rounding(it);
    follow(it);
    const pk_real *a = part(it, A), ahead = LEAST * pk_abs(it->t), first = while_it_falls(it);
    pk_real *own = part(it, OWN), *fall = part(it, MOVED) + n;
    const pk_real *of = part(it, GROUP + 1);
    for (size_t i = 0; i < n; i++)
        own[i] = pk_max(own[i], it->options.rtol * ahead * pk_abs(it->v[i]));
    pk_scale_attempt(it, first);
    for (size_t i = 0; i < n && it->count.steps == 0; i++) {
        const pk_real x = PK_F(sqrt)(it->options.rtol * pk_abs(a[i]) * it->own->atol[i]);
        pk_real *shared = fall + ((size_t)of[i] - n);
        if (pk_finite(x))
            own[n + i] = pk_max(own[n + i], x);
        *shared = i == (size_t)of[i] - n ? own[n + i] : pk_max(*shared, own[n + i]);
    }
    for (size_t i = 0; i < n && it->count.steps == 0; i++)
        own[n + i] = pk_max(own[n + i], SHARE * fall[(size_t)of[i] - n]);
    pk_scale_attempt(it, first);
}

/* A time from rest in which accelerations change by at most the largest: part of an oscillation. */
static pk_real push(struct pk_integrator *it, pk_real t, pk_real d)
{
    const size_t n = it->n;
    pk_real *moved = part(it, MOVED), *a = part(it, A), *other = part(it, NOISE);
    pk_real most = 0, change = 1;
    for (size_t i = 0; i < n; i++)
        most = pk_max(most, pk_abs(a[i]));
    for (int count = 0; count < 500 && !(change <= most); count++, d /= 2) {
        for (size_t i = 0; i < n; i++) {
            moved[i] = it->q[i] + a[i] * d * d / 2;
            moved[n + i] = it->v[i] + a[i] * d;
        }
        change = acceleration(it, t, moved, other) ? 0 : PK_INFINITY;
        for (size_t i = 0; i < n; i++)
            change = pk_max(change, pk_abs(other[i] - a[i]));
    }
    memset(other, 0, n * sizeof *other);
    return d;
}

int pk_scale_raise(struct pk_integrator *it, pk_real h)
{
    const size_t n = it->n;
    const pk_real *a = part(it, A);
    pk_real *most = part(it, MOST);
    int raised = 0;
    if (!it->own->atol || it->options.atol >= 0 ||
        !acceleration(it, it->t + h, it->own->state, part(it, A)))
        return 0;
    const pk_real d = push(it, it->t + h, pk_abs(h));
    for (size_t i = 0; i < n; i++) {
        if (most[i] > 0 || most[n + i] > 0 || !(pk_abs(a[i]) * d * d > 0))
            continue;
        most[i] = pk_abs(a[i]) * d * d;
        most[n + i] = pk_abs(a[i]) * d;
        raised = 1;
    }
    follow(it);
    return raised;
}

/* What a place that is nearly singular made of rounding counts by the length of steps: where these
 * grow again it would be held for an error of many digits. */
static int outdated(const struct pk_integrator *it)
{
    const pk_real h = pk_abs(it->own->h), *own = part(it, OWN), *noise = part(it, NOISE);
    int counts = 0;
    for (size_t i = 0; i < it->n; i++)
        counts |= h * noise[i] > own[it->n + i];
    return counts && h > LONGER * it->own->looked;
}

void pk_scale_step(struct pk_integrator *it)
{
    if (!it->own->atol || it->options.atol >= 0)
        return;
    note(it);
    if (it->count.rejections - it->own->rounded > 1 || it->count.steps % OFTEN == 0 ||
        outdated(it)) {
        look_at_rounding(it);
        it->own->looked = pk_abs(it->own->h);
    }
    it->own->rounded = it->count.rejections;
    follow(it);
}

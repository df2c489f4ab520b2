/* The absolute tolerances of coordinates and rates. A given tolerance applies to all numbers.
 * Otherwise it is rtol times the scale of each number, its largest value so far, so that a motion
 * of picometres is resolved as well as a motion of metres. Among numbers of one unit, no scale is
 * less than a millionth of the largest scale, so that numbers that have hardly begun to move, such
 * as the far end of a chain, do not shorten the steps.
 *
 * If a number is as small as its rounding error, its digits are noise, and step control must not
 * follow them. The effect of rounding of the state on accelerations is measured by changing each
 * number by units in its last place (rounding.c); such errors in the trial step are tolerated. */
#include <string.h>

#include "band.h"
#include "scale.h"

#define SHARE PK_C(1e-6)
/* shortest time, relative to t, over which the distance moved defines a scale */
#define LEAST (PK_C(1e4) * PK_EPS)
#define LONGER PK_C(4.0)
#define LEAST_SCALE PK_F(sqrt)(PK_TINY) /* least scale of a number */
enum { OFTEN = 64 };                    /* number of steps between two measurements of rounding */

size_t pk_scale_size(const struct pk_problem *problem, const struct pk_method *method, size_t n_q,
                     size_t n)
{
    const struct pk_pattern p = pk_system_pattern(problem->system, problem->params);
    const size_t banded = pk_pattern_numbers(&p) + 3 * (p.rows + p.border);
    const size_t matrix = method->traits & PK_JACOBIANS ? (p.dense ? n * n : banded) : 0;
    return method->traits & PK_ADAPTIVE ? parts_before(n_q, n, PARTS) + matrix : 0;
}

/* Returns the index of number i of copy c in the vector of a variational system, which has `copies`
 * copies of a vector of length `one`. The first `moving` numbers of every copy (rates of
 * coordinates) come before the rest of all copies. */
static size_t place(size_t i, size_t c, size_t moving, size_t one, size_t copies)
{
    return i < moving ? c * moving + i : copies * moving + c * (one - moving) + i - moving;
}

/* Writes for each of `count` numbers the index of the first number of the same unit; `table` has
 * one entry for each declared name. Copies in variational equations are apart. */
static void group(const struct pk_integrator *it, const struct pk_quantity *table, size_t count,
                  size_t base, pk_real *to)
{
    const struct pk_system *system = it->problem.system;
    const size_t declared = system->families.n_coordinates ? system->families.n_coordinates
                                                           : system->n;
    size_t names = 0, first = 0, i = 0;
    for (size_t k = 0; !table && k < count; k++)
        to[k] = (pk_real)base;
    for (size_t k = 0; k < declared; k++)
        names += pk_system_range(system, it->problem.params, PK_OF_COORDINATE, k).count;
    const size_t copies = it->n / names, one = count / copies, moving = it->n_q / copies;
    for (size_t k = 0; table && k < declared && i < one; k++) {
        const size_t members =
            pk_system_range(system, it->problem.params, PK_OF_COORDINATE, k).count;
        first = 0;
        for (size_t j = 0; j < k && strcmp(table[j].unit, table[k].unit) != 0; j++)
            first += pk_system_range(system, it->problem.params, PK_OF_COORDINATE, j).count;
        for (size_t m = 0; m < members && i < one; m++, i++)
            for (size_t c = 0; c < copies; c++) {
                const size_t at = place(i, c, moving, one, copies);
                to[at] = (pk_real)(base + place(first, c, moving, one, copies));
            }
    }
}

static void note(const struct pk_integrator *it)
{
    pk_real *most = part(it, MOST);
    for (size_t i = 0; i < it->n_q + it->n; i++)
        most[i] = pk_max(most[i], pk_abs(it->own->state[i]));
}

static void follow(const struct pk_integrator *it)
{
    const size_t m = it->n_q + it->n;
    const pk_real *most = part(it, MOST), *of = part(it, GROUP);
    pk_real *own = part(it, OWN), *all = part(it, MOVED);
    pk_zero(all, m);
    for (size_t i = 0; i < m; i++)
        all[pk_index(of[i], m)] = pk_max(all[pk_index(of[i], m)], most[i]);
    for (size_t i = 0; i < m; i++)
        own[i] = it->options.rtol * pk_max(most[i], SHARE * all[pk_index(of[i], m)]) + LEAST_SCALE;
}

void pk_scale_attempt(const struct pk_integrator *it, pk_real h)
{
    const size_t n_q = it->n_q, n = it->n;
    if (!it->own->atol || it->options.atol >= 0)
        return;
    const pk_real *own = part(it, OWN), *noise = part(it, NOISE), *by_p = part(it, BY_P);
    h = pk_abs(h);
    for (size_t i = 0; i < n; i++) {
        const pk_real of_v = h * noise[i] + by_p[i];
        if (i < n_q)
            it->own->atol[i] = own[i] + h * of_v;
        it->own->atol[n_q + i] = own[n_q + i] + of_v;
    }
    /* Body rates move quaternions in the way that rates move coordinates. */
    const struct pk_system *system = it->problem.system;
    for (size_t r = 0; r < pk_system_rotations(system, it->problem.params); r++) {
        const struct pk_turning at = pk_system_turning(system, it->problem.params, r);
        pk_real of_rate = 0;
        for (size_t k = 0, i = at.rate; k < 3; k++, i += at.step)
            of_rate = pk_max(of_rate, h * noise[i] + by_p[i]);
        for (size_t k = 0, i = n_q + at.number; k < 4; k++, i += at.step)
            it->own->atol[i] += h * of_rate / 2;
    }
}
/* Returns the shortest time in which an acceleration changes a coordinate from rest, or a rate, by
 * as much as its scale; 0: unknown. */
static pk_real while_it_falls(const struct pk_integrator *it)
{
    const pk_real *most = part(it, MOST), *noise = part(it, NOISE), *a = part(it, A);
    pk_real h = 0;
    for (size_t i = 0; i < it->n; i++) {
        const pk_real v = most[it->n_q + i], size = pk_abs(a[i]);
        const pk_real x = v > 0 ? v / size : i < it->n_q ? PK_F(sqrt)(most[i] / size) : 0;
        if (size > noise[i] && x > 0 && pk_finite(x) && !(h > 0 && h < x))
            h = x;
    }
    return h;
}

/* Initialises tolerances. The scale of a coordinate that is zero is the distance that it moves in
 * the shortest first step. The scale of a rate that is zero is the speed that its acceleration
 * gives it over the scale of its coordinate. A first-order variable that is zero gets no scale
 * from its own rate, and does not shorten the first step. */
void pk_scale_start(struct pk_integrator *it)
{
    const size_t n_q = it->n_q, n = it->n;
    if (!it->own->atol)
        return;
    if (it->options.atol >= 0) {
        for (size_t i = 0; i < n_q + n; i++)
            it->own->atol[i] = it->options.atol;
        return;
    }
    const pk_real *of = part(it, GROUP) + n_q;
    if (!(*of > 0)) {
        group(it, it->problem.system->coordinates, n_q, 0, part(it, GROUP));
        group(it, it->problem.system->rates, n, n_q, part(it, GROUP) + n_q);
    }
    note(it);
    pk_scale_look(it);
    follow(it);
    const pk_real *a = part(it, A), ahead = LEAST * pk_abs(it->t), first = while_it_falls(it);
    pk_real *own = part(it, OWN), *fall = part(it, MOVED) + n_q;
    for (size_t i = 0; i < n_q; i++)
        own[i] = pk_max(own[i], it->options.rtol * ahead * pk_abs(it->v[i]));
    pk_scale_attempt(it, first);
    for (size_t i = 0; i < n && it->count.steps == 0; i++) {
        const pk_real through = i < n_q ? it->own->atol[i] : 0;
        const pk_real x = PK_F(sqrt)(it->options.rtol * pk_abs(a[i]) * through);
        const size_t shared = pk_index(of[i] - (pk_real)n_q, n);
        if (pk_finite(x))
            own[n_q + i] = pk_max(own[n_q + i], x);
        fall[shared] = i == shared ? own[n_q + i] : pk_max(fall[shared], own[n_q + i]);
    }
    for (size_t i = 0; i < n && it->count.steps == 0; i++)
        own[n_q + i] = pk_max(own[n_q + i], SHARE * fall[pk_index(of[i] - (pk_real)n_q, n)]);
    pk_scale_attempt(it, first);
}

/* Forgets the largest values of all numbers, since they may come from a step that is undone. */
void pk_scale_forget(struct pk_integrator *it)
{
    if (it->own->atol)
        pk_zero(part(it, MOST), it->n_q + it->n);
}

/* Returns a time d, at most the given one, such that in a motion from rest over d no acceleration
 * changes by more than the largest acceleration. */
static pk_real push(struct pk_integrator *it, pk_real t, pk_real d)
{
    const size_t n = it->n;
    pk_real *moved = part(it, MOVED), *a = part(it, A), *other = part(it, NOISE);
    const pk_real most = pk_largest(a, n);
    pk_real change = 1;
    for (int count = 0; count < 500 && !(change <= most); count++, d /= 2) {
        for (size_t i = 0; i < it->n_q; i++)
            moved[i] = it->q[i] + a[i] * d * d / 2;
        for (size_t i = 0; i < n; i++)
            moved[it->n_q + i] = it->v[i] + a[i] * d;
        change = pk_scale_acceleration(it, t, moved, other) ? 0 : PK_INFINITY;
        for (size_t i = 0; i < n; i++)
            change = pk_max(change, pk_abs(other[i] - a[i]));
    }
    pk_zero(other, n);
    return d;
}

int pk_scale_raise(struct pk_integrator *it, pk_real h)
{
    const size_t n_q = it->n_q;
    const pk_real *a = part(it, A);
    pk_real *most = part(it, MOST);
    int raised = 0;
    if (!it->own->atol || it->options.atol >= 0 ||
        !pk_scale_acceleration(it, it->t + h, it->own->state, part(it, A)))
        return 0;
    const pk_real d = push(it, it->t + h, pk_abs(h));
    for (size_t i = 0; i < it->n; i++) {
        const int moves = i < n_q && most[i] > 0;
        if (moves || most[n_q + i] > 0 || !(pk_abs(a[i]) * d * d > 0))
            continue;
        if (i < n_q)
            most[i] = pk_abs(a[i]) * d * d;
        most[n_q + i] = pk_abs(a[i]) * d;
        raised = 1;
    }
    follow(it);
    return raised;
}

/* Returns whether the last measurement of rounding is outdated. Near a singular position its
 * tolerance, proportional to the step size, may have grown so much that it hides large errors. */
static int outdated(const struct pk_integrator *it)
{
    const pk_real h = pk_abs(it->own->h), *own = part(it, OWN), *noise = part(it, NOISE);
    int counts = 0;
    for (size_t i = 0; i < it->n; i++)
        counts |= h * noise[i] > own[it->n_q + i];
    return counts && h > LONGER * it->own->progress.rounded_step;
}

void pk_scale_step(struct pk_integrator *it)
{
    if (!it->own->atol || it->options.atol >= 0)
        return;
    note(it);
    if (it->count.rejections - it->own->progress.rounded_rejections > 1 ||
        it->count.steps % OFTEN == 0 || outdated(it)) {
        pk_scale_look(it);
        it->own->progress.rounded_step = pk_abs(it->own->h);
    }
    it->own->progress.rounded_rejections = it->count.rejections;
    follow(it);
}

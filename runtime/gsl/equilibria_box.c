/* The box in which equilibria are sought, and the scale of each equation. Both are taken from the
 * motion and the equations, so that they do not depend on the units. */
#include <stdlib.h>
#include <string.h>

#include <pk/methods.h>

#include "equilibria_search.h"
#include "halton.h"

static const double RUNAWAY = 100, NOTHING = 1e-200;
enum { MOTION = 48, SETTLING = 100 };

void pk_equilibria_normalise(struct search *s)
{
    for (size_t r = 0; r < s->problem->system->n_rotations; r++) {
        double *Q = s->v + quaternions(s) + 4 * r;
        const double size = hypot(hypot(Q[0], Q[1]), hypot(Q[2], Q[3]));
        for (size_t i = 0; i < 4; i++)
            Q[i] /= size;
    }
}

/* Point 0 is the middle of the box. Half of the other points k lie in the box, a quarter in a box 4
 * times as wide and a quarter in one 32 times as wide; k % 4 chooses the box. Angles always lie in
 * the box. The bases of Halton's sequence begin at 3, since base 2 correlates with k % 4. */
void pk_equilibria_place(struct search *s, size_t k)
{
    static const double widths[] = {32, 1, 4, 1};
    for (size_t i = 0; i < s->n; i++) {
        const double wide = s->turns[i] && !is_by_rate(s, i) ? 1 : widths[k % 4];
        const double x = k ? 2 * halton(k, s->primes[i + 1]) - 1 : 0;
        *unknown(s, i) = is_body_rate(s, i) ? 0 : s->middle[i] + wide * s->box[i] * x;
    }
    for (size_t i = quaternions(s); k && i < quaternions(s) + 4 * s->problem->system->n_rotations;
         i++)
        /* The initial quaternion is removed, so that points have any orientation. */
        s->v[i] -= s->middle[i];
    pk_equilibria_normalise(s);
}

/* Returns whether q_i is an angle, so that q_i and q_i + 2 pi are the same position. Compares all
 * momenta and forces at these two values, for three states. The tolerance of each number is
 * relative to its own size, since sizes may differ by orders of magnitude. */
static int is_turn(struct search *s, size_t i)
{
    /* for each number compared: its largest size and largest change by the turn */
    double *size = s->p_q, *change = s->F_q, *copy = s->M;
    const size_t n = s->n;
    const struct {
        const double *of;
        size_t count;
        /* the numbers compared: p and pdot, or the residuals F if is_bound() */
    } parts[] = {{s->p, n}, {s->pdot, n}, {s->F, s->rows}};
    int same = 1;
    for (int part = is_bound(s) ? 2 : 0; part < (is_bound(s) ? 3 : 2) && same; part++) {
        const double *now = parts[part].of;
        const size_t count = parts[part].count;
        memset(size, 0, count * sizeof *size);
        memset(change, 0, count * sizeof *change);
        for (size_t k = 1; k <= 3; k++) {
            for (size_t j = 0; j < n; j++) {
                s->q[j] = s->middle[j] + 2 * halton(k + 7, s->primes[j]) - 1;
                s->v[j] = 0.7 - halton(k + 3, s->primes[j]);
            }
            if (!equations(s))
                return 0;
            memcpy(copy, now, count * sizeof *copy);
            s->q[i] += TWO_PI;
            if (!equations(s))
                return 0;
            for (size_t j = 0; j < count; j++) {
                change[j] = fmax(change[j], fabs(now[j] - copy[j]));
                size[j] = fmax(size[j], fabs(now[j]));
            }
        }
        double most = 0;
        for (size_t j = 0; j < count; j++)
            most = fmax(most, size[j]);
        /* A number that should be 0 has a size[j] of round-off of the largest number, `most`. */
        for (size_t j = 0; j < count; j++)
            same = same && change[j] <= 1e-9 * size[j] + 1e-14 * most;
    }
    return same;
}

/* Sets the box to the extent of the motion in the first MOTION steps of dop853: the largest |q -
 * q0|, or |v| for unknowns v_i. At first the step size grows from its initial guess; steps count
 * from the first one that is less than twice as long as the step before. The motion is cut off
 * where an unknown is RUNAWAY times as large as after the first counted step. */
static void extent(struct search *s, const double *q0, const double *v0)
{
    const struct pk_method *method = &pk_method_dop853;
    struct pk_options options = pk_options_default();
    struct pk_integrator it;
    const size_t size = pk_integrator_size(s->problem, method);
    void *block = malloc(size);
    double before = HUGE_VAL, *begun = s->p;
    int settled = 0, runs = 1;
    options.rtol = 1e-6;
    /* The absolute tolerance is effectively 0, since the scale of q is not known. */
    options.atol = 1e-300;
    memset(s->box, 0, s->n * sizeof *s->box);
    if (!block)
        return;
    runs = pk_integrator_init(&it, s->problem, method, &options, 0, q0, v0, block, size) >= 0;
    for (int k = 0; runs && k < SETTLING && settled < MOTION; k++) {
        const double t = it.t;
        runs = pk_integrator_step(&it, 1e300) >= 0;
        settled += settled || (k > 0 && it.t - t < 2 * before);
        before = it.t - t;
        for (size_t i = 0; i < s->n && runs && settled; i++) {
            const double far = fabs(is_by_rate(s, i) ? it.v[i] : it.q[i] - q0[i]);
            if (settled == 1 || !(begun[i] > 0))
                begun[i] = far;
            if (far > RUNAWAY * begun[i])
                runs = 0;
            else
                s->box[i] = fmax(s->box[i], far);
        }
    }
    pk_integrator_free(&it);
    free(block);
}

/* Sets the box of each unknown: twice the extent of the motion or 2 |q0| (2 |v0| for unknowns v_i),
 * whichever is larger. If both are 0, a coordinate gets the largest box of the other coordinates,
 * or 1. The half-width of the box is pi for an angle and 1 for a quaternion. */
static void choose_box(struct search *s, const double *q0, const double *v0)
{
    double others = 0;
    extent(s, q0, v0);
    for (size_t i = 0; i < s->n; i++) {
        const int c = is_by_rate(s, i);
        s->box[i] = 2 * fmax(s->box[i], fabs(c ? v0[i] : q0[i]));
        if (s->turns[i] && !c)
            s->box[i] = TWO_PI / 2;
        else if (!c)
            others = fmax(others, s->box[i]);
    }
    for (size_t i = 0; i < s->n; i++)
        if (!(s->box[i] > NOTHING))
            s->box[i] = is_by_rate(s, i) || !(others > 0) ? 1 : others;
    for (size_t i = 0; i < 4 * s->problem->system->n_rotations; i++)
        s->box[quaternions(s) + i] = 1;
}

/* Sets the scale of each equation: its largest value at points of the box, but at least the
 * round-off of the largest equation. */
static void measure(struct search *s)
{
    double most = 0;
    for (size_t k = 1; k <= 32; k++) {
        pk_equilibria_place(s, 2 * k + 1);
        if (equations(s))
            for (size_t i = 0; i < s->rows; i++) {
                s->scale[i] = fmax(s->scale[i], fabs(s->F[i]));
                most = fmax(most, s->scale[i]);
            }
    }
    for (size_t i = 0; i < s->rows; i++)
        s->scale[i] = fmax(s->scale[i], most > 0 ? 1e-14 * most : 1);
    /* Body rates are 0 at all points of the search, so their scale is that of the box. */
    for (size_t i = 0; i < s->n; i++)
        if (is_body_rate(s, i))
            s->scale[i] = s->box[i];
    for (size_t r = 0; r < s->problem->system->n_rotations; r++)
        s->scale[quaternions(s) + 4 * r + 3] = 1;
}

void pk_equilibria_box(struct search *s, const double *q0, const double *v0)
{
    const struct pk_problem *problem = s->problem;
    const size_t n = s->n;
    (is_bound(s) ? problem->system->unconstrained
                 : problem->system->canonical)(problem->params, 0, q0, v0, NULL, s->kept, s->pdot);
    memcpy(s->middle, q0, n * sizeof *q0);
    for (size_t i = 0; i < n; i++)
        s->turns[i] = (unsigned char)is_turn(s, i);
    memcpy(s->q, q0, n * sizeof *q0);
    for (size_t i = 0; i < n; i++) {
        const int c = is_by_rate(s, i);
        s->v[i] = c && !is_body_rate(s, i) ? v0[i] : 0;
        s->middle[i] = c ? s->v[i] : s->turns[i] ? 0 : q0[i];
    }
    choose_box(s, q0, v0);
    measure(s);
}

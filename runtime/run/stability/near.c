/* Motions that begin close to an equilibrium, the start, along its modes:
 *
 *     q = q* + A sum Re(u),  v = v* + A sum Re(lambda u)
 *
 * `near` makes `count` steps of a method from there. It reports the growth of the largest
 * displacement of a coordinate that is not cyclic, and the mean angle per step by which the mode's
 * leading coordinate turns about q* in the plane (q, -v/omega). Both are measured along the steps.
 * With a second mode `other` at amplitude `seed`, the growth is that of this mode's part of the
 * motion, hypot(u.M (q - q*), u.M v/omega). Only built with GSL.
 */
#include <pk/constraint.h>
#include <pk/methods.h>

#include "stability.h"

#ifdef PK_WITH_GSL

static const double TWO_PI = 6.283185307179586476925;
static const double FAR = 1e3; /* growth at which the steps end */

/* Returns the largest displacement from the equilibrium, without idle coordinates. */
static double displacement(const struct pk_stability *s, const double *q, const double *v)
{
    double most = 0;
    for (size_t i = 0; i < s->n; i++) {
        const double apart = fabs(stability_apart(s, q, v, i));
        if (!stability_idle(s, i) && !(apart <= most))
            most = apart;
    }
    return most;
}

/* Adds mode k at an amplitude to the start in s->work: q, then v. */
static void add_mode(struct pk_stability *s, size_t k, double amplitude)
{
    const size_t n = s->n;
    const struct pk_mode mode = s->modes[k];
    const double *re = s->shapes + k * 2 * n, *im = re + n;
    for (size_t i = 0; i < n; i++) {
        const int first_order = i >= s->coordinates;
        s->work[i] += first_order ? 0 : amplitude * re[i];
        s->work[n + i] += amplitude *
                          (first_order ? re[i] : mode.growth * re[i] - mode.frequency * im[i]);
    }
}

/* Sets the start in s->work: along one mode, or along all that move and do not grow. */
static void start_near(struct pk_stability *s, size_t from, size_t to, double amplitude)
{
    const size_t n = s->n;
    memcpy(s->work, s->settings->q, n * sizeof *s->work);
    memcpy(s->work + n, s->settings->v, n * sizeof *s->work);
    for (size_t k = from; k < to; k++) {
        const struct pk_mode mode = s->modes[k];
        if (to - from == 1 || (!(mode.growth > 0) && hypot(mode.growth, mode.frequency) > 0))
            add_mode(s, k, amplitude);
    }
}

/* Projects the start onto rotations and constraints, since a mode is only tangential to them.
 */
static void settle(struct pk_stability *s)
{
    enum pk_status status;
    struct pk_integrator *it = NULL;
    if (s->problem.system->n_rotations || s->problem.system->constraints.n)
        it = stability_motion_begun(s, 1, &status);
    if (it)
        pk_constraint_project(it, 0, s->work, s->work + s->n);
    stability_end(s, it);
}

/* Returns mode k's part of the state: its amplitude times u.M u. `weights` is M u. */
static double part_of(const struct pk_stability *s, size_t k, const double *weights,
                      const double *q, const double *v)
{
    double place = 0, rate = 0;
    for (size_t i = 0; i < s->n; i++) {
        place += weights[i] * stability_apart(s, q, v, i);
        rate += i < s->coordinates ? weights[i] * (v[i] - s->settings->v[i]) : 0;
    }
    return hypot(place, rate / s->modes[k].frequency);
}

static void weigh(const struct pk_stability *s, size_t k, double *weights, double *mass)
{
    const struct settings *at = s->settings;
    const size_t n = s->n;
    const double *u = s->shapes + k * 2 * n;
    s->problem.system->mass(at->params, 0, at->q, at->v, at->u, mass);
    for (size_t i = 0; i < n; i++) {
        weights[i] = 0;
        for (size_t j = 0; j < n; j++)
            weights[i] += mass[i * n + j] * u[j];
    }
}

/* Sets the range of modes from..to - 1: one mode, or all (mode -1). Returns 0 if there are none. */
static int take_modes(struct pk_stability *s, long mode, size_t *from, size_t *to)
{
    if (!s->has_modes) {
        const enum pk_status status = pk_gsl_modes(&s->problem, s->settings->q, s->settings->v,
                                                   s->modes, s->shapes, &s->n_modes);
        if (status < 0) {
            run_say(s->run, "no modes here: %s", pk_status_name(status));
            return 0;
        }
        s->has_modes = 1;
    }
    *from = mode < 0 ? 0 : (size_t)mode;
    *to = mode < 0 ? s->n_modes : *from + 1;
    return *to <= s->n_modes ? 1 : stability_wrong(s, "no such mode");
}

/* Rotation of a coordinate about the equilibrium in the plane (q, -v/omega), step by step. */
struct turning {
    size_t lead, half, steps; /* the coordinate; half of all steps; steps made */
    double omega, angle, turned;
    double sums[2]; /* sums of `turned` over the first and second half of the steps */
};

static double phase(const struct pk_stability *s, const struct turning *x,
                    const struct pk_integrator *it)
{
    return atan2(s->settings->v[x->lead] - it->v[x->lead],
                 x->omega * (it->q[x->lead] - s->settings->q[x->lead]));
}

static void turn(const struct pk_stability *s, struct turning *x, const struct pk_integrator *it)
{
    const double now = phase(s, x, it);
    x->turned += now < x->angle ? now - x->angle + TWO_PI : now - x->angle;
    x->angle = now;
    if (x->steps < 2 * x->half)
        x->sums[x->steps >= x->half] += x->turned;
    x->steps++;
}

/* Returns the mean angle per step. The orbit is not a circle in that plane, so the phase oscillates
 * about a line; the difference of the means of both halves nearly cancels the oscillation. */
static double mean_turn(const struct turning *x)
{
    const double half = (double)x->half;
    if (x->half && x->steps >= 2 * x->half)
        return (x->sums[1] - x->sums[0]) / (half * half);
    return x->steps ? x->turned / (double)x->steps : 0;
}

/* Returns the coordinate with the largest part in a mode, without idle ones. */
static size_t leading(const struct pk_stability *s, size_t mode)
{
    const double *re = s->shapes + mode * 2 * s->n;
    size_t lead = 0;
    for (size_t i = 0; i < s->n; i++)
        if (!stability_idle(s, i) && (stability_idle(s, lead) || fabs(re[i]) > fabs(re[lead])))
            lead = i;
    return lead;
}

int stability_near(struct pk_stability *s, const struct pk_stability_question *x)
{
    const struct pk_method *method = stability_method(s, x->method);
    const size_t steps = x->count, other = x->other < 0 ? 0 : (size_t)x->other;
    const int seeded = x->other >= 0;
    const double h = x->h, amplitude = x->amplitude, seed = x->seed;
    size_t from, to;
    double grown = 1;
    if (!method || !take_modes(s, x->mode, &from, &to))
        return 0;
    if (!(h > 0) || (seeded && other >= s->n_modes))
        return stability_wrong(s, "a step is positive, and a mode one of those that there are");
    const size_t n = s->n;
    start_near(s, from, to, amplitude);
    settle(s);
    double *weights = memory_take(&s->run->memory, n * (n + 1), sizeof *weights);
    if (seeded) {
        add_mode(s, other, seed);
        weigh(s, other, weights, weights + n);
    }
    const double first = seeded ? part_of(s, other, weights, s->work, s->work + n)
                                : displacement(s, s->work, s->work + s->n);
    struct pk_options options = s->settings->options;
    enum pk_status status;
    options.h = h;
    struct pk_integrator *it = stability_begin(s, method, &options, s->work, s->work + n, &status);
    struct turning turning = {
        leading(s, from), steps / 2, 0, s->modes[from].frequency, 0, 0, {0, 0}};
    turning.angle = it ? phase(s, &turning, it) : 0;
    while (it && turning.steps < steps && grown < FAR) {
        status = pk_integrator_step(it, (double)(steps + 1) * h);
        if (status < 0)
            break;
        grown = fmax(grown, (seeded ? part_of(s, other, weights, it->q, it->v)
                                    : displacement(s, it->q, it->v)) /
                                first);
        turn(s, &turning, it);
    }
    json_text(&s->out, "near", method->name);
    json_real(&s->out, "h", h);
    json_text(&s->out, "status", pk_status_name(status));
    json_integer(&s->out, "steps", turning.steps);
    json_reals(&s->out, {"growth", grown}, {"turn", mean_turn(&turning)});
    stability_end(s, it);
    memory_drop(&s->run->memory, weights);
    return 1;
}

int stability_leave(struct pk_stability *s, const struct pk_stability_question *x)
{
    size_t from, to;
    double most = 0;
    const double amplitude = x->amplitude;
    if (!take_modes(s, x->mode, &from, &to))
        return 0;
    const struct pk_mode mode = s->modes[from];
    if (to != from + 1 || !(mode.growth > 0))
        return stability_wrong(s, "one mode that grows, please");
    for (size_t k = 0; k < s->n_modes; k++)
        most = fmax(most, s->modes[k].growth);
    double until = log(FAR) / most; /* limited, since a faster mode grows from round-off */
    if (mode.frequency > 0)         /* whole periods, so that the phase does not matter */
        until = ceil(until * mode.frequency / TWO_PI) * TWO_PI / mode.frequency;
    struct pk_options options = s->settings->options;
    options.h = 0;
    options.rtol = 1e-13;
    options.atol = 1e-13 * amplitude;
    start_near(s, from, to, amplitude);
    settle(s);
    const double first = displacement(s, s->work, s->work + s->n);
    enum pk_status status;
    struct pk_integrator *it =
        stability_begin(s, &pk_method_dop853, &options, s->work, s->work + s->n, &status);
    double rate = 0;
    if (it && (status = pk_integrator_to(it, until)) >= 0)
        rate = log(displacement(s, it->q, it->v) / first) / until;
    json_integer(&s->out, "leave", from);
    json_text(&s->out, "status", pk_status_name(status));
    json_real(&s->out, "rate", rate);
    stability_end(s, it);
    return 1;
}

#else
extern int stability_needs_gsl; /* ISO C forbids an empty file */
#endif

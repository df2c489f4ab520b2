/* Closed orbits. Distances are in units of the box that the motion covers. Only built with GSL. */
#include <pk/methods.h>

#include "../settings/settings.h"
#include "stability.h"

#ifdef PK_WITH_GSL

enum { SAMPLES = 8192, MOST_RETURNS = 8 };
static const double TWO_PI = 6.283185307179586476925;
static const double FAR = 1e3;  /* growth at which the steps of `beside` end */
static const double NEAR = 0.1; /* largest distance, in boxes, that counts as a return */

enum { MOST = 32 };

/* Returns the largest difference of the unknowns of two states, in boxes. */
static double apart(const struct pk_stability *s, const struct unknowns *x, const double *a,
                    const double *b)
{
    double most = 0;
    for (size_t k = 0; k < x->count; k++) {
        const size_t i = x->of[k];
        const double d = b[i] - a[i];
        const double way = x->turns[k] ? d - TWO_PI * round(d / TWO_PI) : d;
        most = fmax(most, fabs(way) / s->box[i]);
    }
    return most;
}

/* Finds the unknowns of closed orbits. The box of an angle is at most half a turn. */
static const struct unknowns *unknowns(struct pk_stability *s)
{
    struct unknowns *x = &s->unknowns;
    if (x->of)
        return x;
    stability_cover(s);
    x->turns = memory_take(&s->run->memory, 2 * s->n, 1);
    x->of = memory_take(&s->run->memory, 2 * s->n, sizeof *x->of);
    x->count = pk_closed_unknowns(&s->problem, s->middle, s->box, x->of, x->turns);
    for (size_t k = 0; k < x->count; k++)
        if (x->turns[k])
            s->box[x->of[k]] = fmin(s->box[x->of[k]], TWO_PI / 2);
    return x;
}

int stability_returns(struct pk_stability *s, const struct pk_stability_question *x)
{
    const size_t n = s->n;
    double *from = memory_take(&s->run->memory, 4 * n, sizeof *from), *now = from + 2 * n;
    double times[MOST_RETURNS] = {0}, before = 0, last = 0, most = 0;
    size_t found = 0;
    const struct unknowns *of = unknowns(s);
    double until = s->settings->until;
    if (x->h > 0)
        until = ceil(until / x->h) * x->h;
    enum pk_status status;
    struct pk_integrator *it = stability_motion_begun(s, 1, &status);
    for (int k = SAMPLES; k <= 2 * SAMPLES && it && found < MOST_RETURNS; k++) {
        if (pk_integrator_to(it, until * k / SAMPLES) < 0)
            break;
        double *to = k == SAMPLES ? from : now;
        memcpy(to, it->q, it->n_q * sizeof *to);
        memcpy(to + n, it->v, n * sizeof *to);
        const double d = k == SAMPLES ? 0 : apart(s, of, from, now);
        if (before > last && d >= last && last < NEAR && last < most / 3)
            times[found++] = until * (k - 1 - SAMPLES) / SAMPLES;
        most = fmax(most, d);
        before = last;
        last = d;
    }
    stability_end(s, it);
    json_numbers(&s->out, "q", from, n);
    json_numbers(&s->out, "v", from + n, n);
    json_numbers(&s->out, "times", times, found);
    memory_drop(&s->run->memory, from);
    return 1;
}

static void take_state(const struct pk_stability *s, const struct pk_stability_question *x,
                       double *y)
{
    memcpy(y, x->state ? x->state : s->settings->q, s->n * sizeof *y);
    memcpy(y + s->n, x->state ? x->state + s->n : s->settings->v, s->n * sizeof *y);
}

/* Steps from the start and from a state `amplitude` boxes away in each unknown, and reports the
 * growth of their distance. */
int stability_neighbour(struct pk_stability *s, const struct pk_stability_question *x)
{
    const struct pk_method *method = stability_method(s, x->method);
    if (!method)
        return 0;
    if (!(x->h > 0) || !(x->amplitude > 0))
        return stability_wrong(s, "a step is positive, and so is an amplitude");
    const size_t n = s->n;
    const struct unknowns *of = unknowns(s);
    double *y = memory_take(&s->run->memory, 4 * n, sizeof *y), *other = y + 2 * n, most = 0;
    struct pk_options options = s->settings->options;
    enum pk_status status, second;
    options.h = x->h;
    take_state(s, x, y);
    memcpy(other, y, 2 * n * sizeof *y);
    for (size_t k = 0; k < of->count; k++)
        other[of->of[k]] += (k % 2 ? -1 : 1) * x->amplitude * s->box[of->of[k]];
    struct pk_integrator *a = stability_begin(s, method, &options, y, y + n, &status);
    struct pk_integrator *b = stability_begin(s, method, &options, other, other + n, &second);
    for (size_t k = 0; k < x->count && a && b && most < FAR * x->amplitude; k++) {
        const double limit = (double)(x->count + 1) * x->h;
        status = pk_integrator_step(a, limit);
        second = pk_integrator_step(b, limit);
        if (status < 0 || second < 0)
            break;
        memcpy(y, a->q, a->n_q * sizeof *y);
        memcpy(y + n, a->v, n * sizeof *y);
        memcpy(other, b->q, b->n_q * sizeof *y);
        memcpy(other + n, b->v, n * sizeof *y);
        most = fmax(most, apart(s, of, y, other));
    }
    json_text(&s->out, "status", pk_status_name(status < 0 ? status : second));
    json_real(&s->out, "growth", most / x->amplitude);
    json_numbers(&s->out, "state", other, 2 * n);
    stability_end(s, a);
    stability_end(s, b);
    memory_drop(&s->run->memory, y);
    return 1;
}

static void print(struct pk_stability *s, const struct pk_closed_orbits *found)
{
    const size_t n = s->n;
    struct json *j = &s->out;
    json_counts(j, {"failed", found->failed}, {"unknowns", found->multipliers});
    json_open(j, "orbits", '[');
    for (size_t k = 0; k < found->count; k++) {
        const struct pk_closed_orbit *one = &found->list[k];
        const size_t states = one->steps < PK_CLOSED_STATES ? one->steps : PK_CLOSED_STATES;
        json_open(j, NULL, '{');
        json_integer(j, "steps", one->steps);
        json_reals(j, {"h", one->h}, {"residual", one->residual});
        json_flag(j, "rests", one->rests);
        json_open(j, "states", '[');
        for (size_t i = 0; i < states; i++)
            json_numbers(j, NULL, one->y + i * 2 * n, 2 * n);
        json_close(j, ']');
        json_numbers(j, "re", one->re, found->multipliers);
        json_numbers(j, "im", one->im, found->multipliers);
        json_close(j, '}');
    }
    json_close(j, ']');
}

int stability_orbits(struct pk_stability *s, const struct pk_stability_question *x)
{
    const size_t n = s->n;
    struct pk_options options = s->settings->options;
    const struct pk_method *method = &pk_method_dop853;
    if (x->method && !(method = stability_method(s, x->method)))
        return 0;
    if (!(x->h > 0) || !x->count)
        return stability_wrong(s, "a step is positive, and there is one at least");
    unknowns(s);
    options.h = x->method ? x->h : 0;
    options.rtol = 1e-12;
    options.atol = PK_ATOL_OF_MOTION;
    double *room = memory_take(&s->run->memory, (MOST + 1) * pk_orbit_size(n), sizeof *room);
    double *y0 = room + MOST * pk_orbit_size(n);
    take_state(s, x, y0);
    struct pk_closed_orbit *list = memory_take(&s->run->memory, MOST, sizeof *list);
    struct pk_closed_orbits found = {.method = method,
                                     .options = &options,
                                     .h = x->h,
                                     .first = x->first ? x->first : x->count,
                                     .last = x->count,
                                     .tries = x->tries,
                                     .free = x->free != 0,
                                     .middle = s->middle,
                                     .box = s->box,
                                     .most = MOST,
                                     .list = list};
    const enum pk_status status = pk_gsl_orbits(&s->problem, y0, &found, room);
    json_text(&s->out, "status", pk_status_name(status));
    print(s, &found);
    memory_drop(&s->run->memory, list);
    memory_drop(&s->run->memory, room);
    return 1;
}

#else
extern int stability_orbits_need_gsl; /* ISO C forbids an empty file */
#endif

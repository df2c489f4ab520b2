/* Orbits that close, and what the motion covers, which is the unit that all is measured in. */
#include "../settings/settings.h"
#include "stability.h"

enum { SAMPLES = 8192, MOST_RETURNS = 8 };
static const double NEAR = 0.1; /* of what is covered: so close it comes back */

static struct pk_integrator *motion(struct pk_stability *s, double rtol)
{
    struct pk_options options = s->settings->options;
    options.h = 0;
    options.rtol = rtol;
    options.atol = PK_ATOL_OF_MOTION;
    stability_end(s, s->exact);
    s->exact = NULL;
    s->known = 0;
    return s->exact = stability_begin(s, pk_method_find("dop853"), &options, s->settings->q,
                                      s->settings->v, &s->motion);
}

static void stretch(double *low, double *high, const double *x, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        low[i] = fmin(low[i], x[i]);
        high[i] = fmax(high[i], x[i]);
    }
}

/* What does not move is as far from 0, or as the largest of all. */
static void cover(struct pk_stability *s)
{
    const size_t n = s->n;
    if (s->box)
        return;
    double *low = s->middle = memory_take(&s->run->memory, 4 * n, sizeof *s->box);
    double *high = s->box = low + 2 * n, most = 0;
    for (size_t i = 0; i < 2 * n; i++)
        low[i] = high[i] = i < n ? s->settings->q[i] : s->settings->v[i - n];
    struct pk_integrator *it = motion(s, 1e-8);
    for (int k = 1; k <= SAMPLES && it; k++) {
        if (pk_integrator_to(it, s->settings->until * k / SAMPLES) < 0)
            break;
        stretch(low, high, it->q, n);
        stretch(low + n, high + n, it->v, n);
    }
    for (size_t i = 0; i < 2 * n; i++) {
        const double a = low[i], b = high[i];
        low[i] = (a + b) / 2;
        high[i] = b - a > 1e-9 * fabs(a + b) ? b - a : fabs(a + b) / 2;
        most = fmax(most, high[i]);
    }
    for (size_t i = 0; i < 2 * n; i++)
        if (!(high[i] > 0))
            high[i] = most > 0 ? most : 1;
}

/* Farthest of the coordinates and rates, in boxes. */
static double apart(const struct pk_stability *s, const double *a, const double *b)
{
    double most = 0;
    for (size_t i = 0; i < 2 * s->n; i++)
        most = fmax(most, fabs(a[i] - b[i]) / s->box[i]);
    return most;
}

int stability_returns(struct pk_stability *s, const struct pk_stability_question *x)
{
    (void)x;
    const size_t n = s->n;
    double *from = memory_take(&s->run->memory, 4 * n, sizeof *from), *now = from + 2 * n;
    double times[MOST_RETURNS] = {0}, before = 0, last = 0, most = 0;
    size_t found = 0;
    cover(s);
    const double until = s->settings->until;
    struct pk_integrator *it = motion(s, 1e-10);
    for (int k = SAMPLES; k <= 2 * SAMPLES && it && found < MOST_RETURNS; k++) {
        if (pk_integrator_to(it, until * k / SAMPLES) < 0)
            break;
        double *to = k == SAMPLES ? from : now;
        memcpy(to, it->q, n * sizeof *to);
        memcpy(to + n, it->v, n * sizeof *to);
        const double d = k == SAMPLES ? 0 : apart(s, from, now);
        if (before > last && d >= last && last < NEAR && last < most / 3)
            times[found++] = until * (k - 1 - SAMPLES) / SAMPLES;
        most = fmax(most, d);
        before = last;
        last = d;
    }
    json_numbers(&s->out, "q", from, n);
    json_numbers(&s->out, "v", from + n, n);
    json_numbers(&s->out, "times", times, found);
    memory_drop(&s->run->memory, from);
    return 1;
}

#ifdef PK_WITH_GSL

enum { MOST = 32 };

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
        json_whole(j, "steps", one->steps);
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
    const struct pk_method *method = pk_method_find("dop853");
    if (x->method && !(method = stability_method(s, x->method)))
        return 0;
    if (!(x->h > 0) || !x->count)
        return stability_wrong(s, "a step is positive, and there is one at least");
    cover(s);
    options.h = x->method ? x->h : 0;
    options.rtol = 1e-12;
    options.atol = PK_ATOL_OF_MOTION;
    double *room = memory_take(&s->run->memory, (MOST + 1) * pk_orbit_size(n), sizeof *room);
    double *y0 = room + MOST * pk_orbit_size(n);
    memcpy(y0, s->settings->q, n * sizeof *y0);
    memcpy(y0 + n, s->settings->v, n * sizeof *y0);
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

#endif

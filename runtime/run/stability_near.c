/* Equilibria, and motions that begin close to one along its modes:
 *
 *     q = q* + A sum Re(u),  v = v* + A sum Re(lambda u)
 *
 * `near` tells of STEPS steps of a method from there: by how much the largest displacement of a
 * coordinate that is not cyclic has grown, and the mean angle a step by which the mode's leading
 * coordinate turns about q* in the plane (q, -v/omega). Both are measured, not taken from a map.
 * With a second mode OTHER, begun at amplitude SEED, what grows is that mode's part of the motion,
 * |u.M (q - q*)| and |u.M v|/omega together.
 * Built with GSL alone.
 */
#include "stability.h"

#ifdef PK_WITH_GSL

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "output.h"
#include "words.h"

static const double TWO_PI = 6.283185307179586476925;
static const double FAR = 1e3; /* growth that settles it */

int stability_equilibria(struct stability *s, size_t line, char *const words[])
{
    const size_t n = s->n;
    size_t tries;
    struct pk_equilibria found = {MOST_EQUILIBRIA, s->q, s->v, 0, 0, 0, 0, NULL};
    if (!words_index(words[1], 100000, &tries))
        return words_usage(line, "not a number of tries", words[1]);
    found.turns = (unsigned char *)words_allocate(n, 1);
    const enum pk_status status =
        pk_gsl_equilibria(&s->problem, s->settings.q, s->settings.v, tries, &found);
    s->equilibria = found.count;
    for (size_t i = 0; i < n; i++)
        s->work[i] = found.turns[i];
    free(found.turns);
    printf("{\"status\": \"%s\", \"failed\": %zu, \"singular\": %zu, \"more\": %s, ",
           pk_status_name(status), found.failed, found.singular, found.more ? "true" : "false");
    output_numbers(stdout, "turns", s->work, n);
    fputs(", \"equilibria\": [", stdout);
    for (size_t k = 0; k < found.count; k++) {
        double energy, vp, size;
        const double *q = s->q + k * n, *v = s->v + k * n;
        struct pk_mode *modes = s->modes + k * 2 * n;
        double *shapes = s->shapes + k * 4 * n * n;
        const enum pk_status solved =
            pk_gsl_modes(&s->problem, q, v, modes, shapes, &s->counts[k]);
        stability_energies(s, 0, q, v, &energy, &vp, &size);
        fputs(k ? ", {" : "{", stdout);
        output_numbers(stdout, "q", q, n);
        fputs(", ", stdout);
        output_numbers(stdout, "v", v, n);
        fputs(", \"energy\": ", stdout);
        output_real(stdout, energy);
        printf(", \"status\": \"%s\", \"modes\": [", pk_status_name(solved));
        for (size_t m = 0; m < s->counts[k]; m++) {
            printf("%s{\"growth\": %.17g, \"frequency\": %.17g, ", m ? ", " : "",
                   modes[m].growth, modes[m].frequency);
            output_numbers(stdout, "re", shapes + m * 2 * n, n);
            fputs(", ", stdout);
            output_numbers(stdout, "im", shapes + m * 2 * n + n, n);
            fputs("}", stdout);
        }
        fputs("]}", stdout);
    }
    fputs("]}\n", stdout);
    return 0;
}

static int is_cyclic(const struct stability *s, size_t i)
{
    return s->problem.system->cyclic && s->problem.system->cyclic[i];
}

/* The largest displacement from equilibrium `e` of what is not cyclic. */
static double displacement(const struct stability *s, size_t e, const double *q)
{
    double most = 0;
    for (size_t i = 0; i < s->n; i++)
        if (!is_cyclic(s, i) && !(fabs(q[i] - s->q[e * s->n + i]) <= most))
            most = fabs(q[i] - s->q[e * s->n + i]);
    return most;
}

/* Adds a mode at some amplitude to the start in s->work: q, then v. */
static void add_mode(struct stability *s, size_t e, size_t k, double amplitude)
{
    const size_t n = s->n;
    const struct pk_mode mode = s->modes[e * 2 * n + k];
    const double *re = s->shapes + e * 4 * n * n + k * 2 * n, *im = re + n;
    for (size_t i = 0; i < n; i++) {
        s->work[i] += amplitude * re[i];
        s->work[n + i] += amplitude * (mode.growth * re[i] - mode.frequency * im[i]);
    }
}

/* The start: of several modes those that move and do not grow. */
static void start_near(struct stability *s, size_t e, size_t from, size_t to, double amplitude)
{
    const size_t n = s->n;
    memcpy(s->work, s->q + e * n, n * sizeof *s->work);
    memcpy(s->work + n, s->v + e * n, n * sizeof *s->work);
    for (size_t k = from; k < to; k++) {
        const struct pk_mode mode = s->modes[e * 2 * n + k];
        if (to - from == 1 || (!(mode.growth > 0) && hypot(mode.growth, mode.frequency) > 0))
            add_mode(s, e, k, amplitude);
    }
}

/* Mode k's part of the motion at q, v: its amplitude times u.M u. `weights` is M u. */
static double part_of(const struct stability *s, size_t e, size_t k, const double *weights,
                      const double *q, const double *v)
{
    const size_t n = s->n;
    double place = 0, rate = 0;
    for (size_t i = 0; i < n; i++) {
        place += weights[i] * (q[i] - s->q[e * n + i]);
        rate += weights[i] * (v[i] - s->v[e * n + i]);
    }
    return hypot(place, rate / s->modes[e * 2 * n + k].frequency);
}

static void weigh(const struct stability *s, size_t e, size_t k, double *weights, double *mass)
{
    const size_t n = s->n;
    const double *u = s->shapes + e * 4 * n * n + k * 2 * n;
    s->problem.system->mass(s->problem.params, 0, s->q + e * n, s->v + e * n, s->settings.u, mass);
    for (size_t i = 0; i < n; i++) {
        weights[i] = 0;
        for (size_t j = 0; j < n; j++)
            weights[i] += mass[i * n + j] * u[j];
    }
}

static int read_mode(const struct stability *s, size_t line, char *const words[], size_t *e,
                     size_t *from, size_t *to)
{
    if (!words_index(words[0], s->equilibria, e))
        return words_usage(line, "no such equilibrium", words[0]);
    *from = 0;
    *to = s->counts[*e];
    if (words[1] && strcmp(words[1], "all") == 0)
        return 0;
    if (!words_index(words[1], s->counts[*e], from))
        return words_usage(line, "no such mode", words[1]);
    *to = *from + 1;
    return 0;
}

int stability_near(struct stability *s, size_t line, char *const words[])
{
    const struct pk_method *method = words[1] ? run_method_find(words[1]) : NULL;
    size_t e, from, to, steps, other = 0, lead = 0, k = 0;
    double h, amplitude, seed = 0, turned = 0, grown = 1;
    if (!method || method->traits & PK_ADAPTIVE)
        return words_usage(line, "no method of a fixed step", words[1]);
    if (!words_real(words[2], &h) || !(h > 0))
        return words_usage(line, "not a step", words[2]);
    const int code = read_mode(s, line, words + 3, &e, &from, &to);
    if (code)
        return code;
    if (!words_real(words[5], &amplitude) || !words_index(words[6], 100000000, &steps))
        return words_usage(line, "an amplitude and a number of steps, please", words[5]);
    if (words[7] && (!words_index(words[7], s->counts[e], &other) || !words_real(words[8], &seed)))
        return words_usage(line, "no such mode, or no amplitude of it", words[7]);
    const size_t n = s->n;
    const double *rest = s->q + e * n, *going = s->v + e * n;
    const double omega = s->modes[e * 2 * n + from].frequency;
    const double *re = s->shapes + e * 4 * n * n + from * 2 * n;
    for (size_t i = 0; i < n; i++)
        if (!is_cyclic(s, i) && (is_cyclic(s, lead) || fabs(re[i]) > fabs(re[lead])))
            lead = i;
    start_near(s, e, from, to, amplitude);
    double *weights = (double *)words_allocate(n * (n + 1), sizeof *weights);
    if (words[7]) {
        add_mode(s, e, other, seed);
        weigh(s, e, other, weights, weights + n);
    }
    const double first = words[7] ? part_of(s, e, other, weights, s->work, s->work + n)
                                  : displacement(s, e, s->work);
    struct pk_options options = s->settings.options;
    enum pk_status status;
    options.h = h;
    struct pk_integrator *it =
        stability_begin(&s->problem, method, &options, s->work, s->work + n, &status);
    double angle = it ? atan2(-(it->v[lead] - going[lead]), omega * (it->q[lead] - rest[lead])) : 0;
    for (; it && k < steps && grown < FAR; k++) {
        status = pk_integrator_step(it, (double)(steps + 1) * h);
        if (status < 0)
            break;
        grown = fmax(grown, (words[7] ? part_of(s, e, other, weights, it->q, it->v)
                                      : displacement(s, e, it->q)) / first);
        const double now =
            atan2(-(it->v[lead] - going[lead]), omega * (it->q[lead] - rest[lead]));
        turned += now < angle ? now - angle + TWO_PI : now - angle;
        angle = now;
    }
    printf("{\"near\": \"%s\", \"h\": %.17g, \"status\": \"%s\", \"steps\": %zu, \"growth\": ",
           method->name, h, pk_status_name(status), k);
    output_real(stdout, grown);
    fputs(", \"turn\": ", stdout);
    output_real(stdout, k ? turned / (double)k : 0);
    fputs("}\n", stdout);
    stability_end(it);
    free(weights);
    return 0;
}

int stability_leave(struct stability *s, size_t line, char *const words[])
{
    size_t e, from, to;
    double amplitude;
    const int code = read_mode(s, line, words + 1, &e, &from, &to);
    if (code)
        return code;
    const struct pk_mode mode = s->modes[e * 2 * s->n + from];
    if (!words_real(words[3], &amplitude) || to != from + 1 || !(mode.growth > 0))
        return words_usage(line, "one mode that grows, and an amplitude", words[3]);
    double until = log(FAR) / mode.growth;
    if (mode.frequency > 0) /* whole turns, so that phases do not count */
        until = ceil(until * mode.frequency / TWO_PI) * TWO_PI / mode.frequency;
    struct pk_options options = s->settings.options;
    options.h = 0;
    options.rtol = 1e-13;
    options.atol = 1e-13 * amplitude;
    start_near(s, e, from, to, amplitude);
    const double first = displacement(s, e, s->work);
    enum pk_status status;
    struct pk_integrator *it = stability_begin(&s->problem, pk_method_find("dop853"), &options,
                                               s->work, s->work + s->n, &status);
    double rate = 0;
    if (it && (status = pk_integrator_to(it, until)) >= 0)
        rate = log(displacement(s, e, it->q) / first) / until;
    printf("{\"leave\": %zu, \"status\": \"%s\", \"rate\": ", from, pk_status_name(status));
    output_real(stdout, rate);
    fputs("}\n", stdout);
    stability_end(it);
    return 0;
}

#else
extern int stability_needs_gsl; /* a file is not to be empty */
#endif

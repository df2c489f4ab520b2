/* What a method makes of a motion, told from its energy. With E the method's energy, E0 the first,
 * S the range of v.p over the motion itself (twice the kinetic energy that comes and goes), [a, b]
 * the energies met in the last quarter of the run, and R the size |v.p| + |L| that round-off of the
 * energy is relative to:
 *
 *     away      distance of E0 from [a, b]
 *     rise      max E - E0;   early: the same over the first eighth
 *     growing   rise > S, and it goes on (rise > 2 early), or E does not come back
 *               (away > (b - a)/4), or it is beyond any beat (rise > 1e4 S)
 *     drifting  not growing, away > (b - a)/4 and away > 1e-11 R
 *     bounded   neither: E comes back to where it was
 *
 * A drift that is smaller than 2.2 times the oscillation is not seen. Where energy is not constant
 * by itself, in place of E0 stand the energies of the motion: in its last quarter, and the largest.
 * Below a limit Verlet's energy may rise by E0/(1 - y^2/4) and come back: that is bounded. All other
 * classes are statuses of the runtime.
 */
#include <math.h>
#include <string.h>

#include "output.h"
#include "stability.h"
#include "words.h"

enum { LEAST_STEPS = 200, MOST_STEPS = 4000000 };

int stability_motion(struct stability *s)
{
    struct pk_options options = s->settings.options;
    const double until = s->settings.until;
    const int constant = (s->problem.system->facts & PK_CONSERVATIVE) != 0;
    double e, vp, size, least, most;
    enum pk_status status;
    options.rtol = options.atol = 1e-10;
    options.h = 0;
    options.max_steps = MOST_STEPS;
    struct pk_integrator *it = stability_begin(&s->problem, pk_method_find("dop853"), &options,
                                               s->settings.q, s->settings.v, &status);
    stability_energies(s, 0, s->settings.q, s->settings.v, &e, &vp, &size);
    s->first = s->top = s->low = s->high = e;
    s->size = size;
    least = most = vp;
    int late = 0;
    double t = 0;
    while (it && status >= 0 && it->t < until) {
        status = pk_integrator_step(it, until);
        if (status < 0)
            break;
        t = it->t;
        stability_energies(s, t, it->q, it->v, &e, &vp, &size);
        least = fmin(least, vp);
        most = fmax(most, vp);
        s->size = fmax(s->size, size);
        if (constant)
            continue;
        s->top = fmax(s->top, e);
        if (t >= 0.75 * until) {
            s->low = late ? fmin(s->low, e) : e;
            s->high = late ? fmax(s->high, e) : e;
            late = 1;
        }
    }
    s->scale = fmax(most - least, 1e-3 * fmax(fabs(most), fabs(least)));
    s->known = 1;
    printf("{\"motion\": \"%s\", \"t\": %.17g, \"energy\": ",
           status < 0 ? pk_status_name(status) : "PK_DONE", t);
    output_real(stdout, s->first);
    fputs(", \"scale\": ", stdout);
    output_real(stdout, s->scale);
    fputs(", ", stdout);
    output_numbers(stdout, "q", s->settings.q, s->n);
    fputs(", ", stdout);
    output_numbers(stdout, "v", s->settings.v, s->n);
    fputs("}\n", stdout);
    stability_end(it);
    return 0;
}

static const char *failure(enum pk_status status)
{
    switch (status) {
    case PK_REFUSED:
        return "refused";
    case PK_NO_CONVERGENCE:
        return "not converged";
    case PK_AMBIGUOUS_STEP:
        return "wrong branch";
    case PK_NOT_FINITE:
        return "not finite";
    case PK_SINGULAR_MASS:
    case PK_SINGULAR_TIME:
    case PK_SINGULAR_COORDINATES:
        return "singular";
    default:
        return "failed";
    }
}

/* Energies of a run, as they come. */
struct energies {
    double rise, early; /* beyond the largest of the motion */
    double low, high;   /* in the last quarter */
    int late;
};

static const char *classify(const struct stability *s, const struct energies *e, double *away)
{
    const double width = e->high - e->low;
    *away = fmax(fmax(e->low - s->high, s->low - e->high), 0);
    const int left = *away > width / 4;
    if (e->rise > s->scale && (e->rise > 2 * e->early || left || e->rise > 1e4 * s->scale))
        return "growing";
    return left && *away > 1e-11 * s->size ? "drifting" : "bounded";
}

int stability_point(struct stability *s, size_t line, char *const words[])
{
    const struct pk_method *method = words[1] ? run_method_find(words[1]) : NULL;
    double h, away = 0;
    if (!method || method->traits & PK_ADAPTIVE)
        return words_usage(line, "no method of a fixed step", words[1]);
    if (!words_real(words[2], &h) || !(h > 0))
        return words_usage(line, "not a step", words[2]);
    if (!s->known)
        return words_usage(line, "ask for the motion first", words[0]);
    struct pk_options options = s->settings.options;
    options.h = h;
    const double wanted = ceil(s->settings.until / h);
    const unsigned long steps =
        (unsigned long)fmin(fmax(wanted, (double)LEAST_STEPS), (double)MOST_STEPS);
    struct energies e = {0, 0, 0, 0, 0};
    enum pk_status status;
    struct pk_integrator *it = stability_begin(&s->problem, method, &options, s->settings.q,
                                               s->settings.v, &status);
    unsigned long k = 0;
    while (it && k < steps) {
        double energy, vp, size;
        status = pk_integrator_step(it, (double)(steps + 1) * h);
        if (status < 0)
            break;
        k++;
        stability_energies(s, it->t, it->q, it->v, &energy, &vp, &size);
        if (!(fabs(energy) < HUGE_VAL)) {
            status = PK_NOT_FINITE;
            break;
        }
        e.rise = fmax(e.rise, energy - s->top);
        if (8 * k <= steps)
            e.early = e.rise;
        if (4 * k >= 3 * steps) {
            e.low = e.late ? fmin(e.low, energy) : energy;
            e.high = e.late ? fmax(e.high, energy) : energy;
            e.late = 1;
        }
    }
    const char *class = status < 0 ? failure(status) : classify(s, &e, &away);
    printf("{\"point\": \"%s\", \"h\": %.17g, \"class\": \"%s\", \"status\": \"%s\", "
           "\"steps\": %lu, \"rise\": ",
           method->name, h, class, pk_status_name(status), k);
    output_real(stdout, e.rise / s->scale);
    fputs(", \"away\": ", stdout);
    output_real(stdout, away / s->scale);
    fputs("}\n", stdout);
    stability_end(it);
    return 0;
}

/* Classifies a method's run at one step size, mostly by its energy E. E0 is the first energy, S the
 * range of v.p over the reference motion (twice the kinetic energy that comes and goes), [a, b] the
 * range of E in the last quarter of the run, and R = |v.p| + |L| the size of round-off:
 *
 *     away      distance of E0 from [a, b]
 *     rise      max E - E0;   early: the same over the first eighth
 *     growing   rise > S, and it continues (rise > 2 early), or E does not return (away > S/2 or
 *               away > (b - a)/4), or rise is larger than any beat (rise > 1e4 S)
 *     drifting  not growing, away > (b - a)/4 and away > 1e-11 R
 *     exchange  not growing, and a coordinate swings TIMES as far as in the reference motion
 *     constant lost   not drifting, and another constant has moved by MOVED (both: see watch.c)
 *     bounded   otherwise: E returns to E0
 *
 * A drift smaller than 2.2 times the oscillation is not seen. Near a resonance with the step, the
 * energy may oscillate more slowly than the run is long, or the motion may lock to the resonance: a
 * symplectic or symmetric method drifts only if after four times as long `away` is a fifth larger.
 * If energy is not constant by itself, E0 is replaced by energies of the reference motion: the
 * range in its last quarter, and the largest. A run has at least LEAST_STEPS steps; the reference
 * motion is followed for as long. If that leaves or ends, the run is `not judged`. Below its
 * limit, Verlet's energy may rise by E0/(1 - y^2/4) and return: that is bounded. The other classes
 * are failures of the steps, see failure().
 */

#include "stability.h"

enum { LEAST_STEPS = 200, MOST_STEPS = 4000000 };
static const double TIMES = 3;    /* amplitude ratio above which energy has gone to a coordinate */
static const double MOVED = 1e-2; /* relative change above which a constant is lost */

static const char *failure(enum pk_status status)
{
    switch (status) {
    case PK_REFUSED:
        return "refused";
    case PK_NO_CONVERGENCE:
        return "not converged";
    case PK_NO_PROJECTION:
        return "off constraints";
    case PK_AMBIGUOUS_STEP:
        return "wrong branch";
    case PK_NOT_FINITE:
        return "not finite";
    case PK_SINGULAR_MASS:
    case PK_SINGULAR_TIME:
    case PK_SINGULAR_COORDINATES:
    case PK_STEP_TOO_LONG:
        return "singular";
    default:
        return "failed";
    }
}

/* Energies of a method's run so far. */
struct energies {
    double most, early_most; /* largest; largest in the first eighth */
    double low, high;        /* range in the last quarter */
    double rise, early;      /* `most` and `early_most` above the motion's largest */
    double away;             /* distance of [low, high] from the motion's range */
    unsigned long steps;
    struct watched watched;
};

/* Steps until there are `steps` in all, and compares with the motion over the same time. */
static enum pk_status follow(struct pk_stability *s, struct pk_integrator *it, unsigned long steps,
                             struct energies *e, struct reference *motion)
{
    const unsigned long early = steps / 8, late = steps - steps / 4;
    int begun = 0;
    while (e->steps < steps) {
        double energy, vp, size;
        const enum pk_status status = pk_integrator_step(it, (double)(steps + 1) * it->options.h);
        if (status < 0)
            return status;
        stability_energies(s, it->t, it->q, it->v, &energy, &vp, &size);
        if (!(fabs(energy) < HUGE_VAL))
            return PK_NOT_FINITE;
        stability_watch(s, &e->watched, it->t, it->q, it->v);
        stability_compare(s, &e->watched, it->t, it->q, it->v);
        e->most = fmax(e->most, energy);
        if (++e->steps <= early)
            e->early_most = e->most;
        if (e->steps > late) {
            e->low = begun ? fmin(e->low, energy) : energy;
            e->high = begun ? fmax(e->high, energy) : energy;
            begun = 1;
        }
    }
    *motion = stability_reference(s, it->t);
    e->rise = fmax(e->most - motion->top, 0);
    e->early = fmax(e->early_most - motion->top, 0);
    e->away = fmax(fmax(e->low - motion->high, motion->low - e->high), 0);
    return PK_DONE;
}

static int has_left(const struct energies *e) { return e->away > (e->high - e->low) / 4; }

/* Returns PK_DONE and sets *class, or returns the status that ended the run. */
static enum pk_status classify(struct pk_stability *s, struct pk_integrator *it,
                               unsigned long steps, struct energies *e, struct reference *motion,
                               const char **class)
{
    enum pk_status status = follow(s, it, steps, e, motion);
    if (status < 0)
        return status;
    const double scale = motion->scale;
    *class = "bounded";
    if (!motion->judges) {
        *class = "not judged";
    } else if (e->rise > scale && (e->rise > 2 * e->early || e->away > scale / 2 || has_left(e) ||
                                   e->rise > 1e4 * scale)) {
        *class = "growing";
    } else if (has_left(e) && e->away > 1e-11 * motion->size) {
        const double before = e->away;
        const int again = (it->method->traits & (PK_SYMPLECTIC | PK_SYMMETRIC)) != 0;
        if (again)
            status = follow(s, it, 4 * steps, e, motion);
        if (!again || (has_left(e) && e->away > 1.2 * before))
            *class = "drifting";
    }
    stability_judge(s, &e->watched);
    const int stays = strcmp(*class, "bounded") == 0;
    if (e->watched.exchange > TIMES && (stays || strcmp(*class, "drifting") == 0))
        *class = "exchange";
    else if (e->watched.moved > MOVED && stays)
        *class = "constant lost";
    return status;
}

int stability_point(struct pk_stability *s, const struct pk_stability_question *x)
{
    const struct pk_method *method = stability_method(s, x->method);
    const double h = x->h;
    if (!method)
        return 0;
    if (!(h > 0) || !s->known)
        return stability_wrong(s, s->known ? "a step is positive" : "ask for the motion first");
    struct pk_options options = s->settings->options;
    options.h = h;
    const double wanted = ceil(s->settings->until / h);
    const unsigned long steps =
        (unsigned long)fmin(fmax(wanted, (double)LEAST_STEPS), (double)MOST_STEPS);
    struct energies e = {.most = -HUGE_VAL, .early_most = -HUGE_VAL};
    struct reference motion = {.scale = 1};
    stability_watch_begin(s, &e.watched);
    const char *class = "";
    enum pk_status status;
    struct pk_integrator *it =
        stability_begin(s, method, &options, s->settings->q, s->settings->v, &status);
    if (it)
        status = classify(s, it, steps, &e, &motion, &class);
    json_text(&s->out, "point", method->name);
    json_real(&s->out, "h", h);
    json_text(&s->out, "class", status < 0 ? failure(status) : class);
    json_text(&s->out, "status", pk_status_name(status));
    json_integer(&s->out, "steps", e.steps);
    json_reals(&s->out, {"rise", e.rise / motion.scale}, {"away", e.away / motion.scale});
    json_real(&s->out, "cond",
              status < 0 ? 0 : condition_of_step(&s->run->memory, &s->problem, it));
    json_reals(&s->out, {"exchange", e.watched.exchange}, {"moved", e.watched.moved},
               {"follows", e.watched.follows});
    json_text(&s->out, "constant", e.watched.constant ? e.watched.constant : "");
    stability_watch_end(s, &e.watched);
    stability_end(s, it);
    return 1;
}

/* Questions about rotations and constraints. `place` projects a start onto them; `resolved` judges
 * steps by their state, since a free body's energy may stay constant at any step size. */
#include <pk/constraint.h>

#include "stability.h"

enum { LOOKS = 16 };             /* states along the motion */
static const double STILL = 0.1; /* least unit of a variable, relative to the widest of its kind */

int stability_place(struct pk_stability *s, const struct pk_stability_question *x)
{
    const size_t n = s->n;
    double *y = memory_take(&s->run->memory, 2 * n, sizeof *y);
    enum pk_status status;
    struct pk_integrator *it = stability_motion_begun(s, 1, &status);
    memcpy(y, x->state ? x->state : s->settings->q, n * sizeof *y);
    memcpy(y + n, x->state ? x->state + n : s->settings->v, n * sizeof *y);
    if (it)
        status = pk_constraint_project(it, it->t, y, y + n);
    stability_end(s, it);
    json_text(&s->out, "status", pk_status_name(status));
    json_numbers(&s->out, "q", y, n);
    json_numbers(&s->out, "v", y + n, n);
    memory_drop(&s->run->memory, y);
    return 1;
}

/* Returns the largest |a_i - b_i| of the variables from..to - 1, in units of their boxes. */
static double off(const double *box, const double *a, const double *b, size_t from, size_t to)
{
    double widest = 0, most = 0;
    for (size_t i = from; i < to; i++)
        widest = fmax(widest, box[i]);
    for (size_t i = from; i < to; i++) {
        const double d = fabs(a[i] - b[i]) / fmax(box[i], STILL * widest);
        most = d <= most ? most : d;
    }
    return most;
}

/* Makes `count` steps of a method from the motion's state; *most becomes the largest error. */
static enum pk_status leap(struct pk_stability *s, struct pk_integrator *it,
                           struct pk_integrator *motion, size_t count, double *most)
{
    const struct pk_system *system = s->problem.system;
    const size_t m = s->coordinates, r = system->n_rotations;
    /* Rates of coordinates, body rates, quaternions, first-order variables. */
    const size_t kinds[] = {0, m, m + 3 * r, m + 7 * r, s->n};
    enum pk_status status = pk_integrator_reset(it, motion->t, motion->q, motion->v);
    const double from = motion->t, h = it->options.h;
    for (size_t k = 1; k <= count && status >= 0; k++) {
        status = pk_integrator_step(it, from + (double)(count + 1) * h);
        if (status >= 0 && pk_integrator_to(motion, it->t) < 0)
            return PK_DONE; /* a failure of the motion itself is not the method's */
        if (status < 0)
            break;
        *most = fmax(*most, off(s->box, it->q, motion->q, 0, m));
        for (size_t i = 0; i < 4; i++)
            *most = fmax(*most, off(s->box + s->n, it->v, motion->v, kinds[i], kinds[i + 1]));
    }
    return status;
}

int stability_resolved(struct pk_stability *s, const struct pk_stability_question *x)
{
    const struct pk_method *method = stability_method(s, x->method);
    if (!method)
        return 0;
    if (!(x->h > 0))
        return stability_wrong(s, "a step is positive");
    struct pk_options options = s->settings->options;
    enum pk_status status, known;
    double most = 0;
    options.h = x->h;
    stability_cover(s);
    struct pk_integrator *motion = stability_motion_begun(s, 1, &known);
    struct pk_integrator *it =
        stability_begin(s, method, &options, s->settings->q, s->settings->v, &status);
    for (size_t k = 0; k < LOOKS && it && motion && status >= 0; k++) {
        const double t = s->settings->until * (double)k / LOOKS;
        if (t > motion->t)
            known = pk_integrator_to(motion, t);
        if (known < 0)
            break;
        status = leap(s, it, motion, x->count, &most);
    }
    stability_end(s, it);
    stability_end(s, motion);
    json_text(&s->out, "status", pk_status_name(status));
    json_real(&s->out, "off", most);
    return 1;
}

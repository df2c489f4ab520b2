/* Fastest frequencies and growth rates along the motion: eigenvalues of the equations linearised at
 * up to MOST steps of dop853, whose steps are short where rates are large. Only built with GSL.
 */
#include "../settings/settings.h"
#include "stability.h"

#ifdef PK_WITH_GSL

enum { MOST = 128, MOST_STEPS = 1000000 };

static void print(struct pk_stability *s, const double *states, size_t count, double *room)
{
    const size_t n = s->n;
    struct json *j = &s->out;
    json_open(j, "rates", '[');
    for (size_t k = 0; k < count; k++) {
        const double *at = states + k * (2 * n + 1);
        size_t found;
        const enum pk_status status =
            pk_gsl_rates(&s->problem, at[2 * n], at, at + n, room, room + 2 * n, &found);
        json_open(j, NULL, '{');
        json_real(j, "t", at[2 * n]);
        json_text(j, "status", pk_status_name(status));
        double turns = 0; /* largest |body rate|; the eigenvalues of a quaternion are half of it */
        for (size_t r = 0; r < s->problem.system->n_rotations; r++) {
            const double *w = at + n + s->coordinates + 3 * r;
            turns = fmax(turns, hypot(hypot(w[0], w[1]), w[2]));
        }
        json_numbers(j, "growth", room, found);
        json_numbers(j, "frequency", room + 2 * n, found);
        json_real(j, "turns", turns);
        json_close(j, '}');
    }
    json_close(j, ']');
}

/* Keeps every stride-th state; when the memory is full, drops every second one. */
int stability_fastest(struct pk_stability *s, const struct pk_stability_question *x)
{
    const size_t n = s->n, wide = 2 * n + 1;
    double *states = memory_take(&s->run->memory, MOST * wide + 4 * n, sizeof *states);
    size_t count = 0, stride = 1;
    enum pk_status status;
    struct pk_integrator *it = stability_motion_begun(s, 1, &status);
    (void)x;
    for (size_t step = 0; it && status >= 0 && step < MOST_STEPS; step++) {
        if (step % stride == 0) {
            if (count == MOST) {
                for (size_t k = 0; k < MOST / 2; k++)
                    memcpy(states + k * wide, states + 2 * k * wide, wide * sizeof *states);
                count /= 2;
                stride *= 2;
            }
            if (step % stride == 0) {
                double *at = states + count++ * wide;
                memcpy(at, it->q, it->n_q * sizeof *at);
                memcpy(at + n, it->v, n * sizeof *at);
                at[2 * n] = it->t;
            }
        }
        if (!(it->t < s->settings->until))
            break;
        status = pk_integrator_step(it, s->settings->until);
    }
    stability_end(s, it);
    print(s, states, count, states + MOST * wide);
    memory_drop(&s->run->memory, states);
    return 1;
}

#else
extern int stability_rates_need_gsl; /* ISO C forbids an empty file */
#endif

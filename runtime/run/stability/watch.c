/* Measurements besides energy, of the reference motion and of a method's motion:
 *
 *     exchange  amplitude of a coordinate by the method, relative to the reference motion: the
 *               square root of the ratio of their largest |v_i p_i| (the coordinate's share of v.p)
 *     moved     largest secular change of a proved constant, relative to its scale
 *               (pk/diagnostics.h)
 *     follows   fraction of the time up to the horizon until a coordinate first differs from the
 *               motion by more than APART of its reach, or its rate by more than the largest rate:
 *               pi/3 in phase. First-order variables are not compared
 *
 * Only coordinates with a share above 1e-4 of the largest share count.
 */
#include "../settings/settings.h"
#include "stability.h"

enum { MOST_REALS = 4000000 };     /* numbers kept of states of the motion: 32 MB */
static const double APART = 0.5;   /* tolerated distance, relative to the motion's reach */
static const double PART = 1e-4;   /* least share, relative to the largest */
static const double STEADY = 1e-6; /* largest relative change of a constant in the exact motion */
static const double SECULAR = 0.5; /* part of the change that is a slope, not an oscillation */

void stability_watch_begin(struct pk_stability *s, struct watched *w)
{
    struct memory *memory = &s->run->memory;
    const size_t size = pk_monitor_size(&s->problem);
    *w = (struct watched){
        .lost = HUGE_VAL, .exchange = (double)NAN, .moved = (double)NAN, .follows = (double)NAN};
    w->share = memory_take(memory, 2 * s->n, sizeof *w->share);
    w->swift = w->share + s->n;
    w->block = memory_take(memory, size + 1, 1);
    pk_monitor_init(&w->monitor, &s->problem, w->block, size);
}

void stability_watch_end(struct pk_stability *s, struct watched *w)
{
    if (w->share) {
        memory_drop(&s->run->memory, w->block);
        memory_drop(&s->run->memory, w->share);
    }
    w->share = NULL;
}

void stability_watch(struct pk_stability *s, struct watched *w, double t, const double *q,
                     const double *v)
{
    const double *p = s->work + 2 * s->n; /* of stability_energies() */
    if (s->by_norm)
        return;
    for (size_t i = 0; i < s->coordinates; i++) {
        w->share[i] = fmax(w->share[i], fabs(v[i] * p[i]));
        w->most = fmax(w->most, w->share[i]);
        w->swift[i] = fmax(w->swift[i], fabs(v[i]));
    }
    pk_monitor_update(&w->monitor, t, q, v);
}

void stability_keep(struct pk_stability *s, const double *q, const double *v)
{
    const size_t n = s->n;
    if (s->n_states + 1 != s->n_records || s->n_records * 2 * n > MOST_REALS)
        return; /* no room: the stored motion ends here */
    s->states = memory_room(&s->run->memory, s->states, s->n_records, &s->states_room,
                            2 * n * sizeof *s->states);
    memcpy(s->states + s->n_states * 2 * n, q, s->coordinates * sizeof *q);
    memcpy(s->states + s->n_states * 2 * n + n, v, n * sizeof *v);
    s->n_states++;
}

/* Returns whether q, v are apart from the motion at t: positions are a cubic Hermite interpolant
 * between records k and k + 1, rates a linear one. */
static int is_apart(const struct pk_stability *s, size_t k, double t, const double *q,
                    const double *v)
{
    const size_t n = s->n;
    const double *a = s->states + k * 2 * n, *b = a + 2 * n;
    const double h = s->records[k + 1].t - s->records[k].t, x = (t - s->records[k].t) / h;
    const double y = 1 - x;
    for (size_t i = 0; i < s->coordinates; i++) {
        const double there = y * y * ((1 + 2 * x) * a[i] + x * h * a[n + i]) +
                             x * x * ((1 + 2 * y) * b[i] - y * h * b[n + i]);
        const double rate = y * a[n + i] + x * b[n + i];
        if (s->watched.share[i] > PART * s->watched.most &&
            !(fabs(q[i] - there) <= APART * s->far[2 * n + i] &&
              fabs(v[i] - rate) <= s->watched.swift[i]))
            return 1;
    }
    return 0;
}

void stability_compare(const struct pk_stability *s, struct watched *w, double t, const double *q,
                       const double *v)
{
    const struct record *r = s->records;
    if (w->lost < HUGE_VAL || t > s->settings->until)
        return;
    while (w->at + 2 < s->n_states && r[w->at + 1].t < t)
        w->at++;
    if (w->at + 1 < s->n_states && r[w->at + 1].t >= t && is_apart(s, w->at, t, q, v))
        w->lost = t;
}

static int counts(const struct pk_stability *s, size_t i)
{
    return !s->by_norm && !stability_idle(s, i);
}

static double exchange(const struct pk_stability *s, const struct watched *w)
{
    const size_t n = s->coordinates;
    double most = 0;
    size_t several = 0;
    for (size_t i = 0; i < n; i++) {
        several += (size_t)counts(s, i);
        if (counts(s, i) && w->share[i] > PART * s->watched.most)
            most = fmax(most, sqrt(w->share[i] / s->watched.share[i]));
    }
    return several > 1 ? most : 0;
}

/* Returns the largest change of a constant, relative to its scale in the reference motion, if it is
 * mostly a slope; 0 if it oscillates, has no scale, or is not constant in that motion. */
static double secular(const struct pk_drift *mine, const struct pk_drift *its)
{
    const double far = mine->max / its->scale;
    const double slope = pk_drift_slope(mine) * mine->scale * 2 * mine->mean_t / its->scale;
    if (!(its->scale > 0) || !(its->max < STEADY * its->scale))
        return 0;
    return fabs(slope) > SECULAR * far ? far : 0;
}

static void constants(const struct pk_stability *s, struct watched *w)
{
    const struct pk_system *system = s->problem.system;
    const struct pk_monitor *mine = &w->monitor, *its = &s->watched.monitor;
    const size_t momenta = system->cyclic && system->canonical ? s->n : 0;
    for (size_t i = 0; !s->by_norm && i < momenta + system->n_conserved; i++) {
        const int momentum = i < momenta;
        if (momentum && !system->cyclic[i])
            continue;
        const struct pk_quantity *of = momentum ? system->momenta + i
                                                : system->conserved + (i - momenta);
        const double far =
            momentum ? secular(&mine->momenta[i], &its->momenta[i])
                     : secular(&mine->conserved[i - momenta], &its->conserved[i - momenta]);
        if (far > w->moved) {
            w->moved = far;
            w->constant = of->name;
        }
    }
}

void stability_judge(struct pk_stability *s, struct watched *w)
{
    const double known = fmin(s->horizon, s->settings->until);
    w->follows = w->lost < known ? w->lost / known : 1;
    w->exchange = exchange(s, w);
    w->moved = 0;
    constants(s, w);
}

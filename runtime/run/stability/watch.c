/* What is watched of a motion besides its energy, of the motion itself and of what methods make of
 * it:
 *
 *     exchange  how many times as far a coordinate swings by the method as in the motion itself:
 *               the root of the quotient of the largest |v_i p_i|, its share of v.p
 *     moved     how far a constant that is proved has come from its first value, relative to its
 *               scale (pk/diagnostics.h)
 *     follows   the part of the time, up to the horizon, over which no coordinate is APART from the
 *               motion by half of how far that goes, nor its rate by the largest there: a third of
 *               pi in phase. Of first-order variables it is not judged
 *
 * A coordinate counts whose share is a ten-thousandth of the largest.
 */
#include "../settings/settings.h"
#include "stability.h"

enum { MOST_REALS = 4000000 };     /* kept of states of the motion: 32 MB */
static const double APART = 0.5;   /* of how far the motion goes: another is elsewhere there */
static const double PART = 1e-4;   /* of the largest share */
static const double STEADY = 1e-6; /* a constant that moves less by the motion itself is one */
static const double SECULAR = 0.5; /* of how far it moved is a slope, not an oscillation */

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
        return; /* what is known of the motion ends before */
    s->states = memory_room(&s->run->memory, s->states, s->n_records, &s->states_room,
                            2 * n * sizeof *s->states);
    memcpy(s->states + s->n_states * 2 * n, q, s->coordinates * sizeof *q);
    memcpy(s->states + s->n_states * 2 * n + n, v, n * sizeof *v);
    s->n_states++;
}

/* From the motion at time t between records k and k + 1, of which it is a cubic. */
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

/* How far it moved, secularly, in the scale that the motion itself gives it; 0 of what has none, or
 * is no constant of the motion. */
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

/* The reference motion, by dop853 at 1e-10, with which methods are compared. It is followed for as
 * long as a point of the map, which at long steps goes past `until`.
 *
 * The motion "leaves", and then judges no method, if two conditions hold. A coordinate that is not
 * cyclic still moves away at `until`, by a fifth more in each of the last two quarters. And nothing
 * returns: v.p, twice the kinetic energy, has no extremum in the last half; or, if energy is
 * constant, the range of v.p grows by half in each of these quarters. x'' = x, a fall and a free
 * flight leave; a driven resonance and a chain that drifts while it vibrates do not.
 */

#include <pk/methods.h>

#include "../settings/settings.h"
#include "stability.h"

enum { MOST_RECORDS = 4000000 };
static const double LOOSER = 1e3;  /* factor of rtol for horizon() */
static const double SLIGHT = 1e-3; /* least range of v.p, relative to the largest |v.p| */

static void keep(struct pk_stability *s, double t, const double *q, const double *v)
{
    s->records =
        memory_room(&s->run->memory, s->records, s->n_records + 1, &s->room, sizeof *s->records);
    struct record *r = &s->records[s->n_records++];
    r->t = t;
    stability_energies(s, t, q, v, &r->energy, &r->vp, &r->size);
    stability_watch(s, &s->watched, t, q, v);
    stability_keep(s, q, v);
}

/* Follows the motion to `until`, or to its end; far[i] becomes the largest |q_i - q0_i|. */
static void go_on(struct pk_stability *s, double until, double *far)
{
    struct pk_integrator *it = s->exact;
    while (s->motion >= 0 && it->t < until) {
        s->motion = s->n_records < MOST_RECORDS ? pk_integrator_step(it, until) : PK_TOO_MANY_STEPS;
        if (s->motion < 0)
            break;
        keep(s, it->t, it->q, it->v);
        condition_step(s->looking, NULL, s->settings->until, &(struct moment){it->t, it->q, it->v});
        for (size_t i = 0; i < s->n; i++)
            far[i] = fmax(far[i], fabs(stability_apart(s, it->q, it->v, i)));
    }
}

static struct reference summary(const struct pk_stability *s, double until)
{
    const int constant = !s->by_norm && (s->problem.system->facts & PK_CONSERVATIVE) != 0;
    const struct record *r = s->records;
    struct reference found = {.top = r->energy, .low = r->energy, .high = r->energy};
    double least = r->vp, most = r->vp;
    int late = 0;
    for (size_t k = 0; k < s->n_records && r[k].t <= until; k++) {
        const int last = k + 1 == s->n_records || r[k + 1].t > until;
        least = fmin(least, r[k].vp);
        most = fmax(most, r[k].vp);
        found.size = fmax(found.size, r[k].size);
        if (constant)
            continue;
        found.top = fmax(found.top, r[k].energy);
        if (r[k].t >= 0.75 * until || (last && !late)) {
            found.low = late ? fmin(found.low, r[k].energy) : r[k].energy;
            found.high = late ? fmax(found.high, r[k].energy) : r[k].energy;
            late = 1;
        }
    }
    found.scale = fmax(most - least, SLIGHT * fmax(fabs(most), fabs(least)));
    found.judges = !s->leaves && s->motion >= 0;
    return found;
}

struct reference stability_reference(struct pk_stability *s, double until)
{
    go_on(s, until, s->far + 2 * s->n);
    return summary(s, until);
}

/* Returns whether v.p is monotonic in the last half, up to round-off. */
static int turns_no_more(const struct pk_stability *s, double until)
{
    double path = 0, least = HUGE_VAL, most = -HUGE_VAL, before = 0;
    for (size_t k = 0; k < s->n_records; k++) {
        const double vp = s->records[k].vp;
        if (s->records[k].t < until / 2)
            continue;
        path += most < least ? 0 : fabs(vp - before);
        least = fmin(least, vp);
        most = fmax(most, vp);
        before = vp;
    }
    return path <= 1.01 * (most - least) + 1e-6 * fmax(fabs(most), fabs(least));
}

static int leaves(const struct pk_stability *s, double until, const double scales[3])
{
    const struct pk_system *system = s->problem.system;
    int away = 0;
    for (size_t i = 0; i < s->n; i++)
        if (!stability_idle(s, i))
            away |= s->far[s->n + i] > 1.2 * s->far[i] &&
                    s->far[2 * s->n + i] > 1.2 * s->far[s->n + i];
    const int faster = !s->by_norm && (system->facts & PK_CONSERVATIVE) != 0 &&
                       scales[1] > 1.5 * scales[0] && scales[2] > 1.5 * scales[1];
    /* With rotations or constraints, the coordinates of a steady motion are not marked cyclic. */
    const int evenly = (system->n_rotations || system->constraints.n) &&
                       (system->facts & PK_CONSERVATIVE) != 0;
    return away && (faster || (!evenly && turns_no_more(s, until)));
}

struct pk_integrator *stability_motion_begun(struct pk_stability *s, double looser,
                                             enum pk_status *status)
{
    struct pk_options options = s->settings->options;
    options.rtol = looser * 1e-10;
    options.atol = PK_ATOL_OF_MOTION;
    options.h = 0;
    return stability_begin(s, &pk_method_dop853, &options, s->settings->q, s->settings->v, status);
}

static void stretch(double *low, double *high, const double *x, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        low[i] = fmin(low[i], x[i]);
        high[i] = fmax(high[i], x[i]);
    }
}

/* Gives variables that stay at 0 the box of the widest variable of their kind. */
static void widen(double *box, size_t from, size_t to, double others)
{
    double widest = 0;
    for (size_t i = from; i < to; i++)
        widest = fmax(widest, box[i]);
    for (size_t i = from; i < to; i++)
        if (!(box[i] > 0))
            box[i] = widest > 0 ? widest : others > 0 ? others : 1;
}

void stability_cover(struct pk_stability *s)
{
    const size_t n = s->n, m = s->coordinates;
    const size_t r = s->problem.system->n_rotations;
    /* Coordinates, integrals of first-order variables, rates, body rates, quaternions, others. */
    const size_t kinds[] = {0, m, n, n + m, n + m + 3 * r, n + m + 7 * r, 2 * n};
    double most = 0;
    enum pk_status status;
    if (s->box)
        return;
    double *low = s->middle = memory_take(&s->run->memory, 5 * n, sizeof *s->box);
    double *high = s->box = low + 2 * n;
    s->reach = high + 2 * n;
    memcpy(low, s->settings->q, n * sizeof *low);
    memcpy(low + n, s->settings->v, n * sizeof *low);
    memcpy(high, low, 2 * n * sizeof *low);
    struct pk_integrator *it = stability_motion_begun(s, 1, &status);
    for (size_t k = 0; it && k < MOST_RECORDS && it->t < s->settings->until; k++) {
        if (pk_integrator_step(it, s->settings->until) < 0)
            break;
        stretch(low, high, it->q, m);
        stretch(low + n, high + n, it->v, n);
    }
    stability_end(s, it);
    for (size_t i = 0; i < n; i++) {
        const size_t x = i < m ? i : n + i;
        const double start = i < m ? s->settings->q[i] : s->settings->v[i];
        s->reach[i] = fmax(high[x] - start, start - low[x]);
    }
    for (size_t i = 0; i < 2 * n; i++) {
        const double a = low[i], b = high[i];
        low[i] = (a + b) / 2;
        high[i] = b - a > 1e-9 * fabs(a + b) ? b - a : fabs(a + b) / 2;
        most = i < m || i >= n ? fmax(most, high[i]) : most;
    }
    for (size_t k = 0; k + 1 < sizeof kinds / sizeof *kinds; k++)
        widen(high, kinds[k], kinds[k + 1], most);
}

static void begin(struct pk_stability *s)
{
    if (s->by_norm)
        stability_cover(s);
    stability_end(s, s->exact);
    memory_drop(&s->run->memory, s->looking);
    s->looking = condition_begin(&s->run->memory, &s->problem, NULL);
    s->exact = stability_motion_begun(s, 1, &s->motion);
    s->known = s->leaves = 0;
    memset(s->far, 0, 3 * s->n * sizeof *s->far);
    s->n_records = s->n_states = 0;
    stability_watch_end(s, &s->watched);
    stability_watch_begin(s, &s->watched);
    keep(s, 0, s->settings->q, s->settings->v);
}

/* Returns the time until which a looser tolerance agrees: so long the motion is known; or
 * infinity. */
static double horizon(struct pk_stability *s)
{
    struct watched other = {.lost = HUGE_VAL};
    enum pk_status status;
    struct pk_integrator *it = stability_motion_begun(s, LOOSER, &status);
    while (it && it->t < s->settings->until && other.lost == HUGE_VAL) {
        if (pk_integrator_step(it, s->settings->until) < 0)
            other.lost = it->t;
        else
            stability_compare(s, &other, it->t, it->q, it->v);
    }
    stability_end(s, it);
    return other.lost;
}

static int print(struct pk_stability *s, double scale)
{
    const struct record *first = s->records, *last = first + s->n_records - 1;
    struct json *j = &s->out;
    json_text(j, "motion", s->motion < 0 ? pk_status_name(s->motion) : "PK_DONE");
    json_flag(j, "leaves", s->leaves);
    json_flag(j, "by_norm", s->by_norm);
    json_real(j, "horizon",
              s->known && s->horizon < s->settings->until ? s->horizon : s->settings->until);
    json_reals(j, {"t", last->t}, {"energy", first->energy}, {"scale", scale});
    json_numbers(j, "q", s->settings->q, s->n);
    json_numbers(j, "v", s->settings->v, s->n);
    json_parameters_known(j, s->problem.system, s->problem.params);
    condition_report(s->looking, j);
    char reason[640];
    if (condition_warning(s->looking, reason, sizeof reason))
        json_text(j, "warning", reason);
    return 1;
}

int stability_ready(struct pk_stability *s, const struct pk_stability_question *x)
{
    (void)x;
    begin(s);
    return print(s, summary(s, 0).scale);
}

int stability_motion(struct pk_stability *s, const struct pk_stability_question *x)
{
    (void)x;
    const double until = s->settings->until;
    const size_t n = s->n;
    double scales[3];
    begin(s);
    for (size_t k = 0; k < 3; k++) { /* up to a half, three quarters, all of `until` */
        const double part = (double)(k + 2) / 4 * until;
        go_on(s, part, s->far + k * n);
        if (k < 2)
            memcpy(s->far + (k + 1) * n, s->far + k * n, n * sizeof *s->far);
        scales[k] = summary(s, part).scale;
    }
    s->known = 1;
    s->horizon = horizon(s);
    s->leaves = s->motion >= 0 && leaves(s, until, scales);
    return print(s, scales[2]);
}

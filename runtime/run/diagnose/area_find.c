/* The area that the members of an ensemble enclose if they form a loop in phase space. The area is
 * the closed integral of p dq, summed over coordinates, which any flow of a Lagrangian L preserves
 * (Poincare). The loop is represented by Fourier series of q and p over its members. The motion
 * stretches the loop until its members are too few; then the last harmonics are large.
 *
 * The size of a series' last harmonics, called its tail, measures how well the series is resolved.
 * A coordinate that contributes little to the sum may be resolved badly. The tail is therefore
 * weighted by rms(q) rms(p) of its coordinate, relative to the sum over coordinates. If a tail is
 * large and its harmonics decay, the loop has details finer than the spacing of its members; then
 * the area is meaningless. If a tail is small and its harmonics do not decay, it is due to errors
 * of single members, by round-off or step sizes; their effect on the area is known (`noise`).
 * Reference: V. I. Arnold, Mathematical Methods of Classical Mechanics, 44. */
#include "area.h"

#include "../settings/settings.h"

#ifdef PK_WITH_GSL
#include <pk/gsl.h>

#define RESOLVED 1e-12 /* largest weighted tail of a resolved loop */
/* largest weighted tail of a loop with noise; that of a torn (not closed) loop is larger */
#define NOISY 1e-6

enum quality { GOOD, NOISE, COVERED, FINER };

struct finding {
    struct loop *l;
    size_t common;              /* number of rows that all members have */
    double *winding;            /* increase of each coordinate in one turn round the loop */
    struct pk_loop_area *parts; /* areas by row, then coordinate */
    int smooth, adaptive;
};

static const struct pk_loop_area *part(const struct finding *f, size_t row, size_t i)
{
    return f->parts + row * f->l->n + i;
}

static double size_at(const struct finding *f, size_t row)
{
    double sum = 0;
    for (size_t i = 0; i < f->l->n; i++)
        sum += part(f, row, i)->size;
    return sum;
}

static double weight(double size, double of_all) { return of_all > 0 ? size / of_all : 1; }

static double allowed(double rounding) { return fmax(RESOLVED, fmin(rounding, NOISY)); }

static enum quality judge(const struct finding *f, const struct pk_loop_series *s, double w)
{
    const double tail = s->tail * w;
    if (tail <= allowed(s->rounding * w))
        return GOOD;
    if (!s->flat)
        return FINER;
    return tail <= NOISY && f->smooth ? NOISE : COVERED;
}

struct row {
    double area, size, noise, tail;
    enum quality quality;
};

static struct row row_of(const struct finding *f, size_t row)
{
    struct row found = {0, size_at(f, row), 0, 0, GOOD};
    for (size_t i = 0; i < f->l->n; i++) {
        const struct pk_loop_area *x = part(f, row, i);
        const double w = weight(x->size, found.size);
        const struct pk_loop_series *const series[] = {&x->q, &x->p};
        found.area += x->area;
        found.noise = hypot(found.noise, x->noise);
        for (size_t k = 0; k < 2; k++) {
            const enum quality quality = judge(f, series[k], w);
            found.tail = fmax(found.tail, series[k]->tail * w);
            found.quality = quality > found.quality ? quality : found.quality;
        }
    }
    return found;
}

/* Returns whether q_i and q_i + turn are the same position. At three members, with nonzero rates, p
 * and pdot must be the same for both. */
static int is_turn(struct pk_run *run, size_t i, double turn)
{
    const struct loop *l = run->loop;
    const struct settings *s = &run->settings;
    const size_t n = l->whole;
    const char *unit = s->system->coordinates ? s->system->coordinates[i].unit : NULL;
    pk_real *q = memory_take(&run->memory, 6 * n, sizeof *q), *v = q + n;
    pk_real *p = v + n, *P = p + 2 * n; /* p holds p and pdot at q_i, P the same at q_i + turn */
    int same = !unit || !*unit || strcmp(unit, "1") == 0 || strcmp(unit, "rad") == 0;
    for (size_t k = 0; k < 3 && same; k++) {
        double off = 0, most = 0;
        memcpy(v, s->v, n * sizeof *v);
        for (size_t j = 0; j < l->n; j++) {
            q[j] = (pk_real)area_series(l, 0, j, 0)[k * l->members / 3];
            v[j] = PK_C(0.7) / (pk_real)(j + k + 1);
        }
        s->system->canonical(s->params, 0, q, v, s->u, p, p + n);
        q[i] += (pk_real)turn;
        s->system->canonical(s->params, 0, q, v, s->u, P, P + n);
        for (size_t j = 0; j < 2 * n; j++) {
            off = fmax(off, fabs((double)(p[j] - P[j])));
            most = fmax(most, fabs((double)p[j]));
        }
        same = off <= 1e-9 * most;
    }
    return same;
}

/* Returns the increase of a coordinate in one turn round the initial loop: whole turns of an angle,
 * otherwise 0. */
static double winding_of(struct pk_run *run, size_t i)
{
    const size_t count = run->loop->members;
    const double *q = area_series(run->loop, 0, i, 0);
    const double gap = 2 * q[count - 1] - q[count - 2] - q[0];
    const double turn = 2 * PK_PI * round(gap / (2 * PK_PI));
    return fabs(turn) > 0 && is_turn(run, i, turn) ? turn : 0;
}

/* Differences between neighbouring members in a series of q or p. `closing`: from the last member
 * to the first; `before`: between the last two members. */
struct ends {
    double closing, before;
};

static struct ends ends_of(const double *x, size_t count, double winding)
{
    return (struct ends){x[0] + winding - x[count - 1], x[count - 1] - x[count - 2]};
}

/* Writes why the initial states form no loop and returns 1, or returns 0 if they form one. The
 * weight of a coordinate is the larger of its weights at rows 0 and 1, since q or p may be 0 for
 * all members at the start. A series that is 0 or round-off is not checked. */
static int no_loop(const struct pk_run *run, const struct finding *f, const struct ends *ends,
                   char *reason, size_t size)
{
    const struct loop *l = f->l;
    const size_t next = f->common > 1;
    const double all = fmax(size_at(f, 0), size_at(f, next));
    double worst = 0;
    if (!(all > 0)) {
        snprintf(reason, size,
                 "the starts are no loop: they enclose nothing, all of them in one "
                 "place or with the same q or the same p, or less than a double holds");
        return 1;
    }
    for (size_t k = 0; k < 2 * l->n; k++) {
        const struct pk_loop_area *now = part(f, 0, k / 2), *then = part(f, next, k / 2);
        const struct pk_loop_series *s = k % 2 ? &now->p : &now->q;
        const double later = k % 2 ? then->p.rms : then->q.rms;
        const double w = weight(fmax(now->size, then->size), all), tail = w * s->tail;
        if (s->rms <= 16 * PK_EPSILON * later || tail <= allowed(s->rounding * w) || tail <= worst)
            continue;
        char name[128];
        worst = tail;
        pk_system_name(run->settings.system, run->settings.params,
                       run->settings.system->coordinates, k / 2, name, sizeof name);
        snprintf(
            reason, size,
            "the starts are no smooth closed loop with members equally far apart, or too few "
            "for it, or of too few digits: %.1e of %s%s is in its last harmonics; from the last "
            "member to the first it goes by %.3g, from the one before by %.3g",
            s->tail, k % 2 ? "the momentum of " : "", name, ends[k].closing, ends[k].before);
    }
    return worst > 0;
}

/* Computes the areas at all rows that all members have; overwrites the series. */
static enum pk_status transform(struct pk_run *run, struct finding *f)
{
    const struct loop *l = f->l;
    for (size_t row = 0; row < f->common; row++) {
        for (size_t i = 0; i < l->n; i++) {
            const enum pk_status status =
                pk_gsl_loop_area(area_series(l, row, i, 0), area_series(l, row, i, 1), l->members,
                                 f->winding[i], f->parts + row * l->n + i);
            if (status == PK_NOT_FINITE && row > 0) { /* M is singular, or numbers overflow */
                f->common = row;
                return PK_DONE;
            }
            if (status < 0)
                return status;
        }
        if (run_stopped(run, (double)row / (double)l->rows))
            return PK_STOPPED_USER;
    }
    return PK_DONE;
}

static const char *words_of(const struct finding *f, enum quality quality)
{
    if (!f->smooth)
        return "it has kinks, where the equations have (abs, min, max, step), or is finer than its "
               "members are apart";
    if (quality == COVERED && f->adaptive)
        return "each member's own error, by steps of its own, covers it, or it is finer than they "
               "are apart: take a fixed step, of a symplectic method (--method gauss8 --step H)";
    return "it is finer than its members are apart";
}

/* Writes why some members lack rows; returns 0 if no member does. */
static int parted(const struct pk_run *run, const struct finding *f, char *text, size_t size)
{
    const struct loop *l = f->l;
    size_t missing = 0, first = 0;
    if (f->common == l->rows)
        return 0;
    for (size_t k = l->members; k-- > 0;)
        if (l->came[k] <= f->common)
            missing++, first = k;
    if (missing)
        snprintf(
            text, size,
            "%zu of %zu members, first member %ld, are not there at t = %.6g, for %s: the last "
            "row that all have is at t = %.6g",
            missing, l->members, member_number(&run->settings, first), l->t[f->common], l->gone,
            l->t[f->common - 1]);
    else
        snprintf(text, size,
                 "q, p or the area is not finite at t = %.6g: the last row before is at t = %.6g",
                 l->t[f->common], l->t[f->common - 1]);
    return 1;
}

static void write_rows(struct diagnostics *d, const struct finding *f)
{
    struct pk_run *run = d->run;
    const struct loop *l = f->l;
    struct json *j = &d->json;
    struct pk_drift drift;
    /* `size`: the loop's size at the first row where it is not 0; all members may begin at rest */
    double until = -1, size = 0;
    char ends[400] = "", apart[400] = "";
    int resolved = 1;
    if (parted(run, f, apart, sizeof apart)) {
        run_say(run, "diagnose area: %s", apart);
        d->code = 4;
    }
    pk_drift_init(&drift);
    json_integer(j, "members", l->members);
    json_numbers(j, "winding", f->winding, l->n);
    json_real(j, "threshold", RESOLVED);
    json_flag(j, "conserved", (run->settings.system->facts & PK_VARIATIONAL) != 0);
    json_open(j, "rows", '[');
    for (size_t k = 0; k < f->common; k++) {
        const struct row row = row_of(f, k);
        if (resolved && row.quality > NOISE) {
            resolved = 0;
            snprintf(ends, sizeof ends, "%s", words_of(f, row.quality));
        }
        if (resolved) {
            size = size > 0 ? size : row.size;
            pk_drift_update_scaled(&drift, l->t[k], row.area, fmax(fabs(row.area), size));
            until = l->t[k];
        }
        const double numbers[] = {l->t[k], row.area, row.tail, row.noise};
        json_numbers(j, NULL, numbers, 4);
    }
    json_close(j, ']');
    json_real(j, "resolved_until", until);
    json_text(j, "ends", *ends ? ends : *apart ? apart : NULL);
    if (drift.samples > 1)
        report_drift(j, "drift", "area", &drift);
    else
        json_text(j, "drift", NULL);
}

static size_t rows_of_all(const struct loop *l)
{
    size_t least = l->rows;
    for (size_t k = 0; k < l->members; k++)
        least = l->came[k] < least ? l->came[k] : least;
    return least;
}

static void find(struct diagnostics *d)
{
    struct pk_run *run = d->run;
    struct loop *l = run->loop;
    struct finding f = {.l = l, .common = rows_of_all(l)};
    char reason[512] = "";
    f.smooth = (run->settings.system->facts & PK_SMOOTH) != 0;
    f.adaptive = !run->model->ensemble->fixed(&run->settings);
    f.winding = memory_take(&run->memory, l->n, sizeof *f.winding);
    f.parts = memory_take(&run->memory, l->rows * l->n, sizeof *f.parts);
    struct ends *ends = memory_take(&run->memory, 2 * l->n, sizeof *ends);
    enum pk_status status = f.common ? PK_DONE : PK_NOT_FINITE;
    for (size_t i = 0; i < l->n && status == PK_DONE; i++) {
        f.winding[i] = winding_of(run, i);
        for (int k = 0; k < 2; k++)
            ends[2 * i + (size_t)k] =
                ends_of(area_series(l, 0, i, k), l->members, k ? 0 : f.winding[i]);
    }
    if (status == PK_DONE)
        status = transform(run, &f);
    if (status == PK_DONE && no_loop(run, &f, ends, reason, sizeof reason))
        status = PK_REFUSED;
    else
        snprintf(reason, sizeof reason, "%s",
                 !f.common                 ? "there are members that could not start"
                 : status == PK_NOT_FINITE ? "q, p or the area is not finite at the start"
                                           : pk_status_text(status));
    if (diagnose_told(d, status, reason, NULL))
        write_rows(d, &f);
}

enum pk_run_code area_find(struct pk_run *run, enum pk_run_code code, const char *gone)
{
    run->loop->gone = gone;
    struct diagnostics *d = diagnose_open(run);
    diagnose_one(d, "area", find);
    diagnose_close(d);
    return code ? code : d->code;
}
#else
enum pk_run_code area_find(struct pk_run *run, enum pk_run_code code, const char *gone)
{
    (void)run, (void)gone;
    return code;
}
#endif

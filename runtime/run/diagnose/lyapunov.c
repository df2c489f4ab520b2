/* The largest Lyapunov exponent of a run, and its interpretation; see motion.h.
 *
 * Exponential growth of displacements means chaos only if the motion stays bounded. If the motion
 * is still moving away from its start at the end, or does not move at all, growth only shows that a
 * simple motion (an equilibrium, a steady rotation) is unstable. A single coordinate, or two
 * first-order variables, without explicit time cannot be chaotic: orbits are curves in a plane
 * (Poincare and Bendixson). */

#include "../../src/core/internal.h"
#include "parts.h"

enum { RATES = 64 }; /* limit of the number of values of G from which the exponent is estimated */
/* A displacement is normalised before its length leaves 1/LARGE .. LARGE, even within a block. */
#define LARGE PK_C(1e12)
#define REST 1e-8 /* an excursion below this fraction of the largest coordinate counts as rest */
/* A motion leaves if its excursion in the second half of the run exceeds that in the first half by
 * more than this factor. An excursion that grows as t^3 gives 8. */
#define LEAVING 8

static pk_real length(const struct lyapunov *l, const pk_real *Q, const pk_real *V)
{
    variation_take(&l->variation, V, 1, l->variation.v);
    return metric_length(&l->metric, Q + l->variation.n_q, l->variation.v);
}

/* Normalises the displacement of the start. Returns the log of its length, perhaps not finite. */
static pk_real normalise(struct lyapunov *l)
{
    const struct variation *of = &l->variation;
    const pk_real size = length(l, of->Q, of->V);
    for (size_t i = of->n_q; i < 2 * of->n_q; i++)
        of->Q[i] /= size;
    for (size_t i = 0; i < of->n; i++)
        of->V[variation_place(of, 1, i)] /= size;
    return PK_F(log)(size);
}

enum pk_status lyapunov_begin(struct lyapunov *l, const struct motion *m, pk_real block)
{
    struct variation *of = &l->variation;
    memset(l, 0, sizeof *l);
    PK_TRY(variation_init(of, m, 1));
    PK_TRY(metric_init(&l->metric, of, m->t, m->q, m->v, block));
    l->G = memory_take(m->memory, LYAPUNOV_BLOCKS, sizeof *l->G);
    l->block = block;
    if (pk_is_fixed(m->method) && m->options.h > 0)
        l->block = m->options.h * pk_max(1, PK_F(ceil)(block / m->options.h - PK_C(1e-6)));
    /* A direction without any symmetry: fractional parts of multiples of the golden section. */
    const size_t n = of->n;
    const pk_real root = PK_F(sqrt)(l->metric.tau);
    pk_real *dq = of->a, *dv = of->b, part = 0;
    for (size_t i = 0; i < 2 * n; i++) {
        part += PK_C(0.61803398874989484820458683436563812);
        part -= part >= 1 ? 1 : 0;
        (i < n ? dq : dv)[i % n] = part + PK_C(0.1);
    }
    metric_dq(&l->metric, dq); /* makes the components of similar length, whatever their units */
    metric_dq(&l->metric, dv);
    for (size_t i = 0; i < n; i++) {
        dq[i] *= root;
        dv[i] /= root;
    }
    memcpy(of->Q + of->n_q, dq, of->n_q * sizeof *dq);
    variation_put(of, dv, 1, of->V);
    normalise(l);
    return motion_begin(&of->motion);
}

/* Normalises the displacement and adds the logarithm of its length to G. */
static enum pk_status renew(struct lyapunov *l)
{
    const struct variation *of = &l->variation;
    struct pk_integrator *it = &l->variation.motion.it;
    memcpy(of->Q, it->q, 2 * of->n_q * sizeof *of->Q);
    memcpy(of->V, it->v, 2 * of->n * sizeof *of->V);
    const pk_real grown = normalise(l);
    if (!pk_finite(grown))
        return it->status = PK_NOT_FINITE;
    l->grown += grown;
    return pk_integrator_reset(it, it->t, of->Q, of->V);
}

enum pk_status lyapunov_step(struct lyapunov *l)
{
    struct pk_integrator *it = &l->variation.motion.it;
    const pk_real end = l->variation.motion.t + (pk_real)(l->blocks + 1) * l->block;
    while (it->t < end) {
        PK_TRY(pk_integrator_step(it, end));
        const pk_real size = length(l, it->q, it->v);
        if (it->t < end && (!(size < LARGE) || !(size > 1 / LARGE)))
            PK_TRY(renew(l));
    }
    PK_TRY(renew(l));
    l->G[l->blocks++] = l->grown;
    return PK_DONE;
}

/* Returns the increase of G per unit of time in mark k: the marks are `stride` blocks long. */
static pk_real rate(const struct lyapunov *l, size_t k, size_t stride)
{
    return (l->G[(k + 1) * stride - 1] - l->G[k * stride - 1]) / (l->block * (pk_real)stride);
}

struct growth lyapunov_growth(const struct lyapunov *l)
{
    struct growth found = {0, PK_INFINITY, 0, UNDECIDED};
    pk_real before = 0, Y = 0, sum_G = 0, sum_Y = 0, var = 0;
    size_t stride = 1;
    for (size_t k = 0; k < l->blocks; k++) { /* integrals over t, by trapezoids */
        const pk_real last = Y;
        sum_G += l->block * (before + l->G[k]) / 2;
        Y = 2 * (l->G[k] - sum_G / ((pk_real)(k + 1) * l->block));
        sum_Y += l->block * (last + Y) / 2;
        before = l->G[k];
    }
    if (l->blocks)
        found.megno = sum_Y / ((pk_real)l->blocks * l->block);
    while (l->blocks > RATES * stride)
        stride *= 2;
    const size_t n = l->blocks / stride, first = (n + 9) / 10;
    if (n < 16)
        return found;
    const pk_real count = (pk_real)(n - first);
    for (size_t k = first; k < n; k++)
        found.exponent += rate(l, k, stride) / count;
    for (size_t k = first; k < n; k++) {
        const pk_real d = rate(l, k, stride) - found.exponent;
        var += d * d / (count - 1);
    }
    found.error = PK_F(sqrt)(var / count);
    found.kind = found.megno <= 3 ? REGULAR : found.megno >= 6 ? CHAOTIC : UNDECIDED;
    return found;
}

/* Returns whether a motion leaves its start or rests; `most` has the excursions of both halves. */
static int leaves(const pk_real *most, const struct settings *s)
{
    int moves = 0;
    pk_real size = 0;
    for (size_t i = 0; i < s->n; i++)
        size = PK_F(fmax)(size, PK_F(fabs)(s->q[i]));
    for (size_t i = 0; i < 2 * s->n; i++) {
        if (most[2 * s->n + i] > LEAVING * most[i])
            return 1;
        moves |= most[2 * s->n + i] > (pk_real)REST * size;
    }
    return !moves;
}

static int can_be_chaotic(const struct pk_run *run)
{
    const struct pk_system *system = run->problem.system;
    const size_t dimension = 2 * system->n - system->n_first_order;
    return dimension > 2 || system->families.count || run->acts || !(system->facts & PK_AUTONOMOUS);
}

static enum pk_status by_variation(struct lyapunov *l, struct pk_run *run, pk_real *most,
                                   const char **why)
{
    const struct settings *s = &run->settings;
    const struct motion m = motion_of(run);
    const struct pk_integrator *it = &l->variation.motion.it;
    /* Displacements that violate the constraints may grow although no allowed motion does. */
    *why = s->system->constraints.n ? diagnose_not_free(s->system) : NULL;
    enum pk_status status = *why ? PK_REFUSED : lyapunov_begin(l, &m, m.end / LYAPUNOV_BLOCKS);
    for (int k = 0; status >= 0 && k < LYAPUNOV_BLOCKS && it->t < m.end; k++) {
        status = lyapunov_step(l);
        motion_note(most + (2 * k >= LYAPUNOV_BLOCKS ? 2 * s->n : 0), s, it);
        if (run_stopped(run, (double)(it->t / m.end)))
            break;
    }
    if (!*why && status == PK_REFUSED)
        *why = diagnose_no_variation(run);
    return status;
}

void diagnose_lyapunov(struct diagnostics *d)
{
    static const char *const kinds[] = {"regular", "chaotic", "undecided"};
    struct pk_run *run = d->run;
    const struct settings *s = &run->settings;
    struct lyapunov l = {0};
    const struct pk_integrator *it = &l.variation.motion.it;
    pk_real *most = memory_take(&run->memory, 4 * s->n, sizeof *most);
    const char *why = NULL;
    const enum pk_status status = run->acts ? lyapunov_beside(&l, run, &run->memory, most, &why)
                                            : by_variation(&l, run, most, &why);
    if (diagnose_told(d, status, why, it)) {
        const struct growth found = lyapunov_growth(&l);
        /* stored even for an unbounded motion, since round-off errors grow at this rate, too */
        if (found.kind == CHAOTIC)
            d->exponent = (double)found.exponent;
        json_reals(&d->json, {"exponent", found.exponent}, {"error", found.error},
                   {"megno", found.megno}, {"time", run->acts ? run->it.t : it->t});
        json_text(&d->json, "motion",
                  found.kind == CHAOTIC && (leaves(most, s) || !can_be_chaotic(run))
                      ? "leaving"
                      : kinds[found.kind]);
    }
    pk_integrator_free(&l.variation.motion.it);
}

struct member {
    struct pk_run *of;
    struct motion motion;
    pk_real exponent;
};

static void of_member(void *context)
{
    struct member *x = context;
    struct lyapunov l = {0};
    const pk_real end = x->motion.end;
    enum pk_status status;
    if (x->of->acts) {
        pk_real *most = memory_take(x->motion.memory, 4 * x->of->settings.n, sizeof *most);
        const char *why;
        status = lyapunov_beside(&l, x->of, x->motion.memory, most, &why);
    } else {
        status = lyapunov_begin(&l, &x->motion, end / LYAPUNOV_BLOCKS);
        for (int k = 0; status >= 0 && k < LYAPUNOV_BLOCKS && l.variation.motion.it.t < end; k++)
            status = lyapunov_step(&l);
    }
    if (status >= 0)
        x->exponent = lyapunov_growth(&l).exponent;
    pk_integrator_free(&l.variation.motion.it);
}

/* Returns the largest exponent of an ensemble member that has a struct pk_run; NAN on failure. */
pk_real diagnose_exponent(struct pk_run *of)
{
    struct memory memory = {0};
    struct member x = {of, motion_of(of), (pk_real)NAN};
    x.motion.memory = &memory;
    if (of->acts || !of->problem.system->constraints.n)
        memory_try(&memory, of_member, &x);
    memory_end(&memory);
    return x.exponent;
}

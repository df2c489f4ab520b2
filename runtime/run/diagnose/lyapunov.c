/* The largest Lyapunov exponent of a run, and its interpretation.
 *
 * Exponential growth of displacements means chaos only if the motion stays bounded. If the motion
 * is still moving away from its start at the end, or does not move at all, growth only shows that a
 * simple motion (an equilibrium, a steady rotation) is unstable. A single coordinate, or two
 * first-order variables, without explicit time cannot be chaotic: orbits are curves in a plane
 * (Poincare and Bendixson).
 */

#include <pk/lyapunov.h>

#include "parts.h"

enum { BLOCKS = 1000 };
#define REST 1e-8 /* an excursion below this fraction of the largest coordinate counts as rest */
/* A motion leaves if its excursion in the second half of the run exceeds that in the first half by
 * more than this factor. An excursion that grows as t^3 gives 8. */
#define LEAVING 8

/* Largest |x - x(0)| of each coordinate and rate in the first and in the second half of the run. */
struct excursion {
    size_t count;
    pk_real *most[2];
};

static void excursion_begin(struct excursion *e, struct memory *memory, size_t n)
{
    e->count = 2 * n;
    e->most[0] = memory_take(memory, 2 * e->count, sizeof(pk_real));
    e->most[1] = e->most[0] + e->count;
}

/* Updates the excursions from the integrator `it`. The displacements, which follow the n
 * coordinates and first-order variables in its state, are skipped. */
static void excursion_note(struct excursion *e, const struct settings *s,
                           const struct pk_integrator *it, int half)
{
    const size_t n = s->n, seen = pk_system_coordinates(s->system, s->params);
    for (size_t i = 0; i < e->count; i++) {
        if (i >= seen && i < n)
            continue;
        const pk_real x = i < n ? it->q[i] - s->q[i] : it->v[i - n] - s->v[i - n];
        e->most[half][i] = PK_F(fmax)(e->most[half][i], PK_F(fabs)(x));
    }
}

static int excursion_leaves(const struct excursion *e, const struct settings *s)
{
    int moves = 0;
    pk_real size = 0;
    for (size_t i = 0; i < s->n; i++)
        size = PK_F(fmax)(size, PK_F(fabs)(s->q[i]));
    for (size_t i = 0; i < e->count; i++) {
        if (e->most[1][i] > LEAVING * e->most[0][i])
            return 1;
        moves |= e->most[1][i] > (pk_real)REST * size;
    }
    return !moves;
}

static int can_be_chaotic(const struct pk_system *system)
{
    const size_t dimension = 2 * system->n - system->n_first_order;
    return dimension > 2 || system->families.count || !(system->facts & PK_AUTONOMOUS);
}

void diagnose_lyapunov(struct pk_run *run, struct diagnostics *d)
{
    static const char *const motions[] = {"regular", "chaotic", "undecided"};
    struct excursion excursion;
    const struct settings *s = &run->settings;
    const size_t size = pk_lyapunov_size(&run->problem, s->method);
    void *block = memory_take(&run->memory, size, 1);
    struct pk_lyapunov l = {0};
    /* Displacements that violate the constraints may grow although no allowed motion does. */
    const int bound = run->problem.system->constraints.n > 0;
    enum pk_status status = PK_REFUSED;
    if (!bound)
        status = pk_lyapunov_init(&l, &run->problem, s->method, &s->options, 0, s->q, s->v,
                                  run->it.t / BLOCKS, block, size);
    excursion_begin(&excursion, &run->memory, s->n);
    for (int k = 0; status >= 0 && k < BLOCKS && l.it.t < run->it.t; k++) {
        status = pk_lyapunov_step(&l);
        excursion_note(&excursion, s, &l.it, 2 * k >= BLOCKS);
        if (run_stopped(run, (double)(l.it.t / run->it.t)))
            break;
    }
    const char *why = bound                  ? diagnose_not_free(run->problem.system)
                      : status == PK_REFUSED ? diagnose_no_variation(run)
                                             : NULL;
    if (diagnose_told(d, status, why, &l.it)) {
        pk_real error;
        const pk_real exponent = pk_lyapunov_exponent(&l, &error);
        const enum pk_motion motion = pk_lyapunov_motion(&l);
        /* stored even for an unbounded motion, since round-off errors grow at this rate, too */
        if (motion == PK_CHAOTIC)
            d->exponent = (double)exponent;
        const int leaving = motion == PK_CHAOTIC && (excursion_leaves(&excursion, s) ||
                                                     !can_be_chaotic(run->problem.system));
        json_reals(&d->json, {"exponent", exponent}, {"error", error},
                   {"megno", pk_lyapunov_megno(&l)}, {"time", l.it.t});
        json_text(&d->json, "motion", leaving ? "leaving" : motions[motion]);
    }
    pk_lyapunov_free(&l);
}

/* Returns the largest exponent of an ensemble member that has a struct pk_run; NAN on failure. */
pk_real diagnose_exponent(struct pk_run *of)
{
    const struct settings *s = &of->settings;
    const struct pk_problem *problem = &of->problem;
    const pk_real until = of->it.t;
    struct pk_lyapunov l = {0};
    enum pk_status status = PK_REFUSED;
    const size_t size = problem->system->constraints.n ? 0 : pk_lyapunov_size(problem, s->method);
    void *block = size ? memory_ask(&of->memory, size, 1) : NULL;
    if (block)
        status = pk_lyapunov_init(&l, problem, s->method, &s->options, 0, s->q, s->v,
                                  until / BLOCKS, block, size);
    for (int k = 0; status >= 0 && k < BLOCKS && l.it.t < until; k++)
        status = pk_lyapunov_step(&l);
    const pk_real found = status < 0 ? (pk_real)NAN : pk_lyapunov_exponent(&l, NULL);
    if (block) {
        pk_lyapunov_free(&l);
        memory_drop(&of->memory, block);
    }
    return found;
}

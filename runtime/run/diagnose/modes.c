/* Normal modes at the equilibrium about which a motion oscillates, and the energy of each mode.
 *
 * This equilibrium is chosen as follows. If the run starts at rest at an equilibrium, it is this
 * equilibrium. Otherwise it is a minimum of the potential that is below the energy of the motion:
 * the nearest minimum for which the potential on the straight line from the start stays below this
 * energy; else the nearest minimum. Without any, it is the nearest unstable equilibrium. */

#include "parts.h"

#ifdef PK_WITH_GSL
#include <pk/gsl_equilibria.h>
#endif

#ifdef PK_WITH_GSL
enum { MOST = 256, ROWS = 200, MODES = 64, PLACES = 16, TRIES = 100, FEW = 8, WAY = 64 };
/* step of finite differences, as a fraction of the distance from the equilibrium to the start */
static const double PART = 1e-6;

struct modes {
    struct pk_run *run;
    size_t n;
    /* q: position of the equilibrium; h: its energy */
    double *q, *p, *h, *M, *squares, *shapes, *E, *x, *work;
    unsigned char *turns; /* whether q_i + 2 pi is the same position as q_i */
};

/* Ranks of equilibria, best first. */
enum fitness { START, IN_SIGHT, BELOW, UNSTABLE, KINKED, NO_MODES, NOTHING };

static const char *unfit(const struct pk_system *system, size_t n)
{
    if (diagnose_not_free(system))
        return diagnose_not_free(system);
    if (system->n_first_order)
        return "normal modes are of coordinates alone, and the model has states, which have no "
               "momenta";
    if (n > MOST)
        return "of more than 256 coordinates: take a shorter family";
    if (!system->jacobian || !system->mass || !system->canonical || !system->energy)
        return "the system has no kernel jacobian: its families are kept as loops";
    if (!(system->facts & PK_AUTONOMOUS))
        return "normal modes are of a system without explicit time, and without inputs";
    if (!(system->facts & PK_VARIATIONAL))
        return "normal modes are of a system without forces besides those of L";
    return NULL;
}

/* Returns whether the system can rest at q. The derivative of the force at q, times the distance to
 * the start, estimates how much the force changes up to the start; the force at q must be below the
 * fraction `share` of this change. Far away, where forces decay, the ratio is about 1. */
static int rests(const struct modes *m, const double *q, double share)
{
    const struct pk_problem *problem = &m->run->problem;
    const size_t n = m->n;
    double *rest = m->work, *p = rest + n, *pdot = p + n, *off = pdot + n, *moved = off + n;
    double force = 0, change = 0;
    memset(rest, 0, n * sizeof *rest);
    problem->system->canonical(problem->params, 0, q, rest, NULL, p, pdot);
    for (size_t i = 0; i < n; i++)
        off[i] = q[i] + PART * (m->run->settings.q[i] - q[i]);
    problem->system->canonical(problem->params, 0, off, rest, NULL, p, moved);
    for (size_t i = 0; i < n; i++) {
        /* a force may be infinite, as that between two bodies at one position */
        if (!isfinite(pdot[i]) || !isfinite(moved[i]))
            return 0;
        force = fmax(force, fabs(pdot[i]));
        change = fmax(change, fabs(moved[i] - pdot[i]));
    }
    return force <= share / PART * change || !(force > 0);
}

static double distance(const struct modes *m, const double *q)
{
    double sum = 0;
    for (size_t i = 0; i < m->n; i++)
        sum += (q[i] - m->run->settings.q[i]) * (q[i] - m->run->settings.q[i]);
    return sqrt(sum);
}

static double energy_at(const struct modes *m, const double *q, const double *v)
{
    return m->run->problem.system->energy(m->run->problem.params, 0, q, v, NULL);
}

/* Returns the distance of q from the start, relative to the largest coordinate of the start. */
static double away(const struct modes *m, const double *q)
{
    const double far = distance(m, q);
    double size = 0;
    for (size_t i = 0; i < m->n; i++)
        size = fmax(size, fabs(m->run->settings.q[i]));
    return size > 0 ? far / size : far > 0 ? HUGE_VAL : 0;
}

/* Returns whether the run starts at q with all rates 0. */
static int is_start(const struct modes *m, const double *q)
{
    for (size_t i = 0; i < m->n; i++)
        if (fabs(m->run->settings.v[i]) > 0)
            return 0;
    return away(m, q) <= 1e-6;
}

/* Returns whether the potential is at most h on the straight line from the start to q. */
static int in_sight(const struct modes *m, const double *q, const double *rest, double h)
{
    const double *from = m->run->settings.q;
    for (int k = 1; k < WAY; k++) {
        for (size_t i = 0; i < m->n; i++)
            m->x[i] = from[i] + (q[i] - from[i]) * k / WAY;
        if (!(energy_at(m, m->x, rest) <= h))
            return 0;
    }
    return 1;
}

/* Returns whether the equations have a kink at q (their derivatives jump), tested at points on both
 * sides of q on the straight line to the start. */
static int is_kinked(const struct modes *m, const double *q)
{
    const double *start = m->run->settings.q;
    double *before = m->work, *behind = before + m->n;
    for (size_t i = 0; i < m->n; i++) {
        before[i] = q[i] + PART * (start[i] - q[i]);
        behind[i] = q[i] - PART * (start[i] - q[i]);
    }
    return diagnose_kink(m->run, before, behind);
}

static enum fitness fitness_of(const struct modes *m, const double *q)
{
    const struct settings *s = &m->run->settings;
    double *rest = m->E;
    memset(rest, 0, m->n * sizeof *rest);
    const double h = energy_at(m, s->q, s->v), there = energy_at(m, q, rest);
    const double slack = 1e-9 * fmax(fabs(h), fabs(there));
    if (away(m, q) > 0.1 && !rests(m, q, 1e-3))
        return NOTHING;
    if (pk_gsl_normal(&m->run->problem, q, m->M, m->squares, m->shapes) < 0)
        return NO_MODES;
    int pulled = 0;
    for (size_t k = 0; k < m->n; k++)
        pulled |= m->squares[k] < 0 || m->squares[k] > 0;
    if (is_kinked(m, q))
        return KINKED;
    if (is_start(m, q))
        return START;
    if (!pulled) /* no force at all: far away, exponentially decaying forces underflow to 0 */
        return NOTHING;
    if (m->squares[0] < 0 || there > h + slack)
        return UNSTABLE;
    return in_sight(m, q, rest, h + slack) ? IN_SIGHT : BELOW;
}

/* Shifts angles of q by whole turns towards the start. Copies q to m->q if q is of a better kind
 * (enum fitness) than `best`, or of the same and nearer than m->q. Returns the better kind. */
static enum fitness consider(struct modes *m, double *q, enum fitness best)
{
    for (size_t i = 0; i < m->n; i++)
        if (m->turns[i])
            q[i] += 2 * PK_PI * round((m->run->settings.q[i] - q[i]) / (2 * PK_PI));
    const enum fitness found = fitness_of(m, q);
    if (found == NOTHING || found > best || (found == best && distance(m, q) >= distance(m, m->q)))
        return best;
    memcpy(m->q, q, m->n * sizeof *q);
    return found;
}

/* Sets m->q to the best equilibrium and returns its rank. Candidates are q = 0, if no force acts
 * there, and the equilibria found from the start and, for few coordinates, from other points. */
static enum fitness choose(struct modes *m)
{
    struct pk_run *run = m->run;
    const struct settings *s = &run->settings;
    struct pk_system still = *run->problem.system;
    struct pk_problem problem = run->problem;
    double *q = memory_take(&run->memory, 2 * PLACES * m->n, sizeof *q);
    struct pk_equilibria found = {
        .most = PLACES, .q = q, .v = q + PLACES * m->n, .turns = m->turns};
    double *rest = memory_take(&run->memory, m->n, sizeof *rest);
    still.cyclic = NULL; /* excludes steady motions: cyclic coordinates must rest too */
    problem.system = &still;
    enum fitness best = NOTHING;
    const enum pk_status status =
        pk_gsl_equilibria(&problem, s->q, rest, m->n <= FEW ? TRIES : 0, &found);
    if (rests(m, rest, 1e-12)) /* tests whether q = 0 is an equilibrium */
        best = consider(m, rest, best);
    for (size_t k = 0; status >= 0 && k < found.count; k++)
        best = consider(m, q + k * m->n, best);
    return best;
}

static void row(struct modes *m, struct json *j, double t, const double *q, const double *v)
{
    const struct pk_problem *problem = &m->run->problem;
    const size_t n = m->n, shown = n < MODES ? n : MODES;
    double *p = m->work, *pdot = p + n, sum = 0;
    /* M q' = p - p(rest), where p(rest) is the momentum at rates of 0. p(rest) is not 0 if L
     * contains a total time derivative. */
    memset(m->p, 0, n * sizeof *m->p);
    problem->system->canonical(problem->params, t, q, m->p, NULL, p, pdot);
    memcpy(m->p, p, n * sizeof *p);
    problem->system->canonical(problem->params, t, q, v, NULL, p, pdot);
    for (size_t i = 0; i < n; i++) {
        m->x[i] = m->turns[i] ? remainder(q[i] - m->q[i], 2 * PK_PI) : q[i] - m->q[i];
        p[i] -= m->p[i];
    }
    pk_normal_energies(n, m->M, m->squares, m->shapes, m->x, p, m->E);
    for (size_t k = 0; k < n; k++)
        sum += m->E[k];
    const double h = problem->system->energy(problem->params, t, q, v, NULL);
    json_open(j, NULL, '[');
    json_real(j, NULL, t);
    json_real(j, NULL, sum);
    json_real(j, NULL, h - *m->h - sum);
    for (size_t k = 0; k < shown; k++)
        json_real(j, NULL, m->E[k]);
    json_close(j, ']');
}

static void write_modes(struct modes *m, struct diagnostics *d)
{
    const size_t n = m->n, shown = n < MODES ? n : MODES;
    const size_t rows = d->n_rows < ROWS ? d->n_rows : ROWS;
    struct json *j = &d->json;
    json_numbers(j, "equilibrium", m->q, n);
    json_real(j, "energy", *m->h);
    json_numbers(j, "squares", m->squares, n);
    json_open(j, "frequencies", '[');
    for (size_t k = 0; k < n; k++)
        json_real(j, NULL, m->squares[k] < 0 ? PK_INFINITY : sqrt(m->squares[k]));
    json_close(j, ']');
    json_open(j, "shapes", '[');
    for (size_t k = 0; k < shown; k++) {
        json_open(j, NULL, '{');
        json_numbers(j, "shape", m->shapes + k * n, n);
        json_close(j, '}');
    }
    json_close(j, ']');
    json_counts(j, {"modes", n}, {"left_out", n - shown});
    json_open(j, "rows", '[');
    for (size_t k = 0; k < rows; k++) {
        const double *x = diagnose_row(d, k, rows);
        row(m, j, x[0], x + 1, x + 1 + n);
    }
    json_close(j, ']');
}

void diagnose_modes(struct diagnostics *d)
{
    struct pk_run *run = d->run;
    const struct pk_problem *problem = &run->problem;
    struct modes m = {.run = run, .n = run->settings.n};
    const size_t n = m.n;
    const char *reason = unfit(problem->system, n);
    int cyclic = 0;
    for (size_t i = 0; problem->system->cyclic && i < n; i++)
        cyclic |= problem->system->cyclic[i];
    if (reason) {
        diagnose_told(d, PK_REFUSED, reason, NULL);
        return;
    }
    double *block = memory_take(&run->memory, 2 * n * n + 10 * n + 1, sizeof *block);
    m.M = block;
    m.shapes = m.M + n * n;
    m.q = m.shapes + n * n;
    m.p = m.q + n;
    m.squares = m.p + n;
    m.E = m.squares + n;
    m.x = m.E + n;
    m.work = m.x + n; /* work memory of 5 n numbers */
    m.h = m.work + 5 * n;
    m.turns = memory_take(&run->memory, n, 1);
    const enum fitness best = choose(&m);
    enum pk_status status = best < NOTHING && best != KINKED ? PK_DONE : PK_REFUSED;
    reason = best == KINKED
                 ? "where nothing pulls the equations have a kink (abs, min, max, step): "
                   "there are no modes, for no motion is small beside it"
                 : "no equilibrium was found about which it could oscillate";
    if (status == PK_DONE) {
        double *rest = m.work;
        memset(rest, 0, n * sizeof *rest);
        *m.h = problem->system->energy(problem->params, 0, m.q, rest, NULL);
        status = pk_gsl_normal(problem, m.q, m.M, m.squares, m.shapes);
        reason = status == PK_REFUSED ? "at the equilibrium forces depend on rates: its modes have "
                                        "no energies of their own (pkgen stability has their rates)"
                                      : pk_status_text(status);
    }
    if (status == PK_SINGULAR_MASS) {
        status = PK_REFUSED;
        reason = cyclic ? "where nothing pulls, next to the start, the coordinates themselves are "
                          "singular, and others are cyclic: a scene that records none of these has "
                          "modes of what is left"
                        : "where nothing pulls, next to the start, the coordinates themselves are "
                          "singular";
    }
    if (diagnose_told(d, status, reason, NULL))
        write_modes(&m, d);
}
#else
DIAGNOSE_NEEDS_GSL(modes)
#endif

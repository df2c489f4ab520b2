/* Normal modes at the equilibrium next to the start, and how the energy is shared among them. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "diagnose_parts.h"
#include "ensemble.h"
#include "words.h"

#ifdef PK_WITH_GSL
#include <pk/gsl_equilibria.h>
#endif

#ifdef PK_WITH_GSL
enum { MOST = 256, ROWS = 200, MODES = 64, PLACES = 16, TRIES = 100, FEW = 8 };

struct modes {
    struct run *run;
    size_t n;
    double *q, *p, *h, *M, *squares, *shapes, *E, *x, *work; /* q, p, h: of the equilibrium */
};

static const char *unfit(const struct pk_system *system, size_t n)
{
    if (n > MOST)
        return "of more than 256 coordinates: take a shorter family";
    if (!system->jacobian || !system->mass || !system->canonical || !system->energy)
        return "the system has no kernel jacobian: its families are kept as loops";
    if (!(system->facts & PK_AUTONOMOUS) || !(system->facts & PK_VARIATIONAL))
        return "normal modes are of a system without explicit time, and without forces besides "
               "those of L";
    return NULL;
}

/* Whether nothing pulls at q: beside what would if each coordinate were a little off. */
static int rests(const struct modes *m, const double *q)
{
    const struct pk_problem *problem = &m->run->problem;
    const size_t n = m->n;
    double *rest = m->work, *p = rest + n, *pdot = p + n, *off = pdot + n, *moved = off + n;
    double force = 0, change = 0;
    memset(rest, 0, n * sizeof *rest);
    problem->system->canonical(problem->params, 0, q, rest, NULL, p, pdot);
    for (size_t i = 0; i < n; i++)
        off[i] = q[i] + 1e-6 * (m->run->settings.q[i] - q[i]);
    problem->system->canonical(problem->params, 0, off, rest, NULL, p, moved);
    for (size_t i = 0; i < n; i++) {
        if (!isfinite(pdot[i]) || !isfinite(moved[i])) /* two bodies in one place, say */
            return 0;
        force = fmax(force, fabs(pdot[i]));
        change = fmax(change, fabs(moved[i] - pdot[i]));
    }
    return force <= 1e-6 * change || !(force > 0);
}

static double distance(const struct modes *m, const double *q)
{
    double sum = 0;
    for (size_t i = 0; i < m->n; i++)
        sum += (q[i] - m->run->settings.q[i]) * (q[i] - m->run->settings.q[i]);
    return sum;
}

/* The nearest equilibrium: q = 0, if it is one, or what is found from the start and around. */
static int nearest(struct modes *m)
{
    struct run *run = m->run;
    const struct settings *s = &run->settings;
    struct pk_system still = *run->problem.system;
    struct pk_problem problem = run->problem;
    double *q = (double *)words_allocate(2 * PLACES * m->n, sizeof *q);
    struct pk_equilibria found = {PLACES, q, q + PLACES * m->n, 0, 0, 0, 0, NULL, NULL};
    double *rest = (double *)words_allocate(m->n, sizeof *rest);
    int any = rests(m, rest); /* at 0 */
    memcpy(m->q, rest, m->n * sizeof *rest);
    still.cyclic = NULL; /* those that go on rest nowhere */
    problem.system = &still;
    if (pk_gsl_equilibria(&problem, s->q, rest, m->n <= FEW ? TRIES : 0, &found) >= 0)
        for (size_t k = 0; k < found.count; k++) {
            const double *at = q + k * m->n;
            if (any && distance(m, at) >= distance(m, m->q))
                continue;
            memcpy(m->q, at, m->n * sizeof *at);
            any = 1;
        }
    free(rest);
    free(q);
    return any;
}

static void row(struct modes *m, FILE *file, double t, const double *q, const double *v, int first)
{
    const struct pk_problem *problem = &m->run->problem;
    const size_t n = m->n, shown = n < MODES ? n : MODES;
    double *p = m->work, *pdot = p + n, sum = 0;
    problem->system->canonical(problem->params, t, q, v, NULL, p, pdot);
    for (size_t i = 0; i < n; i++) {
        m->x[i] = q[i] - m->q[i];
        p[i] -= m->p[i];
    }
    pk_normal_energies(n, m->M, m->squares, m->shapes, m->x, p, m->E);
    for (size_t k = 0; k < n; k++)
        sum += m->E[k];
    const double h = problem->system->energy(problem->params, t, q, v, NULL);
    fputs(first ? "\n      [" : ",\n      [", file);
    output_real(file, t);
    fputs(", ", file);
    output_real(file, sum);
    fputs(", ", file);
    output_real(file, h - *m->h - sum);
    for (size_t k = 0; k < shown; k++) {
        fputs(", ", file);
        output_real(file, m->E[k]);
    }
    fputs("]", file);
}

static void write_modes(struct modes *m, struct diagnostics *d)
{
    const size_t n = m->n, shown = n < MODES ? n : MODES, width = 1 + 2 * n;
    const size_t rows = d->n_rows < ROWS ? d->n_rows : ROWS;
    fputs(", ", d->file);
    output_numbers(d->file, "equilibrium", m->q, n);
    diagnose_real(d, "energy", *m->h);
    fputs(", ", d->file);
    output_numbers(d->file, "squares", m->squares, n);
    fputs(", \"frequencies\": [", d->file);
    for (size_t k = 0; k < n; k++) {
        fputs(k ? ", " : "", d->file);
        output_real(d->file, m->squares[k] < 0 ? PK_INFINITY : sqrt(m->squares[k]));
    }
    fputs("], \"shapes\": [", d->file);
    for (size_t k = 0; k < shown; k++) {
        fputs(k ? ",\n      {" : "{", d->file);
        output_numbers(d->file, "shape", m->shapes + k * n, n);
        fputs("}", d->file);
    }
    fprintf(d->file, "], \"modes\": %zu, \"left_out\": %zu, \"rows\": [", n, n - shown);
    for (size_t k = 0; k < rows; k++) {
        const double *x = d->rows + (rows > 1 ? k * (d->n_rows - 1) / (rows - 1) : 0) * width;
        row(m, d->file, x[0], x + 1, x + 1 + n, k == 0);
    }
    fputs("]}", d->file);
}

void diagnose_modes(struct run *run, struct diagnostics *d)
{
    const struct pk_problem *problem = &run->problem;
    struct modes m = {.run = run, .n = run->settings.n};
    const size_t n = m.n;
    const char *reason = unfit(problem->system, n);
    if (reason) {
        diagnose_member(d, "modes", PK_REFUSED, reason);
        return;
    }
    double *block = (double *)words_allocate(2 * n * n + 10 * n + 1, sizeof *block);
    m.M = block;
    m.shapes = m.M + n * n;
    m.q = m.shapes + n * n;
    m.p = m.q + n;
    m.squares = m.p + n;
    m.E = m.squares + n;
    m.x = m.E + n;
    m.work = m.x + n; /* 5 n */
    m.h = m.work + 5 * n;
    enum pk_status status = nearest(&m) ? PK_DONE : PK_REFUSED;
    reason = "no equilibrium was found about which it could oscillate";
    if (status == PK_DONE) {
        double *rest = m.work, *pdot = m.work + n;
        memset(rest, 0, n * sizeof *rest);
        problem->system->canonical(problem->params, 0, m.q, rest, NULL, m.p, pdot);
        *m.h = problem->system->energy(problem->params, 0, m.q, rest, NULL);
        status = pk_gsl_normal(problem, m.q, m.M, m.squares, m.shapes);
        reason = status == PK_REFUSED ? "at the equilibrium forces depend on rates: its modes have "
                                        "no energies of their own (pkgen stability has their rates)"
                                      : pk_status_text(status);
    }
    if (status == PK_SINGULAR_MASS) {
        status = PK_REFUSED;
        reason = "where nothing pulls, next to the start, the coordinates themselves are singular";
    }
    if (diagnose_member(d, "modes", status, reason))
        write_modes(&m, d);
    free(block);
}
#else
void diagnose_modes(struct run *run, struct diagnostics *d)
{
    (void)run;
    diagnose_member(d, "modes", PK_REFUSED,
                    "it needs the GNU Scientific Library, which is not here");
}
#endif

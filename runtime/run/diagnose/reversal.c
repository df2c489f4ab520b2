/* Integrates the run forward and then back to its start; see motion.h. Finds the time after which
 * integrating back no longer leads to the initial state. Each trial begins at the initial state and
 * uses one integrator both ways, which keeps the low parts of compensated sums. */

#include "../../src/core/internal.h"
#include "parts.h"

enum { OCTAVES = 12, NARROWINGS = 4 };
/* largest relative error at which integrating back still counts as leading to the start */
#define THRESHOLD PK_C(1e-3)

static pk_real off(const struct motion *m, size_t i)
{
    const size_t n = m->it.n;
    if (i < n && i >= pk_coordinates_of(m->problem))
        return 0; /* first-order variables are in v only */
    return pk_abs(i < n ? m->it.q[i] - m->q[i] : m->it.v[i - n] - m->v[i - n]);
}

/* Measures the scales of errors: for each q_i, v_i the largest distance from its start. */
static enum pk_status measure(struct motion *m, pk_real t, pk_real *reach)
{
    PK_TRY(motion_begin(m));
    while (m->it.t < m->t + t) {
        PK_TRY(pk_integrator_step(&m->it, m->t + t));
        for (size_t i = 0; i < 2 * m->it.n; i++)
            reach[i] = pk_max(reach[i], off(m, i));
    }
    return PK_DONE;
}

static enum pk_status there_and_back(struct reversal *r, struct motion *m, pk_real t,
                                     pk_real threshold, const pk_real *reach)
{
    pk_real error = 0;
    PK_TRY(motion_begin(m));
    PK_TRY(pk_integrator_to(&m->it, m->t + t));
    PK_TRY(pk_integrator_to(&m->it, m->t));
    for (size_t i = 0; i < 2 * m->it.n; i++) {
        const pk_real miss = off(m, i);
        if (miss > 0) /* an error in a component that never moves counts as 1 */
            error = pk_max(error, reach[i] > 0 ? miss / reach[i] : 1);
    }
    r->at[r->count].t = t;
    r->at[r->count++].error = error;
    r->passed |= error > threshold;
    *(error > threshold ? &r->horizon_hi : &r->horizon_lo) = t;
    return PK_DONE;
}

/* Rounds t to a whole number of steps, at least one. */
static pk_real rounded(const struct motion *m, pk_real t)
{
    const pk_real h = m->options.h;
    if (m->method->traits & PK_ADAPTIVE || !(h > 0))
        return t;
    return h * pk_max(1, PK_F(floor)(t / h + PK_C(0.5)));
}

enum pk_status reversal_find(struct reversal *r, struct motion *m, pk_real threshold)
{
    const size_t n = pk_count_of(m->problem);
    pk_real *reach = memory_take(m->memory, 2 * n, sizeof *reach), last = 0;
    memset(r, 0, sizeof *r);
    enum pk_status status = measure(m, rounded(m, m->end - m->t), reach);
    for (int k = OCTAVES; k >= 0 && status >= 0 && !r->passed; k--) {
        const pk_real t = rounded(m, PK_F(ldexp)(m->end - m->t, -k));
        if (t > last)
            status = there_and_back(r, m, t, threshold, reach);
        last = t;
    }
    for (int k = 0; k < NARROWINGS && status >= 0 && r->passed; k++) {
        const pk_real t = rounded(m, (r->horizon_lo + r->horizon_hi) / 2);
        if (t > r->horizon_lo && t < r->horizon_hi)
            status = there_and_back(r, m, t, threshold, reach);
    }
    return status;
}

void diagnose_reversal(struct diagnostics *d)
{
    struct motion m = motion_of(d->run);
    struct reversal r;
    const enum pk_status status = reversal_find(&r, &m, THRESHOLD);
    const struct pk_system *system = m.problem->system;
    const int sides = system->switches.n && !system->switches.impulses;
    const char *why = status == PK_REFUSED && sides && !(system->facts & PK_SMOOTH)
                          ? "the way back is not followed through switches: give a method that "
                            "needs no smooth equations, as dop853"
                          : NULL;
    if (diagnose_told(d, status, why, &m.it)) {
        struct json *j = &d->json;
        const pk_real digits = PK_F(log)(THRESHOLD / PK_EPSILON);
        json_real(j, "threshold", THRESHOLD);
        json_flag(j, "symmetric", (m.method->traits & PK_SYMMETRIC) != 0);
        json_flag(j, "lost", r.passed);
        json_reals(j, {"horizon_lo", r.horizon_lo},
                   {"horizon_hi", r.passed ? r.horizon_hi : PK_INFINITY},
                   {"predicted", d->exponent > 0 ? digits / (pk_real)d->exponent : PK_INFINITY});
        json_open(j, "times", '[');
        for (size_t i = 0; i < r.count; i++)
            json_numbers(j, NULL, (const pk_real[]){r.at[i].t, r.at[i].error}, 2);
        json_close(j, ']');
    }
    pk_integrator_free(&m.it);
}

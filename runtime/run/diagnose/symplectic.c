/* The symplecticity defect of the steps of a run; see motion.h. For each column of the derivative S
 * of a step, a unit displacement in (Q, P) becomes (dq, dv), is advanced, and converted back. */
#include "../../src/core/internal.h"
#include "parts.h"

enum { STATES = 16 };

enum pk_status stepmap_begin(struct stepmap *w, const struct motion *m)
{
    const struct pk_system *system = m->problem->system;
    const unsigned traits = m->method->traits;
    memset(w, 0, sizeof *w);
    if (traits & PK_ADAPTIVE && traits & PK_LINEAR && !(traits & PK_IMPLICIT))
        return PK_REFUSED; /* step sizes depend on the state */
    if (system->n_first_order || system->constraints.n)
        return PK_REFUSED; /* first-order variables have no momenta; rows make q and p dependent */
    PK_TRY(variation_init(&w->variation, m, 1));
    const size_t n = w->variation.n, size = 4 * n * n;
    w->S = memory_take(m->memory, 2 * size + 3 * n * n + 3 * n, sizeof *w->S);
    w->LU = w->S + size;
    w->J = w->LU + size;
    w->dp = w->J + 3 * n * n;
    w->pivot = w->dp + n;
    return PK_DONE;
}

/* Sets w->dp = (dp/dq) dq at a state. */
static void momentum_slope(struct stepmap *w, pk_real t, const pk_real *q, const pk_real *v,
                           const pk_real *dq)
{
    const struct pk_problem *of = &w->variation.of;
    const size_t n = w->variation.n, nn = n * n;
    of->system->jacobian(of->params, t, q, v, variation_inputs(&w->variation, t), w->J, w->J + nn,
                         w->J + 2 * nn);
    memset(w->dp, 0, n * sizeof *w->dp);
    pk_add_product(w->dp, w->J, dq, n);
}

/* Sets the displacement at the start of the step, which follows q and v in Q and V: the unit vector
 * j of (Q, P), converted to (dq, dv). */
static void displace(struct stepmap *w, size_t j)
{
    const struct variation *of = &w->variation;
    const size_t n = of->n;
    pk_real *dq = of->Q + n, *dv = of->V + n;
    memset(dq, 0, n * sizeof *dq);
    memset(dv, 0, n * sizeof *dv);
    (j < n ? dq : dv)[j % n] = 1;
    metric_dq(&w->metric, dq);
    metric_dp(&w->metric, dv); /* at this point dv holds dp */
    momentum_slope(w, of->motion.t, of->Q, of->V, dq);
    for (size_t i = 0; i < n; i++)
        dv[i] -= w->dp[i];
    pk_ldl_solve(w->metric.L, n, dv);
}

/* Sets column j of S from the state of the integrator. */
static void take_column(struct stepmap *w, size_t j)
{
    const struct pk_problem *of = &w->variation.of;
    const struct pk_integrator *it = &w->variation.motion.it;
    const size_t n = w->variation.n, m = 2 * n;
    const pk_real *q = it->q, *v = it->v, *dq = q + n, *dv = v + n;
    momentum_slope(w, it->t, q, v, dq);
    of->system->mass(of->params, it->t, q, v, variation_inputs(&w->variation, it->t), w->J);
    pk_add_product(w->dp, w->J, dv, n);
    pk_real *const Q = w->pivot; /* not in use yet */
    memcpy(Q, dq, n * sizeof *dq);
    metric_Q(&w->metric, Q);
    metric_P(&w->metric, w->dp);
    for (size_t i = 0; i < n; i++) {
        w->S[i * m + j] = Q[i];
        w->S[(n + i) * m + j] = w->dp[i];
    }
}

static void measure(struct stepmap *w)
{
    const size_t n = w->variation.n, m = 2 * n;
    pk_real size = 1;
    int sign;
    w->defect = 0;
    for (size_t i = 0; i < m; i++)
        for (size_t j = 0; j < m; j++) {
            pk_real form = (j == i + n) ? -PK_C(1.0) : (i == j + n) ? PK_C(1.0) : 0, sum = 0;
            for (size_t k = 0; k < n; k++) {
                const pk_real a = w->S[k * m + i] * w->S[(n + k) * m + j];
                const pk_real b = w->S[(n + k) * m + i] * w->S[k * m + j];
                form += a - b;
                sum += pk_abs(a) + pk_abs(b);
            }
            if (!(pk_abs(form) <= w->defect)) /* the condition is true for NaN */
                w->defect = pk_abs(form);
            size = pk_max(size, sum);
        }
    memcpy(w->LU, w->S, m * m * sizeof *w->S);
    w->volume = -1;
    if (pk_lu_factor(w->LU, w->pivot, m))
        w->volume += pk_lu_determinant(w->LU, w->pivot, m, &sign);
    w->rounding = 16 * PK_EPSILON * size * (pk_real)m;
}

enum pk_status stepmap_find(struct stepmap *w, pk_real h, pk_real t, const pk_real *q,
                            const pk_real *v)
{
    struct variation *of = &w->variation;
    struct motion *m = &of->motion;
    m->t = t;
    m->options.h = h;
    if (m->method->traits & PK_ADAPTIVE) {
        m->options.h_max = h;
        m->options.rtol = m->options.atol = PK_C(1e10);
        m->options.newton_tol = 8 * PK_EPSILON;
    }
    PK_TRY(metric_init(&w->metric, of, t, q, v, h));
    for (size_t j = 0; j < 2 * of->n; j++) {
        memcpy(of->Q, q, of->n * sizeof *q);
        memcpy(of->V, v, of->n * sizeof *v);
        displace(w, j);
        PK_TRY(motion_begin(m));
        PK_TRY(pk_integrator_to(&m->it, t + h));
        if (m->it.count.steps != 1)
            return PK_REFUSED;
        take_column(w, j);
    }
    measure(w);
    return pk_finite(w->defect) ? PK_DONE : PK_NOT_FINITE;
}

/* Returns why no step could be made, if it was refused. */
static const char *refusal(const struct pk_run *run)
{
    const struct pk_system *system = run->problem.system;
    const char *why = diagnose_not_free(system);
    if (!why && system->n_first_order)
        why = "states have no momenta, so there is no symplectic form to be kept";
    why = why ? why : diagnose_no_variation(run);
    return why ? why : "steps of this method have no length of their own: take one of fixed steps";
}

/* Reports the largest defect at states spread over the rows. Failed steps are counted; the
 * diagnostic fails only if all steps fail. */
void diagnose_symplectic(struct diagnostics *d)
{
    const struct pk_run *run = d->run;
    const struct motion m = motion_of(d->run);
    const size_t states = d->n_rows < 1 ? 1 : d->n_rows < STATES ? d->n_rows : STATES;
    const int fixed = pk_is_fixed(m.method);
    const pk_real h = fixed ? m.options.h : m.end / (pk_real)run->it.count.steps;
    struct stepmap w;
    pk_real most = -1, volume = 0, rounding = 0, t = 0;
    enum pk_status status = stepmap_begin(&w, &m), last = status;
    size_t made = 0;
    for (size_t k = 0; k < states && status != PK_REFUSED; k++) {
        /* without rows, the initial state */
        const pk_real *row = d->rows ? diagnose_row(d, k, states) : NULL;
        const pk_real at = row ? row[0] : 0;
        status =
            stepmap_find(&w, h, at, row ? row + 1 : m.q, row ? row + 1 + run->settings.n : m.v);
        last = status < 0 ? status : last;
        made += status >= 0;
        if (status >= 0 && (w.defect - w.rounding > most - rounding || most < 0))
            most = w.defect, volume = w.volume, rounding = w.rounding, t = at;
    }
    pk_integrator_free(&w.variation.motion.it);
    if (diagnose_told(d, made ? PK_DONE : last,
                      !made && last == PK_REFUSED ? refusal(run)
                                                  : pk_status_text(made ? PK_DONE : last),
                      NULL)) {
        struct json *j = &d->json;
        json_reals(j, {"defect", most}, {"volume", volume}, {"rounding", rounding}, {"step", h},
                   {"t", t});
        json_counts(j, {"states", made}, {"failed", states - made});
        json_flag(j, "symplectic", most <= rounding);
        json_flag(j, "variational", (m.problem->system->facts & PK_VARIATIONAL) != 0);
    }
}

/* Adaptive Radau IIA of 3 stages, order 5, for stiff or dissipative systems: L-stable, so that fast
 * motion that has decayed does not limit the step size. The stages are computed as in gauss.c, in
 * (q, p): p' = dL/dq + Q - dD/dv needs no derivative of M, so that M(q, v) and any dissipation need
 * only the kernels of Newton's matrix, and the change of p equals the sum of forces to round-off.
 *
 * Newton's iteration ends at a fraction of the tolerance of the error (radau_error.c). If it does
 * not converge, or not to the branch of short steps (branch.c), the step is shortened.
 *
 * References: E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, IV.8,
 * (8.17)-(8.25), and the code RADAU5; K. Gustafsson, ACM TOMS 20 (1994) 496, for the predictive
 * control. */
#include "radau.h"

#define SAFETY PK_C(0.9)
#define SHRINK PK_C(0.2)
#define GROW PK_C(8.0)
#define KEEP PK_C(1.2) /* a smaller increase is not made, so that Newton's matrix can be reused */
/* Fraction of the tolerance. Smaller corrections that do not decrease as expected are rounding. */
#define LITTLE PK_C(1e-3)
enum { MOST_ITERATIONS = 10 };

static size_t lay_out(struct pk_radau_parts *r, size_t n, struct pk_pattern pattern, pk_real *base)
{
    pk_real *kept, *E;
    r->E = (struct pk_band){.rows = pattern.rows,
                            .below = pattern.width,
                            .above = pattern.width,
                            .border = pattern.border,
                            .pivoting = 1};
    /* clang-format off */
    const struct pk_slot slots[] = {
        {&E, pk_band_lay_out(&r->E, NULL)}, {&r->pdot, n}, {&r->dq, n}, {&r->dv, n}, {&r->of_q, n},
        {&r->of_v, n}, {&r->x, n}, {&kept, PK_REALS_OF(*r->kept)}};
    /* clang-format on */
    const size_t size = PK_LAY_OUT(base, slots);
    r->kept = (struct pk_radau_kept *)(void *)kept;
    if (base)
        pk_band_lay_out(&r->E, E);
    return size;
}

static struct pk_radau_parts parts_of(const struct pk_integrator *it, const struct pk_gauss_work *w)
{
    struct pk_radau_parts r;
    lay_out(&r, it->n, w->pattern, w->rest);
    return r;
}

static size_t size(const struct pk_method *method, const struct pk_problem *problem, size_t n)
{
    struct pk_radau_parts r;
    const struct pk_pattern pattern = pk_system_pattern(problem->system, problem->params);
    return pk_gauss_size(method, problem, n) + lay_out(&r, n, pattern, NULL);
}

static enum pk_status init(struct pk_integrator *it)
{
    const enum pk_status status = pk_gauss_init(it);
    const struct pk_gauss_work w = pk_gauss_parts(it);
    const struct pk_radau_parts r = parts_of(it, &w);
    *r.kept = (struct pk_radau_kept){.left = 1};
    return status;
}

/* Returns the last correction relative to the tolerance: root mean square over stages, q and v. */
static pk_real correction(const struct pk_integrator *it, const struct pk_gauss_work *w,
                          const struct pk_radau_parts *r)
{
    const size_t read = pk_gauss_read(w), moving = read < it->n_q ? read : it->n_q;
    pk_real sum = 0;
    for (size_t i = 0; i < w->s; i++)
        for (size_t k = 0; k < read; k++) {
            const pk_real d = w->G[i * it->n + k], dv = d / r->of_v[k];
            const pk_real dq = k < moving ? it->own->h * d / r->of_q[k] : 0;
            sum += dv * dv + dq * dq;
        }
    return read ? PK_F(sqrt)(sum / (pk_real)(w->s * (read + moving))) : 0;
}

/* Returns the last correction relative to rates and |q/h|. */
static pk_real relative(const struct pk_integrator *it, const struct pk_gauss_work *w)
{
    pk_real size = 0, scale = PK_TINY;
    for (size_t i = 0; i < w->s * it->n; i++) {
        if (i % it->n >= pk_gauss_read(w))
            continue;
        size = pk_max(size, pk_abs(w->G[i]));
        scale = pk_max(scale, pk_abs(w->V[i]));
        if (i % it->n < it->n_q)
            scale = pk_max(scale, pk_abs(it->q[i % it->n] / it->own->h));
    }
    return size / scale;
}

/* Iterates by simplified Newton to a fraction of the tolerance. *count: number of iterations. */
static enum pk_status iterate(struct pk_integrator *it, struct pk_gauss_work *w,
                              const struct pk_radau_parts *r, int *count)
{
    const int most = it->options.max_iterations > 0 ? it->options.max_iterations
                     : it->options.newton_tol > 0   ? 50
                                                    : MOST_ITERATIONS;
    pk_real before = 0, left = PK_F(pow)(pk_max(r->kept->left, PK_EPS), PK_C(0.8));
    int done = 0;
    for (*count = 0; *count <= most; ++*count) {
        if (!pk_gauss_residual(it, w))
            return PK_NOT_FINITE;
        if (done) {
            pk_gauss_settle(it, w);
            return PK_DONE;
        }
        if (*count == 0 && pk_gauss_stale(it, w) && !pk_gauss_refactor(it, w, PK_SIMPLIFIED))
            return PK_NO_CONVERGENCE;
        pk_gauss_correct(it, w, PK_SIMPLIFIED);
        it->count.iterations++;
        const pk_real now = correction(it, w, r), asked_for = it->options.newton_tol;
        it->reason = PK_WHY(.value = now);
        if (!pk_finite(now))
            return PK_NOT_FINITE;
        if (asked_for > 0) {
            done = relative(it, w) <= asked_for;
        } else if (*count > 0) {
            const pk_real rate = now / before;
            const int little = now <= LITTLE;
            if (!(rate < 1) && !little)
                return PK_NO_CONVERGENCE;
            left = rate < 1 ? rate / (1 - rate) : 0;
            if (rate > PK_C(1e-3)) /* so slow that a new matrix is worth its cost */
                it->own->flags |= PK_REFRESH;
            if (left * now * PK_F(pow)(rate, (pk_real)(most - 1 - *count)) > r->kept->enough) {
                if (!little)
                    return PK_NO_CONVERGENCE;
                left = 0;
            }
        }
        before = now;
        if (!(asked_for > 0))
            done = left * now <= r->kept->enough;
    }
    return PK_NO_CONVERGENCE;
}

/* Tries a step of size it->own->h: solves the stages, estimates the error, certifies the branch. */
static enum pk_status attempt(struct pk_integrator *it, struct pk_gauss_work *w,
                              const struct pk_radau_parts *r, int again, int *count)
{
    enum pk_status status;
    if (it->own->h > w->kept->h || it->own->h < w->kept->h)
        pk_gauss_set_step(it, w, it->own->h);
    /* gives q = 0 a tolerance, from the distance moved in the step */
    for (size_t k = 0; k < it->n_q; k++)
        r->dq[k] = it->q[k] + it->own->h * it->v[k];
    pk_radau_tolerances(it, r, r->dq, it->v);
    do {
        w->kept->fresh = w->kept->noisy = 0;
        pk_gauss_predict(it, w);
        status = iterate(it, w, r, count);
        it->own->flags |= status < 0 ? PK_REFRESH : 0; /* a reused matrix may be the cause */
    } while (status == PK_NO_CONVERGENCE && !(w->kept->fresh > 0));
    if (status < 0 || (status = pk_radau_judge(it, w, r, again)) < 0 || it->own->error > 1)
        return status;
    status = pk_gauss_certify(it, w);
    if (status >= 0 && !pk_finite(w->kept->contraction)) /* V may be another solution */
        status = pk_radau_judge(it, w, r, again);
    return status;
}

/* Returns the ratio of the next step size to this one, from the errors of this step and the last
 * one. The ratio is smaller if Newton's iteration took long. */
static pk_real growth(const struct pk_integrator *it, const struct pk_radau_parts *r, int count)
{
    const pk_real error = pk_max(it->own->error, PK_C(1e-10)), most = 2 * MOST_ITERATIONS;
    const pk_real safety = SAFETY * (most + 1) / (most + (pk_real)count);
    pk_real grow = safety / PK_F(sqrt)(PK_F(sqrt)(error));
    if (it->own->error <= 1 && pk_abs(r->kept->h) > 0)
        grow = pk_min(grow, SAFETY * pk_abs(it->own->h / r->kept->h) *
                                PK_F(sqrt)(PK_F(sqrt)(r->kept->error / (error * error))));
    return pk_max(SHRINK, pk_min(GROW, grow));
}

static enum pk_status step(struct pk_integrator *it, pk_real limit)
{
    struct pk_integrator_private *const own = it->own;
    struct pk_gauss_work w = pk_gauss_parts(it);
    const struct pk_radau_parts r = parts_of(it, &w);
    int count = 0;
    if (!(pk_abs(own->h) > 0)) {
        own->flags = 0;
        r.kept->left = 1;
        r.kept->h = 0;
        PK_TRY(pk_eval_acceleration(it, it->t, it->q, it->v, r.x));
        own->h = (pk_real)own->direction * pk_first_step(it, r.x, PK_C(0.01), limit);
    }
    pk_eval_canonical(it, it->t, it->q, it->v, w.G, r.pdot);
    struct pk_trial x = pk_trial(it, limit);
    for (;;) {
        if (!pk_trial_next(it, limit, &x))
            return pk_underflow(it, x.planned);
        own->h = x.h;
        enum pk_status status =
            attempt(it, &w, &r, x.rejected || !(own->flags & PK_HAVE_STEP), &count);
        if (status >= 0 && own->error <= 1 && (status = pk_gauss_finish(it, &w)) >= 0)
            break;
        if (status < 0 && status != PK_NO_CONVERGENCE && status != PK_AMBIGUOUS_STEP)
            pk_trouble(it, status, own->next_t); /* otherwise the step was too long */
        const pk_real less = status < 0 ? PK_C(0.5) : pk_min(growth(it, &r, count), PK_C(0.9));
        pk_trial_reject(it, &x, pk_abs(own->h) * less);
    }
    pk_real grow = growth(it, &r, count);
    if (x.rejected)
        grow = pk_min(grow, 1);
    else if (grow >= 1 && grow <= KEEP)
        grow = 1;
    r.kept->h = own->h;
    r.kept->error = pk_max(own->error, PK_C(0.01));
    pk_trial_accept(it, &x, pk_abs(own->h) * grow, grow >= 1);
    return PK_DONE;
}

#define RADAU(of)                                                                                 \
    .needs = PK_NEEDS_RADAU, .table = &pk_##of##_table, .formula = &pk_method_##of, .size = size, \
    .init = init, .step = step, .equations = pk_gauss_equations, .last = pk_gauss_last
PK_METHODS_RADAU(PK_DEFINE_METHOD, RADAU)

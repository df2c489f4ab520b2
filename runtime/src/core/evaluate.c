/* Calls kernels: computes inputs, counts the calls, reports failures with their cause. */
#include "generic.h"
#include "project.h"

int pk_all_finite(const pk_real *x, size_t count)
{
    size_t i = 0;
    for (int bad = 0; i + 8 <= count; i += 8) { /* in blocks of 8, so that the inner loop is
                                                   vectorised */
        for (size_t k = 0; k < 8; k++)
            bad |= !pk_finite(x[i + k]);
        if (bad)
            return 0;
    }
    for (; i < count; i++)
        if (!pk_finite(x[i]))
            return 0;
    return 1;
}

void pk_constant_input(void *context, pk_real t, pk_real *u)
{
    const struct pk_constant_input *input = (const struct pk_constant_input *)context;
    (void)t;
    for (size_t i = 0; i < input->count; i++)
        u[i] = input->u[i];
}

void pk_input(const struct pk_problem *problem, pk_real t, pk_real *u)
{
    for (size_t i = 0; i < problem->system->n_inputs && !problem->input; i++)
        u[i] = 0;
    if (problem->system->n_inputs && problem->input)
        problem->input(problem->context, t, u);
}

const pk_real *pk_eval_input(struct pk_integrator *it, pk_real t)
{
    if (it->problem.system->n_inputs)
        pk_input(&it->problem, t, it->own->u);
    return it->own->u;
}

void pk_feedback(const struct pk_problem *problem, pk_real t, const pk_real *q, const pk_real *v,
                 pk_real *u)
{
    if (problem->system->n_inputs && problem->feedback)
        problem->feedback(problem->context, t, q, v, u);
    else
        pk_input(problem, t, u);
}

const pk_real *pk_eval_feedback(struct pk_integrator *it, pk_real t, const pk_real *q,
                                const pk_real *v)
{
    if (it->problem.system->n_inputs)
        pk_feedback(&it->problem, t, q, v, it->own->u);
    return it->own->u;
}

enum pk_status pk_eval_acceleration(struct pk_integrator *it, pk_real t, const pk_real *q,
                                    const pk_real *v, pk_real *a)
{
    return generic_acceleration(it, t, q, v, a);
}

/* Returns the ratio of a pivot in M = L D L^T to its diagonal entry. It is the pivot of coordinate
 * `last` if the other coordinates are eliminated first: the ratio is 1 if coordinate `last` is not
 * coupled to them, 0 if M is singular in its direction. If an earlier pivot is only rounding, the
 * ratio of that pivot is returned. NaN: M is not available or too large. */
static pk_real pivot_ratio(const struct pk_integrator *it, pk_real t, const pk_real *q,
                           const pk_real *v, size_t last)
{
    enum { MOST = 16 };
    pk_real M[MOST * MOST], ratio = (pk_real)NAN;
    size_t order[MOST];
    const size_t n = it->n;
    if (n > MOST || last >= n || !it->problem.system->mass || it->problem.system->families.count)
        return ratio;
    it->problem.system->mass(it->problem.params, t, q, v, it->own->u, M);
    for (size_t i = 0, k = 0; i < n; i++)
        if (i != last)
            order[k++] = i;
    order[n - 1] = last;
    for (size_t k = 0; k < n; k++) {
        const size_t row = order[k] * n, at = row + order[k];
        const pk_real diagonal = M[at];
        /* M now has the entries of L below the diagonal and those of D on the diagonal */
        for (size_t j = 0; j < k; j++)
            M[at] -= M[row + order[j]] * M[row + order[j]] * M[order[j] * n + order[j]];
        ratio = diagonal > 0 ? M[at] / diagonal : diagonal < 0 ? -1 : 0;
        if (!(ratio > PK_PIVOT_MIN))
            break;
        for (size_t i = k + 1; i < n; i++) {
            pk_real *entry = &M[order[i] * n + order[k]];
            for (size_t j = 0; j < k; j++)
                *entry -= M[order[i] * n + order[j]] * M[row + order[j]] *
                          M[order[j] * n + order[j]];
            *entry /= M[at];
        }
    }
    return ratio;
}

enum pk_status pk_eval_failed(struct pk_integrator *it, pk_real t, const pk_real *q,
                              const pk_real *v, int failed)
{
    /* If the state is not finite, M is not either: the state is the cause to report. */
    if (!pk_all_finite(q, it->n_q) || !pk_all_finite(v, it->n))
        return PK_NOT_FINITE;
    it->reason = PK_WHY(.index = (size_t)PK_FAILURE_AT(failed), .time = t);
    if (PK_FAILURE(failed) == PK_FAILURE_CONSTRAINT)
        return pk_project_singular(it, q, v);
    it->reason.value = pivot_ratio(it, t, q, v, it->reason.index);
    return PK_SINGULAR_MASS;
}

unsigned long long pk_eval_lanes(struct pk_integrator *it, const pk_real *t, const pk_real *q,
                                 const pk_real *v, const pk_real *u, pk_real *a)
{
    const struct pk_system *system = it->problem.system;
    if (system->lanes)
        return system->lanes(it->problem.params, t, q, v, u, a);
    const size_t n_q = it->n_q, n = it->n, m = system->n_inputs;
    pk_real *q1 = it->own->lane, *v1 = q1 + n_q, *a1 = v1 + n, *u1 = a1 + n;
    unsigned long long failed = 0;
    for (size_t l = 0; l < PK_LANES; l++) {
        for (size_t i = 0; i < n_q; i++)
            q1[i] = q[i * PK_LANES + l];
        for (size_t i = 0; i < n; i++)
            v1[i] = v[i * PK_LANES + l];
        for (size_t i = 0; i < m; i++)
            u1[i] = u[i * PK_LANES + l];
        if (system->acceleration(it->problem.params, t[l], q1, v1, u1, a1))
            failed |= 1ull << l;
        for (size_t i = 0; i < n; i++)
            a[i * PK_LANES + l] = a1[i];
    }
    return failed;
}

void pk_eval_canonical(struct pk_integrator *it, pk_real t, const pk_real *q, const pk_real *v,
                       pk_real *p, pk_real *pdot)
{
    const pk_real *u = pk_eval_input(it, t);
    it->problem.system->canonical(it->problem.params, t, q, v, u, p, pdot);
    it->count.evaluations++;
}

pk_real pk_first_step(const struct pk_integrator *it, const pk_real *a, pk_real share,
                      pk_real limit)
{
    const size_t n_q = it->n_q, n = it->n;
    const pk_real span = pk_abs(limit - it->t);
    pk_real d0 = 0, d1 = 0;
    for (size_t i = 0; i < n; i++) {
        const pk_real q = i < n_q ? it->q[i] : 0;
        const pk_real of_q = i < n_q ? pk_scale_known(pk_tolerance(it, i, q, q)) : PK_INFINITY;
        const pk_real v = it->v[i], of_v = pk_scale_known(pk_tolerance(it, n_q + i, v, v));
        d0 += v / of_v * (v / of_v) + q / of_q * (q / of_q);
        d1 += a[i] / of_v * (a[i] / of_v) + v / of_q * (v / of_q);
    }
    pk_real h = d0 > PK_C(1e-10) && d1 > PK_C(1e-10) ? share * PK_F(sqrt)(d0 / d1) : 0;
    if (!(h > 0) || !pk_finite(h)) /* y'/scale is infinite if atol = 0 and y = 0 */
        h = PK_C(1e-6) * span;
    return pk_min(it->options.h > 0 ? it->options.h : h, span);
}

/* The cause of the underflow is the failure of an earlier trial step if that failed just ahead of
 * the state. Otherwise a singular M is looked for on the straight line along which the state moves,
 * since step sizes may shrink before a singular M without reaching it. */
enum pk_status pk_underflow(struct pk_integrator *it, pk_real h)
{
    const pk_real near = 64 * PK_F(sqrt)(PK_EPS) * pk_abs(it->t);
    pk_real *q = pk_next(it, PK_Q), *a = pk_next(it, PK_A);
    struct pk_trouble *of = &it->own->trouble;
    if (of->status == PK_DONE || !(pk_abs(of->reason.time - it->t) <= near)) {
        of->reason.time = it->t + pk_direction(it) * near;
        for (size_t i = 0; i < it->n_q; i++)
            q[i] = it->q[i] + pk_direction(it) * near * it->v[i];
        if (pk_eval_acceleration(it, of->reason.time, q, it->v, a) != PK_SINGULAR_MASS)
            return pk_fail_with(it, PK_STEP_UNDERFLOW, PK_WHY(.value = h));
        pk_trouble(it, PK_SINGULAR_MASS, of->reason.time);
    }
    return pk_fail_with(it, of->status, of->reason);
}

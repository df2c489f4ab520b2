/* The projection of a step onto unit quaternions and the constraints phi(t, q) = 0 and J v + j0 =
 * 0. The equations of motion conserve these (their index was reduced by differentiation); a step of
 * order p violates them by O(h^(p+1)), and the correction is of this size:
 *
 *     q -= M^-1 J^T mu  until  phi = 0         v -= M^-1 J^T nu  with  J v + j0 = 0
 *
 * by Newton's method, in the metric of M: to first order the result is the nearest state that
 * satisfies the constraints, and the method keeps its order. A quaternion is rotated by the vector
 * of its three entries of M^-1 J^T mu. Rolling constrains rates only. Derivatives that a method
 * reuses from its last step are not recomputed: their error is the step's, its effect smaller by h.
 *
 * A large first correction means that the step did not resolve phi(t), such as a steep ramp. If the
 * step can be retried, a correction of more than MOST_OFF error tolerances makes the step fail;
 * otherwise one that is longer than |h v| does.
 *
 * Reference: E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration, IV.4 (projection),
 * VII.1.3; E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, VII.2. */

#include "../core/attitude.h"
#include "../core/project.h"

#define ROUND (PK_EPS / 2)      /* a relative residual up to this counts as 0: larger ones drift */
#define STALLED (1024 * PK_EPS) /* a smaller residual that stops falling is rounding */
#define NOTICED (PK_C(1e5) * PK_EPS) /* a larger relative residual is not rounding */
#define MOST_OFF PK_C(10.0) /* limit of a first correction, in tolerances, as in Gauss steps */
enum { MOST = 20 };         /* limit of the number of corrections */

int pk_project_dependent(struct pk_integrator *it)
{
    struct pk_projection w = pk_projection(it);
    if (!w.c)
        return 0;
    w.t = it->t;
    w.u = pk_eval_input(it, it->t);
    if (pk_project_inertia(&w, it->q, it->v))
        return 0;
    pk_project_rows(&w, it->q, it->v);
    if (pk_project_factor(&w, w.c, it->q, it->v))
        return 0; /* a step itself reports that J M^-1 J^T is singular */
    pk_project_rank(&w);
    for (size_t row = 0; row < w.c; row++)
        if (w.sines[row] < PK_DEPENDENT) {
            it->reason = PK_WHY(.index = row);
            if (w.whole)
                pk_project_explain(&w, w.c, row);
            return 1;
        }
    return 0;
}

pk_real pk_project_worst(const pk_real *residual, const pk_real *terms, size_t rows, size_t *which)
{
    pk_real most = 0, largest = 0;
    *which = 0;
    for (size_t i = 0; i < rows; i++)
        largest = pk_max(largest, terms[i]);
    for (size_t i = 0; i < rows; i++) {
        const pk_real x = pk_abs(residual[i]);
        if (!(x > 0) && pk_finite(x))
            continue;
        const pk_real ratio = x / (terms[i] + PK_EPS * largest + PK_TINY);
        if (!(ratio <= most)) /* the condition is true for NaN */
            most = ratio, *which = i;
    }
    return most;
}

/* Returns 1 if an iteration has converged, -1 if it has failed, otherwise 0. */
static int judged(pk_real ratio, pk_real before, int count)
{
    if (ratio <= ROUND || (count && ratio >= before / 2 && ratio <= STALLED))
        return 1;
    return !pk_finite(ratio) || count == MOST ? -1 : 0;
}

static void subtract(pk_real *x, const pk_real *d, pk_real *low, size_t count)
{
    for (size_t k = 0; k < count; k++) {
        pk_real none = 0;
        x[k] = pk_sum(x[k], -d[k], low ? &low[k] : &none);
    }
}

static void turn_back(const struct pk_projection *w, pk_real *v, pk_real *low)
{
    for (size_t r = 0; r < pk_system_rotations(w->system, w->params); r++) {
        const struct pk_turning at = pk_system_turning(w->system, w->params, r);
        pk_real theta[3], Q[4], added[4];
        for (size_t i = 0; i < 3; i++)
            theta[i] = -w->d[at.rate + i * at.step];
        for (size_t i = 0; i < 4; i++)
            Q[i] = v[at.number + i * at.step];
        pk_exponential_added(Q, theta, added);
        for (size_t i = 0; i < 4; i++) {
            const size_t k = at.number + i * at.step;
            const pk_real back = -added[i];
            subtract(v + k, &back, low ? low + k : NULL, 1);
        }
    }
}

/* Returns the largest component of the correction d, by MOST_OFF tolerances of y. */
static pk_real correction_in_tolerances(const struct pk_integrator *it, const pk_real *d,
                                        const pk_real *y, size_t first, size_t count)
{
    pk_real most = 0;
    for (size_t k = 0; k < count; k++)
        most = pk_max(most, pk_abs(d[k]) / pk_tolerance(it, first + k, y[k], y[k]));
    return most / MOST_OFF;
}

/* Returns whether the correction d of positions is longer than the step, |d| > |h v|, in the metric
 * of M = L D L^T; v is the larger of the rates at both ends. */
static int longer_than_step(const struct pk_integrator *it, const struct pk_projection *w)
{
    const pk_real h = it->own->next_t - it->t;
    const pk_real *ends[2] = {it->v, pk_next(it, PK_V)};
    const pk_real back = pk_dot(w->mu, w->phi, w->h);
    pk_real longest = PK_TINY;
    for (int end = 0; end < 2; end++) {
        pk_real way = 0;
        for (size_t j = 0; j < w->m; j++) {
            pk_real x = ends[end][j];
            if (!w->whole) { /* uses only the diagonal of M */
                way += w->M[j] * (h * x) * (h * x);
                continue;
            }
            for (size_t i = j + 1; i < w->m; i++)
                x += w->M[i * w->m + j] * ends[end][i];
            way += w->M[j * w->m + j] * (h * x) * (h * x);
        }
        longest = pk_max(longest, way);
    }
    return pk_abs(back) > longest;
}

/* Returns whether the first correction of a step is too large to be due to the step's error. */
static int off(const struct pk_integrator *it, const struct pk_projection *w, pk_real ratio,
               const pk_real *q, const pk_real *y, int of_rates)
{
    const size_t count = of_rates ? w->m : w->rotation;
    const int repeats = it->own->atol && pk_repeats(it); /* whether advance() can retry the step */
    pk_real most = 0;
    if (!(ratio > NOTICED) || !(it->own->next_t > it->t || it->own->next_t < it->t))
        return 0;
    if (!repeats)
        return !of_rates && longer_than_step(it, w);
    for (size_t k = 0; of_rates && k < count; k++)
        most = pk_max(most, PK_F(sqrt)(pk_project_mass(w, k)) * pk_abs(w->d[k]));
    return !(of_rates && most <= pk_project_rest(it, w, q)) &&
           correction_in_tolerances(it, w->d, y, of_rates ? it->n_q : 0, count) > 1;
}

/* Corrects positions or, once they are corrected, rates. J does not depend on rates, so that apart
 * from rounding one correction of rates suffices. */
static enum pk_status correct(struct pk_integrator *it, struct pk_projection *w, pk_real *q,
                              pk_real *v, pk_real *low_q, pk_real *low_v, int of_rates, int *moved)
{
    const pk_real *residual = of_rates ? w->rate : w->phi;
    const pk_real *terms = of_rates ? w->rate_size : w->phi_size;
    const size_t rows = of_rates ? w->c : w->h;
    pk_real before = 0;
    for (int count = 0;; count++) {
        size_t which;
        if (count || !of_rates)
            pk_project_rows(w, q, v);
        const pk_real ratio = pk_project_worst(residual, terms, rows, &which);
        const int done = judged(ratio, before, count);
        w->depends[0] = 0;
        if (done > 0)
            return PK_DONE;
        const size_t singular = done ? 0 : pk_project_factor(w, rows, q, v);
        if (singular && w->inertia)
            return pk_eval_failed(it, w->t, q, v, w->inertia);
        if (singular)
            which = singular - 1;
        else if (!done)
            pk_project_solve(w, rows, residual);
        if (done || singular || (!count && off(it, w, ratio, q, of_rates ? v : q, of_rates)))
            return pk_fail_with(it, PK_NO_PROJECTION,
                                PK_WHY(.kind = of_rates ? PK_REASON_ROW_RATE : PK_REASON_ROW,
                                       .index = pk_project_row(w, which), .value = residual[which]));
        if (of_rates) {
            pk_project_seen(it, w);
            subtract(v, w->d, low_v, w->m);
        } else {
            subtract(q, w->d, low_q, w->rotation);
            turn_back(w, v, low_v);
        }
        *moved = 1;
        before = ratio;
    }
}

enum pk_status pk_project(struct pk_integrator *it, pk_real t, pk_real *q, pk_real *v,
                          pk_real *low_q, pk_real *low_v, int *moved)
{
    struct pk_projection w = pk_projection(it);
    *moved = 0;
    for (size_t r = 0; r < pk_system_rotations(w.system, w.params); r++) {
        const struct pk_turning at = pk_system_turning(w.system, w.params, r);
        const int turned = pk_normalise(v + at.number, low_v ? low_v + at.number : NULL, at.step);
        if (turned < 0)
            return PK_NOT_FINITE;
        *moved |= turned;
    }
    if (!w.c)
        return PK_DONE;
    w.t = t;
    w.u = pk_eval_input(it, t);
    const int singular = pk_project_inertia(&w, q, v);
    if (singular)
        return pk_eval_failed(it, t, q, v, singular);
    pk_project_terms(&w, q, v);
    PK_TRY(correct(it, &w, q, v, low_q, low_v, 0, moved));
    PK_TRY(correct(it, &w, q, v, low_q, low_v, 1, moved));
    if (!it->own->passing.seen)
        pk_singular_crossing_unseen(it, &w, q, v);
    return PK_DONE;
}

enum pk_status pk_project_rates(struct pk_integrator *it, pk_real *q, pk_real *v)
{
    struct pk_projection w = pk_projection(it);
    int moved;
    if (!it->own->project || !w.c)
        return PK_DONE;
    w.t = it->t;
    w.u = pk_eval_input(it, it->t);
    const int singular = pk_project_inertia(&w, q, v);
    if (singular)
        return pk_eval_failed(it, it->t, q, v, singular);
    pk_project_rows(&w, q, v);
    pk_project_terms(&w, q, v);
    return correct(it, &w, q, v, NULL, NULL, 1, &moved);
}

enum pk_status pk_project_step(struct pk_integrator *it)
{
    const size_t n = it->n;
    pk_real *q = pk_next(it, PK_Q), *v = pk_next(it, PK_V);
    pk_real *low_q = pk_next(it, PK_LOW_Q), *low_v = pk_next(it, PK_LOW_X);
    int moved = 0;
    if (!it->own->project)
        return PK_DONE;
    if (!(it->method->traits & PK_HOLONOMIC)) /* methods with PK_HOLONOMIC project by themselves */
        PK_TRY(pk_project(it, it->own->next_t, q, v, low_q, it->p ? NULL : low_v, &moved));
    PK_TRY(pk_project_redundant(it, it->own->next_t, q, v, PK_NO_PROJECTION));
    if (!moved || !it->p)
        return PK_DONE;
    pk_eval_canonical(it, it->own->next_t, q, v, pk_next(it, PK_P), it->own->project + n);
    pk_zero(low_v, n);
    return PK_DONE;
}

/* Crosses a position where constraint rows are linearly dependent for an instant, such as a flat
 * parallelogram. Branches of the motion meet there and the equations are singular, so that only
 * continuity determines the branch. Near it the errors of a step's stages, which violate the
 * constraints, are magnified, and steps may turn into another branch.
 *
 * sigma is the least part of a row that is independent of previous rows, in the metric of M and
 * relative to the largest such part of that row. It falls to 0 linearly in time. Before sigma is 0,
 * a Gauss step is made across the position, with stages that are not near the position. Each stage
 * is predicted by the smooth motion and projected onto the constraints before its acceleration is
 * computed. Projection must move the stages and the end of the step by less than the fraction SURE
 * of the distance covered, since other branches are farther away. It needs no history and serves
 * all methods.
 *
 * Reference: E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration, II.1.2
 * (collocation). */
#include <string.h>

#include <pk/constraint.h>

#include "../core/tableau.h"
#include "singular_crossing.h"

enum { FEWEST = 6, ROUNDS = 60 };
#define SURE PK_C(1e-3)    /* limit of the shift by projection, relative to the distance covered */
#define SETTLED PK_C(1e-9) /* a relative change below this that stops shrinking is rounding */
#define ROUND (64 * PK_EPS)
#define LAST PK_C(0.01) /* rounding forbids to go nearer than this sigma to the position */
#define SHORTER PK_C(0.8)
#define ACCEPT PK_C(10.0) /* limit of the error in tolerances, as in the adaptive Gauss method */

/* Computes w such that the sum of w_j times stage values is the integral over the fraction `to`. */
static void weights(const struct pk_singular_crossing_parts *x, pk_real to, pk_real *w)
{
    const int s = (int)pk_index(x->is->stages, PK_SINGULAR_CROSSING_STAGES + 1);
    pk_real at[PK_SINGULAR_CROSSING_STAGES + 1], P[PK_SINGULAR_CROSSING_STAGES + 1],
        integral[PK_SINGULAR_CROSSING_STAGES + 1];
    pk_legendre(to, 1 - to, s, at, integral);
    for (int j = 0; j < s; j++) {
        pk_legendre(x->c[j], 1 - x->c[j], s, P, NULL);
        w[j] = 0;
        for (int k = 0; k < s; k++)
            w[j] += x->b[j] * (pk_real)(2 * k + 1) * P[k] * integral[k];
        w[j] *= x->is->h;
    }
}

/* Computes the state at the fraction `to` of the step from the stages. */
static void along(const struct pk_integrator *it, const struct pk_singular_crossing_parts *x,
                  pk_real to, pk_real *q, pk_real *v)
{
    const size_t n = it->n, stages = pk_index(x->is->stages, PK_SINGULAR_CROSSING_STAGES + 1);
    pk_real w[PK_SINGULAR_CROSSING_STAGES];
    weights(x, to, w);
    pk_copy(q, x->q, it->n_q);
    pk_copy(v, x->v, n);
    for (size_t j = 0; j < stages; j++) {
        for (size_t i = 0; i < it->n_q; i++)
            q[i] += w[j] * x->V[j * n + i];
        for (size_t i = 0; i < n; i++)
            v[i] += w[j] * x->A[j * n + i];
    }
}

/* Returns the largest component of a - b relative to the largest of c - d (of c, if d is NULL);
 * each component is multiplied by the root of its entry of M's diagonal. */
static pk_real relative_distance(const struct pk_projection *w, const pk_real *a, const pk_real *b,
                                 const pk_real *c, const pk_real *d, size_t count)
{
    pk_real off = 0, way = PK_TINY;
    for (size_t k = 0; k < count; k++) {
        const pk_real root = PK_F(sqrt)(pk_project_mass(w, k));
        off = pk_max(off, root * pk_abs(a[k] - b[k]));
        way = pk_max(way, root * pk_abs(d ? c[k] - d[k] : c[k]));
    }
    return off / way;
}

/* Projects q and v onto the constraints. Raises *off to the relative shift by this projection: of q
 * relative to its distance from the start of the crossing, of v relative to v. */
static enum pk_status put(struct pk_integrator *it, const struct pk_singular_crossing_parts *x,
                          pk_real t, pk_real *q, pk_real *v, pk_real *off)
{
    const struct pk_projection w = pk_projection(it);
    int moved;
    pk_copy(x->q_here, q, it->n_q);
    pk_copy(x->v_here, v, it->n);
    PK_TRY(pk_project(it, t, q, v, NULL, NULL, &moved));
    *off = pk_max(*off, relative_distance(&w, q, x->q_here, q, x->q, w.rotation));
    *off = pk_max(*off, relative_distance(&w, v, x->v_here, v, NULL, w.m));
    return PK_DONE;
}

void pk_singular_crossing_at(struct pk_integrator *it, pk_real t, pk_real *q, pk_real *v)
{
    const struct pk_singular_crossing_parts x = pk_singular_crossing_parts(it);
    const pk_real next_t = it->own->next_t;
    pk_real off = 0;
    along(it, &x, (t - x.is->t) / x.is->h, q, v);
    const int apart = !pk_constraint_singular(it, t, q, v);
    it->own->next_t = it->t;
    if (apart && (put(it, &x, t, q, v, &off) < 0 || !(off < SURE)))
        along(it, &x, (t - x.is->t) / x.is->h, q, v);
    it->own->next_t = next_t;
}

/* Chooses the number of stages so that the singular position is farthest from its nearest stage. */
static void choose(struct pk_singular_crossing_parts *x)
{
    const pk_real place = (x->is->at - x->is->t) / x->is->h;
    pk_real best = -1;
    int stages = FEWEST;
    for (int s = FEWEST; s <= PK_SINGULAR_CROSSING_STAGES; s++) {
        pk_real next = 1;
        pk_gauss_nodes(s, x->c, x->b);
        for (int j = 0; j < s; j++)
            next = pk_min(next, pk_abs(x->c[j] - place));
        /* compares distances in units of the mean spacing of stages */
        if (next * (pk_real)s > best)
            best = next * (pk_real)s, stages = s;
    }
    x->is->stages = (pk_real)stages;
    pk_gauss_nodes(stages, x->c, x->b);
}

/* Computes the stages, by fixed-point iteration from a constant acceleration. */
static enum pk_status solve(struct pk_integrator *it, struct pk_singular_crossing_parts *x,
                            pk_real *off)
{
    const struct pk_projection w = pk_projection(it);
    const size_t n_q = it->n_q, n = it->n,
                 s = pk_index(x->is->stages, PK_SINGULAR_CROSSING_STAGES + 1);
    pk_real before = PK_INFINITY;
    pk_copy(x->q, it->q, n_q);
    pk_copy(x->v, it->v, n);
    PK_TRY(pk_eval_acceleration(it, it->t, it->q, it->v, x->A));
    for (size_t j = 0; j < s; j++) {
        memmove(x->A + j * n, x->A, n * sizeof *x->A);
        for (size_t i = 0; i < n; i++)
            x->V[j * n + i] = x->v[i] + x->c[j] * x->is->h * x->A[i];
    }
    for (int round = 0; round < ROUNDS; round++) {
        pk_real changed = 0;
        *off = 0;
        for (size_t j = 0; j < s; j++) {
            const pk_real t = x->is->t + x->c[j] * x->is->h;
            pk_real *q = x->Q + j * n_q, *v = pk_next(it, PK_V);
            along(it, x, x->c[j], q, v);
            PK_TRY(put(it, x, t, q, v, off));
            changed = pk_max(changed, relative_distance(&w, v, x->V + j * n, v, NULL, w.m));
            pk_copy(x->V + j * n, v, n);
            PK_TRY(pk_eval_acceleration(it, t, q, v, x->A + j * n));
        }
        if (changed <= ROUND || (changed <= SETTLED && changed >= before / 2))
            return PK_DONE;
        before = changed;
    }
    return PK_NO_CONVERGENCE;
}

/* Returns the error of the final rates in tolerances, from the accelerations' last coefficient. */
static pk_real error_of(const struct pk_integrator *it, const struct pk_singular_crossing_parts *x)
{
    const int s = (int)pk_index(x->is->stages, PK_SINGULAR_CROSSING_STAGES + 1);
    pk_real P[PK_SINGULAR_CROSSING_STAGES + 1], last[PK_SINGULAR_CROSSING_STAGES], most = 0;
    for (int j = 0; j < s; j++) {
        pk_legendre(x->c[j], 1 - x->c[j], s, P, NULL);
        last[j] = x->b[j] * P[s - 1] * (pk_real)(2 * s - 1) / (pk_real)(2 * s) * x->is->h;
    }
    for (size_t i = 0; i < it->n; i++) {
        pk_real error = 0;
        for (int j = 0; j < s; j++)
            error += last[j] * x->A[(size_t)j * it->n + i];
        most = pk_max(most, pk_abs(error) / pk_tolerance(it, it->n_q + i, x->v[i], x->v[i]));
    }
    return most;
}

/* Returns whether an adaptive method should first go nearer to the singular position, for a shorter
 * crossing, since the error of this crossing is too large. But if the crossing is shorter than the
 * last attempt and its error is more than half as large, the error is rounding, which grows on the
 * way to the position; then the method should not go nearer. */
static int too_long(const struct pk_integrator *it, const struct pk_singular_crossing_parts *x,
                    int sure)
{
    const int shorter = pk_abs(x->is->h) < SHORTER * pk_abs(x->is->length);
    const pk_real before = shorter ? x->is->error : PK_INFINITY;
    if (pk_is_fixed(it->method) || !(x->is->sigma > LAST))
        return 0;
    x->is->error = sure ? error_of(it, x) : PK_INFINITY;
    x->is->tried = x->is->sigma;
    x->is->length = x->is->h;
    return x->is->error > ACCEPT && !(x->is->error > before / 2);
}

enum pk_status pk_singular_crossing_step(struct pk_integrator *it)
{
    struct pk_integrator_private *const own = it->own;
    struct pk_singular_crossing_parts x = pk_singular_crossing_parts(it);
    const size_t n = it->n;
    const pk_real t = own->next_t, end = x.is->t + x.is->h;
    pk_real *q = pk_next(it, PK_Q), *v = pk_next(it, PK_V), off = 0;
    pk_zero(own->next, pk_state_offset(it->n_q, n, PK_PARTS));
    if (!(x.is->passing > 0)) {
        /* without a step size, the projection of stages is not judged like that of a step */
        own->next_t = it->t;
        choose(&x);
        const enum pk_status status = solve(it, &x, &off);
        const int sure = status >= 0 && off < SURE;
        own->next_t = t;
        if (too_long(it, &x, sure))
            return PK_NO_CONVERGENCE;
        x.is->error = x.is->tried = x.is->length = 0;
        if (!sure)
            return pk_singular_crossing_fail(it, x.is->at);
    }
    own->flags &= ~(PK_HAVE_A | PK_HAVE_STEP | PK_HAVE_DENSE);
    along(it, &x, (t - x.is->t) / x.is->h, q, v);
    x.is->passing = pk_abs(end - t) > PK_C(1e-9) * pk_abs(x.is->h);
    if (!(x.is->passing > 0)) {
        own->next_t = it->t;
        const enum pk_status status = put(it, &x, t, q, v, &off);
        own->next_t = t;
        if (status < 0 || !(off < SURE))
            return pk_singular_crossing_fail(it, x.is->at);
        PK_TRY(pk_project_redundant(it, t, q, v, PK_NO_PROJECTION));
    }
    own->passing.crossed = 1;
    if (it->p)
        pk_eval_canonical(it, t, q, v, pk_next(it, PK_P), own->project + n);
    return PK_DONE;
}

/* The passage of a motion through a position where rows of constraints depend on each other for an
 * instant: a parallelogram that lies flat. Branches of the motion meet there; which one is followed
 * is told by continuity, for the equations are singular there, and next to it the errors of a
 * step's stages, which are off the constraints, are magnified: steps may turn into another branch.
 *
 * sigma, the least part of a row that is not of those before it, in the metric of M and beside the
 * largest that the row had, falls to 0 in proportion to time. Before it does a step of Gauss's is
 * made over the place, whose stages are apart from it, and each put onto the constraints, from where
 * the smooth motion leads, before its acceleration is taken. Its end, and the stages, must be next
 * to the constraints before they are put there, within SURE of the way: branches that cross are
 * farther apart. A step of this kind needs no method's history, so that it serves all.
 *
 * Reference: E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration, II.1.2 (collocation).
 */
#include <string.h>

#include "../core/project.h"
#include "../core/tableau.h"

enum { FEWEST = 6, MOST = 8, ROUNDS = 60 };
#define NEAR PK_C(0.2)     /* sigma, below which it is watched to fall; of fixed steps twice that */
#define AHEAD PK_C(2.0)    /* steps: what is so near is passed */
#define LONG PK_C(1.25)    /* fixed steps: what is nearer than that is within the next, */
#define MIDDLE PK_C(0.75)  /* and what is farther than that wants two */
#define LITTLE PK_C(1e-4)  /* of the time left, for the slope of sigma */
#define FAR PK_C(0.9)      /* sigma, above which a fixed step meets no such place */
#define TURN PK_C(0.3)     /* of its way: more between its ends than rates tell is no motion */
#define SURE PK_C(1e-3)    /* of the way: how far the constraints may be from where it leads */
#define SETTLED PK_C(1e-9) /* what no longer shrinks below this is rounding */
#define ROUND (64 * PK_EPS)

struct passage {
    pk_real sigma; /* the last one */
    pk_real at;    /* when it vanishes, while it falls */
    pk_real falls; /* whether it does */
    pk_real t, h;  /* of the step over it */
    pk_real stages;
    pk_real passing; /* it is made, and its end is still to come */
    pk_real row;     /* which of them has the last sigma */
    pk_real unseen; /* whether the last step left it unknown */
};

struct parts {
    struct passage *is;
    pk_real *q, *v;     /* where the step begins */
    pk_real *Q, *V, *A; /* at its stages */
    pk_real *q_here, *v_here, *a_here;
    pk_real c[MOST], b[MOST];
};

static size_t lay_out(struct parts *x, size_t n, pk_real *base)
{
    pk_real *is = NULL;
    const struct pk_slot slots[] = {{&is, PK_REALS_OF(struct passage)},
                                    {&x->q, n},
                                    {&x->v, n},
                                    {&x->Q, MOST * n},
                                    {&x->V, MOST * n},
                                    {&x->A, MOST * n},
                                    {&x->q_here, n},
                                    {&x->v_here, n},
                                    {&x->a_here, n}};
    const size_t size = PK_LAY_OUT(base, slots);
    x->is = (struct passage *)(void *)is;
    return size;
}

size_t pk_passage_size(const struct pk_system *system, size_t n)
{
    struct parts x;
    return system->constraints.n ? lay_out(&x, n, NULL) : 0;
}

static struct parts parts_of(const struct pk_integrator *it)
{
    struct parts x;
    lay_out(&x, it->n, it->own->passage);
    if (x.is->stages > 0)
        pk_gauss_nodes((int)x.is->stages, x.c, x.b);
    return x;
}

static struct passage *passage_of(const struct pk_integrator *it)
{
    return (struct passage *)(void *)it->own->passage; /* lay_out() has it first */
}

void pk_passage_seen(struct pk_integrator *it, const struct pk_projection *w)
{
    const pk_real low = 4 * NEAR * NEAR, far = FAR * FAR;
    int seen = PK_SEEN;
    for (size_t i = 0; i < w->c; i++) {
        const pk_real pivot = w->A[i * w->c + i];
        w->most[i] = pk_max(w->most[i], w->norms[i]);
        seen |= (pivot < low * w->most[i] ? PK_SEEN_LOW : 0) | (pivot < far * w->most[i] ? PK_SEEN_DIPS : 0);
    }
    it->own->seen = seen;
}

void pk_passage_unseen(struct pk_integrator *it, struct pk_projection *w)
{
    struct passage *is = passage_of(it);
    is->unseen = !(is->unseen > 0);
    if (is->unseen > 0 && !it->own->near)
        return;
    if (pk_project_factor(w, w->c))
        it->own->seen = PK_SEEN_LOW | PK_SEEN_DIPS;
    else
        pk_passage_seen(it, w);
}

/* sigma at (t, q, v); 1 where M is singular. */
static pk_real least(struct pk_integrator *it, pk_real t, const pk_real *q, const pk_real *v)
{
    struct passage *is = passage_of(it);
    struct pk_projection w = pk_project_parts(&it->problem, it->n, it->own->project);
    pk_real found = 1;
    w.t = t;
    w.u = pk_eval_input(it, t);
    if (pk_project_inertia(&w, q, v))
        return 1;
    pk_project_rows(&w, q, v);
    const size_t depends = pk_project_factor(&w, w.c);
    if (depends) {
        is->row = (pk_real)(depends - 1);
        return 0;
    }
    for (size_t i = 0; i < w.c; i++) {
        w.most[i] = pk_max(w.most[i], w.norms[i]);
        if (w.A[i * w.c + i] / w.most[i] <= found)
            found = w.A[i * w.c + i] / w.most[i], is->row = (pk_real)i;
    }
    return PK_F(sqrt)(pk_max(found, 0));
}

/* When sigma vanishes, by its slope along the motion. Roughly in `left`. */
static enum pk_status aim(struct pk_integrator *it, const struct parts *x, pk_real left)
{
    struct passage *is = x->is;
    const size_t n = it->n;
    const pk_real little = LITTLE * left;
    PK_TRY(pk_eval_acceleration(it, it->t, it->q, it->v, x->a_here));
    for (size_t i = 0; i < n; i++) {
        x->q_here[i] = it->q[i] + little * it->v[i];
        x->v_here[i] = it->v[i] + little * x->a_here[i];
    }
    const pk_real then = least(it, it->t + little, x->q_here, x->v_here);
    is->falls = then < is->sigma;
    is->at = it->t + is->sigma * little / (is->sigma - then);
    return PK_DONE;
}

static void look(struct pk_integrator *it)
{
    const struct parts x = parts_of(it);
    struct passage *is = x.is;
    const int fixed = !(it->method->traits & PK_ADAPTIVE);
    const pk_real near = fixed ? 2 * NEAR : NEAR, was = is->sigma;
    is->falls = 0;
    is->sigma = least(it, it->t, it->q, it->v);
    const pk_real way = it->t - it->last_t;
    if (is->sigma < near && is->sigma < was && (way > 0 || way < 0))
        if (aim(it, &x, way) < 0)
            is->falls = 0;
}

void pk_passage_forget(struct pk_integrator *it)
{
    if (!it->own->passage)
        return;
    struct pk_projection w = pk_project_parts(&it->problem, it->n, it->own->project);
    struct passage *is = passage_of(it);
    memset(is, 0, sizeof *is);
    memset(w.most, 0, w.c * sizeof *w.most);
    is->sigma = 1;
    it->own->crossed = it->own->seen = it->own->near = 0;
    if (it->status >= 0)
        look(it);
    it->own->near = is->sigma < FAR;
}

void pk_passage_note(struct pk_integrator *it)
{
    struct passage *is = passage_of(it);
    const int seen = it->own->seen;
    if (is->passing > 0)
        return;
    if (seen & PK_SEEN_LOW) {
        look(it);
    } else if (seen) {
        is->falls = 0;
        is->sigma = seen & PK_SEEN_DIPS ? 2 * NEAR : 1;
    }
    it->own->near = is->sigma < FAR;
}

int pk_passage_due(struct pk_integrator *it, pk_real limit)
{
    struct passage *is = passage_of(it);
    const int fixed = !(it->method->traits & PK_ADAPTIVE);
    if (!(is->passing > 0)) {
        const pk_real left = is->at - it->t, h = fixed ? it->own->h : it->t - it->last_t;
        if (!(is->falls > 0) || !(left / h > 0) || !(left / h < (fixed ? LONG : AHEAD)))
            return 0;
        is->t = it->t;
        is->h = !fixed ? 2 * left : left / h > MIDDLE ? 2 * h : h;
    }
    const pk_real end = is->t + is->h;
    if (!fixed)
        it->own->next_t = pk_abs(end - it->t) < pk_abs(limit - it->t) ? end : limit;
    return 1;
}

pk_real pk_passage_limit(const struct pk_integrator *it, pk_real limit)
{
    const struct passage *is = passage_of(it);
    if (!(is->falls > 0) || !(it->method->traits & PK_ADAPTIVE))
        return limit;
    const pk_real half = (is->at - it->t) / 2;
    return half / (limit - it->t) > 0 && half / (limit - it->t) < 1 ? it->t + half : limit;
}

/* The weights of the stages for the integral up to x of the step. */
static void weights(const struct parts *x, pk_real to, pk_real *w)
{
    const int s = (int)x->is->stages;
    pk_real at[MOST + 1], P[MOST + 1], integral[MOST + 1];
    pk_legendre(to, 1 - to, s, at, integral);
    for (int j = 0; j < s; j++) {
        pk_legendre(x->c[j], 1 - x->c[j], s, P, NULL);
        w[j] = 0;
        for (int k = 0; k < s; k++)
            w[j] += x->b[j] * (pk_real)(2 * k + 1) * P[k] * integral[k];
        w[j] *= x->is->h;
    }
}

/* Where the stages lead. */
static void along(const struct parts *x, size_t n, pk_real to, pk_real *q, pk_real *v)
{
    pk_real w[MOST];
    weights(x, to, w);
    for (size_t i = 0; i < n; i++) {
        q[i] = x->q[i], v[i] = x->v[i];
        for (size_t j = 0; j < (size_t)x->is->stages; j++) {
            q[i] += w[j] * x->V[j * n + i];
            v[i] += w[j] * x->A[j * n + i];
        }
    }
}

int pk_passage_stage(struct pk_integrator *it, int k, struct pk_stage *stage)
{
    const struct parts x = parts_of(it);
    pk_real before[MOST], after[MOST];
    if (k >= (int)x.is->stages)
        return 0;
    weights(&x, (it->t - x.is->t) / x.is->h, before);
    weights(&x, (it->own->next_t - x.is->t) / x.is->h, after);
    stage->t = x.is->t + x.c[k] * x.is->h;
    stage->weight = after[k] - before[k];
    stage->q = x.Q + (size_t)k * it->n;
    stage->v = x.V + (size_t)k * it->n;
    return 1;
}

/* The largest of |a - b| beside that of |c - d|, in the metric of M's diagonal. */
static pk_real beside(const struct pk_projection *w, const pk_real *a, const pk_real *b,
                      const pk_real *c, const pk_real *d, size_t count)
{
    pk_real off = 0, way = PK_TINY;
    for (size_t k = 0; k < count; k++) {
        const pk_real root = PK_F(sqrt)(pk_ldl_diagonal(w->M, w->m, k));
        off = pk_max(off, root * pk_abs(a[k] - b[k]));
        way = pk_max(way, root * pk_abs(d ? c[k] - d[k] : c[k]));
    }
    return off / way;
}

/* q and v onto the constraints; *off: how far that is. */
static enum pk_status put(struct pk_integrator *it, const struct parts *x, pk_real t, pk_real *q,
                          pk_real *v, pk_real *off)
{
    const struct pk_projection w = pk_project_parts(&it->problem, it->n, it->own->project);
    int moved;
    memcpy(x->q_here, q, it->n * sizeof *q);
    memcpy(x->v_here, v, it->n * sizeof *v);
    PK_TRY(pk_project(it, t, q, v, NULL, NULL, &moved));
    *off = pk_max(*off, beside(&w, q, x->q_here, q, x->q, w.rotation));
    *off = pk_max(*off, beside(&w, v, x->v_here, v, NULL, w.m));
    return PK_DONE;
}

void pk_passage_at(struct pk_integrator *it, pk_real t, pk_real *q, pk_real *v)
{
    const struct parts x = parts_of(it);
    const size_t n = it->n;
    const pk_real next_t = it->own->next_t;
    pk_real off = 0;
    along(&x, n, (t - x.is->t) / x.is->h, q, v);
    it->own->next_t = it->t;
    if (put(it, &x, t, q, v, &off) < 0 || !(off < SURE)) /* too near the place */
        along(&x, n, (t - x.is->t) / x.is->h, q, v);
    it->own->next_t = next_t;
}

/* As many stages as keep farthest from the place. */
static void choose(struct parts *x)
{
    const pk_real place = (x->is->at - x->is->t) / x->is->h;
    pk_real best = -1;
    int stages = FEWEST;
    for (int s = FEWEST; s <= MOST; s++) {
        pk_real next = 1;
        pk_gauss_nodes(s, x->c, x->b);
        for (int j = 0; j < s; j++)
            next = pk_min(next, pk_abs(x->c[j] - place));
        if (next * (pk_real)s > best) /* more are nearer anyway, and of higher order */
            best = next * (pk_real)s, stages = s;
    }
    x->is->stages = (pk_real)stages;
    pk_gauss_nodes(stages, x->c, x->b);
}

/* The stages, by fixed-point iteration from a constant acceleration. */
static enum pk_status solve(struct pk_integrator *it, struct parts *x, pk_real *off)
{
    const struct pk_projection w = pk_project_parts(&it->problem, it->n, it->own->project);
    const size_t n = it->n, s = (size_t)x->is->stages;
    pk_real before = PK_INFINITY;
    memcpy(x->q, it->q, n * sizeof *x->q);
    memcpy(x->v, it->v, n * sizeof *x->v);
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
            pk_real *q = x->Q + j * n, *v = pk_part(it->own->next, n, PK_V);
            along(x, n, x->c[j], q, v);
            PK_TRY(put(it, x, t, q, v, off));
            changed = pk_max(changed, beside(&w, v, x->V + j * n, v, NULL, w.m));
            memcpy(x->V + j * n, v, n * sizeof *v);
            PK_TRY(pk_eval_acceleration(it, t, q, v, x->A + j * n));
        }
        if (changed <= ROUND || (changed <= SETTLED && changed >= before / 2))
            return PK_DONE;
        before = changed;
    }
    return PK_NO_CONVERGENCE;
}

/* it->where, of a branch that cannot be told: behind all else, and which row. */
static size_t told(const struct pk_integrator *it)
{
    const struct pk_part_constraints *c = &it->problem.system->constraints;
    return 2 * (c->n + c->n_redundant) + it->problem.system->n_rotations + 1 +
           (size_t)parts_of(it).is->row;
}

enum pk_status pk_passage_judge(struct pk_integrator *it)
{
    const struct passage *is = passage_of(it);
    if (it->method->traits & PK_ADAPTIVE || !(is->sigma < FAR || it->own->seen & PK_SEEN_DIPS))
        return PK_DONE;
    const struct pk_projection w = pk_project_parts(&it->problem, it->n, it->own->project);
    const pk_real *q = it->own->next, *v = pk_part(it->own->next, it->n, PK_V);
    const pk_real h = it->own->next_t - it->t;
    pk_real off = 0, way = PK_TINY;
    for (size_t k = 0; k < w.rotation; k++) {
        const pk_real root = PK_F(sqrt)(pk_ldl_diagonal(w.M, w.m, k));
        off = pk_max(off, root * pk_abs(q[k] - it->q[k] - h / 2 * (v[k] + it->v[k])));
        way = pk_max(way, root * pk_abs(h) * pk_max(pk_abs(v[k]), pk_abs(it->v[k])));
    }
    return off < TURN * way ? PK_DONE : pk_because(it, PK_NO_PROJECTION, told(it), it->t + h / 2);
}

enum pk_status pk_passage_step(struct pk_integrator *it)
{
    struct parts x = parts_of(it);
    const size_t n = it->n;
    const pk_real t = it->own->next_t, end = x.is->t + x.is->h;
    pk_real *q = pk_part(it->own->next, n, PK_Q), *v = pk_part(it->own->next, n, PK_V), off = 0;
    memset(it->own->next, 0, PK_PARTS * n * sizeof *q);
    it->own->flags &= ~(PK_HAVE_A | PK_HAVE_STEP | PK_HAVE_DENSE | PK_HAVE_SERIES);
    if (!(x.is->passing > 0)) {
        it->own->next_t = it->t; /* no step's end: its error is not judged as one */
        choose(&x);
        const enum pk_status status = solve(it, &x, &off);
        it->own->next_t = t;
        if (status < 0 || !(off < SURE))
            return pk_because(it, PK_NO_PROJECTION, told(it), x.is->at);
    }
    along(&x, n, (t - x.is->t) / x.is->h, q, v);
    x.is->passing = pk_abs(end - t) > PK_C(1e-9) * pk_abs(x.is->h);
    if (!(x.is->passing > 0)) {
        it->own->next_t = it->t;
        const enum pk_status status = put(it, &x, t, q, v, &off);
        it->own->next_t = t;
        if (status < 0 || !(off < SURE))
            return pk_because(it, PK_NO_PROJECTION, told(it), x.is->at);
        PK_TRY(pk_project_redundant(it, t, q, v, PK_NO_PROJECTION));
    }
    it->own->crossed = 1;
    if (it->p)
        pk_eval_canonical(it, t, q, v, pk_part(it->own->next, n, PK_P), it->own->project + n);
    return PK_DONE;
}

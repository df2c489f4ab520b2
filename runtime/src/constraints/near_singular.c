/* Monitors sigma, a measure of the distance of a motion from a position where constraint rows are
 * linearly dependent; there sigma is 0 (see singular_crossing.c). A step needs the factors of J
 * M^-1 J^T anyway, and sigma comes from these factors; its slope in time only where it is small. */
#include <string.h>

#include <pk/constraint.h>

#include "../core/tableau.h"
#include "singular_crossing.h"

#define AHEAD PK_C(2.0) /* an adaptive method crosses roots of sigma less than AHEAD steps ahead */
#define EARLY PK_C(0.1) /* an adaptive method also crosses at any sigma below this */
#define LESS PK_C(0.6)  /* after a failed crossing, sigma must first fall to this fraction */
#define LONG PK_C(1.25) /* fixed steps cross roots of sigma less than LONG steps ahead */
#define MIDDLE PK_C(0.75) /* two fixed steps cross a root over MIDDLE steps ahead, else one does */
#define LITTLE PK_C(1e-4) /* time step for the slope of sigma, relative to the time to its root */
/* The change of q in a step may differ from h times the mean rate by this fraction of the change. A
 * larger difference means that the step has turned into another branch of the motion. */
#define TURN PK_C(0.3)

static size_t lay_out(struct pk_singular_crossing_parts *x, size_t n_q, size_t n, pk_real *base)
{
    pk_real *is = NULL;
    /* clang-format off */
    const struct pk_slot slots[] = {
        {&is, PK_REALS_OF(struct pk_singular_crossing)}, {&x->q, n_q}, {&x->v, n},
        {&x->Q, PK_SINGULAR_CROSSING_STAGES * n_q}, {&x->V, PK_SINGULAR_CROSSING_STAGES * n},
        {&x->A, PK_SINGULAR_CROSSING_STAGES * n}, {&x->q_here, n_q}, {&x->v_here, n},
        {&x->a_here, n}};
    /* clang-format on */
    const size_t size = PK_LAY_OUT(base, slots);
    x->is = (struct pk_singular_crossing *)(void *)is;
    return size;
}

size_t pk_singular_crossing_size(const struct pk_system *system, size_t n_q, size_t n)
{
    struct pk_singular_crossing_parts x;
    return system->constraints.n ? lay_out(&x, n_q, n, NULL) : 0;
}

struct pk_singular_crossing_parts pk_singular_crossing_parts(const struct pk_integrator *it)
{
    struct pk_singular_crossing_parts x;
    lay_out(&x, it->n_q, it->n, it->own->crossing);
    if (pk_index(x.is->stages, PK_SINGULAR_CROSSING_STAGES + 1))
        pk_gauss_nodes((int)pk_index(x.is->stages, PK_SINGULAR_CROSSING_STAGES + 1), x.c, x.b);
    return x;
}

void pk_singular_crossing_unseen(struct pk_integrator *it, struct pk_projection *w,
                                 const pk_real *q, const pk_real *v)
{
    struct pk_singular_crossing *is = pk_singular_crossing_of(it);
    is->unseen = !(is->unseen > 0);
    if (is->unseen > 0 && !it->own->passing.near)
        return;
    if (pk_project_factor(w, w->c, q, v))
        it->own->passing.seen = PK_SEEN_LOW | PK_SEEN_DIPS;
    else
        pk_project_seen(it, w);
}

pk_real pk_singular_crossing_sigma(struct pk_integrator *it, pk_real t, const pk_real *q,
                                   const pk_real *v)
{
    struct pk_singular_crossing *is = pk_singular_crossing_of(it);
    struct pk_projection w = pk_projection(it);
    pk_real found = 1;
    w.t = t;
    w.u = pk_eval_input(it, t);
    if (pk_project_inertia(&w, q, v))
        return 1;
    pk_project_rows(&w, q, v);
    const size_t depends = pk_project_factor(&w, w.c, q, v);
    if (depends) {
        is->row = (pk_real)(depends - 1);
        return 0;
    }
    pk_project_rank(&w);
    for (size_t i = 0; i < w.c; i++)
        if (w.sines[i] <= found)
            found = w.sines[i], is->row = (pk_real)i;
    return PK_F(sqrt)(pk_max(found, 0));
}

int pk_constraint_singular(struct pk_integrator *it, pk_real t, const pk_real *q, const pk_real *v)
{
    if (!it->own || !it->own->crossing || !(it->own->passing.near || it->own->passing.crossed))
        return 0;
    struct pk_singular_crossing *is = pk_singular_crossing_of(it);
    const pk_real row = is->row, sigma = pk_singular_crossing_sigma(it, t, q, v);
    is->row = row;
    return sigma < PK_SINGULAR;
}

/* Predicts the time of the root of sigma from the slope of sigma; `left` is a rough estimate of the
 * time that remains until the root. */
static enum pk_status aim(struct pk_integrator *it, const struct pk_singular_crossing_parts *x,
                          pk_real left)
{
    struct pk_singular_crossing *is = x->is;
    const pk_real little = LITTLE * left;
    PK_TRY(pk_eval_acceleration(it, it->t, it->q, it->v, x->a_here));
    for (size_t i = 0; i < it->n_q; i++)
        x->q_here[i] = it->q[i] + little * it->v[i];
    for (size_t i = 0; i < it->n; i++)
        x->v_here[i] = it->v[i] + little * x->a_here[i];
    const pk_real then = pk_singular_crossing_sigma(it, it->t + little, x->q_here, x->v_here);
    is->falls = then < is->sigma;
    is->at = it->t + is->sigma * little / (is->sigma - then);
    return PK_DONE;
}

static void look(struct pk_integrator *it)
{
    const struct pk_singular_crossing_parts x = pk_singular_crossing_parts(it);
    struct pk_singular_crossing *is = x.is;
    const int fixed = pk_is_fixed(it->method);
    const pk_real near = fixed ? 2 * PK_NEAR : PK_NEAR, was = is->sigma;
    is->falls = 0;
    is->sigma = pk_singular_crossing_sigma(it, it->t, it->q, it->v);
    const pk_real way = it->t - it->last_t;
    if (is->sigma < near && is->sigma < was && (way > 0 || way < 0))
        if (aim(it, &x, way) < 0)
            is->falls = 0;
}

void pk_singular_crossing_forget(struct pk_integrator *it)
{
    if (!it->own->crossing)
        return;
    struct pk_singular_crossing *is = pk_singular_crossing_of(it);
    memset(is, 0, sizeof *is);
    is->sigma = 1;
    it->own->passing.crossed = it->own->passing.seen = it->own->passing.near = 0;
    if (it->status >= 0)
        look(it);
    it->own->passing.near = is->sigma < PK_FAR;
}

void pk_singular_crossing_note(struct pk_integrator *it)
{
    struct pk_singular_crossing *is = pk_singular_crossing_of(it);
    const int seen = it->own->passing.seen;
    if (is->passing > 0)
        return;
    if (seen & PK_SEEN_LOW) {
        look(it);
    } else if (seen) {
        is->falls = 0;
        is->sigma = seen & PK_SEEN_DIPS ? 2 * PK_NEAR : 1;
    }
    it->own->passing.near = is->sigma < PK_FAR;
}

int pk_singular_crossing_due(struct pk_integrator *it, pk_real limit)
{
    struct pk_singular_crossing *is = pk_singular_crossing_of(it);
    const int fixed = pk_is_fixed(it->method);
    if (!(is->passing > 0)) {
        const pk_real left = is->at - it->t, h = fixed ? it->own->h : it->t - it->last_t;
        const int early = !fixed && is->sigma < EARLY;
        if (!(is->falls > 0) || !(left / h > 0) || !(early || left / h < (fixed ? LONG : AHEAD)))
            return 0;
        if (is->tried > 0 && is->sigma > LESS * is->tried)
            return 0;
        is->t = it->t;
        is->h = !fixed ? 2 * left : left / h > MIDDLE ? 2 * h : h;
    }
    const pk_real end = is->t + is->h;
    if (!fixed)
        it->own->next_t = pk_abs(end - it->t) < pk_abs(limit - it->t) ? end : limit;
    return 1;
}

pk_real pk_singular_crossing_limit(const struct pk_integrator *it, pk_real limit)
{
    const struct pk_singular_crossing *is = pk_singular_crossing_of(it);
    if (!(is->falls > 0) || pk_is_fixed(it->method))
        return limit;
    const pk_real half = (is->at - it->t) / 2;
    return half / (limit - it->t) > 0 && half / (limit - it->t) < 1 ? it->t + half : limit;
}

enum pk_status pk_singular_crossing_fail(struct pk_integrator *it, pk_real t)
{
    const size_t rows = pk_system_rows(it->problem.system, it->problem.params, 0);
    const size_t row = pk_index(pk_singular_crossing_parts(it).is->row, rows + 1);
    return pk_fail_with(
        it, PK_NO_PROJECTION,
        PK_WHY(.kind = row < rows ? PK_REASON_BRANCH : PK_REASON_NO_ROW, .index = row, .time = t));
}

enum pk_status pk_singular_crossing_judge(struct pk_integrator *it)
{
    const struct pk_singular_crossing *is = pk_singular_crossing_of(it);
    if (it->method->traits & PK_ADAPTIVE ||
        !(is->sigma < PK_FAR || it->own->passing.seen & PK_SEEN_DIPS))
        return PK_DONE;
    const struct pk_projection w = pk_projection(it);
    const pk_real *q = it->own->next, *v = pk_next(it, PK_V);
    const pk_real h = it->own->next_t - it->t;
    pk_real off = 0, way = pk_max(PK_TINY, pk_project_rest(it, &w, q) * pk_abs(h));
    for (size_t k = 0; k < w.rotation; k++) {
        const pk_real root = PK_F(sqrt)(pk_project_mass(&w, k));
        off = pk_max(off, root * pk_abs(q[k] - it->q[k] - h / 2 * (v[k] + it->v[k])));
        way = pk_max(way, root * pk_abs(h) * pk_max(pk_abs(v[k]), pk_abs(it->v[k])));
    }
    return off < TURN * way ? PK_DONE : pk_singular_crossing_fail(it, it->t + h / 2);
}

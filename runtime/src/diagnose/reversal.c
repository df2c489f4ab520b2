/* Integration forward and back; see pk/reversal.h. Each trial begins at the initial state and uses
 * one integrator both ways, which keeps the low parts of compensated sums when it turns round. */
#include <string.h>

#include <pk/reversal.h>

#include "../core/internal.h"

enum { OCTAVES = 12, NARROWINGS = 4 };

struct trial {
    struct pk_integrator *it;
    const struct pk_problem *problem;
    const struct pk_method *method;
    const struct pk_options *options;
    pk_real t0;
    const pk_real *q0, *v0;
    pk_real *reach; /* for each q_i, v_i: largest distance from its start */
    void *block;
    size_t size;
};

size_t pk_reversal_size(const struct pk_problem *problem, const struct pk_method *method)
{
    const size_t size = pk_integrator_size(problem, method);
    if (!size)
        return 0;
    return size + 2 * pk_system_count(problem->system, problem->params) * sizeof(pk_real);
}

static pk_real off(const struct trial *w, size_t i)
{
    const size_t n = w->it->n;
    if (i < n && i >= pk_system_coordinates(w->problem->system, w->problem->params))
        return 0; /* first-order variables are in v only */
    return pk_abs(i < n ? w->it->q[i] - w->q0[i] : w->it->v[i - n] - w->v0[i - n]);
}

static enum pk_status begin(struct trial *w)
{
    pk_integrator_free(w->it);
    return pk_integrator_init(w->it, w->problem, w->method, w->options, w->t0, w->q0, w->v0,
                              w->block, w->size);
}

/* Measures the scales of errors: the largest distances from the start during the motion. */
static enum pk_status measure(struct trial *w, pk_real t)
{
    PK_TRY(begin(w));
    while (w->it->t < w->t0 + t) {
        PK_TRY(pk_integrator_step(w->it, w->t0 + t));
        for (size_t i = 0; i < 2 * w->it->n; i++)
            w->reach[i] = pk_max(w->reach[i], off(w, i));
    }
    return PK_DONE;
}

static enum pk_status there_and_back(struct trial *w, struct pk_reversal *reversal, pk_real t)
{
    PK_TRY(begin(w));
    PK_TRY(pk_integrator_to(w->it, w->t0 + t));
    PK_TRY(pk_integrator_to(w->it, w->t0));
    const size_t at = reversal->count++;
    reversal->at[at].t = t;
    reversal->at[at].error = reversal->at[at].absolute = 0;
    for (size_t i = 0; i < 2 * w->it->n; i++) {
        const pk_real miss = off(w, i);
        reversal->at[at].absolute = pk_max(reversal->at[at].absolute, miss);
        if (miss > 0) /* an error in a component that never moves counts as 1 */
            reversal->at[at].error =
                pk_max(reversal->at[at].error, w->reach[i] > 0 ? miss / w->reach[i] : 1);
    }
    if (reversal->at[at].error > reversal->threshold) {
        reversal->passed = 1;
        reversal->horizon_hi = t;
    } else {
        reversal->horizon_lo = t;
    }
    return PK_DONE;
}

/* Rounds t to a whole number of steps, at least one. */
static pk_real rounded(const struct trial *w, pk_real t)
{
    const pk_real h = w->options->h;
    if (w->method->traits & PK_ADAPTIVE || !(h > 0))
        return t;
    return h * pk_max(1, PK_F(floor)(t / h + PK_C(0.5)));
}

enum pk_status pk_reversal_find(struct pk_reversal *reversal, struct pk_integrator *it,
                                const struct pk_problem *problem, const struct pk_method *method,
                                const struct pk_options *options, pk_real t0, const pk_real *q0,
                                const pk_real *v0, pk_real t_end, pk_real threshold, void *block,
                                size_t block_size)
{
    if (it)
        memset(it, 0, sizeof *it); /* pk_integrator_free() may follow any failure */
    const size_t size = pk_reversal_size(problem, method);
    if (!reversal || !it || !size || !options || !q0 || !v0 || !(t_end > t0) || !(threshold > 0))
        return PK_BAD_ARGUMENT;
    memset(reversal, 0, sizeof *reversal);
    reversal->threshold = threshold;
    if (!block || block_size < size || (size_t)block % _Alignof(pk_real))
        return PK_BLOCK_TOO_SMALL;
    struct trial w = {.it = it,
                      .problem = problem,
                      .method = method,
                      .options = options,
                      .t0 = t0,
                      .q0 = q0,
                      .v0 = v0,
                      .reach = (pk_real *)block};
    w.block = w.reach + 2 * pk_system_count(problem->system, problem->params);
    w.size = size - (size_t)((char *)w.block - (char *)block);

    memset(w.reach, 0, (size_t)((char *)w.block - (char *)block));
    enum pk_status status = measure(&w, rounded(&w, t_end - t0));
    pk_real last = 0;
    for (int k = OCTAVES; k >= 0 && status >= 0 && !reversal->passed; k--) {
        const pk_real t = rounded(&w, PK_F(ldexp)(t_end - t0, -k));
        if (t > last)
            status = there_and_back(&w, reversal, t);
        last = t;
    }
    for (int k = 0; k < NARROWINGS && status >= 0 && reversal->passed; k++) {
        const pk_real t = rounded(&w, (reversal->horizon_lo + reversal->horizon_hi) / 2);
        if (t > reversal->horizon_lo && t < reversal->horizon_hi)
            status = there_and_back(&w, reversal, t);
    }
    return status;
}

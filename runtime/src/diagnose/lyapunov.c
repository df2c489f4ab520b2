/* The largest Lyapunov exponent; see pk/lyapunov.h. Estimates over equal intervals of time come
 * from marks: at most 64 stored values of G, the logarithm of the growth of a displacement. The
 * marks are thinned out as time goes on. */
#include <string.h>

#include <pk/lyapunov.h>

#include "metric.h"

/* A displacement is normalised before its length leaves 1/LARGE .. LARGE, even within a block, the
 * interval between regular normalisations. */
#define LARGE PK_C(1e12)

size_t pk_lyapunov_size(const struct pk_problem *problem, const struct pk_method *method)
{
    if (!problem || !method || !pk_variation_size(problem, 1))
        return 0;
    const size_t n = pk_system_count(problem->system, problem->params);
    return pk_variation_size(problem, 1) + pk_variation_integrator_size(problem, 1, method) +
           (pk_metric_reals(n) + 4 * n + problem->system->n_inputs) * sizeof(pk_real);
}

static struct pk_metric metric_of(const struct pk_lyapunov *l)
{
    return (struct pk_metric){
        .n = l->metric_n, .seen = l->variation.n_q, .tau = l->metric_tau, .L = l->metric_L};
}

static pk_real length(const struct pk_lyapunov *l, const pk_real *Q, const pk_real *V)
{
    const struct pk_metric metric = metric_of(l);
    pk_variation_take(&l->variation, V, 1, l->variation.v);
    return pk_metric_length(&metric, Q + l->variation.n_q, l->variation.v);
}

/* Copies the state and the displacement in q and v, which may be the scratch memory itself, to the
 * scratch memory, and normalises the displacement there. Returns the logarithm of its former
 * length, which may not be finite. */
static pk_real normalise(struct pk_lyapunov *l, const pk_real *q, const pk_real *v)
{
    const struct pk_variation *of = &l->variation;
    pk_real *Q = l->scratch, *V = Q + 2 * of->n_q;
    memmove(Q, q, 2 * of->n_q * sizeof *Q);
    memmove(V, v, 2 * of->n * sizeof *V);
    const pk_real size = length(l, Q, V);
    for (size_t i = of->n_q; i < 2 * of->n_q; i++)
        Q[i] /= size;
    for (size_t i = 0; i < of->n; i++)
        V[pk_variation_place(of, 1, i)] /= size;
    return PK_F(log)(size);
}

enum pk_status pk_lyapunov_init(struct pk_lyapunov *l, const struct pk_problem *problem,
                                const struct pk_method *method, const struct pk_options *options,
                                pk_real t0, const pk_real *q0, const pk_real *v0, pk_real block,
                                void *memory, size_t size)
{
    if (l)
        memset(l, 0, sizeof *l); /* allows pk_lyapunov_free() after any failure */
    const size_t least = pk_lyapunov_size(problem, method);
    if (!l || !least || !options || !q0 || !v0 || !(block > 0) || !pk_finite(block))
        return PK_BAD_ARGUMENT;
    if (!memory || size < least || (size_t)memory % _Alignof(pk_real))
        return PK_BLOCK_TOO_SMALL;
    const size_t n = pk_system_count(problem->system, problem->params);
    pk_real *x = (pk_real *)memory;
    const size_t variation_size = pk_variation_size(problem, 1);
    PK_TRY(pk_variation_init(&l->variation, problem, 1, x, variation_size));
    x += variation_size / sizeof *x;

    struct pk_metric metric;
    l->metric_L = x, x += pk_metric_reals(n);
    l->scratch = x, x += 4 * n;
    pk_real *u = x;
    x += problem->system->n_inputs;
    pk_input(problem, t0, u);
    PK_TRY(pk_metric_init(&metric, &l->variation, t0, q0, v0, u, block, l->metric_L));
    l->metric_n = n;
    l->metric_tau = metric.tau;

    l->t0 = t0;
    l->block = block;
    l->stride = 1;
    if (!(method->traits & PK_ADAPTIVE) && options->h > 0)
        l->block = options->h * pk_max(1, PK_F(ceil)(block / options->h - PK_C(1e-6)));
    /* A direction without any symmetry: fractional parts of multiples of the golden section. */
    const size_t n_q = l->variation.n_q;
    pk_real *Q = l->scratch, *V = Q + 2 * n_q, part = 0;
    pk_real *dq = l->variation.a, *dv = l->variation.b;
    for (size_t i = 0; i < 2 * n; i++) {
        part += PK_C(0.61803398874989484820458683436563812);
        part -= part >= 1 ? 1 : 0;
        (i < n ? dq : dv)[i % n] = part + PK_C(0.1);
    }
    pk_metric_dq(&metric, dq); /* makes the components of similar length, whatever their units */
    pk_metric_dq(&metric, dv);
    for (size_t i = 0; i < n; i++) {
        dq[i] *= PK_F(sqrt)(metric.tau);
        dv[i] /= PK_F(sqrt)(metric.tau);
    }
    memcpy(Q, q0, n_q * sizeof *Q);
    memcpy(Q + n_q, dq, n_q * sizeof *Q);
    pk_variation_put(&l->variation, v0, 0, V);
    pk_variation_put(&l->variation, dv, 1, V);
    normalise(l, Q, V);
    return pk_integrator_init(&l->it, &l->variation.problem, method, options, t0, Q, V, x,
                              pk_variation_integrator_size(problem, 1, method));
}

static int large(const struct pk_lyapunov *l)
{
    const pk_real size = length(l, l->it.q, l->it.v);
    return !(size < LARGE) || !(size > 1 / LARGE);
}

/* Normalises the displacement and adds the logarithm of its length to G. */
static enum pk_status renew(struct pk_lyapunov *l)
{
    const pk_real grown = normalise(l, l->it.q, l->it.v);
    if (!pk_finite(grown))
        return l->it.status = PK_NOT_FINITE;
    l->growth += grown;
    return pk_integrator_reset(&l->it, l->it.t, l->scratch, l->scratch + 2 * l->variation.n_q);
}

static void mark(struct pk_lyapunov *l)
{
    if (l->n_marks == PK_LYAPUNOV_MARKS) { /* every second mark fits the new stride */
        for (unsigned long k = 0; k < PK_LYAPUNOV_MARKS / 2; k++)
            l->marks[k] = l->marks[2 * k + 1];
        l->n_marks /= 2;
        l->stride *= 2;
    }
    if (l->blocks % l->stride == 0)
        l->marks[l->n_marks++] = l->growth;
}

enum pk_status pk_lyapunov_step(struct pk_lyapunov *l)
{
    const pk_real before = l->growth, Y = l->Y;
    const pk_real end = l->t0 + (pk_real)(l->blocks + 1) * l->block;
    if (!pk_ready(&l->it))
        return l->it.status < 0 ? l->it.status : PK_BAD_ARGUMENT;
    while (l->it.t < end) {
        PK_TRY(pk_integrator_step(&l->it, end));
        if (l->it.t < end && large(l))
            PK_TRY(renew(l));
    }
    PK_TRY(renew(l));
    l->blocks++;
    const pk_real T = (pk_real)l->blocks * l->block;
    l->sum_G += l->block * (before + l->growth) / 2;
    l->Y = 2 * (l->growth - l->sum_G / T);
    l->sum_Y += l->block * (Y + l->Y) / 2;
    mark(l);
    return PK_DONE;
}

pk_real pk_lyapunov_exponent(const struct pk_lyapunov *l, pk_real *error)
{
    const unsigned long n = l->n_marks, first = (n + 9) / 10;
    const pk_real interval = l->block * (pk_real)l->stride;
    pk_real mean = 0, var = 0;
    if (n < 16) {
        if (error)
            *error = PK_INFINITY;
        return 0;
    }
    const pk_real count = (pk_real)(n - first);
    for (unsigned long k = first; k < n; k++)
        mean += (l->marks[k] - l->marks[k - 1]) / interval / count;
    for (unsigned long k = first; k < n; k++) {
        const pk_real d = (l->marks[k] - l->marks[k - 1]) / interval - mean;
        var += d * d / (count - 1);
    }
    if (error)
        *error = PK_F(sqrt)(var / count);
    return mean;
}

pk_real pk_lyapunov_megno(const struct pk_lyapunov *l)
{
    return l->blocks ? l->sum_Y / ((pk_real)l->blocks * l->block) : 0;
}

enum pk_motion pk_lyapunov_motion(const struct pk_lyapunov *l)
{
    const pk_real megno = pk_lyapunov_megno(l);
    if (l->n_marks < 16)
        return PK_UNDECIDED;
    return megno <= 3 ? PK_REGULAR : megno >= 6 ? PK_CHAOTIC : PK_UNDECIDED;
}

void pk_lyapunov_free(struct pk_lyapunov *l) { pk_integrator_free(&l->it); }

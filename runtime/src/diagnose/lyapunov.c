/* The largest Lyapunov exponent; see pk/lyapunov.h. Rates over equal intervals come from marks of
 * G, at most 64 of them, thinned as time goes on: nothing else is stored.
 */
#include <string.h>

#include <pk/lyapunov.h>

#include "metric.h"

/* A displacement is made of unit length before it leaves these, however long a block. */
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
    const size_t states = l->variation.of.system->n_first_order;
    return (struct pk_metric){
        .n = l->metric_n, .seen = l->metric_n - states, .tau = l->metric_tau, .L = l->metric_L};
}

/* The displacement in (q, v) made of unit length, from it->q and it->v or from the scratch itself;
 * its logarithm, or what is not finite. */
static pk_real normalise(struct pk_lyapunov *l, const pk_real *q, const pk_real *v)
{
    const size_t n = l->variation.n;
    const struct pk_metric metric = metric_of(l);
    pk_real *Q = l->scratch, *V = Q + 2 * n;
    memmove(Q, q, 2 * n * sizeof *Q);
    memmove(V, v, 2 * n * sizeof *V);
    const pk_real length = pk_metric_length(&metric, Q + n, V + n);
    for (size_t i = n; i < 2 * n; i++) {
        Q[i] /= length;
        V[i] /= length;
    }
    for (size_t i = n + metric.seen; i < 2 * n; i++)
        Q[i] = 0; /* of an integral of a state, on which nothing depends */
    return PK_F(log)(length);
}

enum pk_status pk_lyapunov_init(struct pk_lyapunov *l, const struct pk_problem *problem,
                                const struct pk_method *method, const struct pk_options *options,
                                pk_real t0, const pk_real *q0, const pk_real *v0, pk_real block,
                                void *memory, size_t size)
{
    if (l)
        memset(l, 0, sizeof *l); /* pk_lyapunov_free() may follow whatever is refused */
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
    /* A direction that no symmetry has: multiples of the golden section, less whole numbers. */
    pk_real *Q = l->scratch, *V = Q + 2 * n, part = 0;
    memcpy(Q, q0, n * sizeof *Q);
    memcpy(V, v0, n * sizeof *V);
    for (size_t i = 0; i < 2 * n; i++) {
        part += PK_C(0.61803398874989484820458683436563812);
        part -= part >= 1 ? 1 : 0;
        (i < n ? Q + n : V)[i] = part + PK_C(0.1);
    }
    pk_metric_dq(&metric, Q + n); /* of like lengths, whatever the units */
    pk_metric_dq(&metric, V + n);
    for (size_t i = n; i < 2 * n; i++) {
        Q[i] *= PK_F(sqrt)(metric.tau);
        V[i] /= PK_F(sqrt)(metric.tau);
    }
    normalise(l, Q, V);
    return pk_integrator_init(&l->it, &l->variation.problem, method, options, t0, Q, V, x,
                              pk_variation_integrator_size(problem, 1, method));
}

static int large(const struct pk_lyapunov *l)
{
    const size_t n = l->variation.n;
    const struct pk_metric metric = metric_of(l);
    const pk_real length = pk_metric_length(&metric, l->it.q + n, l->it.v + n);
    return !(length < LARGE) || !(length > 1 / LARGE);
}

/* Back to unit length. */
static enum pk_status renew(struct pk_lyapunov *l)
{
    const pk_real grown = normalise(l, l->it.q, l->it.v);
    if (!pk_finite(grown))
        return l->it.status = PK_NOT_FINITE;
    l->growth += grown;
    return pk_integrator_reset(&l->it, l->it.t, l->scratch, l->scratch + 2 * l->variation.n);
}

static void mark(struct pk_lyapunov *l)
{
    if (l->n_marks == PK_LYAPUNOV_MARKS) { /* marks 1, 3, 5, ... are at whole new strides */
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

/* Fixed-step methods for white noise, M a = f + B dW/dt, in accelerations: q' = v and
 *
 *     v' = a(t, q, v) + sum_k sqrt(S_k) G_k dW_k/dt,
 *
 * where S and G depend on q and t alone. The methods are of weak order 2 and strong order 1. The
 * noise in the middle of a step is that at the place to which the rates carry q. For friction
 * a = g(q, t) + B v with constant B:
 *
 *     stochastic_verlet  (1 - h B/2) d = h v + h^2/2 g + h/2 b,  q += d,
 *                        v += h/2 (g + g1) + B d + b
 *     baoab              half a kick, half a drift, the exact flow of dv = B v dt + sqrt(S) G dW,
 *                        half a drift, half a kick
 *
 * References: N. Gronbech-Jensen, O. Farago, Mol. Phys. 111 (2013) 983; B. Leimkuhler,
 * C. Matthews, Appl. Math. Res. Express 2013, 34; P. E. Kloeden, E. Platen, Numerical Solution of
 * Stochastic Differential Equations, Springer 1992, 15.1. */

#include <pk/noise.h>

#include "../core/generic.h"
#include "../core/tableau.h"

/* S, G: the noise; z: normal numbers; b: increment of v by noise; B: friction; E: factors of
 * 1 - h B/2, or exp(h B); C: covariance of b and then its Cholesky factor; Q: rate of C for which
 * these were computed; h: the step for which they were. */
struct work {
    size_t n, noises;
    pk_real *S, *G, *z, *b, *k, *B, *E, *C, *Q, *pivot, *room, *h;
};

/* The matrices are those of methods for linear friction. */
static size_t lay_out(struct work *w, const struct pk_method *method, const struct pk_system *of,
                      size_t n_q, size_t n, pk_real *base)
{
    const size_t m = w->noises = of->noise.n, nn = method->init ? n * n : 0, y = n_q + n;
    const struct pk_slot slots[] = {{&w->S, m},     {&w->G, m * n},     {&w->z, m > n ? m : n},
                                    {&w->b, 2 * n}, {&w->k, 2 * y + n}, {&w->B, nn},
                                    {&w->E, nn},    {&w->C, nn},        {&w->Q, nn},
                                    {&w->pivot, n}, {&w->h, 1},         {&w->room, 3 * nn}};
    w->n = n;
    return PK_LAY_OUT(base, slots);
}

static size_t noise_size(const struct pk_method *method, const struct pk_problem *problem, size_t n)
{
    struct work w;
    return lay_out(&w, method, problem->system, pk_coordinates_of(problem), n, NULL);
}

static struct work work_of(const struct pk_integrator *it)
{
    struct work w;
    lay_out(&w, it->method, it->problem.system, it->n_q, it->n, it->own->work);
    return w;
}

static void normal(const struct pk_integrator *it, size_t count, pk_real *z)
{
    pk_normal(it->options.seed, it->options.member, it->count.steps, count, z);
}

/* Computes S and G at (t, q). */
static enum pk_status noise_at(struct pk_integrator *it, const struct work *w, pk_real t,
                               const pk_real *q, const pk_real *v)
{
    if (!w->noises)
        return PK_DONE;
    const pk_real *u = pk_eval_feedback(it, t, q, v);
    it->problem.system->noise.values(it->problem.params, t, q, v, u, w->S, w->G);
    for (size_t k = 0; k < w->noises; k++)
        if (!(w->S[k] >= 0))
            return pk_fail_with(
                it, PK_NOT_FINITE,
                PK_WHY(.kind = PK_OF_NOISE, .index = k, .value = w->S[k], .time = t));
    return PK_DONE;
}

/* Writes the increment b of v by the noise at (t, q) over a step of length h. */
static enum pk_status increment(struct pk_integrator *it, const struct work *w, pk_real t,
                                const pk_real *q, const pk_real *v, pk_real *b)
{
    PK_TRY(noise_at(it, w, t, q, v));
    pk_zero(b, w->n);
    for (size_t k = 0; k < w->noises; k++)
        pk_add(b, PK_F(sqrt)(w->S[k] * pk_abs(it->own->h)) * w->z[k], w->G + k * w->n, w->n);
    return PK_DONE;
}

static enum pk_status heun_step(struct pk_integrator *it, pk_real limit)
{
    const size_t n_q = it->n_q, n = it->n, m = n_q + n;
    const struct work w = work_of(it);
    const pk_real h = it->own->h, *y0 = it->own->state;
    const pk_real *low0 = pk_part(it->own->state, n_q, n, PK_LOW_Q);
    pk_real *y = it->own->next, *low = pk_part(y, n_q, n, PK_LOW_Q), *k0 = w.k, *k1 = w.k + m;
    (void)limit;
    normal(it, w.noises, w.z);
    PK_TRY(generic_slope(it, it->t, y0, k0));
    PK_TRY(increment(it, &w, it->t, y0, y0 + n_q, w.b));
    for (size_t i = 0; i < m; i++)
        y[i] = y0[i] + h * k0[i] + (i < n_q ? 0 : w.b[i - n_q]);
    PK_TRY(generic_slope(it, it->own->next_t, y, k1));
    PK_TRY(increment(it, &w, it->own->next_t, y, y + n_q, w.b + n));
    for (size_t i = 0; i < m; i++) {
        const pk_real b = i < n_q ? 0 : w.b[i - n_q] + w.b[i - n_q + n];
        low[i] = low0[i];
        y[i] = pk_sum(y0[i], (h * (k0[i] + k1[i]) + b) / 2, &low[i]);
    }
    return PK_DONE;
}

static enum pk_status langevin_init(struct pk_integrator *it)
{
    const struct work w = work_of(it);
    *w.h = 0;
    pk_zero(w.pivot, w.n);
    return pk_drag_matrix(it, w.pivot, w.b, w.b + w.n, w.B);
}

/* Writes the acceleration g without friction. */
static enum pk_status at_rest(struct pk_integrator *it, const struct work *w, pk_real t,
                              const pk_real *q, pk_real *g)
{
    pk_zero(w->k, w->n);
    return pk_eval_acceleration(it, t, q, w->k, g);
}

/* Returns g at the start of the step: that of the last step, or a new one. */
static enum pk_status at_start(struct pk_integrator *it, const struct work *w, const pk_real **g)
{
    pk_real *own = w->k + 2 * w->n;
    *g = it->own->flags & PK_HAVE_A ? pk_state(it, PK_A) : own;
    return *g == own ? at_rest(it, w, it->t, it->q, own) : PK_DONE;
}

static enum pk_status stochastic_verlet_step(struct pk_integrator *it, pk_real limit)
{
    const size_t n_q = it->n_q, n = it->n;
    const struct work w = work_of(it);
    const pk_real h = it->own->h, *q = it->q, *v = it->v, *g;
    pk_real *to = it->own->next, *low = pk_next(it, PK_LOW_Q), *g1 = pk_next(it, PK_A),
            *d = w.k + n;
    (void)limit;
    PK_TRY(at_start(it, &w, &g));
    normal(it, w.noises, w.z);
    for (size_t i = 0; i < n_q; i++)
        to[i] = q[i] + h / 2 * v[i];
    PK_TRY(increment(it, &w, it->t + h / 2, to, v, w.b));
    if (*w.h < h || *w.h > h) {
        for (size_t i = 0; i < n * n; i++)
            w.E[i] = (pk_real)(i % (n + 1) == 0) - h / 2 * w.B[i];
        *w.h = pk_lu_factor(w.E, w.pivot, n) ? h : 0;
        it->count.factorisations++;
    }
    for (size_t i = 0; i < n; i++)
        d[i] = h * v[i] + h * h / 2 * g[i] + h / 2 * w.b[i];
    pk_lu_solve(w.E, w.pivot, n, d);
    pk_copy(low, pk_state(it, PK_LOW_Q), n_q + n);
    for (size_t i = 0; i < n_q; i++)
        to[i] = pk_sum(q[i], d[i], &low[i]);
    PK_TRY(at_rest(it, &w, it->own->next_t, to, g1));
    pk_add_product(w.b, w.B, d, n);
    for (size_t i = 0; i < n; i++)
        to[n_q + i] = pk_sum(v[i], h / 2 * (g[i] + g1[i]) + w.b[i], &low[n_q + i]);
    it->own->flags |= PK_HAVE_A;
    return PK_DONE;
}

/* Computes to = A x, or A x A^T, of n by n matrices; `room` has n * n numbers. */
static void multiply(const pk_real *A, const pk_real *x, size_t n, pk_real *to)
{
    pk_zero(to, n * n);
    for (size_t i = 0; i < n; i++)
        for (size_t k = 0; k < n; k++)
            pk_add(to + i * n, A[i * n + k], x + k * n, n);
}
static void sandwich(const pk_real *A, const pk_real *x, size_t n, pk_real *room, pk_real *to)
{
    multiply(A, x, n, room);
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < n; j++)
            to[i * n + j] = pk_dot(room + i * n, A + j * n, n);
}

/* Computes E = exp(h B) and C, the integral of exp(s B) Q exp(s B^T) over s from 0 to |h|, by their
 * series over a short time, which is doubled: C(2s) = C(s) + E(s) C(s) E(s)^T. */
static void flow(const struct work *w, pk_real h)
{
    enum { TERMS = 28 };
    const size_t n = w->n, nn = n * n;
    pk_real *term = w->room, *more = term + nn, *other = more + nn, s = h, norm = 0;
    int doublings = 0;
    for (size_t i = 0; i < nn; i++)
        norm = pk_max(norm, (pk_real)n * pk_abs(w->B[i]));
    for (; norm * pk_abs(s) > PK_C(0.25); s /= 2)
        doublings++;
    for (int of_Q = 0; of_Q < 2; of_Q++) {
        pk_real *to = of_Q ? w->C : w->E;
        for (size_t i = 0; i < nn; i++)
            to[i] = term[i] = of_Q ? pk_abs(s) * w->Q[i] : (pk_real)(i % (n + 1) == 0);
        for (int k = 1; k < TERMS; k++) {
            multiply(w->B, term, n, more);
            for (size_t i = 0; i < nn; i++) /* the terms of C are symmetric */
                term[i] = s / (pk_real)(k + of_Q) *
                          (more[i] + (of_Q ? more[i % n * n + i / n] : 0));
            pk_add(to, 1, term, nn);
        }
    }
    for (; doublings; doublings--) {
        sandwich(w->E, w->C, n, term, other);
        pk_add(w->C, 1, other, nn);
        multiply(w->E, w->E, n, term);
        pk_copy(w->E, term, nn);
    }
}

/* Replaces the lower half of C by L with C = L L^T; a column without variance is 0. */
static void cholesky(pk_real *C, size_t n)
{
    const pk_real most = pk_largest(C, n * n);
    for (size_t k = 0; k < n; k++) {
        const pk_real rest = C[k * n + k] - pk_dot(C + k * n, C + k * n, k);
        C[k * n + k] = rest > 8 * (pk_real)n * PK_EPS * most ? PK_F(sqrt)(rest) : 0;
        for (size_t i = k + 1; i < n; i++) {
            pk_real *x = &C[i * n + k];
            *x = C[k * n + k] > 0 ? (*x - pk_dot(C + i * n, C + k * n, k)) / C[k * n + k] : 0;
        }
    }
}

/* Makes the exact flow of friction and noise over the step, at (t, q), of the rates in `to`. */
static enum pk_status rub(struct pk_integrator *it, const struct work *w, pk_real t, pk_real *to)
{
    const size_t n = w->n, nn = n * n;
    const pk_real h = it->own->h;
    pk_real *v = to + it->n_q, *low = pk_next(it, PK_LOW_X), *Q = w->room;
    PK_TRY(noise_at(it, w, t, to, v));
    pk_zero(Q, nn);
    for (size_t k = 0; k < w->noises; k++)
        for (size_t i = 0; i < n; i++)
            pk_add(Q + i * n, w->S[k] * w->G[k * n + i], w->G + k * n, n);
    if (*w->h < h || *w->h > h || memcmp(Q, w->Q, nn * sizeof *Q)) {
        pk_copy(w->Q, Q, nn);
        flow(w, *w->h = h);
        cholesky(w->C, n);
        it->count.factorisations++;
    }
    normal(it, n, w->z);
    for (size_t i = 0; i < n; i++)
        w->b[i] = pk_dot(w->E + i * n, v, n) - v[i] + pk_dot(w->C + i * n, w->z, i + 1);
    for (size_t i = 0; i < n; i++)
        v[i] = pk_sum(v[i], w->b[i], &low[i]);
    return PK_DONE;
}

static enum pk_status baoab_step(struct pk_integrator *it, pk_real limit)
{
    const size_t n_q = it->n_q, n = it->n;
    const struct work w = work_of(it);
    const pk_real h = it->own->h, *g;
    pk_real *to = it->own->next, *g1 = pk_next(it, PK_A);
    (void)limit;
    PK_TRY(at_start(it, &w, &g));
    pk_kick_drift(n_q, n, h / 2, g, h / 2, it->own->state, to);
    PK_TRY(rub(it, &w, it->t + h / 2, to));
    pk_kick_drift(n_q, n, 0, g, h / 2, to, to);
    PK_TRY(at_rest(it, &w, it->own->next_t, to, g1));
    pk_kick(n_q, n, h / 2, g1, to);
    it->own->flags |= PK_HAVE_A;
    return PK_DONE;
}

/* On linear equations heun is as stable as rk2. */
#define HEUN(of) \
    .formula = &pk_method_rk2, .needs = PK_NEEDS_HEUN, .size = noise_size, .step = heun_step
#define LANGEVIN(of) \
    .needs = PK_NEEDS_LANGEVIN, .size = noise_size, .init = langevin_init, .step = of##_step
PK_METHODS_HEUN(PK_DEFINE_METHOD, HEUN)
PK_METHODS_LANGEVIN(PK_DEFINE_METHOD, LANGEVIN)

/* One trial step of the adaptive Gauss method: its equations (see pk/step/gauss.h), evaluated in
 * the lanes of one kernel. Uses the macros of pk/inlined.h. */
#ifndef PK_STEP_GAUSS_STAGES_H
#define PK_STEP_GAUSS_STAGES_H

#include <pk/step/gauss_tables.h>
#include <pk/step/state.h>
#include <pk/step/tableau.h>

/* Compilers unroll a loop over eight lanes before they vectorise, and then vectorise little. */
#if defined __clang__
#define PK_GAUSS_LOOP _Pragma("clang loop unroll(disable) vectorize_width(4) interleave_count(2)")
#elif defined __GNUC__
#define PK_GAUSS_LOOP _Pragma("GCC unroll 1")
#else
#define PK_GAUSS_LOOP
#endif

/* Computes a b + c with one rounding where fma() is fast, which halves the instructions of a
 * matrix-vector product. It is explicit, as contraction may be off (build.py). */
#ifdef PK_HAVE_FMA
#define PK_GAUSS_FMA(a, b, c) PK_F(fma)(a, b, c)
#else
#define PK_GAUSS_FMA(a, b, c) ((a) * (b) + (c))
#endif

#define PK_GAUSS_RATE_LEAST PK_C(0.1)
/* If a step is more than PK_GAUSS_LEAP times as long as the last one, its first iterate is not
 * extrapolated from the last step. The polynomial of the last step is inaccurate so far away, and
 * its round-off grows like the 7th power of the ratio of step sizes. */
#define PK_GAUSS_LEAP PK_C(8.0)
/* Fraction of the tolerance that the method uses, so that its final error is at most that of dop853
 * with the same tolerance. Measured over models and tolerances from 1e-4 to 1e-15, the error is
 * half of dop853's for the worst model and a tenth for most. */
#define PK_GAUSS_SHARE (PK_C(1.0) / PK_C(3.0))

enum { PK_GAUSS_S = PK_LANES, PK_GAUSS_NODES = 2 * PK_LANES };

/* The work memory: arrays of n by 8, unless another shape is given. */
struct pk_gauss_lanes {
    /* a, next_a: the current and the next iterate; q (n_q by 8), v: coordinates and rates at the
     * stages */
    pk_real *a, *next_a, *q, *v;
    pk_real *u; /* inputs at the stages */
    /* coefficients of the polynomial a(t) of the last step, in powers of (t - its end)/h */
    pk_real *poly;
    pk_real *weight; /* weights of errors in a, n numbers */
    /* state at the start of the last step, n_q + n numbers; the n weights of that step */
    pk_real *start, *last_weight;
    /* one number each: size and convergence rate of the last step; largest theta^2 of the next */
    pk_real *h, *rate, *decay;
    struct pk_gauss_matrices *M;
    pk_real *dense; /* work memory of gauss_dense.c */
};

static inline size_t pk_gauss_lanes_size(size_t n_q, size_t n)
{
    return PK_GAUSS_S + sizeof(struct pk_gauss_matrices) / sizeof(pk_real) +
           (n_q + 4 * n) * PK_GAUSS_S + n_q + 3 * n + 3;
}

static inline struct pk_gauss_lanes pk_gauss_lanes(struct pk_integrator *it, size_t n_q, size_t n,
                                                   pk_real *x)
{
    struct pk_gauss_lanes w;
    const size_t m = n * PK_GAUSS_S;
    x += PK_GAUSS_S - (size_t)x / sizeof *x % PK_GAUSS_S; /* aligns vectors with cache lines */
    w.M = (struct pk_gauss_matrices *)(void *)x, x += sizeof *w.M / sizeof *x;
    w.a = x, x += m;
    w.next_a = x, x += m;
    w.q = x, x += n_q * PK_GAUSS_S;
    w.v = x, x += m;
    w.poly = x, x += m;
    w.u = it->own->u + it->problem.system->n_inputs;
    w.weight = x, x += n;
    w.start = x, x += n_q + n;
    w.last_weight = x, x += n;
    w.h = x++, w.rate = x++, w.decay = x++;
    w.dense = x;
    return w;
}

/* Computes y = M x. Each lane has one sum, in two halves whose additions overlap. */
static inline void pk_gauss_rows(const pk_real *PK_RESTRICT M, const pk_real *PK_RESTRICT x,
                                 pk_real *PK_RESTRICT y)
{
    PK_GAUSS_LOOP
    for (int l = 0; l < PK_GAUSS_S; l++) {
        pk_real even = M[l] * x[0], odd = M[8 + l] * x[1];
        even = PK_GAUSS_FMA(M[16 + l], x[2], even);
        odd = PK_GAUSS_FMA(M[24 + l], x[3], odd);
        even = PK_GAUSS_FMA(M[32 + l], x[4], even);
        odd = PK_GAUSS_FMA(M[40 + l], x[5], odd);
        even = PK_GAUSS_FMA(M[48 + l], x[6], even);
        odd = PK_GAUSS_FMA(M[56 + l], x[7], odd);
        y[l] = even + odd;
    }
}

/* Adds the two halves of the terms as vectors first, then the numbers of the resulting vector. */
static inline pk_real pk_gauss_dot(const pk_real *PK_RESTRICT b, const pk_real *PK_RESTRICT x)
{
    pk_real sum[PK_GAUSS_S / 2];
    PK_GAUSS_LOOP
    for (int l = 0; l < PK_GAUSS_S / 2; l++)
        sum[l] = PK_GAUSS_FMA(b[l], x[l], b[l + 4] * x[l + 4]);
    return (sum[0] + sum[2]) + (sum[1] + sum[3]);
}

static inline pk_real pk_gauss_sum(const pk_real *PK_RESTRICT x)
{
    pk_real sum[PK_GAUSS_S / 2];
    PK_GAUSS_LOOP
    for (int l = 0; l < PK_GAUSS_S / 2; l++)
        sum[l] = x[l] + x[l + 4];
    return (sum[0] + sum[2]) + (sum[1] + sum[3]);
}

/* Results of a trial step. Norms are root mean squares relative to the tolerance. */
struct pk_gauss_trial {
    pk_real h, hc[PK_GAUSS_S], t[PK_GAUSS_S];
    pk_real size2, change2;       /* squared norms of a and of the last correction of a */
    pk_real rate;                 /* convergence rate, the ratio of successive corrections */
    pk_real theta_log, error_log; /* log of theta and of the error */
    pk_real growth;               /* factor by which the next step may be longer than this one */
    int count;
};

/* Estimates the error |a| theta^16 from the last two Legendre coefficients: |a_k| = |a| theta^k. */
static inline void pk_gauss_judge(struct pk_gauss_trial *y, pk_real six2, pk_real seven2)
{
    const pk_real six = six2 / (y->size2 + PK_TINY) + PK_TINY;
    const pk_real seven = seven2 / (y->size2 + PK_TINY) + PK_TINY;
    const pk_real six3 = six * six * six, seven3 = seven * seven * seven;
    const pk_real a = PK_F(log)(y->size2 + PK_TINY);
    const pk_real theta = six3 * six3 * six > seven3 * seven3 ? PK_F(log)(six) / 12
                                                              : PK_F(log)(seven) / 14;
    y->theta_log = theta;
    y->error_log = a / 2 + 16 * theta;
    y->growth = PK_SAME(PK_F(exp)(-y->error_log / 17));
}

#endif

/* Sets the first iterate: the last polynomial at 1 + r c_l, or the acceleration at the start. */
static inline enum pk_status PK_STEPPER(gauss_predict)(struct pk_integrator *it,
                                                       const struct pk_gauss_lanes *w,
                                                       struct pk_gauss_trial *y)
{
    const size_t n = PK_STEPPER_N(it);
    if (!(it->own->flags & PK_HAVE_STEP) || pk_abs(y->h) > PK_GAUSS_LEAP * pk_abs(*w->h)) {
        pk_real *a0 = pk_next(it, PK_A);
        const enum pk_status status = PK_STEPPER(acceleration)(it, it->t, it->q, it->v, a0);
        for (size_t i = 0; i < n * PK_GAUSS_S; i++)
            w->a[i] = a0[i / PK_GAUSS_S];
        y->rate = PK_C(0.5);
        return status;
    }
    const pk_real r = y->h / *w->h;
    pk_real power[PK_GAUSS_S] = {1}, x[PK_GAUSS_S];
    for (int k = 1; k < PK_GAUSS_S; k++)
        power[k] = power[k - 1] * r;
    for (size_t i = 0; i < n; i++) {
        for (int k = 0; k < PK_GAUSS_S; k++)
            x[k] = w->poly[i * PK_GAUSS_S + (size_t)k] * power[k];
        pk_gauss_rows(w->M->powers, x, w->a + i * PK_GAUSS_S);
    }
    /* This convergence rate is used until one is measured. The first iterate is never accepted. */
    y->rate = pk_max(pk_min(*w->rate * r * r, PK_C(0.5)), PK_GAUSS_RATE_LEAST);
    return PK_DONE;
}

/* Computes coordinates and rates at the stages from the accelerations. */
static inline void PK_STEPPER(gauss_stages)(struct pk_integrator *it,
                                            const struct pk_gauss_lanes *w,
                                            const struct pk_gauss_trial *y, int with_v)
{
    const size_t n_q = PK_STEPPER_COORDINATES(it), n = PK_STEPPER_N(it);
    const pk_real h = y->h, h2 = h * h;
    for (size_t i = 0; i < n_q; i++) {
        const pk_real q0 = it->q[i], v0 = it->v[i];
        pk_real *PK_RESTRICT q = w->q + i * PK_GAUSS_S;
        pk_real d[PK_GAUSS_S];
        pk_gauss_rows(w->M->A2, w->a + i * PK_GAUSS_S, d);
        PK_GAUSS_LOOP
        for (int l = 0; l < PK_GAUSS_S; l++)
            q[l] = PK_GAUSS_FMA(h2, d[l], PK_GAUSS_FMA(y->hc[l], v0, q0));
    }
    for (size_t i = 0; with_v && i < n; i++) {
        const pk_real v0 = it->v[i];
        pk_real *PK_RESTRICT v = w->v + i * PK_GAUSS_S;
        pk_real d[PK_GAUSS_S];
        pk_gauss_rows(w->M->A, w->a + i * PK_GAUSS_S, d);
        PK_GAUSS_LOOP
        for (int l = 0; l < PK_GAUSS_S; l++)
            v[l] = PK_GAUSS_FMA(h, d[l], v0);
    }
}

/* Computes the weights of errors in a. An error in a changes v and q at the end of the step; its
 * weight is the larger of these changes relative to the tolerances of v and q. */
static inline void PK_STEPPER(gauss_weights)(struct pk_integrator *it,
                                             const struct pk_gauss_lanes *w,
                                             const struct pk_gauss_trial *y)
{
    const size_t n_q = PK_STEPPER_COORDINATES(it), n = PK_STEPPER_N(it);
    const pk_real h = pk_abs(y->h), rtol = PK_GAUSS_SHARE * pk_max(it->options.rtol, 2 * PK_EPS);
    for (size_t i = 0; i < n; i++) {
        const size_t last = i * PK_GAUSS_S + PK_GAUSS_S - 1;
        /* The size of v includes its change in the step, since v may be zero at the start. */
        const pk_real moved = y->h * w->next_a[last], v0 = it->v[i];
        const pk_real v = pk_max(pk_abs(v0), pk_abs(moved));
        w->weight[i] = h / (PK_GAUSS_SHARE * it->own->atol[n_q + i] + rtol * v + PK_TINY);
        if (i >= n_q) /* a first-order variable: its rate moves no coordinate */
            continue;
        const pk_real q = pk_max(pk_abs(it->q[i]), pk_abs(it->q[i] + y->h * (v0 + moved / 2)));
        const pk_real of_q = h * h / (PK_GAUSS_SHARE * it->own->atol[i] + rtol * q + PK_TINY);
        w->weight[i] = pk_max(w->weight[i], of_q);
    }
}

/* Computes the acceleration a in all lanes. A lane that fails is evaluated alone, for the cause. */
static inline enum pk_status PK_STEPPER(gauss_evaluate)(struct pk_integrator *it, const pk_real *t,
                                                        const pk_real *q, const pk_real *v,
                                                        pk_real *u, pk_real *a)
{
    const size_t n_q = PK_STEPPER_COORDINATES(it), n = PK_STEPPER_N(it);
    const size_t m = it->problem.system->n_inputs;
    for (int l = 0; m && l < PK_GAUSS_S; l++) {
        const pk_real *u1 = PK_STEPPER_INPUT(it, t[l]);
        for (size_t i = 0; i < m; i++)
            u[i * PK_GAUSS_S + (size_t)l] = u1[i];
    }
    unsigned long long failed = PK_STEPPER_LANES(it, t, q, v, u, a);
    it->count.evaluations += PK_GAUSS_S;
    it->count.iterations++;
    for (size_t l = 0; failed; l++, failed >>= 1)
        if (failed & 1) {
            pk_real *q1 = pk_next(it, PK_Q), *v1 = pk_next(it, PK_V), *a1 = pk_next(it, PK_A);
            for (size_t i = 0; i < n_q; i++)
                q1[i] = q[i * PK_GAUSS_S + l];
            for (size_t i = 0; i < n; i++)
                v1[i] = v[i * PK_GAUSS_S + l];
            PK_TRY(PK_STEPPER(acceleration)(it, t[l], q1, v1, a1));
            for (size_t i = 0; i < n; i++)
                a[i * PK_GAUSS_S + l] = a1[i];
        }
    return PK_DONE;
}

/* Copies next_a to a; computes sizes of a and its change. Returns 0 if one is not finite. */
static inline int PK_STEPPER(gauss_compare)(struct pk_integrator *it,
                                            const struct pk_gauss_lanes *w,
                                            struct pk_gauss_trial *y)
{
    const size_t n = PK_STEPPER_N(it);
    pk_real change[PK_GAUSS_S] = {0}, size[PK_GAUSS_S] = {0};
    for (size_t i = 0; i < n; i++) {
        pk_real *PK_RESTRICT a = w->a + i * PK_GAUSS_S;
        const pk_real *PK_RESTRICT b = w->next_a + i * PK_GAUSS_S;
        const pk_real weight = w->weight[i];
        PK_GAUSS_LOOP
        for (int l = 0; l < PK_GAUSS_S; l++) {
            const pk_real s = weight * b[l], d = weight * (b[l] - a[l]);
            size[l] = PK_GAUSS_FMA(s, s, size[l]);
            change[l] = PK_GAUSS_FMA(d, d, change[l]);
            a[l] = b[l];
        }
    }
    const pk_real mean = 1 / (pk_real)(PK_GAUSS_S * n), before = y->change2;
    y->size2 = mean * pk_gauss_sum(size);
    y->change2 = mean * pk_gauss_sum(change);
    if (y->count > 0)
        y->rate = pk_max(PK_F(sqrt)(y->change2 / before), PK_C(1e-4));
    return pk_finite(y->change2) && pk_finite(y->size2);
}

/* Computes the mean squares of the last two Legendre coefficients of a. */
static inline void PK_STEPPER(gauss_coefficients)(struct pk_integrator *it,
                                                  const struct pk_gauss_lanes *w, pk_real *six2,
                                                  pk_real *seven2)
{
    const size_t n = PK_STEPPER_N(it);
    pk_real sum6 = 0, sum7 = 0;
    for (size_t i = 0; i < n; i++) {
        const pk_real *a = w->a + i * PK_GAUSS_S;
        const pk_real six = w->weight[i] * pk_gauss_dot(w->M->legendre6, a);
        const pk_real seven = w->weight[i] * pk_gauss_dot(w->M->legendre7, a);
        sum6 += six * six;
        sum7 += seven * seven;
    }
    *six2 = sum6 / (pk_real)n;
    *seven2 = sum7 / (pk_real)n;
}

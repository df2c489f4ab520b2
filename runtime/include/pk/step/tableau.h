/* Tables of coefficients, and sums of stages with them. Reference for all names: E. Hairer, S. P.
 * Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed., II.1 and II.4-6 ("HNW").
 */
#ifndef PK_STEP_TABLEAU_H
#define PK_STEP_TABLEAU_H

#include <pk/step/numbers.h>

/* An explicit Runge-Kutta method of s stages, y1 = y0 + h sum b_i k_i. If `e` or `d` uses the
 * derivative at the new point y1, it counts as stage number s (the first is stage 0). */
struct pk_tableau {
    int stages;
    const pk_real *c; /* s nodes, then the nodes of the extra stages after y1 */
    const pk_real *a; /* strictly lower triangle row by row, without the empty first row */
    const pk_real *b;

    /* Adaptive methods: the error estimate is h sum e_i k_i (s + 1 terms); with e3, a second
     * estimate of lower order is included, HNW II.10 (10.17). Step size control: HNW II.4, IV.2. */
    const pk_real *e, *e3;
    int error_order; /* the error estimate is O(h^error_order) */
    pk_real beta, shrink, grow;

    /* Dense output: extra stages, and rows of d over all stages; HNW II.6 (6.12)-(6.14). */
    int extra;
    /* coefficients of the extra stages: s + 1 + i numbers for extra stage i */
    const pk_real *extra_a;
    int rows;
    const pk_real *d; /* rows of s + 1 + extra numbers */
};

/* A splitting method: kick[0], drift[0], kick[1], ..., kick[s], as fractions of the step. */
struct pk_splitting {
    int stages;
    const pk_real *kick;  /* s + 1 kicks */
    const pk_real *drift; /* s drifts */
};

/* The largest number of stages of an explicit method. */
#define PK_MOST_STAGES 16
/* PK_EACH_STAGE(X) expands to X(i) for every stage that a table may have, except the first. If code
 * is compiled for one table, these loops are unrolled completely, so that the sums over stages
 * become straight-line code without the zeros of the table; PK_UNROLL asks for this, since
 * compilers unroll only small loops by themselves. PK_UNROLL_FEW unrolls four iterations at a time;
 * it is for loops with an acceleration in each iteration. */
#if defined PK_ANY_TABLE
#define PK_EACH_STAGE(X)                     \
    for (int i = 1; i < PK_MOST_STAGES; i++) \
    X(i)
#define PK_UNROLL
#define PK_UNROLL_FEW
#else
#define PK_EACH_STAGE(X) \
    X(1) X(2) X(3) X(4) X(5) X(6) X(7) X(8) X(9) X(10) X(11) X(12) X(13) X(14) X(15)
#if defined __clang__
#define PK_UNROLL _Pragma("clang loop unroll(full)")
#define PK_UNROLL_FEW _Pragma("clang loop unroll_count(4)")
#elif defined __GNUC__
#define PK_UNROLL _Pragma("GCC unroll 16")
#define PK_UNROLL_FEW _Pragma("GCC unroll 4")
#else
#define PK_UNROLL
#define PK_UNROLL_FEW
#endif
#endif

/* Returns number i of the vector sum a_j k_j, where the k_j are `count` successive vectors of m
 * numbers. Terms with a_j = 0 are skipped. */
static PK_INLINE pk_real pk_row_sum(const pk_real *a, int count, const pk_real *k, size_t m,
                                    size_t i)
{
    pk_real sum = 0;
    int any = 0;
    PK_UNROLL
    for (int j = 0; j < count; j++)
        if (a[j] > 0 || a[j] < 0) {
            const pk_real x = a[j] * k[(size_t)j * m + i];
            sum = any ? sum + x : x;
            any = 1;
        }
    return sum;
}

/* Computes y = y0 + h sum a_j k_j. */
static PK_INLINE void pk_erk_combine(pk_real *y, const pk_real *y0, pk_real h, const pk_real *a,
                                     int count, const pk_real *k, size_t m)
{
    const size_t whole = m - m % 4;
    size_t i = 0;
    for (; i < whole; i += 4) { /* four sums in parallel hide the latency of additions */
        pk_real s0 = 0, s1 = 0, s2 = 0, s3 = 0;
        int any = 0;
        PK_UNROLL
        for (int j = 0; j < count; j++) {
            const pk_real *kj = k + (size_t)j * m + i;
            if (!(a[j] > 0) && !(a[j] < 0))
                continue;
            s0 = any ? s0 + a[j] * kj[0] : a[j] * kj[0];
            s1 = any ? s1 + a[j] * kj[1] : a[j] * kj[1];
            s2 = any ? s2 + a[j] * kj[2] : a[j] * kj[2];
            s3 = any ? s3 + a[j] * kj[3] : a[j] * kj[3];
            any = 1;
        }
        y[i] = y0[i] + h * s0;
        y[i + 1] = y0[i + 1] + h * s1;
        y[i + 2] = y0[i + 2] + h * s2;
        y[i + 3] = y0[i + 3] + h * s3;
    }
    for (; i < m; i++)
        y[i] = y0[i] + h * pk_row_sum(a, count, k, m, i);
}

/* Computes v += kappa a, then q += delta v; `from` has the old state, `to` receives the new one.
 * One pass over the arrays is faster than two, since fewer additions wait for each other. */
static PK_INLINE void pk_kick_drift(size_t n_q, size_t n, pk_real kappa, const pk_real *a,
                                    pk_real delta, const pk_real *from, pk_real *to)
{
    const size_t of_v = pk_state_offset(n_q, n, PK_V), of_low_q = pk_state_offset(n_q, n, PK_LOW_Q);
    const size_t of_low_v = pk_state_offset(n_q, n, PK_LOW_X);
    PK_LANE_LOOP
    for (size_t k = 0; k < n_q; k++) {
        pk_real low_v = from[of_low_v + k], low_q = from[of_low_q + k];
        const pk_real v = pk_sum(from[of_v + k], kappa * a[k], &low_v);
        to[k] = pk_sum(from[k], delta * v, &low_q);
        to[of_v + k] = v;
        to[of_low_v + k] = low_v;
        to[of_low_q + k] = low_q;
    }
    PK_LANE_LOOP
    /* the rest of v, first-order variables, which move no coordinate */
    for (size_t k = n_q; k < n; k++) {
        pk_real low = from[of_low_v + k];
        to[of_v + k] = pk_sum(from[of_v + k], kappa * a[k], &low);
        to[of_low_v + k] = low;
    }
}

/* Computes v += kappa a in place: the last kick of a step. */
static PK_INLINE void pk_kick(size_t n_q, size_t n, pk_real kappa, const pk_real *a, pk_real *to)
{
    pk_real *v = pk_part(to, n_q, n, PK_V), *low = pk_part(to, n_q, n, PK_LOW_X);
    PK_LANE_LOOP
    for (size_t k = 0; k < n; k++)
        v[k] = pk_sum(v[k], kappa * a[k], &low[k]);
}

#endif

/* Explicit Runge-Kutta methods at a fixed step, on y = (q, v) with y' = (v, a(q, v, t)):
 *
 *     k_i = f(t0 + c_i h, y0 + h sum_j<i a_ij k_j),   y1 = y0 + h sum b_i k_i
 *
 * with a compensated sum for y1. Reference: E. Hairer, S. P. Norsett, G. Wanner, Solving
 * Ordinary Differential Equations I, II.1.
 */
#include <string.h>

#include "internal.h"
#include "tableau.h"

/* Four components at once hide the latency of the sums; zeros of a sparse tableau are skipped. */
void pk_erk_combine(pk_real *y, const pk_real *y0, pk_real h, const pk_real *a, int count,
                    const pk_real *k, size_t m)
{
    size_t i = 0;
    for (; i + 4 <= m; i += 4) {
        pk_real s0 = 0, s1 = 0, s2 = 0, s3 = 0;
        for (int j = 0; j < count; j++) {
            const pk_real *kj = k + (size_t)j * m + i;
            if (!(a[j] > 0) && !(a[j] < 0))
                continue;
            s0 += a[j] * kj[0];
            s1 += a[j] * kj[1];
            s2 += a[j] * kj[2];
            s3 += a[j] * kj[3];
        }
        y[i] = y0[i] + h * s0;
        y[i + 1] = y0[i + 1] + h * s1;
        y[i + 2] = y0[i + 2] + h * s2;
        y[i + 3] = y0[i + 3] + h * s3;
    }
    for (; i < m; i++) {
        pk_real s = 0;
        for (int j = 0; j < count; j++)
            s += a[j] * k[(size_t)j * m + i];
        y[i] = y0[i] + h * s;
    }
}

size_t pk_erk_size(const struct pk_method *method, size_t n)
{
    const struct pk_tableau *table = (const struct pk_tableau *)method->table;
    return ((size_t)table->stages + 2) * 2 * n;
}

enum pk_status pk_erk_init(struct pk_integrator *it)
{
    (void)it;
    return PK_DONE;
}

enum pk_status pk_erk_step(struct pk_integrator *it, pk_real limit)
{
    const struct pk_tableau *table = (const struct pk_tableau *)it->method->table;
    const size_t n = it->n, m = 2 * n;
    const pk_real h = it->h;
    const pk_real *a = table->a;
    pk_real *k = it->work, *y = k + (size_t)table->stages * m, *sum = y + m;
    (void)limit;

    memcpy(y, it->state, m * sizeof *y);
    for (int i = 0; i < table->stages; i++) {
        pk_real *ki = k + (size_t)i * m;
        if (i > 0) {
            pk_erk_combine(y, it->state, h, a, i, k, m);
            a += i;
        }
        memcpy(ki, y + n, n * sizeof *y);
        const enum pk_status status =
            pk_eval_acceleration(it, it->t + table->c[i] * h, y, y + n, ki + n);
        if (status < 0)
            return status;
    }
    memcpy(it->next, it->state, PK_PARTS * n * sizeof *y);
    memset(y, 0, m * sizeof *y);
    pk_erk_combine(sum, y, h, table->b, table->stages, k, m);
    pk_real *low = pk_part(it->next, n, PK_LOW_Q); /* those of q and of v are neighbours */
    for (size_t i = 0; i < m; i++)
        it->next[i] = pk_sum(it->next[i], sum[i], &low[i]);
    return PK_DONE;
}

static const pk_real euler_c[] = {PK_C(0.0)};
static const pk_real euler_b[] = {PK_C(1.0)};
static const struct pk_tableau euler_table = {
    .stages = 1, .c = euler_c, .a = NULL, .b = euler_b};
const struct pk_method pk_euler = {.name = "euler",
                                   .doc = "explicit Euler; HNW I.7",
                                   .order = 1,
                                   .stages = 1,
                                   .table = &euler_table,
                                   .size = pk_erk_size,
                                   .init = pk_erk_init,
                                   .step = pk_erk_step};

static const pk_real rk4_c[] = {PK_C(0.0), PK_C(0.5), PK_C(0.5), PK_C(1.0)};
static const pk_real rk4_a[] = {PK_C(0.5), PK_C(0.0), PK_C(0.5),
                                PK_C(0.0), PK_C(0.0), PK_C(1.0)};
static const pk_real rk4_b[] = {PK_C(1.0) / PK_C(6.0), PK_C(1.0) / PK_C(3.0),
                                PK_C(1.0) / PK_C(3.0), PK_C(1.0) / PK_C(6.0)};
static const struct pk_tableau rk4_table = {.stages = 4, .c = rk4_c, .a = rk4_a, .b = rk4_b};
const struct pk_method pk_rk4 = {.name = "rk4",
                                 .doc = "the classical Runge-Kutta method; W. Kutta (1901), "
                                        "HNW II.1 Table 1.2",
                                 .order = 4,
                                 .stages = 4,
                                 .table = &rk4_table,
                                 .size = pk_erk_size,
                                 .init = pk_erk_init,
                                 .step = pk_erk_step};

/* The gradient of one number at the end of a run, by the discrete adjoint method: backwards through
 * the steps of the tape, whose stages are computed again. Explicit Runge-Kutta methods have
 *
 *     Y_i = y + h sum a_ij F(Y_j),   y1 = y + h sum b_i F(Y_i),
 *     l_i = h (b_i lambda1 + sum_j a_ji m_j),   m_i = F'(Y_i)^T l_i,   lambda = lambda1 + sum m_i,
 *
 * and splitting methods kicks and drifts, in reverse order; for implicit methods see
 * adjoint_implicit.c. The product F'^T l is that of the kernel `adjoint`, with mu from M mu = l. Reference: J. M. Sanz-Serna, SIAM Rev. 58 (2016) 3. */
#include "../../src/core/internal.h"
#include "../../src/core/tableau.h"
#include "../settings/settings.h"
#include "adjoint.h"

/* largest number of stages, not below PK_MOST_STAGES */
enum { MOST = 24 };

static void make(struct adjoint *x)
{
    struct memory *memory = &x->run->memory;
    x->d = &x->run->tape->differences;
    x->system = x->d->problem.system;
    x->n = x->d->n;
    x->n_q = x->d->n_q;
    x->m = x->system->n_inputs + x->system->n_parameters;
    x->kernel = run_jacobian_named(x->system, "adjoint");
    adjoint_implicit_make(x);
    const size_t n = x->n, of_stages = (MOST + 2) * 2 * n, wide = 2 * n + 1 + x->m;
    x->q = memory_take(memory, 3 * of_stages + 2 * n + n * n + 2 * wide, sizeof *x->q);
    x->k = x->q + of_stages;
    x->l = x->k + of_stages;
    x->moving = x->l + of_stages;
    x->M = x->moving + 2 * n;
    x->bars = x->M + n * n;
    x->lambda = x->bars + wide;
}

/* Writes F = (q', v') of y = (q, v). */
static int rates(struct adjoint *x, pk_real t, const pk_real *y, pk_real *F)
{
    pk_zero(F, x->n);
    pk_copy(F, y + x->n, x->n_q);
    return x->system->acceleration(x->d->params, t, y, y + x->n, x->d->u, F + x->n);
}

/* Writes F'^T l to `out` where a is the acceleration at y, and adds the derivatives of F.l by inputs
 * and parameters to lambda. */
static void pull(struct adjoint *x, pk_real t, const pk_real *y, const pk_real *a, const pk_real *l,
                 pk_real *out)
{
    const size_t n = x->n;
    adjoint_mass(x, t, y);
    adjoint_sweep(x, t, y, a, l + n);
    pk_copy(out, x->bars, 2 * n);
    pk_add(out + n, 1, l, x->n_q);
    pk_add(x->lambda + 2 * n, 1, x->bars + 2 * n + 1, x->m);
}

static void runge_kutta(struct adjoint *x, const struct pk_tableau *table, const pk_real *row)
{
    const size_t n2 = 2 * x->n;
    const int s = table->stages;
    const pk_real t = row[TAPE_T0], h = row[TAPE_T1] - t, *a = table->a;
    for (int i = 0; i < s; a += i++) {
        pk_real *const Y = x->q + (size_t)i * n2;
        pk_copy(Y, x->d->q, n2);
        for (int j = 0; j < i; j++)
            pk_add(Y, h * a[j], x->k + (size_t)j * n2, n2);
        if (rates(x, t + table->c[i] * h, Y, x->k + (size_t)i * n2))
            x->status = PK_SINGULAR_MASS;
    }
    /* `a` points past the last row; x->l has m_i */
    for (int i = s; i-- > 0;) {
        pk_real *const l = x->l + (size_t)s * n2, *const m = x->l + (size_t)i * n2;
        for (size_t k = 0; k < n2; k++)
            l[k] = h * table->b[i] * x->lambda[k];
        for (int j = i + 1; j < s; j++)
            pk_add(l, h * table->a[j * (j - 1) / 2 + i], x->l + (size_t)j * n2, n2);
        pull(x, t + table->c[i] * h, x->q + (size_t)i * n2, x->k + (size_t)i * n2 + x->n, l, m);
    }
    for (int i = 0; i < s; i++)
        pk_add(x->lambda, 1, x->l + (size_t)i * n2, n2);
}

/* A step of a splitting method of a separable system: forces do not depend on rates. */
static void splitting(struct adjoint *x, const struct pk_splitting *table, const pk_real *row)
{
    const size_t n = x->n, n2 = 2 * n;
    const pk_real h = row[TAPE_T1] - row[TAPE_T0];
    pk_real t = row[TAPE_T0], *l = x->l, *m = l + n2, *y = x->q;
    pk_copy(y, x->d->q, n2);
    for (int i = 0; i <= table->stages; i++) {
        pk_real *const next = y + n2, *const k = x->k + (size_t)i * n2;
        const int kicks = table->kick[i] > 0 || table->kick[i] < 0;
        if (kicks && rates(x, t, y, k))
            x->status = PK_SINGULAR_MASS;
        if (i == table->stages)
            break;
        pk_copy(next, y, n2);
        if (kicks)
            pk_add(next + n, h * table->kick[i], k + n, n);
        pk_add(next, h * table->drift[i], next + n, x->n_q);
        t += h * table->drift[i];
        y = next;
    }
    for (int i = table->stages; i >= 0; i--) {
        y = x->q + (size_t)i * n2;
        if (table->kick[i] > 0 || table->kick[i] < 0) {
            pk_zero(l, n2);
            pk_add(l + n, h * table->kick[i], x->lambda + n, n);
            pull(x, t, y, x->k + (size_t)i * n2 + n, l, m);
            pk_add(x->lambda, 1, m, n2);
        }
        if (i > 0) {
            pk_add(x->lambda + n, h * table->drift[i - 1], x->lambda, x->n_q);
            t -= h * table->drift[i - 1];
        }
    }
}

static void steps(void *context)
{
    struct adjoint *x = context;
    make(x);
    const struct settings *s = &x->run->settings;
    const struct pk_system *system = x->system;
    const size_t n2 = 2 * x->n;
    const struct pk_tableau *table = pk_explicit_table(s->method);
    const struct pk_splitting *kicks = pk_splitting_table(s->method);
    const int splits = kicks && system->facts & PK_SEPARABLE && kicks->stages <= MOST;
    const int takes = table || x->stages || (splits && !(s->method->traits & PK_LINEAR));
    if (!x->kernel || !takes || s->method->traits & (PK_GROUP | PK_NOISE | PK_HOLONOMIC) ||
        s->method->needs & PK_FAST || system->constraints.n || system->n_rotations) {
        x->status = PK_REFUSED;
        return;
    }
    double *of_times = memory_take(&x->run->memory, n2, sizeof *of_times); /* of a step */
    for (size_t i = 0; i < n2 + x->m; i++)
        x->lambda[i] = (pk_real)x->out[i];
    for (size_t k = x->end; k-- > x->begin && x->status >= 0;) {
        const pk_real *row = tape_row(x->run->tape, k);
        if (!(row[TAPE_T1] > row[TAPE_T0]))
            continue;
        const int cut = tape_is_cut(x->run, row, row[TAPE_T1]);
        const struct shift shift = {NULL, 1, !cut, 0};
        if (cut)
            x->out[n2 + x->m] = 0;
        if (x->shifts && (cut || !(system->facts & PK_AUTONOMOUS))) {
            x->status = differences_find(x->d, k, row[TAPE_T1], &shift, of_times);
            for (size_t i = 0; i < n2; i++)
                x->out[n2 + x->m] += (double)x->lambda[i] * of_times[i];
        }
        differences_place(x->d, row);
        if (x->stages)
            x->status = adjoint_implicit(x, k);
        else if (table)
            runge_kutta(x, table, row);
        else
            splitting(x, kicks, row);
    }
    for (size_t i = 0; i < n2 + x->m; i++)
        x->out[i] = (double)x->lambda[i];
}

int pk_run_adjoint(struct pk_run *run, size_t begin, size_t end, int shifts, double *lambda)
{
    struct adjoint x = {.run = run, .begin = begin, .end = end, .shifts = shifts, .out = lambda};
    const int done = memory_try(&run->memory, steps, &x);
    return done ? x.status : PK_NO_MEMORY;
}

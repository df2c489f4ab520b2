/* Evaluates kernels at many states in one call: accelerations in SIMD lanes; da/dq and da/dv by the
 * kernel `linear` or, without it, by central differences with errors of about PK_EPSILON^(2/3). */

#include <pk/linear.h>

#include "settings/settings.h"

static size_t work_size(const struct pk_problem *problem)
{
    const size_t n = pk_count_of(problem);
    const size_t exact = 2 * n + pk_system_linear_size(problem), differences = 4 * n;
    const size_t rows = problem->system->constraints.n * n;
    const size_t most = exact > differences ? exact : differences;
    return most > rows ? most : rows;
}

static int differences(const struct pk_problem *problem, pk_real t, const pk_real *q,
                       const pk_real *v, const pk_real *u, pk_real *a_q, pk_real *a_v,
                       pk_real *work)
{
    const struct pk_system *system = problem->system;
    const size_t n = pk_count_of(problem);
    pk_real *y = work, *plus = y + 2 * n, *minus = plus + n;
    const pk_real delta = PK_F(cbrt)(PK_EPSILON);
    for (size_t j = 0; j < 2 * n; j++) {
        memcpy(y, q, n * sizeof *y);
        memcpy(y + n, v, n * sizeof *y);
        const pk_real x = y[j], h = delta * (PK_F(fabs)(x) > 1 ? PK_F(fabs)(x) : 1);
        y[j] = x + h;
        const pk_real up = y[j];
        if (system->acceleration(problem->params, t, y, y + n, u, plus))
            return 0;
        y[j] = x - h;
        if (system->acceleration(problem->params, t, y, y + n, u, minus))
            return 0;
        pk_real *const column = j < n ? a_q + j : a_v + (j - n);
        for (size_t i = 0; i < n; i++)
            column[i * n] = (plus[i] - minus[i]) / (up - y[j]);
    }
    return 1;
}

static int jacobian(const struct pk_problem *problem, pk_real t, const pk_real *q, const pk_real *v,
                    const pk_real *u, pk_real *a_q, pk_real *a_v, pk_real *work)
{
    const size_t n = pk_count_of(problem);
    const enum pk_status status =
        pk_system_linear(problem, t, q, v, work, a_q, a_v, work + n, work + 2 * n);
    return status == PK_REFUSED ? differences(problem, t, q, v, u, a_q, a_v, work)
                                : status == PK_DONE;
}

/* A kernel by its name. `width` is its number of values per state, or 0 if the system lacks it. */
struct kernel {
    const char *name;
    enum { ACCELERATION, JACOBIAN, FIRST, SECOND, SLOPES, ENERGY, MOVING, PLAIN } kind;
    size_t width;
    pk_kernel *plain;
    pk_kernel_2 *pair; /* of a kernel that is the FIRST or the SECOND result of this one */
    pk_kernel_moving *moving;
};

static struct kernel find(const struct settings *s, const char *name)
{
    const struct pk_system *system = s->system;
    const size_t n = s->n, solved = system->acceleration ? n : 0;
    const struct pk_part_constraints *held = &system->constraints;
    pk_kernel_2 *const rows = held->jacobian;
    pk_kernel_2 *const free = system->unconstrained ? system->unconstrained : system->canonical;
    const size_t outputs = pk_system_outputs(system, s->params);
    const struct kernel kernels[] = {
        {"acceleration", ACCELERATION, .width = solved},
        {"jacobian", JACOBIAN, .width = 2 * n * solved},
        {"momenta", FIRST, system->canonical ? n : 0, .pair = system->canonical},
        {"free momenta", FIRST, free ? n : 0, .pair = free},
        {"momentum jacobian", SLOPES, .width = system->jacobian ? 3 * n * n : 0},
        {"constraint jacobian", FIRST, held->n * n, .pair = rows},
        {"constraint", PLAIN, held->n_holonomic, .plain = held->values},
        {"constraint rates", SECOND, held->n, .pair = rows},
        {"energy", ENERGY, .width = system->energy != NULL},
        {"force", PLAIN, system->force ? n : 0, .plain = system->force},
        {"mass", PLAIN, system->mass ? n * n : 0, .plain = system->mass},
        {"outputs", PLAIN, outputs, .plain = system->observe},
        {"", PLAIN, .width = 0},
    };
    const struct kernel *k = kernels;
    while (*k->name && strcmp(k->name, name) != 0)
        k++;
    const struct pk_jacobian *of = *k->name ? NULL : run_jacobian_named(system, name);
    return of ? (struct kernel){name, of->moving ? MOVING : PLAIN, of->width, of->plain,
                                .moving = of->moving}
              : *k;
}

/* Evaluates a kernel at one state. Returns 0, with `out` undefined, if M is singular there. */
static int at(const struct settings *s, const struct pk_problem *problem, const struct kernel *k,
              pk_real t, const pk_real *q, const pk_real *v, const pk_real *u, pk_real *out,
              pk_real *work)
{
    const struct pk_system *system = s->system;
    switch (k->kind) {
    case ACCELERATION:
        return system->acceleration(s->params, t, q, v, u, out) == 0;
    case JACOBIAN:
        return jacobian(problem, t, q, v, u, out, out + s->n * s->n, work);
    case FIRST:
        k->pair(s->params, t, q, v, u, out, work);
        return 1;
    case SECOND:
        k->pair(s->params, t, q, v, u, work, out);
        return 1;
    case SLOPES:
        system->jacobian(s->params, t, q, v, u, out, out + s->n * s->n, out + 2 * s->n * s->n);
        return 1;
    case ENERGY:
        *out = system->energy(s->params, t, q, v, u);
        return 1;
    case MOVING:
        if (system->acceleration(s->params, t, q, v, u, work))
            return 0;
        k->moving(s->params, t, q, v, u, work, out);
        return 1;
    default:
        k->plain(s->params, t, q, v, u, out);
        return 1;
    }
}

/* Computes accelerations in blocks of PK_LANES states. Returns the number of states that failed. */
static size_t in_lanes(const struct settings *s, size_t count, const double *t, const double *q,
                       const double *v, const double *u, double *out, pk_real *work)
{
    const size_t n = s->n, m = s->system->n_inputs;
    pk_real *T = work, *Q = T + PK_LANES, *V = Q + n * PK_LANES, *A = V + n * PK_LANES,
            *U = A + n * PK_LANES;
    size_t failed = 0;
    for (size_t k = 0; k < count; k += PK_LANES) {
        const size_t some = count - k < PK_LANES ? count - k : PK_LANES;
        for (size_t l = 0; l < PK_LANES; l++) {
            const size_t from = k + (l < some ? l : 0);
            T[l] = (pk_real)t[from];
            for (size_t i = 0; i < m; i++)
                U[i * PK_LANES + l] = u ? (pk_real)u[from * m + i] : s->u[i];
            for (size_t i = 0; i < n; i++) {
                Q[i * PK_LANES + l] = (pk_real)q[from * n + i];
                V[i * PK_LANES + l] = (pk_real)v[from * n + i];
            }
        }
        const unsigned long long bad = s->system->lanes(s->params, T, Q, V, U, A);
        for (size_t l = 0; l < some; l++) {
            const int wrong = bad >> l & 1;
            failed += (size_t)wrong;
            for (size_t i = 0; i < n; i++)
                out[(k + l) * n + i] = wrong ? (double)NAN : (double)A[i * PK_LANES + l];
        }
    }
    return failed;
}

size_t pk_run_width(const struct pk_run *run, const char *what)
{
    return find(&run->settings, what).width;
}

size_t pk_run_evaluate(struct pk_run *run, const char *what, size_t count, const double *t,
                       const double *q, const double *v, const double *u, double *out)
{
    const struct settings *s = &run->settings;
    const struct kernel kernel = find(s, what);
    const size_t n = s->n, wide = kernel.width;
    if (!wide || run->code)
        return count;
    struct pk_problem problem = run_problem(run);
    const size_t m = s->system->n_inputs;
    const size_t lanes = (3 * n + 1 + m) * PK_LANES, one = 3 * n + m + wide;
    pk_real *work = memory_ask(&run->memory, lanes + one + work_size(&problem), sizeof *work);
    if (!work)
        return count;
    if (kernel.kind == ACCELERATION && s->system->lanes && count > 1) {
        const size_t failed = in_lanes(s, count, t, q, v, u, out, work);
        memory_drop(&run->memory, work);
        return failed;
    }
    pk_real *Q = work, *V = Q + n, *U = V + n, *found = U + m, *rest = found + wide;
    size_t failed = 0;
    struct pk_constant_input held = {U, m};
    problem.input = pk_constant_input;
    problem.context = &held;
    for (size_t k = 0; k < count; k++) {
        for (size_t i = 0; i < n; i++) {
            Q[i] = (pk_real)q[k * n + i];
            V[i] = (pk_real)v[k * n + i];
        }
        for (size_t i = 0; i < m; i++)
            U[i] = u ? (pk_real)u[k * m + i] : s->u[i];
        const int good = at(s, &problem, &kernel, (pk_real)t[k], Q, V, U, found, rest);
        failed += !good;
        for (size_t i = 0; i < wide; i++)
            out[k * wide + i] = good ? (double)found[i] : (double)NAN;
    }
    memory_drop(&run->memory, work);
    return failed;
}

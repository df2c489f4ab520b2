/* The variational equations as a system; see motion.h. The columns of displacements share M,
 * its factors, and the derivatives of the right-hand side r of M q'' = r. */
#include "../../src/core/internal.h"
#include "../settings/settings.h"
#include "motion.h"

#define OF(x) (x)->of.params, t, q, v, u

static const struct variation *self(const void *params) { return (const struct variation *)params; }

static size_t count(const void *params) { return self(params)->n * (1 + self(params)->columns); }

static size_t first_order(const void *params)
{
    return (self(params)->n - self(params)->n_q) * (1 + self(params)->columns);
}

size_t variation_place(const struct variation *w, size_t k, size_t i)
{
    return i < w->n_q ? k * w->n_q + i : w->columns * w->n_q + k * (w->n - w->n_q) + i;
}

void variation_take(const struct variation *w, const pk_real *V, size_t k, pk_real *v)
{
    for (size_t i = 0; i < w->n; i++)
        v[i] = V[variation_place(w, k, i)];
}

void variation_put(const struct variation *w, const pk_real *v, size_t k, pk_real *V)
{
    for (size_t i = 0; i < w->n; i++)
        V[variation_place(w, k, i)] = v[i];
}

/* y += A x, where A has a column for each component of v, and x has coordinates only. */
static void add_by_q(const struct variation *w, pk_real *y, const pk_real *A, const pk_real *x)
{
    for (size_t i = 0; i < w->n; i++)
        for (size_t j = 0; j < w->n_q; j++)
            y[i] += A[i * w->n + j] * x[j];
}

/* Copies the rates and first-order variables of the motion to the work memory. */
static const pk_real *own(const struct variation *w, const pk_real *V)
{
    variation_take(w, V, 0, w->v);
    return w->v;
}

/* Returns the change of a quantity by the inputs and the parameters of column k, from 0. U and P are
 * its derivatives by all inputs and by all parameters. */
static pk_real driven(const struct variation *w, size_t k, const pk_real *U, const pk_real *P)
{
    const size_t m = w->of.system->n_inputs, n_p = w->of.system->n_parameters;
    const pk_real *const d = w->du + k * (m + n_p);
    return pk_dot(U, d, m) + pk_dot(P, d + m, n_p);
}

static int acceleration(ARGS, pk_real *a)
{
    const struct variation *w = self(params);
    const struct pk_system *system = w->of.system;
    const size_t n_q = w->n_q, n = w->n, nn = n * n;
    const pk_real *const V = v;
    pk_real *r_q = w->work, *r_v = r_q + nn, *M = r_v + nn, *r_t = M + nn;
    v = own(w, V);
    int failed = system->acceleration(OF(w), w->a);
    if (failed)
        return failed;
    variation_put(w, w->a, 0, a);
    if (w->columns == 0)
        return 0;
    system->linear(OF(w), w->a, r_q, r_v, r_t);
    system->mass(OF(w), M);
    const size_t m = system->n_inputs, n_p = system->n_parameters;
    pk_real *const r_u = w->drive, *const r_p = w->du ? r_u + n * m : NULL;
    if (w->du && m)
        w->r_u->moving(OF(w), w->a, r_u);
    if (w->du && n_p)
        w->r_p->moving(OF(w), w->a, r_p);
    const size_t pivot = pk_ldl_factor(M, n);
    if (pivot)
        return PK_FAILED(PK_FAILURE_MASS, pivot - 1);
    for (size_t k = 1; k <= w->columns; k++) {
        variation_take(w, V, k, w->v);
        memset(w->a, 0, n * sizeof *w->a);
        add_by_q(w, w->a, r_q, q + k * n_q);
        pk_add_product(w->a, r_v, w->v, n);
        for (size_t i = 0; i < n && w->du; i++)
            w->a[i] += driven(w, k - 1, r_u + i * m, r_p + i * n_p);
        pk_ldl_solve(M, n, w->a);
        variation_put(w, w->a, k, a);
    }
    return 0;
}

/* Copies an n by n block to the blocks of the motion and of each displacement in A. */
static void spread(const struct variation *w, const pk_real *block, pk_real *A)
{
    const size_t n = w->n, m = count(w);
    memset(A, 0, m * m * sizeof *A);
    for (size_t k = 0; k <= w->columns; k++)
        for (size_t i = 0; i < n; i++)
            variation_put(w, block + i * n, k, A + variation_place(w, k, i) * m);
}

static void mass(ARGS, pk_real *M)
{
    const struct variation *w = self(params);
    v = own(w, v);
    w->of.system->mass(OF(w), w->work);
    spread(w, w->work, M);
}

static void jacobian(ARGS, pk_real *p_q, pk_real *pdot_q, pk_real *pdot_v)
{
    const struct variation *w = self(params);
    const size_t nn = w->n * w->n;
    v = own(w, v);
    w->of.system->jacobian(OF(w), w->work, w->work + nn, w->work + 2 * nn);
    spread(w, w->work, p_q);
    spread(w, w->work + nn, pdot_q);
    spread(w, w->work + 2 * nn, pdot_v);
}

static void linear(ARGS, const pk_real *a, pk_real *r_q, pk_real *r_v, pk_real *r_t)
{
    const struct variation *w = self(params);
    const size_t nn = w->n * w->n;
    pk_real *own_t = w->work + 2 * nn;
    v = own(w, v);
    variation_take(w, a, 0, w->a);
    w->of.system->linear(OF(w), w->a, w->work, w->work + nn, own_t);
    memset(r_t, 0, count(w) * sizeof *r_t);
    variation_put(w, own_t, 0, r_t);
    spread(w, w->work, r_q);
    spread(w, w->work + nn, r_v);
}

static void canonical(ARGS, pk_real *p, pk_real *pdot)
{
    const struct variation *w = self(params);
    const struct pk_system *system = w->of.system;
    const size_t n_q = w->n_q, n = w->n, nn = n * n;
    const pk_real *const V = v;
    pk_real *p_q = w->work, *pdot_q = p_q + nn, *pdot_v = pdot_q + nn, *M = pdot_v + nn;
    v = own(w, V);
    system->canonical(OF(w), w->a, w->b);
    system->jacobian(OF(w), p_q, pdot_q, pdot_v);
    system->mass(OF(w), M);
    if (w->du)
        w->canonical->plain(OF(w), w->drive);
    for (size_t k = 0;; k++) {
        variation_put(w, w->a, k, p);
        variation_put(w, w->b, k, pdot);
        if (k == w->columns)
            return;
        variation_take(w, V, k + 1, w->v);
        memset(w->a, 0, 2 * n * sizeof *w->a); /* also clears w->b, which follows w->a */
        pk_add_product(w->a, M, w->v, n);
        add_by_q(w, w->a, p_q, q + (k + 1) * n_q);
        add_by_q(w, w->b, pdot_q, q + (k + 1) * n_q);
        pk_add_product(w->b, pdot_v, w->v, n);
        const size_t m = system->n_inputs, wide = 2 * n + 1 + m + system->n_parameters;
        for (size_t i = 0; i < 2 * n && w->du; i++) { /* w->b follows w->a */
            const pk_real *row = w->drive + i * wide + 2 * n + 1;
            w->a[i] += driven(w, k, row, row + m);
        }
    }
}

/* Evaluates the singularities of the motion; displacements have none. */
static void singularity(ARGS, pk_real *out)
{
    const struct variation *w = self(params);
    v = own(w, v);
    w->of.system->singularities.values(OF(w), out);
}

const pk_real *variation_inputs(const struct variation *w, pk_real t)
{
    pk_input(&w->of, t, w->u);
    return w->u;
}

enum pk_status variation_init(struct variation *w, const struct motion *m, size_t columns)
{
    const struct pk_system *system = m->problem->system;
    const size_t n = pk_system_count(system, m->problem->params);
    memset(w, 0, sizeof *w);
    /* At a kink, displacements jump, and derivatives do not show by how much. */
    if (!system->linear || !system->mass || !system->jacobian ||
        !(system->facts & (PK_SMOOTH | (m->sided ? PK_SWITCHED : 0u))))
        return PK_REFUSED;
    w->of = *m->problem;
    w->n_q = pk_coordinates_of(m->problem);
    w->n = n;
    w->columns = columns;
    w->work = memory_take(m->memory, 4 * n * n + 3 * n + system->n_inputs, sizeof *w->work);
    w->v = w->work + 4 * n * n;
    w->a = w->v + n;
    w->b = w->a + n;
    w->u = w->b + n;
    w->Q = memory_take(m->memory, (1 + columns) * (w->n_q + n), sizeof *w->Q);
    w->V = w->Q + (1 + columns) * w->n_q;
    memcpy(w->Q, m->q, w->n_q * sizeof *w->Q);
    variation_put(w, m->v, 0, w->V);
    /* The momentum p of a displacement depends on q of the motion, and also on v unless M is
     * constant. The mass kernel lacks the terms of dp/dv by v, so PK_QUADRATIC is off. */
    unsigned kept = PK_MASS_CONSTANT | PK_SEPARABLE | PK_AUTONOMOUS | PK_SMOOTH | PK_MASS_DIAGONAL |
                    PK_AFFINE | PK_LINEAR_DRAG;
    if (system->facts & PK_MASS_CONSTANT)
        kept |= PK_QUADRATIC;
    const unsigned smooth = m->sided ? PK_SMOOTH : 0u;
    w->system =
        (struct pk_system){.abi = PK_ABI,
                           .name = system->name,
                           .source_hash = system->source_hash,
                           .facts = (system->facts & kept) | smooth,
                           .n = n * (1 + columns),
                           .n_first_order = first_order(w),
                           .families.n_coordinates = n,
                           .n_inputs = system->n_inputs,
                           .inputs = system->inputs,
                           .coordinates = system->coordinates,
                           .rates = system->rates,
                           .momenta = system->momenta,
                           .acceleration = acceleration,
                           .mass = mass,
                           .canonical = canonical,
                           .jacobian = jacobian,
                           .linear = linear,
                           .singularities.n = system->singularities.n,
                           .singularities.table = system->singularities.table,
                           .singularities.values = system->singularities.n ? singularity : NULL,
                           .families.count = count,
                           .families.first_order = first_order};
    w->problem = (struct pk_problem){.system = &w->system,
                                     .params = w,
                                     .input = m->problem->input,
                                     .context = m->problem->context};
    w->motion = *m;
    w->motion.problem = &w->problem;
    w->motion.q = w->Q;
    w->motion.v = w->V;
    w->motion.it = (struct pk_integrator){0};
    w->motion.block = NULL;
    return PK_DONE;
}

enum pk_status variation_drive(struct variation *w, const pk_real *du)
{
    const struct pk_system *system = w->of.system;
    const size_t n = w->n, more = system->n_inputs + system->n_parameters;
    w->r_u = run_jacobian_named(system, "r_u");
    w->r_p = run_jacobian_named(system, "r_p");
    w->canonical = run_jacobian_named(system, "canonical_d");
    if ((system->n_inputs && !w->r_u) || (system->n_parameters && !w->r_p))
        return PK_REFUSED;
    if (!w->canonical)
        w->system.canonical = NULL;
    w->drive = memory_take(w->motion.memory, 2 * n * (2 * n + 1 + more), sizeof *w->drive);
    w->du = du;
    return PK_DONE;
}

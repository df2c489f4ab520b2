/* The variational equations as a system; see pk/variation.h. The columns of displacements share M,
 * its factors, and the derivatives of the right-hand side r of M q'' = r. */
#include <string.h>

#include <pk/variation.h>

#include "../core/internal.h"

#define OF(x) (x)->of.params, t, q, v, u

static const struct pk_variation *self(const void *params)
{
    return (const struct pk_variation *)params;
}

static size_t count(const void *params) { return self(params)->n * (1 + self(params)->columns); }

static size_t first_order(const void *params)
{
    return (self(params)->n - self(params)->n_q) * (1 + self(params)->columns);
}

size_t pk_variation_place(const struct pk_variation *w, size_t k, size_t i)
{
    return i < w->n_q ? k * w->n_q + i : w->columns * w->n_q + k * (w->n - w->n_q) + i;
}

void pk_variation_take(const struct pk_variation *w, const pk_real *V, size_t k, pk_real *v)
{
    for (size_t i = 0; i < w->n; i++)
        v[i] = V[pk_variation_place(w, k, i)];
}

void pk_variation_put(const struct pk_variation *w, const pk_real *v, size_t k, pk_real *V)
{
    for (size_t i = 0; i < w->n; i++)
        V[pk_variation_place(w, k, i)] = v[i];
}

/* y += A x, where A has a column for each component of v, and x has coordinates only. */
static void add_by_q(const struct pk_variation *w, pk_real *y, const pk_real *A, const pk_real *x)
{
    for (size_t i = 0; i < w->n; i++)
        for (size_t j = 0; j < w->n_q; j++)
            y[i] += A[i * w->n + j] * x[j];
}

/* Copies the rates and first-order variables of the motion to the work memory. */
static const pk_real *own(const struct pk_variation *w, const pk_real *V)
{
    pk_variation_take(w, V, 0, w->v);
    return w->v;
}

static int acceleration(ARGS, pk_real *a)
{
    const struct pk_variation *w = self(params);
    const struct pk_system *system = w->of.system;
    const size_t n_q = w->n_q, n = w->n, nn = n * n;
    const pk_real *const V = v;
    pk_real *r_q = w->work, *r_v = r_q + nn, *M = r_v + nn, *r_t = M + nn;
    v = own(w, V);
    int failed = system->acceleration(OF(w), w->a);
    if (failed)
        return failed;
    pk_variation_put(w, w->a, 0, a);
    if (w->columns == 0)
        return 0;
    system->linear(OF(w), w->a, r_q, r_v, r_t);
    system->mass(OF(w), M);
    const size_t pivot = pk_ldl_factor(M, n);
    if (pivot)
        return PK_FAILED(PK_FAILURE_MASS, pivot - 1);
    for (size_t k = 1; k <= w->columns; k++) {
        pk_variation_take(w, V, k, w->v);
        memset(w->a, 0, n * sizeof *w->a);
        add_by_q(w, w->a, r_q, q + k * n_q);
        pk_add_product(w->a, r_v, w->v, n);
        pk_ldl_solve(M, n, w->a);
        pk_variation_put(w, w->a, k, a);
    }
    return 0;
}

/* Copies an n by n block to the blocks of the motion and of each displacement in A. */
static void spread(const struct pk_variation *w, const pk_real *block, pk_real *A)
{
    const size_t n = w->n, m = count(w);
    memset(A, 0, m * m * sizeof *A);
    for (size_t k = 0; k <= w->columns; k++)
        for (size_t i = 0; i < n; i++)
            pk_variation_put(w, block + i * n, k, A + pk_variation_place(w, k, i) * m);
}

static void mass(ARGS, pk_real *M)
{
    const struct pk_variation *w = self(params);
    v = own(w, v);
    w->of.system->mass(OF(w), w->work);
    spread(w, w->work, M);
}

static void jacobian(ARGS, pk_real *p_q, pk_real *pdot_q, pk_real *pdot_v)
{
    const struct pk_variation *w = self(params);
    const size_t nn = w->n * w->n;
    v = own(w, v);
    w->of.system->jacobian(OF(w), w->work, w->work + nn, w->work + 2 * nn);
    spread(w, w->work, p_q);
    spread(w, w->work + nn, pdot_q);
    spread(w, w->work + 2 * nn, pdot_v);
}

static void linear(ARGS, const pk_real *a, pk_real *r_q, pk_real *r_v, pk_real *r_t)
{
    const struct pk_variation *w = self(params);
    const size_t nn = w->n * w->n;
    pk_real *own_t = w->work + 2 * nn;
    v = own(w, v);
    pk_variation_take(w, a, 0, w->a);
    w->of.system->linear(OF(w), w->a, w->work, w->work + nn, own_t);
    memset(r_t, 0, count(w) * sizeof *r_t);
    pk_variation_put(w, own_t, 0, r_t);
    spread(w, w->work, r_q);
    spread(w, w->work + nn, r_v);
}

static void canonical(ARGS, pk_real *p, pk_real *pdot)
{
    const struct pk_variation *w = self(params);
    const struct pk_system *system = w->of.system;
    const size_t n_q = w->n_q, n = w->n, nn = n * n;
    const pk_real *const V = v;
    pk_real *p_q = w->work, *pdot_q = p_q + nn, *pdot_v = pdot_q + nn, *M = pdot_v + nn;
    v = own(w, V);
    system->canonical(OF(w), w->a, w->b);
    system->jacobian(OF(w), p_q, pdot_q, pdot_v);
    system->mass(OF(w), M);
    for (size_t k = 0;; k++) {
        pk_variation_put(w, w->a, k, p);
        pk_variation_put(w, w->b, k, pdot);
        if (k == w->columns)
            return;
        pk_variation_take(w, V, k + 1, w->v);
        memset(w->a, 0, 2 * n * sizeof *w->a); /* also clears w->b, which follows w->a */
        pk_add_product(w->a, M, w->v, n);
        add_by_q(w, w->a, p_q, q + (k + 1) * n_q);
        add_by_q(w, w->b, pdot_q, q + (k + 1) * n_q);
        pk_add_product(w->b, pdot_v, w->v, n);
    }
}

/* Evaluates the singularities of the motion; displacements have none. */
static void singularity(ARGS, pk_real *out)
{
    const struct pk_variation *w = self(params);
    v = own(w, v);
    w->of.system->singularities.values(OF(w), out);
}

size_t pk_variation_size(const struct pk_problem *of, size_t columns)
{
    (void)columns; /* displacements share the work memory */
    if (!of || !of->system || of->system->abi != PK_ABI)
        return 0;
    const size_t n = pk_system_count(of->system, of->params);
    const size_t work = 4 * n * n + 4 * n, params = pk_params_reals(of->system);
    return (work > params ? work : params) * sizeof(pk_real);
}

size_t pk_variation_integrator_size(const struct pk_problem *of, size_t columns,
                                    const struct pk_method *method)
{
    const size_t n = pk_system_count(of->system, of->params);
    const size_t states = n - pk_system_coordinates(of->system, of->params);
    struct pk_system larger = {.abi = PK_ABI, .n = (1 + columns) * n};
    larger.n_first_order = (1 + columns) * states;
    larger.n_inputs = of->system->n_inputs;
    larger.singularities.n = of->system->singularities.n;
    return pk_integrator_size(&(struct pk_problem){.system = &larger}, method);
}

enum pk_status pk_variation_init(struct pk_variation *variation, const struct pk_problem *of,
                                 size_t columns, void *block, size_t block_size)
{
    if (!variation || !of || !of->system || !block || of->system->abi != PK_ABI)
        return PK_BAD_ARGUMENT;
    const struct pk_system *system = of->system;
    /* At a kink, displacements jump, and derivatives do not show by how much. */
    if (!system->linear || !system->mass || !system->jacobian || !(system->facts & PK_SMOOTH))
        return PK_REFUSED;
    if (block_size < pk_variation_size(of, columns) || (size_t)block % _Alignof(pk_real))
        return PK_BLOCK_TOO_SMALL;
    struct pk_integrator checked = {.problem = *of};
    PK_TRY(pk_check_params(&checked, (pk_real *)block));

    memset(variation, 0, sizeof *variation);
    variation->of = *of;
    variation->n_q = pk_system_coordinates(system, of->params);
    variation->n = pk_system_count(system, of->params);
    variation->columns = columns;
    variation->work = (pk_real *)block;
    variation->v = variation->work + 4 * variation->n * variation->n;
    variation->a = variation->v + variation->n;
    variation->b = variation->a + variation->n;
    /* The momentum p of a displacement depends on q of the motion, and also on v unless M is
     * constant. The mass kernel lacks the terms of dp/dv due to v, so that PK_QUADRATIC does not
     * hold then. */
    unsigned kept = PK_MASS_CONSTANT | PK_SEPARABLE | PK_AUTONOMOUS | PK_SMOOTH | PK_MASS_DIAGONAL |
                    PK_AFFINE | PK_LINEAR_DRAG;
    if (system->facts & PK_MASS_CONSTANT)
        kept |= PK_QUADRATIC;
    variation->system =
        (struct pk_system){.abi = PK_ABI,
                           .name = system->name,
                           .source_hash = system->source_hash,
                           .facts = system->facts & kept,
                           .n = variation->n * (1 + columns),
                           .n_first_order = first_order(variation),
                           .families.n_coordinates = variation->n,
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
    variation->problem = (struct pk_problem){.system = &variation->system,
                                             .params = variation,
                                             .input = of->input,
                                             .context = of->context};
    return PK_DONE;
}

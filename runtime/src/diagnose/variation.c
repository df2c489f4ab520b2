/* The variational equations as a system; see pk/variation.h. The displacements of all columns
 * share M, its factors, and the derivatives of r.
 */
#include <string.h>

#include <pk/variation.h>

#include "../core/internal.h"

#define OF(x) (x)->of.params, t, q, v, u

static const struct pk_variation *self(const void *params)
{
    return (const struct pk_variation *)params;
}

static size_t count(const void *params) { return self(params)->n * (1 + self(params)->columns); }

static int acceleration(ARGS, pk_real *a)
{
    const struct pk_variation *w = self(params);
    const struct pk_system *system = w->of.system;
    const size_t n = w->n, nn = n * n;
    pk_real *r_q = w->work, *r_v = r_q + nn, *M = r_v + nn, *r_t = M + nn;
    int failed = system->acceleration(OF(w), a);
    if (failed || w->columns == 0)
        return failed;
    system->linear(OF(w), a, r_q, r_v, r_t);
    system->mass(OF(w), M);
    const size_t pivot = pk_ldl_factor(M, n);
    if (pivot)
        return PK_FAILED(PK_FAILURE_MASS, pivot - 1);
    for (size_t k = 1; k <= w->columns; k++) {
        pk_real *da = a + k * n;
        memset(da, 0, n * sizeof *da);
        pk_add_product(da, r_q, q + k * n, n);
        pk_add_product(da, r_v, v + k * n, n);
        pk_ldl_solve(M, n, da);
    }
    return 0;
}

/* An n by n block from `block` into each place of the diagonal of A. */
static void spread(const struct pk_variation *w, const pk_real *block, pk_real *A)
{
    const size_t n = w->n, m = count(w);
    memset(A, 0, m * m * sizeof *A);
    for (size_t k = 0; k <= w->columns; k++)
        for (size_t i = 0; i < n; i++)
            memcpy(A + (k * n + i) * m + k * n, block + i * n, n * sizeof *A);
}

static void mass(ARGS, pk_real *M)
{
    const struct pk_variation *w = self(params);
    w->of.system->mass(OF(w), w->work);
    spread(w, w->work, M);
}

static void jacobian(ARGS, pk_real *p_q, pk_real *pdot_q, pk_real *pdot_v)
{
    const struct pk_variation *w = self(params);
    const size_t nn = w->n * w->n;
    w->of.system->jacobian(OF(w), w->work, w->work + nn, w->work + 2 * nn);
    spread(w, w->work, p_q);
    spread(w, w->work + nn, pdot_q);
    spread(w, w->work + 2 * nn, pdot_v);
}

static void linear(ARGS, const pk_real *a, pk_real *r_q, pk_real *r_v, pk_real *r_t)
{
    const struct pk_variation *w = self(params);
    const size_t nn = w->n * w->n;
    memset(r_t, 0, count(w) * sizeof *r_t);
    w->of.system->linear(OF(w), a, w->work, w->work + nn, r_t);
    spread(w, w->work, r_q);
    spread(w, w->work + nn, r_v);
}

static void canonical(ARGS, pk_real *p, pk_real *pdot)
{
    const struct pk_variation *w = self(params);
    const struct pk_system *system = w->of.system;
    const size_t n = w->n, nn = n * n;
    pk_real *p_q = w->work, *pdot_q = p_q + nn, *pdot_v = pdot_q + nn, *M = pdot_v + nn;
    system->canonical(OF(w), p, pdot);
    system->jacobian(OF(w), p_q, pdot_q, pdot_v);
    system->mass(OF(w), M);
    memset(p + n, 0, w->columns * n * sizeof *p);
    memset(pdot + n, 0, w->columns * n * sizeof *pdot);
    for (size_t k = n; k <= w->columns * n; k += n) {
        pk_add_product(p + k, M, v + k, n);
        pk_add_product(p + k, p_q, q + k, n);
        pk_add_product(pdot + k, pdot_q, q + k, n);
        pk_add_product(pdot + k, pdot_v, v + k, n);
    }
}

/* The motion ends where it did without displacements. */
static void singularity(ARGS, pk_real *out)
{
    const struct pk_variation *w = self(params);
    w->of.system->singularities.values(OF(w), out);
}

size_t pk_variation_size(const struct pk_problem *of, size_t columns)
{
    (void)columns; /* they share what is worked out along the motion */
    if (!of || !of->system || of->system->abi != PK_ABI)
        return 0;
    const size_t n = pk_system_count(of->system, of->params);
    const size_t work = 4 * n * n + n, params = pk_params_reals(of->system);
    return (work > params ? work : params) * sizeof(pk_real);
}

size_t pk_variation_integrator_size(const struct pk_problem *of, size_t columns,
                                    const struct pk_method *method)
{
    const size_t n = pk_system_count(of->system, of->params);
    struct pk_system larger = {.abi = PK_ABI, .n = (1 + columns) * n};
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
    /* Across a kink displacements jump, and derivatives do not tell by how much. */
    if (!system->linear || !system->mass || !system->jacobian || !(system->facts & PK_SMOOTH))
        return PK_REFUSED;
    if (block_size < pk_variation_size(of, columns) || (size_t)block % _Alignof(pk_real))
        return PK_BLOCK_TOO_SMALL;
    struct pk_integrator checked = {.problem = *of};
    PK_TRY(pk_check_params(&checked, (pk_real *)block));

    memset(variation, 0, sizeof *variation);
    variation->of = *of;
    variation->n = pk_system_count(system, of->params);
    variation->columns = columns;
    variation->work = (pk_real *)block;
    /* p of the displacements depends on q, so on v too unless M is constant: then M, with zeros
     * for that, is not the whole of dp/dv. */
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
                           .families.count = count};
    variation->problem = (struct pk_problem){.system = &variation->system,
                                             .params = variation,
                                             .input = of->input,
                                             .context = of->context};
    return PK_DONE;
}

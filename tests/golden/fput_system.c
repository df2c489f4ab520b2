/* fput_system.c
 *
 * The kernels as pkgen's runtime calls them: fput.c includes this with -DPK_RUNTIME, so that
 * steps may have the kernels inlined.
 *
 * SPDX-License-Identifier: MIT-0
 */
#ifdef PK_RUNTIME
#include "fput_system.h"
#endif

#ifdef fput_kernels_are_here
/* For the runtime, which does not know the type of the parameters. */
static void fput_sys_defaults(void *p)
{
    fput_defaults((struct fput_params *)p);
}

static void fput_sys_derive(void *p, const unsigned char *given)
{
    fput_derive((struct fput_params *)p, given);
}

static int fput_sys_prepare(void *p)
{
    return fput_prepare((struct fput_params *)p);
}

static void fput_sys_bounds(const void *p, pk_real *lo, pk_real *hi)
{
    fput_bounds((const struct fput_params *)p, lo, hi);
}

static void fput_sys_start(const void *p, pk_real *q, pk_real *v)
{
    fput_start((const struct fput_params *)p, q, v);
}

static int fput_sys_acceleration(const void *p, pk_real t, const pk_real *q, const pk_real *v,
                                 const pk_real *u, pk_real *a)
{
    return fput_acceleration((const struct fput_params *)p, t, q, v, u, a);
}

static void fput_sys_force(const void *p, pk_real t, const pk_real *q, const pk_real *v,
                           const pk_real *u, pk_real *f)
{
    fput_force((const struct fput_params *)p, t, q, v, u, f);
}

static void fput_sys_canonical(const void *p, pk_real t, const pk_real *q, const pk_real *v,
                               const pk_real *u, pk_real *momenta, pk_real *pdot)
{
    fput_canonical((const struct fput_params *)p, t, q, v, u, momenta, pdot);
}

static void fput_sys_gradient(const void *p, pk_real t, const pk_real *q, const pk_real *v,
                              const pk_real *u, pk_real *dLdq)
{
    fput_gradient((const struct fput_params *)p, t, q, v, u, dLdq);
}

static pk_real fput_sys_energy(const void *p, pk_real t, const pk_real *q, const pk_real *v,
                               const pk_real *u)
{
    return fput_energy((const struct fput_params *)p, t, q, v, u);
}

static pk_real fput_sys_kinetic(const void *p, pk_real t, const pk_real *q, const pk_real *v,
                                const pk_real *u)
{
    return fput_kinetic((const struct fput_params *)p, t, q, v, u);
}

static pk_real fput_sys_potential(const void *p, pk_real t, const pk_real *q, const pk_real *v,
                                  const pk_real *u)
{
    return fput_potential((const struct fput_params *)p, t, q, v, u);
}

static void fput_sys_sizes(void *p)
{
    fput_sizes((struct fput_params *)p);
}

static size_t fput_sys_count(const void *p)
{
    return fput_count((const struct fput_params *)p);
}

static size_t fput_sys_block_size(const void *p)
{
    return fput_block_size((const struct fput_params *)p);
}

static void fput_sys_attach(void *p, void *block)
{
    fput_attach((struct fput_params *)p, block);
}

static void fput_sys_range(const void *params, enum pk_range_of of, size_t k,
                           struct pk_range *range)
{
    const struct fput_params *p = (const struct fput_params *)params;

    (void)p;
    range->lo = 0;
    range->count = 1;
    range->is_family = 0;
    if (of == PK_OF_COORDINATE && k == 0) {
        range->lo = 1;
        range->count = (size_t)(p->N);
        range->is_family = 1;
    }
}

static void fput_sys_mass(const void *p, pk_real t, const pk_real *q, const pk_real *v,
                          const pk_real *u, pk_real *out)
{
    fput_mass((const struct fput_params *)p, t, q, v, u, out);
}

static void fput_sys_pattern(const void *params, struct pk_pattern *pattern)
{
    fput_slopes_pattern((const struct fput_params *)params, &pattern->rows, &pattern->width,
        &pattern->border);
    pattern->dense = 0;
}

static ptrdiff_t fput_sys_slopes_place(const void *p, size_t i)
{
    return fput_slopes_place((const struct fput_params *)p, i);
}

static void fput_sys_slopes_mass(const void *p, pk_real t, const pk_real *q, const pk_real *v,
                                 const pk_real *u, pk_real *M)
{
    fput_slopes_mass((const struct fput_params *)p, t, q, v, u, M);
}

static void fput_sys_slopes_jacobian(const void *p, pk_real t, const pk_real *q, const pk_real *v,
                                     const pk_real *u, pk_real *p_q, pk_real *pdot_q,
                                     pk_real *pdot_v)
{
    fput_slopes_jacobian((const struct fput_params *)p, t, q, v, u, p_q, pdot_q, pdot_v);
}

static void fput_sys_advance(const void *p, int stages, const pk_real *kick, const pk_real *drift,
                             pk_real t, pk_real h, unsigned long steps, pk_real *q, pk_real *v)
{
    fput_advance((const struct fput_params *)p, stages, kick, drift, t, h, steps, q, v);
}

const struct pk_system fput_system = {
    .abi = PK_ABI,
    .size = sizeof(struct pk_system),
    .scalar = PK_SCALAR,
    .name = "fput",
    .source_hash = fput_source_hash,
    .facts = PK_MASS_CONSTANT | PK_MASS_DIAGONAL | PK_QUADRATIC | PK_SEPARABLE | PK_AUTONOMOUS
        | PK_CONSERVATIVE | PK_VARIATIONAL | PK_SMOOTH,
    .n = 31,
    .n_parameters = 1,
    .n_inputs = 0,
    .n_observed = 0,
    .n_conserved = 0,
    .params_size = sizeof(struct fput_params),
    .coordinates = fput_coordinates,
    .rates = fput_rates,
    .momenta = fput_momentum_names,
    .parameters = fput_parameters,
    .defaults = fput_sys_defaults,
    .derive = fput_sys_derive,
    .prepare = fput_sys_prepare,
    .bounds = fput_sys_bounds,
    .start = fput_sys_start,
    .acceleration = fput_sys_acceleration,
    .force = fput_sys_force,
    .canonical = fput_sys_canonical,
    .gradient = fput_sys_gradient,
    .energy = fput_sys_energy,
    .kinetic = fput_sys_kinetic,
    .potential = fput_sys_potential,
    .families = {.count = fput_sys_count, .n_sizes = 1, .sizes = fput_size_names,
        .set_sizes = fput_sys_sizes, .block_size = fput_sys_block_size, .attach = fput_sys_attach,
        .n_coordinates = 1, .range = fput_sys_range, .advance = fput_sys_advance,
        .diagonal = fput_sys_mass, .pattern = fput_sys_pattern, .place = fput_sys_slopes_place,
        .mass = fput_sys_slopes_mass, .jacobian = fput_sys_slopes_jacobian},
};
#endif

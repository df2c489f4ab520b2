/* thrown_stone_system.c
 *
 * The kernels as pkgen's runtime calls them: thrown_stone.c includes this with -DPK_RUNTIME,
 * so that steps may have the kernels inlined.
 *
 * SPDX-License-Identifier: MIT-0
 */
#ifdef PK_RUNTIME
#include "thrown_stone_system.h"
#endif

#ifdef thrown_stone_kernels_are_here
/* For the runtime, which does not know the type of the parameters. */
static void thrown_stone_sys_defaults(void *p)
{
    thrown_stone_defaults((struct thrown_stone_params *)p);
}

static void thrown_stone_sys_derive(void *p, const unsigned char *given)
{
    thrown_stone_derive((struct thrown_stone_params *)p, given);
}

static int thrown_stone_sys_prepare(void *p)
{
    return thrown_stone_prepare((struct thrown_stone_params *)p);
}

static void thrown_stone_sys_bounds(const void *p, pk_real *lo, pk_real *hi)
{
    thrown_stone_bounds((const struct thrown_stone_params *)p, lo, hi);
}

static void thrown_stone_sys_start(const void *p, pk_real *q, pk_real *v)
{
    thrown_stone_start((const struct thrown_stone_params *)p, q, v);
}

static int thrown_stone_sys_acceleration(const void *p, pk_real t, const pk_real *q,
                                         const pk_real *v, const pk_real *u, pk_real *a)
{
    return thrown_stone_acceleration((const struct thrown_stone_params *)p, t, q, v, u, a);
}

static void thrown_stone_sys_mass(const void *p, pk_real t, const pk_real *q, const pk_real *v,
                                  const pk_real *u, pk_real *M)
{
    thrown_stone_mass((const struct thrown_stone_params *)p, t, q, v, u, M);
}

static void thrown_stone_sys_force(const void *p, pk_real t, const pk_real *q, const pk_real *v,
                                   const pk_real *u, pk_real *f)
{
    thrown_stone_force((const struct thrown_stone_params *)p, t, q, v, u, f);
}

static void thrown_stone_sys_canonical(const void *p, pk_real t, const pk_real *q,
                                       const pk_real *v, const pk_real *u, pk_real *momenta,
                                       pk_real *pdot)
{
    thrown_stone_canonical((const struct thrown_stone_params *)p, t, q, v, u, momenta, pdot);
}

static void thrown_stone_sys_gradient(const void *p, pk_real t, const pk_real *q,
                                      const pk_real *v, const pk_real *u, pk_real *dLdq)
{
    thrown_stone_gradient((const struct thrown_stone_params *)p, t, q, v, u, dLdq);
}

static void thrown_stone_sys_jacobian(const void *p, pk_real t, const pk_real *q,
                                      const pk_real *v, const pk_real *u, pk_real *p_q,
                                      pk_real *pdot_q, pk_real *pdot_v)
{
    thrown_stone_jacobian((const struct thrown_stone_params *)p, t, q, v, u, p_q, pdot_q, pdot_v);
}

static void thrown_stone_sys_linear(const void *p, pk_real t, const pk_real *q, const pk_real *v,
                                    const pk_real *u, const pk_real *a, pk_real *r_q,
                                    pk_real *r_v, pk_real *r_t)
{
    thrown_stone_linear((const struct thrown_stone_params *)p, t, q, v, u, a, r_q, r_v, r_t);
}

static pk_real thrown_stone_sys_energy(const void *p, pk_real t, const pk_real *q,
                                       const pk_real *v, const pk_real *u)
{
    return thrown_stone_energy((const struct thrown_stone_params *)p, t, q, v, u);
}

static pk_real thrown_stone_sys_kinetic(const void *p, pk_real t, const pk_real *q,
                                        const pk_real *v, const pk_real *u)
{
    return thrown_stone_kinetic((const struct thrown_stone_params *)p, t, q, v, u);
}

static pk_real thrown_stone_sys_potential(const void *p, pk_real t, const pk_real *q,
                                          const pk_real *v, const pk_real *u)
{
    return thrown_stone_potential((const struct thrown_stone_params *)p, t, q, v, u);
}

static void thrown_stone_sys_event(const void *p, pk_real t, const pk_real *q, const pk_real *v,
                                   const pk_real *u, pk_real *out)
{
    thrown_stone_event((const struct thrown_stone_params *)p, t, q, v, u, out);
}

static void thrown_stone_sys_switching(const void *p, pk_real t, const pk_real *q,
                                       const pk_real *v, const pk_real *u, pk_real *out)
{
    thrown_stone_switching((const struct thrown_stone_params *)p, t, q, v, u, out);
}

static unsigned long long thrown_stone_sys_lanes(const void *p, const pk_real *t,
                                                 const pk_real *q, const pk_real *v,
                                                 const pk_real *u, pk_real *a)
{
    return thrown_stone_lanes((const struct thrown_stone_params *)p, t, q, v, u, a);
}

static const struct pk_quantity thrown_stone_sys_switches[1] = {
    {"y'", "", ""},
};

static const unsigned char thrown_stone_sys_cyclic[1] = {0};

/* Steps with these kernels inlined, of the families that -DPK_INLINE_ERK and the like ask for. */
#undef PK_MODEL
#define PK_MODEL(x) thrown_stone_##x
#define PK_MODEL_EVENTS 2
#define PK_MODEL_SWITCHES 1
#include <pk/inlined.h>
#undef PK_MODEL_EVENTS
#undef PK_MODEL_SWITCHES

const struct pk_system thrown_stone_system = {
    .abi = PK_ABI,
    .size = sizeof(struct pk_system),
    .scalar = PK_SCALAR,
    .name = "thrown_stone",
    .source_hash = thrown_stone_source_hash,
    .facts = PK_MASS_CONSTANT | PK_MASS_DIAGONAL | PK_QUADRATIC | PK_AUTONOMOUS | PK_SWITCHED,
    .n = 1,
    .n_parameters = 3,
    .n_inputs = 0,
    .n_observed = 0,
    .n_conserved = 0,
    .params_size = sizeof(struct thrown_stone_params),
    .coordinates = thrown_stone_coordinates,
    .rates = thrown_stone_rates,
    .momenta = thrown_stone_momentum_names,
    .parameters = thrown_stone_parameters,
    .cyclic = thrown_stone_sys_cyclic,
    .defaults = thrown_stone_sys_defaults,
    .derive = thrown_stone_sys_derive,
    .prepare = thrown_stone_sys_prepare,
    .bounds = thrown_stone_sys_bounds,
    .start = thrown_stone_sys_start,
    .acceleration = thrown_stone_sys_acceleration,
    .mass = thrown_stone_sys_mass,
    .force = thrown_stone_sys_force,
    .canonical = thrown_stone_sys_canonical,
    .gradient = thrown_stone_sys_gradient,
    .jacobian = thrown_stone_sys_jacobian,
    .energy = thrown_stone_sys_energy,
    .kinetic = thrown_stone_sys_kinetic,
    .potential = thrown_stone_sys_potential,
    .linear = thrown_stone_sys_linear,
    .lanes = thrown_stone_sys_lanes,
    .members = thrown_stone_members,
    .steppers = PK_INLINE_STEPPERS,
    .block_steppers = PK_INLINE_BLOCK_STEPPERS,
    .events = {.n = 2, .table = thrown_stone_events, .values = thrown_stone_sys_event},
    .switches = {.n = 1, .names = thrown_stone_sys_switches,
        .sides = offsetof(struct thrown_stone_params, side_),
        .values = thrown_stone_sys_switching},
};
#endif

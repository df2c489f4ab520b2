/* A pendulum, of g, and a spring, of `limit`, that know nothing of each other: the whole has no
 * more kernels than rows, drifts and the report ask of it. /
 */
#include <pk/subsystems.h>

#include "systems_make.h"

POINT_MASS(spring, LIMIT(params) * q[0] * q[0] / 2, -LIMIT(params) * q[0], -LIMIT(params), 0)
SIZES(spring, 1, 0)
#undef PK_MODEL
#define PK_MODEL(x) spring_##x
#include <pk/inlined.h>
SYSTEM(spring, 1, NATURAL | PK_AFFINE, PK_C(1.0), PK_C(1.0), none_cyclic, LIST(0), LIST(1),
       .linear = spring_linear);

static void pair_defaults(void *params)
{
    pendulum_system.defaults(params);
    ((struct test_params *)params)->limit = 400;
}
static void pair_start(const void *params, pk_real *q, pk_real *v)
{
    pendulum_system.start(params, q, v);
    q[1] = PK_C(0.5);
    v[1] = 0;
}
static void pair_canonical(ARGS, pk_real *p, pk_real *pdot)
{
    UNUSED;
    p[0] = v[0], p[1] = v[1];
    pdot[0] = -G(params) * PK_F(sin)(q[0]);
    pdot[1] = -LIMIT(params) * q[1];
}
static pk_real pair_energy(ARGS)
{
    UNUSED;
    return (v[0] * v[0] + v[1] * v[1] + LIMIT(params) * q[1] * q[1]) / 2 -
           G(params) * PK_F(cos)(q[0]);
}
const struct pk_system pair_system = {.abi = PK_ABI,
                                      .name = "pair",
                                      .source_hash = "by hand",
                                      .facts = NATURAL,
                                      .n = 2,
                                      .n_parameters = 2,
                                      .params_size = sizeof(struct test_params),
                                      .coordinates = coordinates,
                                      .rates = rates,
                                      .momenta = momenta,
                                      .cyclic = none_cyclic,
                                      .parameters = parameters,
                                      .defaults = pair_defaults,
                                      .derive = derive,
                                      .prepare = prepare,
                                      .bounds = bounds,
                                      .start = pair_start,
                                      .canonical = pair_canonical,
                                      .energy = pair_energy};

static const size_t first[] = {0}, second[] = {1};
const struct pk_part pair_parts[] = {{&pendulum_system, first}, {&spring_system, second}};

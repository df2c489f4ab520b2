/* A system of systems.h that is not of second degree in the rates, with a constraint: a
 * relativistic charge on a unit rod in a magnetic field, L = -sqrt(1 - v^2) + limit/2 (x y' - y x')
 * - g y.
 */
#include "systems_bound.h"

static const struct pk_quantity swift_names[] = {NAMED("x"), NAMED("y")};
static const struct pk_quantity swift_constraints[] = {NAMED("lambda_rod")};
static pk_real gamma_of(const pk_real *v) { return 1 / PK_F(sqrt)(1 - v[0] * v[0] - v[1] * v[1]); }
static void swift_inertia(ARGS, pk_real *M)
{
    const pk_real c = gamma_of(v);
    UNUSED;
    for (size_t i = 0; i < 2; i++)
        for (size_t k = 0; k < 2; k++)
            M[2 * i + k] = c * c * c * v[i] * v[k] + (i == k ? c : 0);
}
static void swift_drift(ARGS, pk_real *f)
{
    UNUSED;
    f[0] = LIMIT(params) * v[1];
    f[1] = -G(params) - LIMIT(params) * v[0];
}
static void swift_unconstrained(ARGS, pk_real *p, pk_real *pdot)
{
    const pk_real c = gamma_of(v), b = LIMIT(params) / 2;
    UNUSED;
    p[0] = c * v[0] - b * q[1], p[1] = c * v[1] + b * q[0];
    pdot[0] = b * v[1], pdot[1] = -G(params) - b * v[0];
}
UNIT_ROD(swift)
static pk_real swift_energy(ARGS)
{
    UNUSED;
    return gamma_of(v) + G(params) * q[1];
}
BOUND(swift, 2, 2, 0, 1, PK_AUTONOMOUS | PK_SMOOTH | PK_CONSERVATIVE | PK_VARIATIONAL, PK_C(1.0),
      PK_C(5.0), LIST(PK_C(0.6), PK_C(-0.8)), LIST(PK_C(0.4), PK_C(0.3)),
      .constraints.n_holonomic = 1, .constraints.names = swift_constraints,
      .constraints.values = swift_constraint, .constraints.scale = swift_terms);

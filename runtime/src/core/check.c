/* Checks before the first step, so that no result comes from bad arguments: options out of range,
 * parameters out of bounds or changed without prepare(). A change without prepare() is detected by
 * preparing a copy of the parameters, which must equal the original bit by bit. */
#include <limits.h>
#include <string.h>

#include "internal.h"

size_t pk_params_reals(const struct pk_system *system)
{
    return (system->params_size + sizeof(pk_real) - 1) / sizeof(pk_real);
}

size_t pk_refused_parameter(const struct pk_system *system, int outside)
{
    if (PK_FAILURE(outside) == PK_FAILURE_PARAMETER)
        return (size_t)PK_FAILURE_AT(outside);
    return system->n_parameters + (PK_FAILURE(outside) == PK_FAILURE_SIZE);
}

enum pk_status pk_check_params(struct pk_integrator *it, pk_real *scratch)
{
    const struct pk_system *system = it->problem.system;
    if (!system->prepare || !system->params_size)
        return PK_DONE;
    memcpy(scratch, it->problem.params, system->params_size);
    const int outside = system->prepare(scratch);
    if (outside)
        return pk_fail_with(it, PK_OUT_OF_BOUNDS,
                            PK_WHY(.index = pk_refused_parameter(system, outside)));
    return memcmp(scratch, it->problem.params, system->params_size)
               ? pk_fail(it, PK_BAD_ARGUMENT, BAD_PARAMS)
               : PK_DONE;
}

unsigned pk_missing_facts(const struct pk_system *system, const struct pk_method *method)
{
    unsigned facts = system->facts;
    /* in this list each fact implies the next one */
    facts |= facts & PK_SEPARABLE ? PK_LINEAR_DRAG : 0;
    facts |= facts & PK_LINEAR_DRAG ? PK_AFFINE_RATES : 0;
    const unsigned missing = method->needs & ~facts;
    return system->facts & PK_SWITCHED ? missing & ~(unsigned)PK_SMOOTH : missing;
}

int pk_sides_missing(const struct pk_integrator *it)
{
    const struct pk_system *system = it->problem.system;
    if (!system->switches.impulses && !(it->method->needs & ~system->facts & PK_SMOOTH))
        return 0;
    const void *const at = (const char *)it->problem.params + system->switches.sides;
    const pk_real *side = system->switches.count ? *(pk_real *const *)at : (const pk_real *)at;
    const size_t count = pk_system_switch_count(system, it->problem.params);
    for (size_t k = 0; k < count; k++)
        if (side[k] >= 0 && side[k] <= 0)
            return 1;
    return 0;
}

const char *pk_missing_kernel(const struct pk_system *system, const struct pk_method *method)
{
    const int turns = system->n_rotations > 0, c = system->constraints.n > 0;
    const int loops = system->constraints.factor != NULL;
    /* Systems with rotations or constraints have momenta only in the kernel `unconstrained`. */
    const unsigned own = turns || c ? PK_HOLONOMIC : 0, plain = turns || c ? 0 : PK_HOLONOMIC;
    const struct {
        const char *name;
        unsigned traits;
        int there;
    } kernels[] = {
        {"constraint_jacobian", c ? ~0u : 0, system->constraints.jacobian || loops},
        {"mass", c && loops ? PK_HOLONOMIC : 0, system->constraints.pull != NULL},
        {"residual_scale", c ? ~0u : 0, system->constraints.scale != NULL},
        {"constraint", c && system->constraints.n_holonomic ? ~0u : 0,
         system->constraints.values != NULL},
        {"redundant", system->constraints.n_redundant ? ~0u : 0,
         system->constraints.redundant != NULL},
        {"inertia",
         loops ? 0
         : c   ? ~0u
               : own,
         system->inertia != NULL},
        {"unconstrained", own, system->unconstrained != NULL},
        {"acceleration", ~0u, system->acceleration != NULL},
        {"canonical", PK_JACOBIANS, system->canonical != NULL},
        {"canonical", plain, system->canonical || system->unconstrained},
        {"jacobian", PK_JACOBIANS, system->jacobian || system->families.jacobian},
        {"fast", method->needs & PK_FAST ? ~0u : 0, system->fast != NULL},
        {"linear", PK_LINEAR, system->linear != NULL},
        {"jet", PK_JETS, PK_SYSTEM_HAS(system, jet)},
        {"mass", PK_LINEAR | plain, system->mass || system->families.diagonal},
        {"mass", PK_JACOBIANS, system->mass || system->families.mass},
    };
    for (size_t i = 0; i < sizeof kernels / sizeof *kernels; i++)
        if (!kernels[i].there && (kernels[i].traits == ~0u || method->traits & kernels[i].traits))
            return kernels[i].name;
    return NULL;
}

enum pk_status pk_check_options(struct pk_integrator *it)
{
    const struct pk_options *o = &it->options;
    const int adaptive = (it->method->traits & PK_ADAPTIVE) != 0;
    if (!pk_finite(o->h) || o->h < 0 || (!adaptive && !(o->h > 0)))
        return pk_fail(it, PK_BAD_ARGUMENT, BAD_STEP);
    if (!(o->h_min >= 0) || !(o->h_max >= 0) || (o->h_max > 0 && !(o->h_min <= o->h_max)))
        return pk_fail(it, PK_BAD_ARGUMENT, BAD_STEP);
    const int relative = o->atol >= PK_ATOL_OF_MOTION && o->atol <= PK_ATOL_OF_MOTION;
    const pk_real atol = relative ? 0 : o->atol;
    if (adaptive &&
        (!(o->rtol >= 0) || !(atol >= 0) || !(o->rtol + atol > 0) || !pk_finite(o->rtol + atol)))
        return pk_fail(it, PK_BAD_ARGUMENT, BAD_TOLERANCE);
    /* newton_tol must be < 1, since a relative correction of 1 would mean no convergence at all. */
    if (!(o->newton_tol >= 0 && o->newton_tol < 1) || o->max_iterations < 0 ||
        o->max_iterations == INT_MAX ||
        (o->iteration != PK_NEWTON && o->iteration != PK_FIXED_POINT))
        return pk_fail(it, PK_BAD_ARGUMENT, BAD_ITERATION);
    return PK_DONE;
}

/* pkgen's kernels. -DARM_HEADER: the model's header; -DARM: its name; -DARM_HAS_...: which kernels
 * it was made with. */
#include ARM_HEADER
#include "arm.h"

#define NAMED_(model, end) model##end
#define NAMED(model, end) NAMED_(model, end)

static struct NAMED(ARM, _params) params;

int arm_open(const char *file, const char *word)
{
    (void)file, (void)word; /* the parameters' defaults are the arm's */
    NAMED(ARM, _defaults)(&params);
    return NAMED(ARM, _prepare)(&params);
}

int arm_evaluate(enum arm_what what, const double *q, const double *v, double *out)
{
#ifdef ARM_HAS_ACCELERATION
    if (what == ARM_ACCELERATION) return NAMED(ARM, _acceleration)(&params, 0, q, v, NULL, out);
#else
    if (what == ARM_MASS) return NAMED(ARM, _mass)(&params, 0, q, v, NULL, out), 0;
    if (what == ARM_FORCE) return NAMED(ARM, _force)(&params, 0, q, v, NULL, out), 0;
#endif
    return 1;
}

/* Values at one state; u are the inputs. The functions return 0 if the value does not exist. */
#include <math.h>

#include "live.h"

int EXPORT(live_outputs)(const void *params, double t, const double *q, const double *v,
                         const double *u, double *out)
{
    if (!live_system->observe)
        return 0;
    live_system->observe(params, t, q, v, u, out);
    return 1;
}

int EXPORT(live_claims)(const void *params, double t, const double *q, const double *v,
                        const double *u, double *out)
{
    if (!live_system->conserve)
        return 0;
    live_system->conserve(params, t, q, v, u, out);
    return 1;
}

double EXPORT(live_energy)(const void *params, double t, const double *q, const double *v,
                           const double *u)
{
    return live_system->energy ? live_system->energy(params, t, q, v, u) : (double)NAN;
}

int EXPORT(live_acceleration)(const void *params, double t, const double *q, const double *v,
                              const double *u, double *out)
{
    return !live_system->acceleration(params, t, q, v, u, out);
}

/* Writes the n momenta to `out`; `rest` is scratch memory for n numbers. */
int EXPORT(live_momenta)(const void *params, double t, const double *q, const double *v,
                         const double *u, double *out, double *rest)
{
    pk_kernel_2 *const kernel = live_system->unconstrained ? live_system->unconstrained
                                                           : live_system->canonical;
    if (!kernel)
        return 0;
    kernel(params, t, q, v, u, out, rest);
    return 1;
}

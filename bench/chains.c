/* What bench/chains.py times, beside the generated chain.c: the same work by other means. */
#include <stddef.h>

#include "chain.h"

typedef int force_callback(const struct chain_params *p, double t, const double *q,
                           const double *v, const double *u, double *a);

void chains_verlet(const struct chain_params *p, double h, long steps, double *q, double *v)
{
    chain_verlet(p, 0, h, (unsigned long)steps, q, v);
}

/* One pass over memory a step: q and v read and written once, and next to nothing computed. */
void chains_roofline(long n, double h, long steps, double *restrict q, double *restrict v)
{
    for (long s = 0; s < steps; s++)
        for (long i = 0; i < n; i++) {
            const double x = q[i], y = v[i];
            q[i] = x + h * y;
            v[i] = y - h * x;
        }
}

/* Velocity Verlet as a library does it that knows a callback for the acceleration alone. */
void chains_callback(const struct chain_params *p, double h, long steps, double *restrict q,
                     double *restrict v, double *restrict a)
{
    force_callback *volatile given = chain_acceleration;
    force_callback *const acceleration = given;
    const long n = (long)chain_count(p);

    acceleration(p, 0, q, v, NULL, a);
    for (long s = 0; s < steps; s++) {
        for (long i = 0; i < n; i++)
            v[i] += h / 2 * a[i];
        for (long i = 0; i < n; i++)
            q[i] += h * v[i];
        acceleration(p, 0, q, v, NULL, a);
        for (long i = 0; i < n; i++)
            v[i] += h / 2 * a[i];
    }
}

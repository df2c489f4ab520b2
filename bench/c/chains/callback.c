/* A library's way: velocity Verlet that knows the system as a force callback, three passes. */
#include "chain.h"

#include <stdlib.h>

typedef void force_function(size_t n, const double *q, double *a);
extern force_function fput_force; /* a file of its own: nothing to inline */

static size_t n;
static double h, *q, *v, *a;
static force_function *volatile force = fput_force;

const char *chain_open(size_t n_, double h_, double *q_, double *v_)
{
    n = n_, h = h_, q = q_, v = v_;
    a = malloc(n * sizeof *a);
    if (!a) return "no memory";
    force(n, q, a);
    return NULL;
}

const char *chain_run(unsigned long steps)
{
    for (unsigned long k = 0; k < steps; k++) {
        for (size_t i = 0; i < n; i++) v[i] += h / 2 * a[i], q[i] += h * v[i];
        force(n, q, a);
        for (size_t i = 0; i < n; i++) v[i] += h / 2 * a[i];
    }
    return NULL;
}

double chain_at(size_t i) { return q[i]; }

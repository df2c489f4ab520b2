/* What probe.c and misused.c share. */
#ifndef PROBE_H
#define PROBE_H

#include <pk/pk.h>

struct probe {
    struct pk_problem problem;
    const struct pk_method *method;
    struct pk_options options;
    struct pk_integrator it;
    size_t n;
    void *params, *families, *block;
    double *q, *v; /* the model's start; two more of n for misused.c */
};

double probe_energy(const struct probe *p, double t, const double *q, const double *v);

#endif

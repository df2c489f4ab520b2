/* Steps that the runtime refuses or does not have, kept in test code to show what they do. They use
 * the model's own acceleration. */
#include <math.h>
#include <string.h>

#include "probe.h"

enum { MOST = 64 };

static void acceleration(const struct probe *p, double t, const double *q, const double *v,
                         double *a)
{
    p->problem.system->acceleration(p->params, t, q, v, NULL, a);
}

/* Velocity Verlet as for a constant mass matrix, where M depends on q and so a on v: the end of the
 * kick takes a at the new position and at rates foreseen by the old one. Returns the energy at the
 * end less the first; q and v are moved. */
double misused_verlet(const struct probe *p, double h, size_t steps, double *q, double *v)
{
    const size_t n = p->n;
    double a[MOST], b[MOST], foreseen[MOST];
    const double first = probe_energy(p, 0, q, v);
    acceleration(p, 0, q, v, a);
    for (size_t k = 0; k < steps; k++) {
        for (size_t i = 0; i < n; i++) {
            q[i] += h * v[i] + h * h / 2 * a[i];
            foreseen[i] = v[i] + h * a[i];
        }
        acceleration(p, 0, q, foreseen, b);
        for (size_t i = 0; i < n; i++)
            v[i] += h / 2 * (a[i] + b[i]);
        acceleration(p, 0, q, v, a);
    }
    return probe_energy(p, 0, q, v) - first;
}

/* Verlet with the step h = eta r^1.5 chosen from the start of each: of the plane, to t_end. */
double misused_variable(const struct probe *p, double eta, double t_end, double *q, double *v)
{
    double a[MOST], worst = 0, t = 0;
    const double first = probe_energy(p, 0, q, v);
    while (t < t_end) {
        const double h = eta * pow(hypot(q[0], q[1]), 1.5);
        acceleration(p, t, q, v, a);
        for (size_t i = 0; i < p->n; i++) {
            v[i] += h / 2 * a[i];
            q[i] += h * v[i];
        }
        acceleration(p, t, q, v, a);
        for (size_t i = 0; i < p->n; i++)
            v[i] += h / 2 * a[i];
        t += h;
        worst = fmax(worst, fabs(probe_energy(p, t, q, v) - first));
    }
    return worst;
}

/* Verlet without compensated sums. */
void plain_verlet(const struct probe *p, double h, size_t steps, double *q, double *v)
{
    const size_t n = p->n;
    double a[MOST];
    acceleration(p, 0, q, v, a);
    for (size_t k = 0; k < steps; k++) {
        for (size_t i = 0; i < n; i++) {
            v[i] += h / 2 * a[i];
            q[i] += h * v[i];
        }
        acceleration(p, 0, q, v, a);
        for (size_t i = 0; i < n; i++)
            v[i] += h / 2 * a[i];
    }
}

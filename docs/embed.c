/* A double pendulum in a program of one's own: the generated C, twenty lines, and libm. */
#include <stdio.h>

#include "double_pendulum.h"

int main(void)
{
    struct double_pendulum_params p;
    double_pendulum_defaults(&p);
    p.l2 = 0.5;
    if (double_pendulum_prepare(&p) != 0) return 1; /* a parameter is outside its bounds */

    double q[2], v[2], a[2];
    double_pendulum_start(&p, q, v);
    const double h = 1e-4;
    for (int k = 0; k < 10000; k++) { /* the explicit midpoint rule */
        if (double_pendulum_acceleration(&p, k * h, q, v, NULL, a) != 0) return 1;
        const double qm[2] = {q[0] + h / 2 * v[0], q[1] + h / 2 * v[1]};
        const double vm[2] = {v[0] + h / 2 * a[0], v[1] + h / 2 * a[1]};
        if (double_pendulum_acceleration(&p, (k + 0.5) * h, qm, vm, NULL, a) != 0) return 1;
        for (int i = 0; i < 2; i++) q[i] += h * vm[i], v[i] += h * a[i];
    }
    printf("%.6f %.6f %.6f\n", q[0], q[1], double_pendulum_energy(&p, 1.0, q, v, NULL));
    return 0;
}

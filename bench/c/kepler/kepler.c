/* The energy of a Kepler orbit of eccentricity 0.6 over many periods, by gauss8 at a fixed step.
 *
 * Usage: kepler PERIODS STEPS_A_PERIOD ANGLE; the start is turned by ANGLE, which
 * changes nothing but the rounding. Prints lines "periods relative-energy-error", sampled evenly in
 * the logarithm of time, at whole steps. The energy is computed in long double: in double its own
 * rounding would be a part of what is measured.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include <pk/pk.h>

#include "kepler.h"

static long double energy(const double *q, const double *v)
{
    const long double x = q[0], y = q[1], vx = v[0], vy = v[1];
    return (vx * vx + vy * vy) / 2 - 1 / sqrtl(x * x + y * y);
}

int main(int argc, char **argv)
{
    if (argc != 4) return 2;
    const double periods = strtod(argv[1], NULL), steps = strtod(argv[2], NULL);
    const double angle = strtod(argv[3], NULL), c = cos(angle), s = sin(angle);
    const double q[2] = {0.4 * c, 0.4 * s}, v[2] = {-2 * s, 2 * c};
    const double period = 6.283185307179586;
    struct kepler_params params;
    kepler_defaults(&params);
    struct pk_problem problem = {.system = &kepler_system, .params = &params};
    const struct pk_method *method = pk_method_find("gauss8");
    if (!method) return 3;
    struct pk_options options = pk_options_default();
    options.h = period / steps;
    const size_t size = pk_integrator_size(&problem, method);
    void *block = malloc(size);
    struct pk_integrator it;
    if (!block || pk_integrator_init(&it, &problem, method, &options, 0, q, v, block, size) < 0)
        return 1;
    const long double first = energy(q, v);
    double sample = 10 * steps;
    for (double k = 1; k <= periods * steps; k++) {
        if (pk_integrator_step(&it, 1e12) < 0) return 1;
        if (k >= sample) {
            printf("%.6g %.6Le\n", k / steps, (energy(it.q, it.v) - first) / first);
            sample *= 1.3335214321633240; /* eight a decade */
        }
    }
    printf("%.6g %.6Le\n", periods, (energy(it.q, it.v) - first) / first);
    free(block);
    return 0;
}

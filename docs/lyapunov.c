/* The largest Lyapunov exponent of a model, in a program of one's own; see docs/diagnostics.md. */
#include <stdio.h>
#include <stdlib.h>

#include <pk/pk.h>

#include "double_pendulum.h"

int main(void)
{
    struct double_pendulum_params params;
    const double q[2] = {2, 2}, v[2] = {0, 0};
    double_pendulum_system.defaults(&params);

    struct pk_problem problem = {.system = &double_pendulum_system, .params = &params};
    const struct pk_method *method = pk_method_find("dop853");
    struct pk_options options = pk_options_default();

    struct pk_lyapunov l;
    size_t size = pk_lyapunov_size(&problem, method);
    void *block = malloc(size);
    pk_lyapunov_init(&l, &problem, method, &options, 0, q, v, 0.5, block, size);
    for (int k = 0; k < 1000; k++) /* blocks of .5 s */
        if (pk_lyapunov_step(&l) < 0) { /* a refusal by init stands, and shows here */
            char reason[200];
            pk_integrator_reason(&l.it, reason, sizeof reason);
            fprintf(stderr, "%s\n", reason);
            return 1;
        }
    double error, exponent = pk_lyapunov_exponent(&l, &error);
    printf("%.3f +- %.3f, megno %.1f: %s\n", exponent, error, pk_lyapunov_megno(&l),
           pk_lyapunov_motion(&l) == PK_CHAOTIC ? "chaotic" : "not chaotic");
    free(block);
    return 0;
}

/* In float: t after 200,000 steps of .001, as a loop of one's own has it, and the runtime's. */
#include <stdio.h>

#include <pk/pk.h>

#include "far.h"

int main(void)
{
    static unsigned char block[100000];
    struct far_params params;
    pk_real q[1] = {0}, v[1] = {1}, t = 0;
    far_defaults(&params);
    far_prepare(&params);
    const struct pk_problem problem = {.system = &far_system, .params = &params};
    struct pk_options options = pk_options_default();
    options.h = (pk_real)0.001;
    struct pk_integrator it;
    if (pk_integrator_init(&it, &problem, pk_method_find("verlet"), &options, 0, q, v, block,
                           sizeof block))
        return 1;
    for (int i = 0; i < 200000; i++) {
        t += options.h;
        pk_integrator_step(&it, 1000);
    }
    printf("%.9g %.9g\n", (double)t, (double)it.t);
    return 0;
}

/* The controller of models/controlled/two_joint_pid.lag in firmware: its generated C and libm. The
 * arm itself stands in for the machine, by steps of a millisecond between two samples. */
#include <stdio.h>

#include "two_joint_pid.h"

enum { INPUTS = two_joint_pid_INPUTS, STEPS = 10 };

int main(void)
{
    struct two_joint_pid_params p;
    two_joint_pid_defaults(&p);
    if (two_joint_pid_prepare(&p) != 0) return 1;

    double q[2], v[2], a[2], times[2], u[INPUTS] = {0}, next[INPUTS];
    two_joint_pid_start(&p, q, v);
    two_joint_pid_sampling(&p, 0, q, v, u, times, next); /* times: T and T0; next: memory at first */
    for (int i = 0; i < INPUTS; i++) u[i] = next[i];

    for (int k = 0; k < 200; k++) { /* the timer's interrupt, every T */
        two_joint_pid_pid_sample(&p, k * times[0], q, v, u, next);
        for (int i = 0; i < INPUTS; i++) u[i] = next[i];
        for (int n = 0; n < STEPS; n++) { /* the machine: u are its torques */
            if (two_joint_pid_acceleration(&p, 0, q, v, u, a) != 0) return 1;
            for (int i = 0; i < 2; i++) v[i] += times[0] / STEPS * a[i];
            for (int i = 0; i < 2; i++) q[i] += times[0] / STEPS * v[i];
        }
    }
    printf("%.6f %.6f\n", q[0], q[1]);
    return 0;
}

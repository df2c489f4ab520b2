/* No kernel, but what any would seem to need: sine and cosine of two angles, and a division. */
#include "kernel.h"

KERNEL_WIDTH(1);

int KERNEL(const double *q, const double *v, double *a)
{
    const double s = sin(q[0]) * cos(q[1]), c = cos(q[0]) * sin(q[1]);

    a[0] = (s + v[0]) / (2 - c);
    a[1] = s + c + v[1];
    return 0;
}

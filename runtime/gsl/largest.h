/* The largest number of an array. Not installed. */
#ifndef PK_GSL_LARGEST_H
#define PK_GSL_LARGEST_H

#include <math.h>
#include <stddef.h>

/* Returns the largest |x_i|. */
static inline double largest(const double *x, size_t count)
{
    double most = 0;
    for (size_t i = 0; i < count; i++)
        most = fmax(most, fabs(x[i]));
    return most;
}

#endif

/* Types of a system's tables: named quantities and kernels. */
#ifndef PK_KERNEL_H
#define PK_KERNEL_H

#include <stddef.h>

#include <pk/begin.h>
#include <pk/real.h>

PK_BEGIN

/* A named quantity as its author declared it. `unit` is in SI units, "" if it has none. */
struct pk_quantity {
    const char *name;
    const char *unit;
    const char *description;
};

/* Writes `out` at (t, q, v, u). */
typedef void pk_kernel(const void *params, pk_real t, const pk_real *q, const pk_real *v,
                       const pk_real *u, pk_real *out);
/* Does the same at the acceleration a. */
typedef void pk_kernel_moving(const void *params, pk_real t, const pk_real *q, const pk_real *v,
                              const pk_real *u, const pk_real *a, pk_real *out);
/* Does the same with two output arrays. */
typedef void pk_kernel_2(const void *params, pk_real t, const pk_real *q, const pk_real *v,
                         const pk_real *u, pk_real *out, pk_real *second);
/* Does the same with three output arrays. */
typedef void pk_kernel_3(const void *params, pk_real t, const pk_real *q, const pk_real *v,
                         const pk_real *u, pk_real *out, pk_real *second, pk_real *third);
/* Returns one number, computed at (t, q, v, u). */
typedef pk_real pk_kernel_number(const void *params, pk_real t, const pk_real *q, const pk_real *v,
                                 const pk_real *u);

PK_END

#endif

/* What an ensemble's program defines, and what main.c does with it: RK4 steps of many double
 * pendulums, each with its own start, one process a turn.
 *
 * Usage: PROGRAM MEMBERS STEPS H THREADS; prints nanoseconds of a member's step, then the final
 * q, q' of the first members, so that the caller sees that all computed the same.
 */
#ifndef BENCH_ENSEMBLE_H
#define BENCH_ENSEMBLE_H

#include <stddef.h>

#ifdef BENCH_FLOAT
typedef float real;
#else
typedef double real;
#endif

enum { DOF = 2 };

/* q[DOF * i], v[DOF * i] of member i, in place. NULL, or what went wrong. */
const char *ensemble_run(size_t members, unsigned long steps, double h, int threads, real *q,
                         real *v);

#endif

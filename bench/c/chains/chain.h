/* What a chain's program defines; main.c times it. Velocity Verlet on the FPUT chain, beta form,
 * m = k = 1, beta = 0.25, walls at both ends.
 *
 * Usage: PROGRAM N STEPS H; prints nanoseconds of a mass-step, then q at three places.
 */
#ifndef BENCH_CHAIN_H
#define BENCH_CHAIN_H

#include <stddef.h>

/* Once, before chain_run(); q and v are the start. NULL, or what went wrong. */
const char *chain_open(size_t n, double h, double *q, double *v);
/* `steps` further steps. */
const char *chain_run(unsigned long steps);
/* The present q[i]. */
double chain_at(size_t i);

#endif

/* See ensemble.h. */
#define _POSIX_C_SOURCE 200809L

#include "ensemble.h"

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { SHOWN = 8 };

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Starts on a lattice about (1.3, -0.9, 0.2, 0.4): the same in every program. */
static void set_starts(size_t members, real *q, real *v)
{
    for (size_t i = 0; i < members; i++) {
        q[2 * i] = (real)(1.3 + 0.002 * (double)(i % 101));
        q[2 * i + 1] = (real)(-0.9 + 0.003 * (double)(i % 89));
        v[2 * i] = (real)(0.2 + 0.004 * (double)(i % 83));
        v[2 * i + 1] = (real)(0.4 - 0.005 * (double)(i % 79));
    }
}

int main(int argc, char **argv)
{
    if (argc != 5) return 2;
    const size_t members = strtoul(argv[1], NULL, 10);
    const unsigned long steps = strtoul(argv[2], NULL, 10);
    const double h = strtod(argv[3], NULL);
    real *q = malloc(DOF * members * sizeof *q), *v = malloc(DOF * members * sizeof *v);

    if (!q || !v) return 1;
    set_starts(members, q, v);
    const char *trouble = ensemble_run(members, 1, h, atoi(argv[4]), q, v); /* warm */
    set_starts(members, q, v);
    const double begin = now();
    if (!trouble) trouble = ensemble_run(members, steps, h, atoi(argv[4]), q, v);
    const double took = now() - begin;
    if (trouble) {
        fprintf(stderr, "%s\n", trouble);
        return 1;
    }
    printf("%.6f", 1e9 * took / ((double)members * (double)steps));
    for (size_t i = 0; i < SHOWN && i < members; i++)
        printf(" %.9g %.9g %.9g %.9g", (double)q[2 * i], (double)q[2 * i + 1], (double)v[2 * i],
               (double)v[2 * i + 1]);
    printf("\n");
    return 0;
}

/* See chain.h. */
#define _POSIX_C_SOURCE 200809L

#include "chain.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

int main(int argc, char **argv)
{
    if (argc != 4) return 2;
    const size_t n = strtoul(argv[1], NULL, 10);
    const unsigned long steps = strtoul(argv[2], NULL, 10);
    const size_t bytes = (n * sizeof(double) + 63) / 64 * 64; /* aligned: as pkgen's are */
    double *q = aligned_alloc(64, bytes), *v = aligned_alloc(64, bytes);

    if (!q || !v) return 1;
    for (size_t i = 0; i < n; i++) q[i] = sin(3.141592653589793 * (double)(i + 1) / (double)(n + 1)), v[i] = 0;
    const char *trouble = chain_open(n, strtod(argv[3], NULL), q, v);
    if (!trouble) trouble = chain_run(2); /* warm: pages, caches */
    const double begin = now();
    if (!trouble) trouble = chain_run(steps);
    const double took = now() - begin;
    if (trouble) {
        fprintf(stderr, "%s\n", trouble);
        return 1;
    }
    printf("%.6f %.12g %.12g %.12g\n", 1e9 * took / ((double)n * (double)steps), chain_at(n / 7),
           chain_at(n / 3), chain_at(n - 1));
    return 0;
}

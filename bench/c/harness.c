/* See harness.h. */
#define _POSIX_C_SOURCE 200809L

#include "harness.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { LONGEST = 64 };

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int read_numbers(double *x, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (scanf("%lf", &x[i]) != 1) return 0;
    return 1;
}

/* Mean time of an integration. The clock is read once a block of runs, so its cost is small. */
static const char *timed(double setting, double t_end, double seconds, const double *y0, double *y,
                         double *mean)
{
    const size_t bytes = bench_length * sizeof *y;
    const char *trouble;
    double elapsed = 0;
    unsigned long done = 0, block = 1;

    do {
        const double begin = now();
        for (unsigned long k = 0; k < block; k++) {
            memcpy(y, y0, bytes);
            if ((trouble = bench_integrate(setting, y, t_end)) != NULL) return trouble;
        }
        const double took = now() - begin;
        elapsed += took;
        done += block;
        if (took < seconds / 8) block *= 2;
    } while (elapsed < seconds);
    *mean = elapsed / (double)done;
    return NULL;
}

int main(int argc, char **argv)
{
    double request[3], y0[LONGEST], y[LONGEST], mean;
    const char *trouble = bench_open(argc, argv);

    if (trouble) {
        printf("failed %s\n", trouble);
        return 1;
    }
    printf("ready\n");
    fflush(stdout);
    while (read_numbers(request, 3) && read_numbers(y0, bench_length)) {
        trouble = bench_prepare(request[0], y0, request[1]);
        if (!trouble) trouble = timed(request[0], request[1], request[2], y0, y, &mean);
        if (trouble) {
            printf("failed %s\n", trouble);
        } else {
            printf("%.9e", mean);
            for (size_t i = 0; i < bench_length; i++) printf(" %.17g", y[i]);
            printf("\n");
        }
        fflush(stdout);
    }
    return 0;
}

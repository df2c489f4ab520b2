/* Nanoseconds of one evaluation of an arm's dynamics, by the way that it is linked with.
 * Each evaluation is a call, of another state than the one before.
 *
 * Usage: arm acceleration|mass|force N FILE WORD SECONDS; prints nanoseconds, then the numbers of the
 * first states, so that the caller sees that all compute the same. SECONDS 0: the numbers alone.
 */
#define _POSIX_C_SOURCE 200809L

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "arm.h"

enum { STATES = 64, SHOWN = 3 };

volatile double sink;

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Between -1 and 1, the same everywhere. */
static double drawn(void)
{
    static unsigned long long state = 2385;
    state = state * 6364136223846793005ull + 1442695040888963407ull;
    return (double)(state >> 11) / 4503599627370496.0 - 1;
}

static double *numbers(size_t count)
{
    double *made = malloc(count * sizeof *made);
    if (!made) exit(2);
    return made;
}

static double measured(enum arm_what what, size_t n, const double *q, const double *v, double *out,
                       double seconds)
{
    double sum = 0, begin = now(), elapsed;
    unsigned long done = 0;

    do {
        for (size_t k = 0; k < STATES; k++) {
            if (arm_evaluate(what, q + k * n, v + k * n, out)) exit(1);
            sum += out[0];
        }
        done += STATES;
        elapsed = now() - begin;
    } while (elapsed < seconds);
    sink = sum;
    return 1e9 * elapsed / (double)done;
}

int main(int argc, char **argv)
{
    static const char *const names[] = {"acceleration", "mass", "force"};
    if (argc != 6) return 2;
    const size_t n = (size_t)atol(argv[2]);
    const double seconds = atof(argv[5]);
    int what = 0;
    while (what < 3 && strcmp(names[what], argv[1])) what++;
    if (what == 3 || n < 1 || arm_open(argv[3], argv[4])) return 2;

    const size_t count = what == ARM_MASS ? n * n : n;
    double *q = numbers(STATES * n), *v = numbers(STATES * n), *out = numbers(count);
    for (size_t i = 0; i < STATES * n; i++) {
        q[i] = 3 * drawn();
        v[i] = 2 * drawn();
    }
    if (seconds > 0) measured((enum arm_what)what, n, q, v, out, seconds / 4); /* warm */
    printf("%.17g", seconds > 0 ? measured((enum arm_what)what, n, q, v, out, seconds) : 0.0);
    for (size_t k = 0; k < SHOWN; k++) {
        if (arm_evaluate((enum arm_what)what, q + k * n, v + k * n, out)) return 1;
        for (size_t i = 0; i < count; i++) printf(" %.17g", out[i]);
    }
    printf("\n");
    free(q), free(v), free(out);
    return 0;
}

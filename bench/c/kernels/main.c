/* Nanoseconds of one evaluation of each kernel of the double pendulum, the kernels in turns.
 * -DKERNELS lists them as X(name) X(name) ...; each is a file of its own, so that nothing is
 * inlined here and each call is one through a pointer, as an integrator's is. Independent states
 * follow each other: it is throughput that is measured.
 *
 * Usage: kernels ROUNDS SECONDS; prints a line "name ns ns ..." for each kernel, a number a round,
 * then "= name a0 a1" for a first state, so that the caller sees that all compute the same.
 */
#define _POSIX_C_SOURCE 200809L

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { STATES = 512, MOST_ROUNDS = 100 };

/* `width` states at once as structure of arrays: 1, or the lanes of a lane kernel. */
typedef int kernel(const double *q, const double *v, double *a);
#define X(name) kernel kernel_##name; extern const int kernel_##name##_width;
KERNELS
#undef X

static const struct {
    const char *name;
    kernel *call;
    const int *width;
} kernels[] = {
#define X(name) {#name, kernel_##name, &kernel_##name##_width},
    KERNELS
#undef X
};

enum { COUNT = sizeof kernels / sizeof *kernels };

static double q[2 * STATES], v[2 * STATES], taken[COUNT][MOST_ROUNDS];
volatile double sink;

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static double measure(kernel *call, int width, double seconds)
{
    double a[2 * 64], sum = 0, begin = now(), elapsed;
    unsigned long done = 0;

    do {
        for (int k = 0; k < STATES; k += width) {
            if (call(&q[2 * k], &v[2 * k], a)) abort();
            sum += a[0] + a[1];
        }
        done += STATES;
        elapsed = now() - begin;
    } while (elapsed < seconds);
    sink = sum;
    return 1e9 * elapsed / (double)done;
}

int main(int argc, char **argv)
{
    const int rounds = argc > 1 ? atoi(argv[1]) : 0;
    const double seconds = argc > 2 ? atof(argv[2]) : 0;
    double a[2 * 64];

    if (rounds < 1 || rounds > MOST_ROUNDS) return 2;
    srand(2385);
    for (int k = 0; k < 2 * STATES; k++) {
        q[k] = 6.28 * rand() / RAND_MAX - 3.14;
        v[k] = 6.0 * rand() / RAND_MAX - 3.0;
    }
    for (int r = 0; r < rounds; r++)
        for (int k = 0; k < COUNT; k++)
            taken[k][r] = measure(kernels[k].call, *kernels[k].width, seconds);
    for (int k = 0; k < COUNT; k++) {
        printf("%s", kernels[k].name);
        for (int r = 0; r < rounds; r++) printf(" %.4f", taken[k][r]);
        printf("\n");
    }
    for (int k = 0; k < COUNT; k++) {
        const int w = *kernels[k].width;
        double one_q[2 * 64], one_v[2 * 64];
        for (int l = 0; l < w; l++)
            for (int i = 0; i < 2; i++) one_q[i * w + l] = q[i], one_v[i * w + l] = v[i];
        kernels[k].call(one_q, one_v, a);
        printf("= %s %.17g %.17g\n", kernels[k].name, a[0], a[w]);
    }
    return 0;
}

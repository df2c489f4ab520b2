/* Times RK4 on many double pendulums: pkgen's lanes with one thread and with all, and the peers of
 * bench/ensemble_peers.c, interleaved. Prints a line a way: name, ns a trajectory-step of each
 * round, and last the largest difference of the final angles from the scalar peer's. Built and
 * read by bench/ensemble.py.
 */
#define _POSIX_C_SOURCE 200809L

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include <pk/pk.h>

#include "double_pendulum.h"

void scalar_rk4(pk_real *y, size_t members, size_t steps, pk_real h);
void vector_rk4(pk_real *y, size_t members, size_t steps, pk_real h);

enum { ROUNDS = 9, WAYS = 4, STEPS = 100 };
static const char *const names[WAYS] = {"pkgen", "pkgen, threads", "scalar libm", "libmvec"};

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Angles and rates that spread over what a pendulum does. */
static void starts(size_t members, pk_real *y, pk_real *q, pk_real *v)
{
    for (size_t i = 0; i < members; i++) {
        y[4 * i] = q[2 * i] = (pk_real)(-2.0 + 4.0 * (double)i / (double)members);
        y[4 * i + 1] = q[2 * i + 1] = (pk_real)(1.3 - 2.1 * (double)(i % 97) / 97);
        y[4 * i + 2] = v[2 * i] = (pk_real)(0.2 + (double)(i % 13) / 13);
        y[4 * i + 3] = v[2 * i + 1] = (pk_real)0.4;
    }
}

int main(int argc, char **argv)
{
    const size_t members = argc > 1 ? strtoul(argv[1], NULL, 10) : 102400;
    const pk_real h = (pk_real)0.01, t = (pk_real)STEPS * h;
    const struct pk_system *system = &double_pendulum_system;
    const size_t bytes = 2 * members * sizeof(pk_real), threads = pk_ensemble_threads();
    struct double_pendulum_params *params = malloc(members * sizeof *params);
    pk_real *q0 = malloc(bytes), *v0 = malloc(bytes), *q = malloc(bytes), *v = malloc(bytes);
    pk_real *y = malloc(2 * bytes), *exact = malloc(2 * bytes), *last = malloc(bytes);
    size_t *done = malloc(members * sizeof *done);
    enum pk_status *status = malloc(members * sizeof *status);
    struct pk_ensemble e = {.system = system,
                            .method = pk_method_find("rk4"),
                            .options = pk_options_default(),
                            .members = members,
                            .params = params,
                            .q0 = q0,
                            .v0 = v0,
                            .rows = 1,
                            .t = &t,
                            .q = q,
                            .v = v,
                            .done = done,
                            .last_t = last,
                            .status = status};
    double times[WAYS][ROUNDS], worst[WAYS] = {0};
    e.options.h = h;
    for (size_t i = 0; i < members; i++)
        double_pendulum_defaults(&params[i]);
    const size_t size = pk_ensemble_size(&e);
    void *block = aligned_alloc(64, threads * size);

    for (int round = -1; round < ROUNDS; round++)
        for (int way = WAYS - 1; way >= 0; way--) {
            starts(members, y, q0, v0);
            const double began = now();
            if (way == 0 && pk_ensemble_run(&e, 0, members, block, size) < 0)
                return 1;
            if (way == 1 && pk_ensemble_run_threads(&e, threads, block, threads * size) < 0)
                return 1;
            if (way == 2)
                scalar_rk4(y, members, STEPS, h);
            if (way == 3)
                vector_rk4(y, members, STEPS, h);
            if (round >= 0)
                times[way][round] = (now() - began) * 1e9 / (double)(members * STEPS);
            else if (way == 2)
                for (size_t i = 0; i < 4 * members; i++)
                    exact[i] = y[i];
            for (size_t i = 0; i < 2 * members && round >= 0; i++) {
                const pk_real mine = way < 2 ? q[i] : y[4 * (i / 2) + i % 2];
                const double d = (double)(mine - exact[4 * (i / 2) + i % 2]);
                if (d > worst[way] || -d > worst[way])
                    worst[way] = d > 0 ? d : -d;
            }
        }
    for (int way = 0; way < WAYS; way++) {
        printf("%s", names[way]);
        for (int round = 0; round < ROUNDS; round++)
            printf(";%.4g", times[way][round]);
        printf(";%.3g\n", worst[way]);
    }
    return 0;
}

/* Ensembles in threads of OpenMP; without -fopenmp, in one thread. A thread takes a few blocks of
 * BLOCK members at a time, since members differ in cost. In large ensembles it takes more blocks at
 * a time: when a member in a SIMD lane has ended, another member of these blocks can use its lane.
 */
#define _POSIX_C_SOURCE 200809L

#include <pk/ensemble.h>

#include <time.h>

#ifdef _OPENMP
#include <omp.h>
#endif

/* BLOCK: members per block, a multiple of every number of SIMD lanes */
enum { BLOCK = 64, MOST = 16, SHARES = 8 };

size_t pk_ensemble_threads(void)
{
#ifdef _OPENMP
    return (size_t)omp_get_max_threads();
#else
    return 1;
#endif
}

size_t pk_thread(void)
{
#ifdef _OPENMP
    return (size_t)omp_get_thread_num();
#else
    return 0;
#endif
}

void pk_parallel(size_t threads, size_t count, void (*work)(void *context, size_t i), void *context,
                 const struct pk_options *options)
{
    size_t left = count;
    (void)threads;
#ifdef _OPENMP
#pragma omp parallel num_threads((int)threads)
#endif
    {
#ifdef _OPENMP
#pragma omp for schedule(dynamic) nowait
#endif
        for (size_t i = 0; i < count; i++) {
            work(context, i);
#ifdef _OPENMP
#pragma omp atomic
#endif
            left--;
        }
        /* Only the first thread asks for a stop: it must not sleep in a barrier. */
        while (options->stop && pk_thread() == 0) {
            size_t now;
#ifdef _OPENMP
#pragma omp atomic read
#endif
            now = left;
            if (now == 0)
                break;
            (void)options->stop(options->context);
            nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
        }
    }
}

struct shared {
    const struct pk_ensemble *e;
    char *block;
    size_t chunk;
};

static void run_chunk(void *context, size_t i)
{
    const struct shared *of = context;
    const size_t first = i * of->chunk, left = of->e->members - first;
    const size_t size = pk_ensemble_size(of->e);
    (void)pk_ensemble_run(of->e, first, left < of->chunk ? left : of->chunk,
                          of->block + pk_thread() * size, size); /* e->status has the results */
}

enum pk_status pk_ensemble_run_threads(const struct pk_ensemble *e, size_t threads, void *block,
                                       size_t size)
{
    const enum pk_status refused = pk_ensemble_run(e, 0, 0, block, threads ? size / threads : 0);
    if (refused < 0)
        return refused;
    const size_t each = e->members / (SHARES * BLOCK * (threads ? threads : 1));
    const size_t chunk = BLOCK * (each < 1 ? 1 : each < MOST ? each : MOST);
    struct shared of = {e, block, chunk};
    pk_parallel(threads, (e->members + chunk - 1) / chunk, run_chunk, &of, &e->options);
    for (size_t i = 0; i < e->members; i++)
        if (e->status[i] != PK_DONE)
            return e->status[i];
    return PK_DONE;
}

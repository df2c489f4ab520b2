/* Ensembles in threads of OpenMP; without -fopenmp, in one. Each thread takes a few blocks of
 * members at a time, since members may differ in cost.
 */
#include <pk/ensemble.h>

#ifdef _OPENMP
#include <omp.h>
#endif

enum { CHUNK = 64 }; /* a multiple of the lanes of every block */

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

void pk_parallel(size_t threads, size_t count, void (*work)(void *context, size_t i), void *context)
{
    (void)threads;
#ifdef _OPENMP
#pragma omp parallel for schedule(dynamic) num_threads((int)threads)
#endif
    for (size_t i = 0; i < count; i++)
        work(context, i);
}

enum pk_status pk_ensemble_run_threads(const struct pk_ensemble *e, size_t threads, void *block,
                                       size_t size)
{
    const size_t one = pk_ensemble_size(e);
    const enum pk_status refused = pk_ensemble_run(e, 0, 0, block, threads ? size / threads : 0);
    if (refused < 0)
        return refused;
    const size_t chunks = (e->members + CHUNK - 1) / CHUNK;
#ifdef _OPENMP
#pragma omp parallel for schedule(dynamic) num_threads((int)threads)
#endif
    for (size_t i = 0; i < chunks; i++) {
        const size_t first = i * CHUNK, left = e->members - first;
        (void)pk_ensemble_run(e, first, left < CHUNK ? left : CHUNK,
                              (char *)block + pk_thread() * one,
                              one); /* what it came to is in e->status */
    }
    for (size_t i = 0; i < e->members; i++)
        if (e->status[i] != PK_DONE)
            return e->status[i];
    return PK_DONE;
}

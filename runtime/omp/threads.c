/* Ensembles in threads of OpenMP; without -fopenmp, in one thread. A thread takes a few blocks of
 * BLOCK members at a time, since members differ in cost. In large ensembles it takes more blocks at
 * a time: when a member in a SIMD lane has ended, another member of these blocks can use its lane.
 */
#include <pk/ensemble.h>

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
    const size_t each = e->members / (SHARES * BLOCK * (threads ? threads : 1));
    const size_t chunk = BLOCK * (each < 1 ? 1 : each < MOST ? each : MOST);
    const size_t chunks = (e->members + chunk - 1) / chunk;
#ifdef _OPENMP
#pragma omp parallel for schedule(dynamic) num_threads((int)threads)
#endif
    for (size_t i = 0; i < chunks; i++) {
        const size_t first = i * chunk, left = e->members - first;
        (void)pk_ensemble_run(e, first, left < chunk ? left : chunk,
                              (char *)block + pk_thread() * one,
                              one); /* e->status holds each member's status */
    }
    for (size_t i = 0; i < e->members; i++)
        if (e->status[i] != PK_DONE)
            return e->status[i];
    return PK_DONE;
}

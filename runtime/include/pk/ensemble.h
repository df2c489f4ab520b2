/* Many trajectories of one system, each with its own start, parameters and inputs.
 *
 *     struct pk_ensemble e = {.system = &pendulum_system, .method = pk_method_find("rk4"), ...};
 *     size_t size = pk_ensemble_size(&e);                 (bytes, for one thread)
 *     pk_ensemble_run(&e, first, count, block, size);     (each thread its own members and block)
 *
 * Explicit methods with a fixed step advance many members side by side, in vector lanes: the
 * Runge-Kutta and the splitting methods of pk/methods.h, and dopri5 and dop853 where options.h is
 * given, which is then kept; the singularities of a system that has some are watched lane by lane.
 * Any other method integrates one member after the other by pk_integrator, adaptive ones with steps
 * of their own. A member's result is the same in any company and any thread; with -ffp-contract=off
 * it is what pk_integrator gives for it alone, to the bit.
 *
 * A member that fails stops alone: its status says why, its results up to then are valid. Nothing
 * is allocated.
 */
#ifndef PK_ENSEMBLE_H
#define PK_ENSEMBLE_H

#include <stddef.h>

#include <pk/integrator.h>

PK_BEGIN

struct pk_ensemble {
    const struct pk_system *system;
    const struct pk_method *method;
    struct pk_options options; /* a member that options.stop ends has PK_STOPPED_USER */
    size_t members;

    /* Of member i: number i of params_size bytes each, prepared; q0[i * n], v0[i * n], and inputs
     * u[i * n_inputs], constant in time (NULL: zero). n is that of member 0 for all. */
    const void *params;
    const pk_real *q0, *v0, *u;

    /* Rows: the times at which results are wanted, one after the other away from t0. Adaptive steps
     * end at each; fixed ones at the last alone, and for a time within one the result is that of a
     * shorter step from where it began. */
    pk_real t0;
    size_t rows;
    const pk_real *t;

    /* Results, the caller's memory: q[(i * rows + row) * n], the same for v, of which
     * the first of q are the coordinates and the rest is left alone; and of each member how many rows there are, its last valid time, and why it ended. */
    pk_real *q, *v;
    size_t *done;
    pk_real *last_t;
    enum pk_status *status;
};

/* Bytes of the block that one thread wants, a multiple of 64, 0 if a pointer is null. It is to be
 * aligned for pk_real and for pointers, as malloc() does; at 64 bytes it is fastest. */
size_t pk_ensemble_size(const struct pk_ensemble *e);

/* Whether all members take the fixed steps options.h. */
int pk_ensemble_fixed(const struct pk_ensemble *e);

/* Members first, ..., first + count - 1. PK_BAD_ARGUMENT or PK_BLOCK_TOO_SMALL, and then no member
 * was touched; else PK_DONE, or the status of the first member that did not arrive. */
enum pk_status pk_ensemble_run(const struct pk_ensemble *e, size_t first, size_t count, void *block,
                               size_t size);

/* Why a member of a run failed, in words, with its last valid time, as pk_integrator_reason() has
 * it: the member goes its way once more, alone. The block is as for pk_ensemble_run(), and what is
 * wrong with the arguments is the text; results stay as they are. Returns its length as snprintf()
 * does. */
int pk_ensemble_reason(const struct pk_ensemble *e, size_t member, void *block, size_t block_size,
                       char *text, size_t size);

/* All members, by `threads` threads of OpenMP (libpk_omp.a, compiled with -fopenmp; without it,
 * one after the other). The block is for all of them: threads * pk_ensemble_size(). */
enum pk_status pk_ensemble_run_threads(const struct pk_ensemble *e, size_t threads, void *block,
                                       size_t size);
/* work(context, 0), ..., work(context, count - 1), by so many threads, in no order. */
void pk_parallel(size_t threads, size_t count, void (*work)(void *context, size_t i),
                 void *context);
/* How many threads there are to be had; 1 without OpenMP. */
size_t pk_ensemble_threads(void);
/* Which of them this is; 0: the one that has called. */
size_t pk_thread(void);

PK_END

#endif

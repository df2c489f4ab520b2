/* Many trajectories of one system, each with its own start, parameters and inputs.
 *
 *     struct pk_ensemble e = {.system = &pendulum_system, .method = pk_method_find("rk4"), ...};
 *     size_t size = pk_ensemble_size(&e);                 (bytes, for one thread)
 *     pk_ensemble_run(&e, first, count, block, size);     (own members and block per thread)
 *
 * Explicit methods with a fixed step size advance many members at once, in SIMD lanes: the
 * Runge-Kutta and splitting methods of pk/methods.h, and dopri5 and dop853 if options.h is set,
 * which makes their step size fixed. Singularities are monitored in each lane. With other methods,
 * pk_integrator integrates one member after the other; an adaptive method chooses the steps of each
 * member. A member's result does not depend on other members or threads; with -ffp-contract=off it
 * has the same bits as with pk_integrator.
 *
 * The failure of a member does not stop the other members: its status is the reason, and its
 * results before the failure are valid. Nothing is allocated. */
#ifndef PK_ENSEMBLE_H
#define PK_ENSEMBLE_H

#include <stddef.h>

#include <pk/integrator.h>

PK_BEGIN

struct pk_ensemble {
    const struct pk_system *system;
    const struct pk_method *method;
    /* options.stop ends members with status PK_STOPPED_USER; options.member is that of member 0 */
    struct pk_options options;
    size_t members;

    /* Arrays with the data of all members. Member i has the params at byte i * params_size, after
     * prepare(); its start values begin at q0[i * n] and v0[i * n], and its constant inputs at u[i
     * * n_inputs]. If u is NULL, inputs are zero. n is the same for all members. */
    const void *params;
    const pk_real *q0, *v0, *u;

    /* `t` has the times of the `rows` results of each member, in the order of increasing distance
     * from t0. Adaptive steps end at each of these times. Fixed steps need not end at them, except
     * at the last one; a state within a step comes from a shorter step with the same start. */
    pk_real t0;
    size_t rows;
    const pk_real *t;

    /* Results, in memory of the caller. q and v: number k of a row is at [(i * rows + row) * n +
     * k]; only the first n_q of q are written. For each member, `done` has the number of rows
     * computed, last_t the last valid time, and `status` the final status. */
    pk_real *q, *v;
    size_t *done;
    pk_real *last_t;
    enum pk_status *status;
};

/* Returns the bytes of the block for one thread, a multiple of 64, 0 if a pointer is null. The
 * block must be aligned as malloc() aligns; it is fastest if aligned to 64 bytes. */
size_t pk_ensemble_size(const struct pk_ensemble *e);

/* Returns whether all members take fixed steps of size options.h. */
int pk_ensemble_fixed(const struct pk_ensemble *e);

/* Runs members first, ..., first + count - 1. Returns PK_BAD_ARGUMENT or PK_BLOCK_TOO_SMALL without
 * changing a member; otherwise PK_DONE, or the status of the first member that failed or was
 * stopped. */
enum pk_status pk_ensemble_run(const struct pk_ensemble *e, size_t first, size_t count, void *block,
                               size_t size);

/* Integrates a failed member once more, alone, and writes the reason of its failure and its last
 * valid time, as pk_integrator_reason() does. Results are unchanged. The block is as for
 * pk_ensemble_run(); bad arguments too. Returns the length as snprintf() does. */
int pk_ensemble_reason(const struct pk_ensemble *e, size_t member, void *block, size_t block_size,
                       char *text, size_t size);

/* Runs all members in `threads` OpenMP threads (libpk_omp.a, compiled with -fopenmp; without
 * OpenMP, one member after the other). The block has threads * pk_ensemble_size() bytes. */
enum pk_status pk_ensemble_run_threads(const struct pk_ensemble *e, size_t threads, void *block,
                                       size_t size);
/* Calls work(context, 0), ..., work(context, count - 1) in `threads` threads, in any order. When
 * no work is left for the first thread, it calls options->stop until the others have ended. */
void pk_parallel(size_t threads, size_t count, void (*work)(void *context, size_t i), void *context,
                 const struct pk_options *options);
/* Returns the number of available threads; 1 without OpenMP. */
size_t pk_ensemble_threads(void);
/* Returns the number of the current thread; 0 is the thread that started the others. */
size_t pk_thread(void);

PK_END

#endif

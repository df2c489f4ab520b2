/* The largest Lyapunov exponent of a motion, from a displacement that the variational equations
 * propagate along it (pk/variation.h), normalised at intervals. With G(t) the logarithm of the
 * growth of the displacement since the start, and T the time reached:
 *
 *     exponent = (G(T) - G(T/10)) / (T - T/10)
 *     megno    = time average of 2 (G(t) - time average of G over [0, t])
 *
 * The first tenth of the time, in which the displacement turns towards the direction of fastest
 * growth, is left out. `error` is the standard error of the exponent by the method of batch means.
 * The batches are the growth rates in 14 to 58 equal intervals of the remaining time. On a regular
 * motion a displacement grows like t, G like ln t, so the exponent is about 2.6/T and keeps
 * falling. The kind of motion is decided by megno: it tends to 2 on a regular motion (0 on a
 * harmonic one) and grows as exponent T/2 on a chaotic one.
 *
 * References: G. Benettin, L. Galgani, A. Giorgilli, J.-M. Strelcyn, Meccanica 15 (1980) 9; P. M.
 * Cincotta, C. Simo, Astron. Astrophys. Suppl. 147 (2000) 205 (megno). */
#ifndef PK_LYAPUNOV_H
#define PK_LYAPUNOV_H

#include <pk/variation.h>

PK_BEGIN

enum { PK_LYAPUNOV_MARKS = 64 };

/* The kind of a motion, decided by its megno: PK_REGULAR if it is at most 3, PK_CHAOTIC if it is at
 * least 6, otherwise PK_UNDECIDED. PK_CHAOTIC means exponential growth. It is chaos only if the
 * motion is bounded; the motion away from an unstable equilibrium has exponential growth too. */
enum pk_motion { PK_REGULAR, PK_CHAOTIC, PK_UNDECIDED };

struct pk_lyapunov {
    struct pk_variation variation;
    /* integrates the motion (the first n_q coordinates) together with the displacement */
    struct pk_integrator it;
    pk_real t0, block;    /* start time; time between normalisations */
    unsigned long blocks; /* number of completed blocks */
    pk_real growth;       /* current value of G, the log of the growth */
    pk_real sum_G, sum_Y; /* integrals over t of G and of 2 (G - mean G), trapezoidal */
    pk_real Y;            /* the current value of 2 (G - mean G) */
    /* Values of G, one after every `stride` blocks. When the array is full, every second value is
     * dropped and `stride` is doubled. */
    pk_real marks[PK_LYAPUNOV_MARKS];
    unsigned long n_marks, stride;
    size_t metric_n; /* metric for lengths of displacements; see src/diagnose/metric.h */
    pk_real metric_tau, *metric_L;
    pk_real *scratch;
};

/* Returns the bytes of the block, aligned for pk_real. */
size_t pk_lyapunov_size(const struct pk_problem *problem, const struct pk_method *method);
/* Starts at t0; the initialised struct must not move. block: time between normalisations, such as a
 * thousandth of the planned time, rounded to whole steps if they are fixed. PK_REFUSED: the system
 * has no kernel `linear`. */
enum pk_status pk_lyapunov_init(struct pk_lyapunov *l, const struct pk_problem *problem,
                                const struct pk_method *method, const struct pk_options *options,
                                pk_real t0, const pk_real *q0, const pk_real *v0, pk_real block,
                                void *memory, size_t size);
/* Integrates over one block. Returns the integrator's status; l->it has the reason. */
enum pk_status pk_lyapunov_step(struct pk_lyapunov *l);
/* Returns the exponent; before about 20 blocks, 0 with an infinite error. `error` may be NULL. */
pk_real pk_lyapunov_exponent(const struct pk_lyapunov *l, pk_real *error);
pk_real pk_lyapunov_megno(const struct pk_lyapunov *l);
enum pk_motion pk_lyapunov_motion(const struct pk_lyapunov *l);
void pk_lyapunov_free(struct pk_lyapunov *l); /* frees memory like pk_integrator_free() */

PK_END

#endif

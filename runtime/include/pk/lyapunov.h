/* The largest Lyapunov exponent of a motion, by a displacement that the variational equations carry
 * along it (pk/variation.h), made unit length again from time to time. With G(t) the logarithm of
 * its growth since the start, and T the time reached:
 *
 *     exponent = (G(T) - G(T/10)) / (T - T/10)
 *     megno    = time average of 2 (G(t) - time average of G over [0, t])
 *
 * The first tenth, in which the displacement turns towards what grows most, is left out. `error` is
 * the standard error of the exponent by the method of batch means: of the growth rates in the
 * equal intervals that make up the rest, 14 to 58 of them. On a regular motion a displacement grows
 * like t, G like ln t, so an exponent of some 2.6/T remains that falls for ever; megno tells: it
 * tends to 2 there (0 on a harmonic one) and grows as exponent T/2 on a chaotic one.
 *
 * References: G. Benettin, L. Galgani, A. Giorgilli, J.-M. Strelcyn, Meccanica 15 (1980) 9; P. M.
 * Cincotta, C. Simo, Astron. Astrophys. Suppl. 147 (2000) 205 (megno).
 */
#ifndef PK_LYAPUNOV_H
#define PK_LYAPUNOV_H

#include <pk/variation.h>

PK_BEGIN

enum { PK_LYAPUNOV_MARKS = 64 };

/* By megno: 3 at most, 6 at least, between them. PK_CHAOTIC is exponential growth, and chaos only
 * where the motion stays in bounds; where it leaves an unstable equilibrium it is no more than
 * that. */
enum pk_motion { PK_REGULAR, PK_CHAOTIC, PK_UNDECIDED };

struct pk_lyapunov {
    struct pk_variation variation;
    struct pk_integrator it; /* its first n coordinates are the motion's; it.t is the time */
    pk_real t0, block;       /* start; time from one unit length to the next */
    unsigned long blocks;    /* made */
    pk_real growth;          /* G now */
    pk_real sum_G, sum_Y;    /* integrals over t of G and of 2 (G - mean G), trapezoidal */
    pk_real Y;               /* the latter now */
    /* G after every `stride` blocks; when full every other one is dropped. */
    pk_real marks[PK_LYAPUNOV_MARKS];
    unsigned long n_marks, stride;
    size_t metric_n; /* of the length; see src/diagnose/metric.h */
    pk_real metric_tau, *metric_L;
    pk_real *scratch;
};

/* Bytes, and alignment for pk_real; the struct must not move once it is initialised. */
size_t pk_lyapunov_size(const struct pk_problem *problem, const struct pk_method *method);
/* `block`: a fraction of the time that is planned, a thousandth say; of a method of a fixed step it
 * is made a whole number of steps. PK_REFUSED where the system has no kernel `linear`. */
enum pk_status pk_lyapunov_init(struct pk_lyapunov *l, const struct pk_problem *problem,
                                const struct pk_method *method, const struct pk_options *options,
                                pk_real t0, const pk_real *q0, const pk_real *v0, pk_real block,
                                void *memory, size_t size);
/* One block of time. A failure is the integrator's, whose reason l->it has. */
enum pk_status pk_lyapunov_step(struct pk_lyapunov *l);
/* 0 and infinite error before some 20 blocks. error may be NULL. */
pk_real pk_lyapunov_exponent(const struct pk_lyapunov *l, pk_real *error);
pk_real pk_lyapunov_megno(const struct pk_lyapunov *l);
enum pk_motion pk_lyapunov_motion(const struct pk_lyapunov *l);
void pk_lyapunov_free(struct pk_lyapunov *l); /* as pk_integrator_free() */

PK_END

#endif

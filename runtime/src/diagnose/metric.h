/* Small displacements without units. With M = C C^T at one state and a time tau of the motion
 *
 *     Q = C^T dq / sqrt(tau),   P = C^-1 dp sqrt(tau)
 *
 * are canonical and all have the same unit, whatever the units of the coordinates. tau is 1/omega;
 * omega^2 is the Frobenius norm of C^-1 (dr/dq) C^-T, where M q'' = r are the equations of motion.
 * The length of a displacement is the root of |C^T dq/tau|^2 + |C^T dv|^2: a velocity times the
 * root of a mass. Not installed.
 */
#ifndef PK_METRIC_H
#define PK_METRIC_H

#include <pk/variation.h>

#include "../core/internal.h"

struct pk_metric {
    size_t n, seen; /* n: number of components of dv; seen: of dq */
    pk_real tau;
    pk_real *L; /* L and D of M = L D L^T in one n by n array */
};

/* Returns the number of pk_real in L, for n degrees of freedom. */
size_t pk_metric_reals(size_t n);
/* Initialises the metric at a state of the motion of `variation`. If dr/dq is 0, tau is set to
 * `otherwise`. */
enum pk_status pk_metric_init(struct pk_metric *metric, const struct pk_variation *variation,
                              pk_real t, const pk_real *q, const pk_real *v, const pk_real *u,
                              pk_real otherwise, pk_real *memory);
/* These functions convert in place: Q to dq, P to dp, dq to Q, dp to P. */
void pk_metric_dq(const struct pk_metric *metric, pk_real *x);
void pk_metric_dp(const struct pk_metric *metric, pk_real *x);
void pk_metric_Q(const struct pk_metric *metric, pk_real *x);
void pk_metric_P(const struct pk_metric *metric, pk_real *x);
pk_real pk_metric_length(const struct pk_metric *metric, const pk_real *dq, const pk_real *dv);

#endif

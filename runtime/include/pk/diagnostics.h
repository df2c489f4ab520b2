/* How well constants of the motion are kept. For a quantity X sampled at times t
 *
 *     max   = max |X - X(0)| / S       final = (X(end) - X(0)) / S
 *     slope = least-squares slope of (X - X(0)) over t, / S
 *     S     = max |X|;  for the energy  max (|v.p| + |L|),  L = v.p - h
 *
 * (S for the energy, because h itself may vanish.) All of it online: nothing is stored.
 */
#ifndef PK_DIAGNOSTICS_H
#define PK_DIAGNOSTICS_H

#include <stddef.h>

#include <pk/integrator.h>

#ifdef __cplusplus
extern "C" {
#endif

struct pk_drift {
    unsigned long samples;
    pk_real first, scale, max, final;                  /* max and final not yet divided by S */
    pk_real mean_t, mean_x, var_t, cov;                /* Welford's sums for the slope */
};

void pk_drift_init(struct pk_drift *drift);
void pk_drift_update(struct pk_drift *drift, pk_real t, pk_real x);
/* The same with its own contribution to S in place of |x|. */
void pk_drift_update_scaled(struct pk_drift *drift, pk_real t, pk_real x, pk_real scale);
pk_real pk_drift_max(const struct pk_drift *drift);
pk_real pk_drift_final(const struct pk_drift *drift);
pk_real pk_drift_slope(const struct pk_drift *drift); /* per unit of time */

/* The drifts of one run: energy if the system is conservative, the momentum of every cyclic
 * coordinate, every `conserve`. Memory is the caller's. */
struct pk_monitor {
    struct pk_problem problem;
    int has_energy;           /* 0: the energy of this system is not conserved */
    struct pk_drift energy;
    struct pk_drift *momenta;   /* n of them; only those of cyclic coordinates are updated */
    struct pk_drift *conserved; /* n_conserved */
    pk_real *work;
};

size_t pk_monitor_size(const struct pk_problem *problem);
enum pk_status pk_monitor_init(struct pk_monitor *monitor, const struct pk_problem *problem,
                               void *block, size_t block_size);
void pk_monitor_update(struct pk_monitor *monitor, pk_real t, const pk_real *q,
                       const pk_real *v);

#ifdef __cplusplus
}
#endif

#endif

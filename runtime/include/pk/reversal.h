/* Time reversal: steps from t0 to t and the same number backward. A symmetric method returns to the
 * start except for round-off. A chaotic motion amplifies round-off like any displacement, to about
 * 1 at t = ln(1/PK_EPSILON)/lambda, where lambda is the Lyapunov exponent. Methods that are not
 * symmetric miss the start by their own errors.
 *
 * The error is the largest over coordinates and rates of |x - x0| / max |x - x0|, the maximum taken
 * over the whole given time. The horizon is the time at which the error exceeds a threshold. If a
 * run is longer, its start cannot be recovered from its end. */
#ifndef PK_REVERSAL_H
#define PK_REVERSAL_H

#include <pk/integrator.h>

PK_BEGIN

enum { PK_REVERSAL_TIMES = 24 };

struct pk_reversal {
    /* number of entries of at[]: first the times t_end/2^k in ascending order, then those of the
     * bisection */
    size_t count;
    struct {
        /* t: time from the start, > 0; error: the relative error; absolute: max |x - x0|, in the
         * unit of x */
        pk_real t, error, absolute;
    } at[PK_REVERSAL_TIMES];
    pk_real threshold;
    int passed; /* 1: the error exceeds the threshold at a time tried */
    /* the horizon lies between: latest time tried with an error below the threshold, earliest
     * with one above */
    pk_real horizon_lo, horizon_hi;
};

/* Returns the bytes of the block, aligned for pk_real. */
size_t pk_reversal_size(const struct pk_problem *problem, const struct pk_method *method);
/* Tries the times t_end/2^k, from at least one step to t_end, stops at the first time whose error
 * exceeds the threshold, and brackets the horizon to a sixteenth of it. With a fixed step size,
 * times are whole numbers of steps. After a failure `it` has the reason. The integrations take
 * about 5 (t_end - t0) in all. */
enum pk_status pk_reversal_find(struct pk_reversal *reversal, struct pk_integrator *it,
                                const struct pk_problem *problem, const struct pk_method *method,
                                const struct pk_options *options, pk_real t0, const pk_real *q0,
                                const pk_real *v0, pk_real t_end, pk_real threshold, void *block,
                                size_t block_size);

PK_END

#endif

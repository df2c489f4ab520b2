/* How well constants of the motion are conserved. For a quantity X sampled at times t
 *
 *     max   = max |X - X(0)| / S       final = (X(end) - X(0)) / S
 *     slope = least-squares slope of (X - X(0)) over t, / S
 *     S     = the largest of max |X|, max |X| of the vector's other components, and a tenth of
 *             the scale of X, since X may vanish;  for the energy  max (|v.p| + |L|),  L = v.p - h,
 *             and of a system without coordinates as for any X
 *
 * Here p are the momenta and h is the energy. The scale of X is the root of the sum of (y_i
 * dX/dy_i)^2 over all numbers y_i of the state; components of one vector have names that differ in
 * the last letter, x, y or z. The growth law is the exponent e of
 *
 *     max over [0, t] of |X - X(0)|  ~  t^e
 *
 * by least squares over the last six octaves of t: 0 if bounded, 1/2 for a random walk, 1 for a
 * secular drift, 2 for a drift whose rate grows linearly. Nothing is stored. */
#ifndef PK_DIAGNOSTICS_H
#define PK_DIAGNOSTICS_H

#include <stddef.h>

#include <pk/integrator.h>

PK_BEGIN

/* number of ends of half octaves in six octaves of time (an octave: t doubles) */
enum { PK_DRIFT_MARKS = 13 };

struct pk_drift {
    unsigned long samples;
    pk_real first, scale, max, final;   /* max and final before division by S */
    pk_real mean_t, mean_x, var_t, cov; /* Welford's sums for the slope */
    /* start: time of the first sample; edge: time from `start` to the end of this half octave */
    pk_real start, edge;
    pk_real marks[PK_DRIFT_MARKS]; /* ring buffer of max |X - X(0)| at the ends of half octaves */
    unsigned long n_marks;         /* number of completed half octaves */
};

/* Kinds of growth; pk_growth_text() returns the texts. */
#define PK_GROWTHS(X)                                        \
    X(PK_GROWTH_ZERO, "zero all along")                      \
    X(PK_GROWTH_CONSTANT, "constant to the last bit")        \
    X(PK_GROWTH_ROUND_OFF, "round-off")                      \
    X(PK_GROWTH_SHORT, "too few steps to tell how it grows") \
    X(PK_GROWTH_BOUNDED, "bounded")                          \
    X(PK_GROWTH_RANDOM, "as a random walk grows")            \
    X(PK_GROWTH_LINEAR, "secular, as t")                     \
    X(PK_GROWTH_QUADRATIC, "as t^2")                         \
    X(PK_GROWTH_FASTER, "faster than t^2")                   \
    X(PK_GROWTH_NO_NUMBER, "not finite")

enum pk_growth { PK_GROWTHS(PK_EACH_NAME) PK_GROWTH_COUNT };

void pk_drift_init(struct pk_drift *drift);
void pk_drift_update(struct pk_drift *drift, pk_real t, pk_real x);
/* Does the same as pk_drift_update(), but S is the largest `scale` instead of the largest |x|. */
void pk_drift_update_scaled(struct pk_drift *drift, pk_real t, pk_real x, pk_real scale);
pk_real pk_drift_max(const struct pk_drift *drift);
pk_real pk_drift_final(const struct pk_drift *drift);
pk_real pk_drift_slope(const struct pk_drift *drift); /* the slope above, per unit of time */
/* Returns the kind of growth. Writes the exponent, and as `spread` the difference between its
 * values for the earlier and the later three octaves; either pointer may be NULL. Both numbers are
 * 0 if no fit is possible (ZERO, CONSTANT, SHORT), NaN if X is not finite. ROUND_OFF: errors are as
 * small as the round-off of X, or as a random walk of roundings. The fit of the exponent uses only
 * errors above the round-off of X. */
enum pk_growth pk_drift_growth(const struct pk_drift *drift, pk_real *exponent, pk_real *spread);
const char *pk_growth_text(enum pk_growth growth);

/* The drifts in one run: of the energy if the system is conservative, of the momenta of cyclic
 * coordinates, and of every quantity declared by `conserve`. The caller provides the memory. */
struct pk_monitor {
    struct pk_problem problem;
    int has_energy; /* 1: the energy of the system is conserved */
    struct pk_drift energy;
    /* n drifts, of which only those of cyclic coordinates are used; NULL: none is cyclic */
    struct pk_drift *momenta;
    struct pk_drift *conserved; /* one drift for each conserved quantity */
    pk_real *work;
};

size_t pk_monitor_size(const struct pk_problem *problem);
enum pk_status pk_monitor_init(struct pk_monitor *monitor, const struct pk_problem *problem,
                               void *block, size_t block_size);
void pk_monitor_update(struct pk_monitor *monitor, pk_real t, const pk_real *q, const pk_real *v);

PK_END

#endif

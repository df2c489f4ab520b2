/* The frequencies of a motion, from `count` samples of one coordinate at times 0, dt, 2 dt, ...:
 *
 *     x(t) = mean + rate t + sum over lines of amplitude cos(frequency t + phase) + residual
 *
 * Frequencies are angular, per unit of time. Lines are found one by one, each where the windowed
 * Fourier integral of the remainder is largest, by the fast Fourier transform of GSL
 * (pk_gsl_spectrum() in pk/gsl.h), and refined to the maximum of that integral. Then all lines are
 * fitted together by least squares with the same window, frequencies included, so that neither the
 * lines bias one another, nor the line at -frequency that at +frequency. The window is Hann's, 1 +
 * cos, over the whole time of the samples.
 *
 * `error` is the change of the frequency if only the first or the second half of the time is
 * fitted. For a regular motion that bounds the error of the whole fit (8 to 16 times smaller); for
 * a chaotic motion it measures the variation of the frequency. Lines closer than `resolution` count
 * as one.
 *
 * Reference: J. Laskar, Icarus 88 (1990) 266; J. Laskar, in Hamiltonian Systems with Three or More
 * Degrees of Freedom (1999) 134. */
#ifndef PK_SPECTRUM_H
#define PK_SPECTRUM_H

#include <stddef.h>

#include <pk/real.h>
#include <pk/status.h>

PK_BEGIN

/* PK_LINES: largest number of lines; PK_SPECTRUM_LEAST: smallest number of samples */
enum { PK_LINES = 8, PK_SPECTRUM_LEAST = 108 };

struct pk_line {
    pk_real frequency, amplitude, phase, error;
};

struct pk_spectrum {
    pk_real mean, rate;
    size_t count; /* number of lines, in order of decreasing amplitude */
    struct pk_line lines[PK_LINES];
    /* root mean square of the residual, weighted with the window, relative to that of x - mean -
     * rate t */
    pk_real residual;
    pk_real resolution; /* 4 pi / (time of the samples), half the width of a spectral line */
    pk_real nyquist;    /* pi/dt: lines of higher frequency appear as lines of lower frequency */
};

/* Returns the frequency w between lo and hi at which |sum of window(t) x(t) exp(-i w t)|^2 is
 * largest. The interval must contain only one maximum. */
pk_real pk_spectrum_peak(const pk_real *x, size_t count, pk_real dt, pk_real lo, pk_real hi);
/* Fits mean, rate and spectrum->count lines, whose frequencies are guesses on entry, and sets
 * resolution, nyquist and residual; writes x minus the fit, `count` numbers, to `left`. Returns
 * PK_NO_CONVERGENCE if lines cannot be distinguished, or PK_NOT_FINITE. */
enum pk_status pk_spectrum_fit(struct pk_spectrum *spectrum, const pk_real *x, size_t count,
                               pk_real dt, pk_real *left);
/* Sets `error` of each line and sorts lines by decreasing amplitude. `left` is work memory. */
void pk_spectrum_judge(struct pk_spectrum *spectrum, const pk_real *x, size_t count, pk_real dt,
                       pk_real *left);

PK_END

#endif

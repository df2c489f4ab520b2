/* Steppers of the GNU Scientific Library as struct pk_method, for comparison, and for problems that
 * they solve faster. Link libpk_gsl.a before libpk.a, then -lgsl -lgslcblas. pk_real must be
 * double. GSL allocates in init, never while stepping; call pk_integrator_free().
 *
 * GSL has one error handler for the whole process. It is switched off and restored around each
 * call, which is not thread-safe: a program that steps these methods in several threads must call
 * gsl_set_error_handler_off() once, before it starts them. */
#ifndef PK_GSL_H
#define PK_GSL_H

#include <pk/method.h>

/* GSL's methods, as rows of X-macros like those of pk/methods.h. */
#define PK_NEEDS_GSL 0
#define PK_METHODS_GSL(X, A)                                                                 \
    X(A, gsl_rkf45, 5, 6, 0, PK_ADAPTIVE, rkf45, "GSL: Fehlberg 4(5); NASA TR R-315 (1969)") \
    X(A, gsl_rk8pd, 8, 13, 0, PK_ADAPTIVE, rk8pd,                                            \
      "GSL: Prince-Dormand 8(9); J. Comp. Appl. Math. 7 (1981) 67")                          \
    X(A, gsl_msadams, 0, 0, 0, PK_ADAPTIVE, msadams,                                         \
      "GSL: Adams in Nordsieck form, orders 1 to 12")                                        \
    X(A, gsl_msbdf, 0, 0, 0, PK_ADAPTIVE | PK_IMPLICIT | PK_LINEAR, msbdf,                   \
      "GSL: backward differentiation, orders 1 to 5; Byrne, Hindmarsh (1975)")               \
    X(A, gsl_bsimp, 0, 0, 0, PK_ADAPTIVE | PK_IMPLICIT | PK_LINEAR | PK_NO_INPUTS, bsimp,    \
      "GSL: extrapolated implicit midpoint; Bader, Deuflhard, Numer. Math. 41 (1983)")

PK_BEGIN

const struct pk_method *pk_gsl_method_find(const char *name);
const struct pk_method *pk_gsl_method_at(size_t index);

/* The frequencies of a motion, from `count` samples of one coordinate at times 0, dt, 2 dt, ...:
 *
 *     x(t) = mean + rate t + sum over lines of amplitude cos(frequency t + phase) + residual
 *
 * Frequencies are angular, per unit of time. Lines are found one by one, each where the windowed
 * Fourier integral of the remainder is largest, by the fast Fourier transform of GSL, and refined to
 * the maximum of that integral. Then all lines are fitted together by least squares with the same
 * window, frequencies included, so that neither the lines bias one another, nor the line at
 * -frequency that at +frequency. The window is Hann's, 1 + cos, over the whole time of the samples.
 *
 * `error` is the change of the frequency if only the first or the second half of the time is
 * fitted. For a regular motion that bounds the error of the whole fit (8 to 16 times smaller); for
 * a chaotic motion it measures the variation of the frequency. Lines within `resolution` are one.
 *
 * Reference: J. Laskar, Icarus 88 (1990) 266; J. Laskar, in Hamiltonian Systems with Three or More
 * Degrees of Freedom (1999) 134. */
enum { PK_LINES = 8 /* largest number of lines */, PK_SPECTRUM_LEAST = 108 /* of samples */ };

struct pk_line {
    pk_real frequency, amplitude, phase, error;
};

struct pk_spectrum {
    pk_real mean, rate;
    size_t count; /* number of lines, in order of decreasing amplitude */
    struct pk_line lines[PK_LINES];
    /* root mean square of the residual, weighted with the window, relative to that of
     * x - mean - rate t */
    pk_real residual;
    pk_real resolution; /* 4 pi / (time of the samples), half the width of a spectral line */
    pk_real nyquist;    /* pi/dt: lines of higher frequency appear as lines of lower frequency */
};

/* Finds mean, rate and at most `lines` (<= PK_LINES) spectral lines of `count` samples at
 * intervals dt; count >= PK_SPECTRUM_LEAST. Finds fewer lines if no more can be distinguished. */
enum pk_status pk_gsl_spectrum(struct pk_spectrum *spectrum, const double *x, size_t count,
                               double dt, size_t lines);

/* Computes lambda, ascending, and u of K u = lambda M u, M positive definite; the eigenvectors u
 * are the columns of U (n by n) with u.M u = 1. Reads the lower triangles of K and M. Returns
 * PK_SINGULAR_MASS if M is not positive definite. */
enum pk_status pk_gsl_pencil(size_t n, const double *K, const double *M, double *lambda, double *U);

enum { PK_LOOP_LEAST = 32 };

/* Computes the closed integral of p dq round a closed curve (loop) in the plane of q and p, given
 * by `count` samples. The samples must be equidistant in a parameter, and the last one is followed
 * by the first at the same distance. The Fourier series used converge the faster the smoother the
 * loop is. `winding`: the increase of q in one turn (of an angle: a multiple of 2 pi). Overwrites
 * both arrays.
 *
 * For the series of q and of p: `rms` of the varying part; `tail`, the rms of the last eighth of
 * the harmonics (four at least); `rounding`, the tail expected from rounding of the samples. If the
 * samples resolve the loop, `tail` is near `rounding`. Otherwise two cases differ. If the loop has
 * structure too fine for the samples, the harmonics still decay at the last ones. If the samples
 * have independent errors, the last harmonics are equally large. `flat` is 1 in the second case: if
 * the last harmonics are at least PK_LOOP_FLAT times as large as the same number of harmonics
 * before them. `size` is the area of an ellipse of the same rms in q and p. `noise` is the standard
 * deviation of the area if the last harmonics are noise and every harmonic has as much noise. Fails
 * with PK_BAD_ARGUMENT if pk_gsl_loop_takes(count) is 0, PK_NOT_FINITE or PK_NO_MEMORY. */
#define PK_LOOP_FLAT 0.25
struct pk_loop_series {
    double rms, tail, rounding;
    int flat;
};
struct pk_loop_area {
    double area, size, noise;
    struct pk_loop_series q, p;
};
enum pk_status pk_gsl_loop_area(double *q, double *p, size_t count, double winding,
                                struct pk_loop_area *found);
/* Returns whether count is at least PK_LOOP_LEAST and has no prime factor above 1000, which would
 * make the Fourier transform slow. */
int pk_gsl_loop_takes(size_t count);

PK_END

#endif

/* Steppers of the GNU Scientific Library behind the same pk_method as the core's, for comparison
 * and for problems where they do better. Link libpk_gsl.a before libpk.a, then -lgsl -lgslcblas.
 * double only. GSL allocates: in init, never while stepping; call pk_integrator_free().
 *
 * GSL's error handler is one for the whole process. It is switched off for each call and put back,
 * which two threads would do across one another: a program that steps these methods in several
 * threads calls gsl_set_error_handler_off() itself, once, before it starts them.
 */
#ifndef PK_GSL_H
#define PK_GSL_H

#include <pk/least_action.h>
#include <pk/method.h>
#include <pk/spectrum.h>

/* Its methods, as rows of pk/methods.h. */
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

/* The mean, the rate and up to `lines` (PK_LINES at most) lines of `count` samples dt apart, of
 * which there must be PK_SPECTRUM_LEAST; see pk/spectrum.h. The block: pk_gsl_spectrum_size(count)
 * bytes, aligned for double. Fewer lines are found where no other can be told from those there are.
 * Nothing allocates. */
size_t pk_gsl_spectrum_size(size_t count);
enum pk_status pk_gsl_spectrum(struct pk_spectrum *spectrum, const double *x, size_t count,
                               double dt, size_t lines, void *block, size_t block_size);

/* The eigenvalues of C a = lambda B a, the least first, with the first `modes` of found->modes
 * modes of each coordinate: n * modes numbers; and of the least one a itself (NULL: not wanted), as
 * a.B a = 1. PK_SINGULAR_MASS, PK_NO_MEMORY: GSL allocates, and gives it back. */
enum pk_status pk_gsl_least_action(const struct pk_least_action *found, size_t modes,
                                   double *lambda, double *lowest);

enum { PK_LOOP_LEAST = 32 };

/* Closed integral of p dq round a loop of `count` samples, equally far apart in a parameter, the
 * last as far from the first; by Fourier series, which converge as fast as the loop is smooth.
 * `winding`: by how much q is more after once round (of an angle a multiple of 2 pi). Both arrays
 * are overwritten.
 *
 * Of the series of q and of p: `rms` of what varies, `tail`, the rms of the last eighth of
 * the harmonics (four at least), and `rounding`, the tail that rounding of the samples would make.
 * If the loop is resolved, `tail` is near `rounding`. Structure too fine for the samples leaves
 * harmonics that decay towards the last one; independent errors leave a plateau: `flat`
 * says that the last ones are no less than PK_LOOP_FLAT of as many before.
 * `size` is the area of an ellipse of the same rms in q and p, and `noise` the standard deviation
 * of the area if the last ones are noise, as much in every harmonic. PK_BAD_ARGUMENT: not
 * pk_gsl_loop_takes(count); PK_NOT_FINITE; PK_NO_MEMORY. */
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
/* Whether there are PK_LOOP_LEAST, and no prime factor above 1000, with which a transform would
 * take long. */
int pk_gsl_loop_takes(size_t count);

PK_END

#endif

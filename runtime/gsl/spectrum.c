/* Finds the lines of a spectrum one by one; see pk/gsl.h. After each line, the residual is the
 * samples minus the lines fitted so far. GSL's radix-2 transform of this residual gives the next
 * line. The residual is multiplied by the window: the fit weights samples by the window, so that it
 * leaves larger residuals at both ends. The residual is padded with zeros to at least twice its
 * length, so that the frequency grid is finer than the width of a line.
 *
 * Gauss-Newton iterations determine mean, rate, and a, b, w of each line a cos wt + b sin wt,
 * weighted by Hann's window; time runs from -1 to 1, for well-scaled normal equations. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <gsl/gsl_errno.h>
#include <gsl/gsl_fft_real.h>

#include <pk/gsl.h>

#include "../src/core/internal.h"
#include <pk/root.h>

enum { MOST = 2 + 3 * PK_LINES, TURNS = 12 };

static double sample_time(size_t j, size_t count)
{
    return (2 * (double)j - (double)(count - 1)) / (double)(count - 1);
}

static double window(double s) { return 1 + cos(PK_PI * s); }

struct samples {
    const double *x;
    size_t count;
};

/* Returns d/dw of the squared modulus of the windowed transform, up to a factor. */
static enum pk_status slope(void *context, double w, double *found)
{
    const struct samples *of = (const struct samples *)context;
    double re = 0, im = 0, re_w = 0, im_w = 0;
    for (size_t j = 0; j < of->count; j++) {
        const double s = sample_time(j, of->count), y = window(s) * of->x[j];
        const double c = y * cos(w * s), d = y * sin(w * s);
        re += c;
        im -= d;
        re_w -= s * d;
        im_w -= s * c;
    }
    *found = re * re_w + im * im_w;
    return PK_DONE;
}

/* Returns the frequency between lo and hi at which |sum of window(t) x(t) exp(-i w t)|^2 is largest.
 * The interval must contain only one maximum. */
static double peak(const double *x, size_t count, double dt, double lo, double hi)
{
    const double half = dt * (double)(count - 1) / 2;
    struct samples of = {x, count};
    double a = lo * half, b = hi * half, rises, falls;
    slope(&of, a, &rises);
    slope(&of, b, &falls);
    if (!(rises > 0) || !(falls < 0)) /* no maximum between lo and hi: returns the higher end */
        return rises > 0 ? hi : lo;
    pk_root(slope, &of, &a, rises, &b, falls, 4 * PK_EPSILON * fabs(b));
    return (a + b) / 2 / half;
}

/* Returns the model at one sample, and its derivatives by the m unknowns: mean, rate, a, b, w. */
static double model(size_t lines, const double *z, double s, double *by)
{
    double sum = z[0] + z[1] * s;
    by[0] = 1;
    by[1] = s;
    for (size_t k = 0; k < lines; k++) {
        const double *line = z + 2 + 3 * k;
        const double c = cos(line[2] * s), d = sin(line[2] * s);
        by[2 + 3 * k] = c;
        by[3 + 3 * k] = d;
        by[4 + 3 * k] = s * (line[1] * c - line[0] * d);
        sum += line[0] * c + line[1] * d;
    }
    return sum;
}

/* Makes one Gauss-Newton iteration for all unknowns, or with fixed frequencies if `held`. Returns 0
 * if the unknowns are not independent. */
static int turn(const double *x, size_t count, size_t lines, double *z, int held, double *largest)
{
    const size_t m = 2 + 3 * lines;
    double A[MOST * MOST] = {0}, g[MOST] = {0}, by[MOST];
    for (size_t j = 0; j < count; j++) {
        const double s = sample_time(j, count), weight = window(s);
        const double miss = x[j] - model(lines, z, s, by);
        for (size_t i = 0; i < m; i++) {
            g[i] += weight * by[i] * miss;
            for (size_t k = 0; k <= i; k++)
                A[i * m + k] += weight * by[i] * by[k];
        }
    }
    for (size_t k = 0; held && k < lines; k++) { /* fixes the frequency w */
        const size_t w = 4 + 3 * k;
        for (size_t i = 0; i < m; i++)
            *(i < w ? &A[w * m + i] : &A[i * m + w]) = 0;
        A[w * m + w] = 1;
        g[w] = 0;
    }
    if (pk_ldl_factor(A, m))
        return 0;
    pk_ldl_solve(A, m, g);
    *largest = 0;
    for (size_t i = 0; i < m; i++)
        z[i] += g[i];
    for (size_t k = 0; k < lines; k++)
        *largest = pk_max(*largest, fabs(g[4 + 3 * k]));
    return pk_all_finite(z, m);
}

static void take(struct pk_spectrum *spectrum, const double *z, double half)
{
    spectrum->mean = z[0] - z[1];
    spectrum->rate = z[1] / half;
    for (size_t k = 0; k < spectrum->count; k++) {
        const double *line = z + 2 + 3 * k, w = line[2];
        struct pk_line *to = &spectrum->lines[k];
        to->frequency = w / half;
        to->amplitude = sqrt(line[0] * line[0] + line[1] * line[1]);
        to->phase = atan2(-line[1], line[0]) - w; /* phase at t = 0, where s = -1 */
        to->phase -= 2 * PK_PI * floor(to->phase / (2 * PK_PI) + 0.5);
    }
}

static void measure(struct pk_spectrum *spectrum, const double *x, size_t count, const double *z,
                    double *left)
{
    double rest = 0, all = 0, by[MOST];
    for (size_t j = 0; j < count; j++) {
        const double s = sample_time(j, count), smooth = z[0] + z[1] * s, moving = x[j] - smooth;
        left[j] = x[j] - model(spectrum->count, z, s, by);
        rest += window(s) * left[j] * left[j];
        all += window(s) * moving * moving;
    }
    spectrum->residual = all > 0 ? sqrt(rest / all) : 0;
}

/* Fits mean, rate and spectrum->count lines, whose frequencies are guesses on entry, and sets
 * resolution, nyquist and residual; writes x minus the fit, `count` numbers, to `left`. Returns
 * PK_NO_CONVERGENCE if lines cannot be distinguished, or PK_NOT_FINITE. */
static enum pk_status fit(struct pk_spectrum *spectrum, const double *x, size_t count, double dt,
                          double *left)
{
    const double half = dt * (double)(count - 1) / 2;
    const size_t lines = spectrum->count;
    double z[MOST] = {0}, largest = 0;
    if (!(half > 0))
        return PK_BAD_ARGUMENT;
    if (!pk_all_finite(x, count))
        return PK_NOT_FINITE;
    spectrum->resolution = 2 * PK_PI / half;
    spectrum->nyquist = PK_PI / dt;
    for (size_t k = 0; k < lines; k++)
        z[4 + 3 * k] = spectrum->lines[k].frequency * half;
    if (!turn(x, count, lines, z, 1, &largest))
        return PK_NO_CONVERGENCE;
    double before = PK_PI; /* limit of the first correction of w: half a line width */
    for (int k = 0; k < TURNS && lines > 0; k++) {
        if (!turn(x, count, lines, z, 0, &largest) || !(largest <= before))
            return PK_NO_CONVERGENCE;
        if (largest <= 1e3 * PK_EPSILON)
            break;
        before = pk_max(largest, 1e-6);
    }
    take(spectrum, z, half);
    measure(spectrum, x, count, z, left);
    return PK_DONE;
}

/* Sets `error` of each line and sorts lines by decreasing amplitude. `left` is work memory. */
static void judge(struct pk_spectrum *spectrum, const double *x, size_t count, double dt,
                  double *left)
{
    const size_t half = count / 2;
    for (size_t k = 0; k < spectrum->count; k++)
        spectrum->lines[k].error = PK_EPSILON * spectrum->lines[k].frequency; /* round-off */
    for (int part = 0; part < 2; part++) {
        struct pk_spectrum of_half = *spectrum;
        /* Last lines, found in rounding, may be absent in half of the samples: they are dropped. */
        while (fit(&of_half, x + (part ? count - half : 0), half, dt, left) < 0 &&
               of_half.count > 0)
            of_half.count--;
        for (size_t k = 0; k < spectrum->count; k++) {
            struct pk_line *line = &spectrum->lines[k];
            const double moved = k < of_half.count
                                     ? fabs(of_half.lines[k].frequency - line->frequency)
                                     : spectrum->resolution;
            line->error = pk_max(line->error, moved);
        }
    }
    for (size_t k = 1; k < spectrum->count; k++) /* sorts by insertion, the largest first */
        for (size_t i = k; i > 0; i--)
            if (spectrum->lines[i].amplitude > spectrum->lines[i - 1].amplitude) {
                const struct pk_line line = spectrum->lines[i];
                spectrum->lines[i] = spectrum->lines[i - 1];
                spectrum->lines[i - 1] = line;
            }
}

/* The search ends when the next line is below this fraction of the largest line's amplitude. */
#define LEAST 1e-13

static size_t padded(size_t count)
{
    size_t size = 1;
    while (size < 2 * count)
        size *= 2;
    return size;
}

/* Finds the largest peak of the transform, and sets lo and hi to grid frequencies below and above
 * it. Returns the peak's amplitude, or -1 on failure. */
static double strongest(const double *left, size_t count, double dt, double *work, double *lo,
                        double *hi)
{
    const size_t size = padded(count);
    size_t at = 1;
    double most = -1;
    memset(work, 0, size * sizeof *work);
    for (size_t j = 0; j < count; j++)
        work[j] = left[j] * (1 - cos(2 * PK_PI * (double)j / (double)(count - 1)));
    gsl_error_handler_t *handler = gsl_set_error_handler_off();
    const int failed = gsl_fft_real_radix2_transform(work, 1, size);
    gsl_set_error_handler(handler);
    if (failed)
        return -1;
    for (size_t k = 1; k < size / 2; k++) {
        const double square = work[k] * work[k] + work[size - k] * work[size - k];
        if (square > most) {
            most = square;
            at = k;
        }
    }
    const double grid = 2 * PK_PI / (dt * (double)size);
    *lo = grid * (double)(at - 1);
    *hi = grid * (double)(at + 1);
    return sqrt(most) / (double)count; /* approximate amplitude */
}

static int resolved(const struct pk_spectrum *spectrum, double frequency)
{
    for (size_t k = 0; k < spectrum->count; k++)
        if (fabs(spectrum->lines[k].frequency - frequency) < spectrum->resolution)
            return 0;
    return 1;
}

enum pk_status pk_gsl_spectrum(struct pk_spectrum *spectrum, const double *x, size_t count,
                               double dt, size_t lines)
{
    if (count < PK_SPECTRUM_LEAST)
        return PK_BAD_ARGUMENT;
    double *left = (double *)malloc((padded(count) + count) * sizeof *left), first = 0;
    if (!left)
        return PK_NO_MEMORY;
    memset(spectrum, 0, sizeof *spectrum);
    const enum pk_status status = fit(spectrum, x, count, dt, left);
    while (status == PK_DONE && spectrum->count < lines) {
        struct pk_spectrum more = *spectrum;
        double lo = 0, hi = 0;
        const double amplitude = strongest(left, count, dt, left + count, &lo, &hi);
        first = first > 0 ? first : amplitude;
        if (!(amplitude > LEAST * first))
            break;
        const double frequency = peak(left, count, dt, lo, hi);
        if (!resolved(spectrum, frequency)) /* the peak belongs to a line already found */
            break;
        more.lines[more.count++].frequency = frequency;
        if (fit(&more, x, count, dt, left) < 0)
            break;
        *spectrum = more;
    }
    if (status == PK_DONE)
        judge(spectrum, x, count, dt, left);
    free(left);
    return status;
}

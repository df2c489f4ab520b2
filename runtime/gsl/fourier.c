/* Finds the lines of a spectrum one by one; see pk/spectrum.h. After each line, the residual is the
 * samples minus the lines fitted so far. GSL's radix-2 transform of this residual gives the next
 * line. The residual is multiplied by the window: the fit weights samples by the window, so that it
 * leaves larger residuals at both ends. The residual is padded with zeros to at least twice its
 * length, so that the frequency grid is finer than the width of a line. */
#include <math.h>
#include <string.h>

#include <gsl/gsl_errno.h>
#include <gsl/gsl_fft_real.h>

#include <pk/gsl.h>

#include "../src/core/internal.h"

/* The search ends when the next line is below this fraction of the largest line's amplitude. */
#define LEAST 1e-13

static size_t padded(size_t count)
{
    size_t size = 1;
    while (size < 2 * count)
        size *= 2;
    return size;
}

size_t pk_gsl_spectrum_size(size_t count) { return (padded(count) + count) * sizeof(double); }

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
                               double dt, size_t lines, void *block, size_t block_size)
{
    double *left = (double *)block, *work = left + count;
    double first = 0;
    if (!spectrum || !x || lines > PK_LINES)
        return PK_BAD_ARGUMENT;
    if (!block || block_size < pk_gsl_spectrum_size(count) || (size_t)block % _Alignof(double))
        return PK_BLOCK_TOO_SMALL;
    memset(spectrum, 0, sizeof *spectrum);
    PK_TRY(pk_spectrum_fit(spectrum, x, count, dt, left));
    while (spectrum->count < lines) {
        struct pk_spectrum more = *spectrum;
        double lo = 0, hi = 0;
        const double amplitude = strongest(left, count, dt, work, &lo, &hi);
        first = first > 0 ? first : amplitude;
        if (!(amplitude > LEAST * first))
            break;
        const double frequency = pk_spectrum_peak(left, count, dt, lo, hi);
        if (!resolved(spectrum, frequency)) /* the peak belongs to a line already found */
            break;
        more.lines[more.count++].frequency = frequency;
        if (pk_spectrum_fit(&more, x, count, dt, left) < 0)
            break;
        *spectrum = more;
    }
    pk_spectrum_judge(spectrum, x, count, dt, left);
    return PK_DONE;
}

/* The area enclosed by a loop in phase space; see pk/gsl.h. It integrates Fourier series of q and p
 * along the loop. The samples do not resolve all harmonics, which causes an error; the size of the
 * last resolved harmonics shows how large this error is. */
#include <math.h>

#include <gsl/gsl_errno.h>
#include <gsl/gsl_fft_real.h>

#include <pk/gsl.h>

#include "../src/core/internal.h"

enum {
    /* limit of the largest prime factor p of the number of samples; a transform takes time p^2 */
    LARGEST = 1000,
    ROUNDINGS = 4, /* assumed rounding error of a sample, in units in the last place */
    FEW = 4
}; /* FEW: least number of harmonics over which last_of() takes a mean square */

static size_t largest_factor(size_t count)
{
    size_t most = 1;
    for (size_t f = 2; f * f <= count; f++)
        for (; count % f == 0; count /= f)
            most = f;
    return count > most ? count : most;
}

/* Returns how many of the highest harmonics are used to estimate the error of the series. */
static size_t last_of(size_t harmonics) { return harmonics / 8 > FEW ? harmonics / 8 : FEW; }

static double square(const double *c, size_t j)
{
    return c[2 * j - 1] * c[2 * j - 1] + c[2 * j] * c[2 * j];
}

/* Returns the mean square amplitude of harmonics from + 1 .. to. */
static double mean_square(const double *c, size_t from, size_t to)
{
    double sum = 0;
    for (size_t j = from + 1; j <= to; j++)
        sum += square(c, j);
    return to > from ? sum / (double)(to - from) : 0;
}

/* Describes a series of samples by its Fourier transform c: sets its rms, its tail (the size of its
 * last harmonics relative to all), its rounding error, and whether the last harmonics are flat (do
 * not decay). `most` is the largest |sample|. `besides` is the variation that the harmonics do not
 * contain, on the scale of c. It is 0 unless q winds round the loop; then it is the increase of q
 * for the series of q, and the mean of p for the series of p. */
static void describe(struct pk_loop_series *s, const double *c, size_t count, double most,
                     double besides)
{
    const size_t harmonics = (count - 1) / 2, last = last_of(harmonics);
    const double all = mean_square(c, 0, harmonics) * (double)harmonics + besides * besides;
    const double end = mean_square(c, harmonics - last, harmonics);
    const double before = mean_square(c, harmonics - 2 * last, harmonics - last);
    s->rms = sqrt(2 * all) / (double)count;
    s->tail = all > 0 ? sqrt(end * (double)last / all) : 0;
    s->rounding = all > 0 ? ROUNDINGS * PK_EPSILON * most / s->rms : 0;
    s->flat = end >= PK_LOOP_FLAT * PK_LOOP_FLAT * before;
}

static int transform(double *q, double *p, size_t count)
{
    gsl_error_handler_t *handler = gsl_set_error_handler_off();
    gsl_fft_real_wavetable *table = gsl_fft_real_wavetable_alloc(count);
    gsl_fft_real_workspace *work = gsl_fft_real_workspace_alloc(count);
    const int failed = !table || !work || gsl_fft_real_transform(q, 1, count, table, work) ||
                       gsl_fft_real_transform(p, 1, count, table, work);
    if (table)
        gsl_fft_real_wavetable_free(table);
    if (work)
        gsl_fft_real_workspace_free(work);
    gsl_set_error_handler(handler);
    return !failed;
}

int pk_gsl_loop_takes(size_t count)
{
    return count >= PK_LOOP_LEAST && largest_factor(count) <= LARGEST;
}

enum pk_status pk_gsl_loop_area(double *q, double *p, size_t count, double winding,
                                struct pk_loop_area *found)
{
    if (!pk_gsl_loop_takes(count))
        return PK_BAD_ARGUMENT;
    if (!pk_all_finite(q, count) || !pk_all_finite(p, count))
        return PK_NOT_FINITE;
    const double most_q = pk_largest(q, count), most_p = pk_largest(p, count);
    for (size_t k = 0; k < count; k++)
        q[k] -= winding * (double)k / (double)count;
    if (!transform(q, p, count))
        return PK_NO_MEMORY;
    const double n = (double)count;
    const size_t harmonics = (count - 1) / 2, rest = harmonics - last_of(harmonics);
    const double noise_q = mean_square(q, rest, harmonics);
    const double noise_p = mean_square(p, rest, harmonics);
    double sum = 0, noise = 0;
    for (size_t j = harmonics; j > 0; j--) { /* smallest terms first, for less round-off */
        const double weight = (double)j;
        sum += weight * (p[2 * j] * q[2 * j - 1] - p[2 * j - 1] * q[2 * j]);
        noise += weight * weight * (square(p, j) * noise_q + square(q, j) * noise_p) / 2;
    }
    found->area = winding * p[0] / n + 4 * PK_PI * sum / (n * n);
    found->noise = hypot(4 * PK_PI * sqrt(noise) / n, fabs(winding) * sqrt(noise_p)) / n;
    describe(&found->q, q, count, most_q, winding * n / (2 * PK_PI));
    describe(&found->p, p, count, most_p, fabs(winding) > 0 ? p[0] : 0);
    found->size = 2 * PK_PI * found->q.rms * found->p.rms;
    if (!isfinite(found->area) || !isfinite(found->size) || !isfinite(found->noise))
        return PK_NOT_FINITE; /* q and p are finite, but their products overflow */
    return PK_DONE;
}

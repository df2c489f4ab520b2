/* The area of a loop; see pk/gsl.h. By Fourier series of q and p round the loop, the derivative of
 * q exact: what is wrong is what samples do not resolve, and that shows in the last harmonics.
 */
#include <math.h>

#include <gsl/gsl_errno.h>
#include <gsl/gsl_fft_real.h>

#include <pk/gsl.h>

#include "../src/internal.h"

enum { LARGEST = 1000 }; /* a prime factor p of the length costs as p^2 */

static size_t largest_factor(size_t count)
{
    size_t most = 1;
    for (size_t f = 2; f * f <= count; f++)
        for (; count % f == 0; count /= f)
            most = f;
    return count > most ? count : most;
}

/* How much of the harmonics is in the last eighth, of their root mean square and of what there is
 * besides: of what winds, the winding and the mean momentum, of which it may be all. */
static double tail_of(const double *c, size_t count, double besides)
{
    double all = besides * besides, last = 0;
    const size_t harmonics = (count - 1) / 2, edge = harmonics - harmonics / 8;
    for (size_t j = 1; j <= harmonics; j++) {
        const double square = c[2 * j - 1] * c[2 * j - 1] + c[2 * j] * c[2 * j];
        all += square;
        last += j > edge ? square : 0;
    }
    return all > 0 ? sqrt(last / all) : 0;
}

enum pk_status pk_gsl_loop_area(double *q, double *p, size_t count, double winding,
                                struct pk_loop_area *found)
{
    if (count < PK_LOOP_LEAST || largest_factor(count) > LARGEST)
        return PK_BAD_ARGUMENT;
    for (size_t k = 0; k < count; k++)
        q[k] -= winding * (double)k / (double)count;
    if (!pk_all_finite(q, count) || !pk_all_finite(p, count))
        return PK_NOT_FINITE;
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
    if (failed)
        return PK_NO_MEMORY;
    const double n = (double)count;
    double sum = 0, size = fabs(winding * p[0]) * n / (4 * PK_PI);
    for (size_t j = (count - 1) / 2; j > 0; j--) { /* the smallest first */
        sum += (double)j * (p[2 * j] * q[2 * j - 1] - p[2 * j - 1] * q[2 * j]);
        size += (double)j * hypot(p[2 * j], p[2 * j - 1]) * hypot(q[2 * j], q[2 * j - 1]);
    }
    found->area = winding * p[0] / n + 4 * PK_PI * sum / (n * n);
    found->size = 4 * PK_PI * size / (n * n);
    const double turn = winding * n / (2 * PK_PI), mean = fabs(winding) > 0 ? p[0] : 0;
    found->tail = fmax(tail_of(q, count, turn), tail_of(p, count, mean));
    return PK_DONE;
}

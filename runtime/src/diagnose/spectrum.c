/* Fits the lines of a spectrum to samples; see pk/spectrum.h. Gauss-Newton iterations determine
 * mean, rate, and a, b, w of each line a cos wt + b sin wt, weighted by Hann's window; time runs
 * from -1 to 1 over the samples, so that the normal equations are well scaled. */
#include <string.h>

#include <pk/spectrum.h>

#include "../core/internal.h"
#include "../core/root.h"

enum { MOST = 2 + 3 * PK_LINES, TURNS = 12 };

static pk_real sample_time(size_t j, size_t count)
{
    return (2 * (pk_real)j - (pk_real)(count - 1)) / (pk_real)(count - 1);
}

static pk_real window(pk_real s) { return 1 + PK_F(cos)(PK_PI * s); }

struct samples {
    const pk_real *x;
    size_t count;
};

/* Returns d/dw of the squared modulus of the windowed transform, up to a factor. */
static enum pk_status slope(void *context, pk_real w, pk_real *found)
{
    const struct samples *of = (const struct samples *)context;
    pk_real re = 0, im = 0, re_w = 0, im_w = 0;
    for (size_t j = 0; j < of->count; j++) {
        const pk_real s = sample_time(j, of->count), y = window(s) * of->x[j];
        const pk_real c = y * PK_F(cos)(w * s), d = y * PK_F(sin)(w * s);
        re += c;
        im -= d;
        re_w -= s * d;
        im_w -= s * c;
    }
    *found = re * re_w + im * im_w;
    return PK_DONE;
}

pk_real pk_spectrum_peak(const pk_real *x, size_t count, pk_real dt, pk_real lo, pk_real hi)
{
    const pk_real half = dt * (pk_real)(count - 1) / 2;
    struct samples of = {x, count};
    pk_real a = lo * half, b = hi * half, rises, falls;
    slope(&of, a, &rises);
    slope(&of, b, &falls);
    if (!(rises > 0) || !(falls < 0)) /* no maximum between lo and hi: returns the higher end */
        return rises > 0 ? hi : lo;
    pk_root(slope, &of, &a, rises, &b, falls, 4 * PK_EPSILON * pk_abs(b));
    return (a + b) / 2 / half;
}

/* Returns the model at one sample, and its derivatives with respect to the m unknowns: mean, rate,
 * and a, b, w of each line. */
static pk_real model(size_t lines, const pk_real *z, pk_real s, pk_real *by)
{
    pk_real sum = z[0] + z[1] * s;
    by[0] = 1;
    by[1] = s;
    for (size_t k = 0; k < lines; k++) {
        const pk_real *line = z + 2 + 3 * k;
        const pk_real c = PK_F(cos)(line[2] * s), d = PK_F(sin)(line[2] * s);
        by[2 + 3 * k] = c;
        by[3 + 3 * k] = d;
        by[4 + 3 * k] = s * (line[1] * c - line[0] * d);
        sum += line[0] * c + line[1] * d;
    }
    return sum;
}

/* Makes one Gauss-Newton iteration for all unknowns, or with fixed frequencies if `held`. Returns 0
 * if the unknowns are not independent. */
static int turn(const pk_real *x, size_t count, size_t lines, pk_real *z, int held,
                pk_real *largest)
{
    const size_t m = 2 + 3 * lines;
    pk_real A[MOST * MOST] = {0}, g[MOST] = {0}, by[MOST];
    for (size_t j = 0; j < count; j++) {
        const pk_real s = sample_time(j, count), weight = window(s);
        const pk_real miss = x[j] - model(lines, z, s, by);
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
        *largest = pk_max(*largest, pk_abs(g[4 + 3 * k]));
    return pk_all_finite(z, m);
}

static void take(struct pk_spectrum *spectrum, const pk_real *z, pk_real half)
{
    spectrum->mean = z[0] - z[1];
    spectrum->rate = z[1] / half;
    for (size_t k = 0; k < spectrum->count; k++) {
        const pk_real *line = z + 2 + 3 * k, w = line[2];
        struct pk_line *to = &spectrum->lines[k];
        to->frequency = w / half;
        to->amplitude = PK_F(sqrt)(line[0] * line[0] + line[1] * line[1]);
        to->phase = PK_F(atan2)(-line[1], line[0]) - w; /* phase at t = 0, where s = -1 */
        to->phase -= 2 * PK_PI * PK_F(floor)(to->phase / (2 * PK_PI) + PK_C(0.5));
    }
}

static void measure(struct pk_spectrum *spectrum, const pk_real *x, size_t count, const pk_real *z,
                    pk_real *left)
{
    pk_real rest = 0, all = 0, by[MOST];
    for (size_t j = 0; j < count; j++) {
        const pk_real s = sample_time(j, count), smooth = z[0] + z[1] * s;
        const pk_real moving = x[j] - smooth;
        left[j] = x[j] - model(spectrum->count, z, s, by);
        rest += window(s) * left[j] * left[j];
        all += window(s) * moving * moving;
    }
    spectrum->residual = all > 0 ? PK_F(sqrt)(rest / all) : 0;
}

enum pk_status pk_spectrum_fit(struct pk_spectrum *spectrum, const pk_real *x, size_t count,
                               pk_real dt, pk_real *left)
{
    const pk_real half = dt * (pk_real)(count - 1) / 2;
    const size_t lines = spectrum->count;
    pk_real z[MOST] = {0}, largest = 0;
    if (lines > PK_LINES || count < PK_SPECTRUM_LEAST || !(half > 0))
        return PK_BAD_ARGUMENT;
    if (!pk_all_finite(x, count))
        return PK_NOT_FINITE;
    spectrum->resolution = 2 * PK_PI / half;
    spectrum->nyquist = PK_PI / dt;
    for (size_t k = 0; k < lines; k++)
        z[4 + 3 * k] = spectrum->lines[k].frequency * half;
    if (!turn(x, count, lines, z, 1, &largest))
        return PK_NO_CONVERGENCE;
    pk_real before = PK_PI; /* limit of the first correction of w: half a line width */
    for (int k = 0; k < TURNS && lines > 0; k++) {
        if (!turn(x, count, lines, z, 0, &largest) || !(largest <= before))
            return PK_NO_CONVERGENCE;
        if (largest <= PK_C(1e3) * PK_EPSILON)
            break;
        before = pk_max(largest, PK_C(1e-6));
    }
    take(spectrum, z, half);
    measure(spectrum, x, count, z, left);
    return PK_DONE;
}

void pk_spectrum_judge(struct pk_spectrum *spectrum, const pk_real *x, size_t count, pk_real dt,
                       pk_real *left)
{
    const size_t half = count / 2;
    for (size_t k = 0; k < spectrum->count; k++)
        spectrum->lines[k].error = PK_EPSILON * spectrum->lines[k].frequency; /* round-off */
    for (int part = 0; part < 2; part++) {
        struct pk_spectrum of_half = *spectrum;
        /* The last lines, found in rounding, may not exist in half of the samples, and are dropped
         * there. */
        while (pk_spectrum_fit(&of_half, x + (part ? count - half : 0), half, dt, left) < 0 &&
               of_half.count > 0)
            of_half.count--;
        for (size_t k = 0; k < spectrum->count; k++) {
            struct pk_line *line = &spectrum->lines[k];
            const pk_real moved = k < of_half.count
                                      ? pk_abs(of_half.lines[k].frequency - line->frequency)
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

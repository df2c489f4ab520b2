/* Newton's method for the gap y -> end - y of some steps of a method; see pk/gsl_orbits.h.
 *
 * Deflation multiplies the gap by p = prod (1 + 1/|y - known|^2). Its Newton correction is that of
 * the gap times 1/(1 - grad(p).correction/p), so it needs no other derivative.
 */
#include <math.h>
#include <string.h>

#include <gsl/gsl_blas.h>
#include <gsl/gsl_linalg.h>

#include "orbit_newton.h"

enum { MOST_TURNS = 60 };
static const double TWO_PI = 6.283185307179586476925;
static const double BESIDE = 1e-6;  /* central differences, in boxes: errors are about 1e-10 */
static const double FLAT = 1e-7;    /* singular value, relative to the largest, that counts as 0 */
static const double SMALL = 1e-9;   /* correction, in boxes, at which the iteration ends */
static const double CLOSED = 1e-6;  /* largest gap of a closed orbit, in boxes */
static const double FURTHEST = 0.5; /* largest correction, in boxes; a quarter of it for log h */

int pk_orbit_advance(struct closing *x, const double *y, double h, size_t steps)
{
    struct pk_integrator *it = &x->it;
    const int whole = (it->method->traits & PK_ADAPTIVE) != 0;
    const double until = (double)steps * h;
    if (!(h > 0) || pk_integrator_reset(it, 0, y, y + x->n) < 0)
        return 0;
    if (whole) {
        if (pk_integrator_set_step(it, until / 64) < 0 || pk_integrator_to(it, until) < 0)
            return 0;
    } else {
        if (pk_integrator_set_step(it, h) < 0)
            return 0;
        for (size_t k = 0; k < steps; k++)
            if (pk_integrator_step(it, until + h) < 0)
                return 0;
    }
    memcpy(x->end, it->q, it->n_q * sizeof *x->end);
    memcpy(x->end + x->n, it->v, x->n * sizeof *x->end);
    return 1;
}

double pk_orbit_apart(const struct closing *x, size_t k, const double *a, const double *b)
{
    const size_t i = x->of[k];
    const double d = b[i] - a[i];
    return (x->turns[k] ? d - TWO_PI * round(d / TWO_PI) : d) / x->asked->box[i];
}

static int gap(struct closing *x, double h, double *out)
{
    if (!pk_orbit_advance(x, x->y, h, x->steps))
        return 0;
    for (size_t k = 0; k < x->d; k++)
        out[k] = pk_orbit_apart(x, k, x->y, x->end);
    return 1;
}

/* Sets x->other to d(gap)/d(unknown k), or for k = d to d(gap)/d(log h). */
static int slope(struct closing *x, size_t k)
{
    const int of_h = k == x->d;
    double *place = of_h ? &x->h : &x->y[x->of[k]];
    const double was = *place, by = of_h ? 1e-6 * was : BESIDE * x->asked->box[x->of[k]];
    *place = was + by;
    int good = gap(x, x->h, x->ahead);
    *place = was - by;
    good = good && gap(x, x->h, x->other);
    *place = was;
    for (size_t i = 0; i < x->d && good; i++)
        x->other[i] = (x->ahead[i] - x->other[i]) / (2 * (of_h ? 1e-6 : BESIDE));
    return good;
}

/* Computes J, and the rows of U, which is its transpose; with a free h, U has another row. */
static int derivative(struct closing *x)
{
    for (size_t k = 0; k < x->U->size1; k++) {
        if (!slope(x, k))
            return 0;
        for (size_t i = 0; i < x->d; i++) {
            if (!(fabs(x->other[i]) < HUGE_VAL))
                return 0;
            gsl_matrix_set(x->U, k, i, x->other[i]);
            if (k < x->d)
                gsl_matrix_set(x->J, i, k, x->other[i]);
        }
    }
    return 1;
}

/* Sets x->step to the shortest Newton correction; returns 0 on failure. */
static int least(struct closing *x)
{
    if (!derivative(x) || gsl_linalg_SV_decomp(x->U, x->V, x->singular, x->work))
        return 0;
    const double flat = FLAT * gsl_vector_get(x->singular, 0);
    for (size_t k = 0; k < x->d; k++) {
        double part = 0;
        const double s = gsl_vector_get(x->singular, k);
        for (size_t i = 0; i < x->d; i++)
            part -= gsl_matrix_get(x->V, i, k) * x->gap[i];
        gsl_vector_set(x->right, k, s > flat ? part / s : 0);
    }
    return !gsl_blas_dgemv(CblasNoTrans, 1, x->U, x->right, 0, x->step);
}

static double deflated(const struct closing *x)
{
    double slope = 0;
    for (size_t k = 0; k < x->n_known; k++) {
        const double *root = x->known + k * 2 * x->n;
        double square = 0, along = 0;
        for (size_t i = 0; i < x->d; i++) {
            const double d = pk_orbit_apart(x, i, root, x->y);
            square += d * d;
            along += d * gsl_vector_get(x->step, i);
        }
        slope -= 2 * along / (square * (1 + square));
    }
    return slope < 1 || slope > 1 ? 1 / (1 - slope) : 1;
}

/* Moves by x->step, deflated and at most FURTHEST long. Returns its size before that limit. */
static double go(struct closing *x)
{
    double size = 0, by = x->n_known ? deflated(x) : 1;
    for (size_t k = 0; k < x->step->size; k++)
        size = fmax(size, (k == x->d ? 4 : 1) * fabs(by * gsl_vector_get(x->step, k)));
    if (size > FURTHEST)
        by *= FURTHEST / size;
    for (size_t k = 0; k < x->d; k++)
        x->y[x->of[k]] += by * gsl_vector_get(x->step, k) * x->asked->box[x->of[k]];
    if (x->step->size > x->d)
        x->h *= 1 + by * gsl_vector_get(x->step, x->d);
    return size;
}

int pk_orbit_newton(struct closing *x)
{
    for (int turn = 0; turn < MOST_TURNS; turn++) {
        if (!gap(x, x->h, x->gap) || !least(x))
            return 0;
        const double size = go(x);
        if (!(size < HUGE_VAL))
            return 0;
        if (size < SMALL) {
            double most = 0;
            if (!gap(x, x->h, x->gap))
                return 0;
            for (size_t k = 0; k < x->d; k++)
                most = fmax(most, fabs(x->gap[k]));
            return most < CLOSED && derivative(x);
        }
    }
    return 0;
}

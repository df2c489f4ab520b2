/* Closed orbits, sought from many starts; see pk/gsl_orbits.h. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <gsl/gsl_eigen.h>
#include <gsl/gsl_errno.h>
#include <gsl/gsl_vector.h>

#include "../src/core/internal.h"
#include "halton.h"
#include "orbit_newton.h"

static const double TWO_PI = 6.283185307179586476925;
static const double SAME = 1e-5;   /* distance of equal states, in boxes */
static const double REST = 1e-6;   /* motion in a step at an equilibrium, in boxes */
static const double ALIKE = 1e-11; /* relative difference of equal rates */
static const double AWAY = 16;     /* distance at which an orbit is ignored, in boxes */
/* ODD skips Halton's first points: at middles and quarters of the box a sine may vanish. */
enum { PROBES = 3, ODD = 16, MOST_KNOWN = 128 };

/* Memory to test which numbers of the state the equations depend on. */
struct probe {
    const struct pk_problem *of;
    const double *middle, *box;
    size_t n;
    double *y, *a, *b, *u; /* 2 n, n, n, inputs */
};

static int rates(const struct probe *x, double t, double *a)
{
    pk_input(x->of, t, x->u);
    return x->of->system->acceleration(x->of->params, t, x->y, x->y + x->n, x->u, a);
}

/* Returns whether the rates at PROBES states stay the same if number i of the state, or t (i = 2
 * n), is increased by `by`. */
static int same_rates(struct probe *x, size_t i, double by)
{
    size_t base[PROBES * 8];
    const size_t bases = sizeof base / sizeof *base, n = x->n;
    int same = 1;
    primes(base, bases);
    for (size_t probe = 1; probe <= PROBES && same; probe++) {
        for (size_t k = 0; k < 2 * n; k++)
            x->y[k] = x->middle[k] + x->box[k] * (2 * halton(probe + ODD, base[k % bases]) - 1);
        const double t = i == 2 * n ? by * halton(probe + ODD, 5) : 0;
        double most = 0;
        int good = !rates(x, t, x->a);
        if (i < 2 * n)
            x->y[i] += by;
        good = good && !rates(x, i == 2 * n ? t + by : t, x->b);
        for (size_t k = 0; k < n && good; k++)
            most = fmax(most, fabs(x->a[k]));
        for (size_t k = 0; k < n && good; k++)
            same = same && fabs(x->a[k] - x->b[k]) <= ALIKE * most;
    }
    return same;
}

static size_t choose(struct probe *x, size_t *of, unsigned char *turns)
{
    const size_t seen = pk_system_coordinates(x->of->system, x->of->params);
    size_t d = 0;
    for (size_t i = 0; i < 2 * x->n; i++) {
        const int place = i < seen || i >= x->n + seen; /* else a rate */
        if (i >= seen && i < x->n)
            continue; /* the integral of a first-order variable, which nothing uses */
        if (place && same_rates(x, i, 0.7390851 * x->box[i]))
            continue;
        turns[d] = place && same_rates(x, i, TWO_PI);
        of[d++] = i;
    }
    return d;
}

static int open_probe(struct probe *x)
{
    x->n = pk_system_count(x->of->system, x->of->params);
    x->y = (double *)calloc(4 * x->n + x->of->system->n_inputs, sizeof *x->y);
    if (x->y) {
        x->a = x->y + 2 * x->n;
        x->b = x->a + x->n;
        x->u = x->b + x->n;
    }
    return x->y != NULL;
}

size_t pk_closed_unknowns(const struct pk_problem *problem, const double *middle, const double *box,
                          size_t *of, unsigned char *turns)
{
    struct probe x = {.of = problem, .middle = middle, .box = box};
    const size_t d = open_probe(&x) ? choose(&x, of, turns) : 0;
    free(x.y);
    return d;
}

/* Returns whether the equations are the same after all steps: if they depend on time, the steps
 * must span whole periods. */
static int in_step(const struct pk_problem *problem, const struct pk_closed_orbits *o)
{
    struct probe x = {.of = problem, .middle = o->middle, .box = o->box};
    if (problem->system->facts & PK_AUTONOMOUS)
        return 1;
    int good = open_probe(&x) && !o->free;
    for (size_t k = o->first; k <= o->last && good; k++)
        good = same_rates(&x, 2 * x.n, (double)k * o->h);
    free(x.y);
    return good;
}

static void know(struct closing *x, const double *y)
{
    if (x->n_known < MOST_KNOWN)
        memcpy(x->known + 2 * x->n * x->n_known++, y, 2 * x->n * sizeof *y);
}

static int is_known(const struct closing *x)
{
    for (size_t k = 0; k < x->n_known; k++) {
        double most = 0;
        for (size_t i = 0; i < x->d; i++)
            most = fmax(most, fabs(pk_orbit_apart(x, i, x->known + k * 2 * x->n, x->y)));
        if (most < SAME)
            return 1;
    }
    return 0;
}

static int in_sight(const struct closing *x)
{
    for (size_t k = 0; k < x->d; k++)
        if (!(fabs(pk_orbit_apart(x, k, x->asked->middle, x->y)) < AWAY))
            return 0;
    return 1;
}

/* Returns whether x->y is an equilibrium. */
static int rests(struct closing *x)
{
    const struct pk_problem *of = x->problem;
    double *a = x->end;
    pk_input(of, 0, x->u);
    if (!(of->system->facts & PK_AUTONOMOUS) ||
        of->system->acceleration(of->params, 0, x->y, x->y + x->n, x->u, a))
        return 0;
    for (size_t k = 0; k < x->d; k++) {
        const size_t i = x->of[k];
        const double rate = i < x->n ? x->y[x->n + i] : a[i - x->n];
        if (fabs(rate) * x->h > REST * x->asked->box[i])
            return 0;
    }
    return 1;
}

static int multipliers(struct closing *x, struct pk_closed_orbit *one)
{
    gsl_eigen_nonsymm_workspace *w = gsl_eigen_nonsymm_alloc(x->d);
    gsl_vector_complex *values = gsl_vector_complex_alloc(x->d);
    int good = w && values;
    if (good) {
        for (size_t k = 0; k < x->d; k++)
            gsl_matrix_set(x->J, k, k, gsl_matrix_get(x->J, k, k) + 1);
        gsl_eigen_nonsymm_params(0, 1, w);
        good = !gsl_eigen_nonsymm(x->J, values, w);
    }
    for (size_t k = 0; k < x->d && good; k++) {
        const gsl_complex z = gsl_vector_complex_get(values, k);
        size_t at = k;
        for (; at && hypot(one->re[at - 1], one->im[at - 1]) < hypot(GSL_REAL(z), GSL_IMAG(z));
             at--) {
            one->re[at] = one->re[at - 1];
            one->im[at] = one->im[at - 1];
        }
        one->re[at] = GSL_REAL(z);
        one->im[at] = GSL_IMAG(z);
    }
    gsl_eigen_nonsymm_free(w);
    gsl_vector_complex_free(values);
    return good;
}

static void keep(struct closing *x, struct pk_closed_orbits *o)
{
    struct pk_closed_orbit *one = &o->list[o->count];
    for (size_t k = 0; k < x->d; k++)
        if (x->turns[k])
            x->y[x->of[k]] -= TWO_PI * round(x->y[x->of[k]] / TWO_PI);
    one->steps = x->steps;
    one->h = x->h;
    one->residual = 0;
    for (size_t k = 0; k < x->d; k++)
        one->residual = fmax(one->residual, fabs(x->gap[k]));
    one->rests = rests(x);
    if (!multipliers(x, one))
        return;
    o->count++;
    for (size_t k = 0; k < x->steps && k < PK_CLOSED_STATES; k++) {
        memcpy(one->y + k * 2 * x->n, x->y, 2 * x->n * sizeof *x->y);
        know(x, x->y);
        if (!pk_orbit_advance(x, x->y, x->h, 1))
            return;
        memcpy(x->y, x->end, 2 * x->n * sizeof *x->y);
    }
}

/* Reduces x->steps to the orbit's least number of steps (up to whole turns), and then repeats
 * Newton's method. Returns 0 if that number is below the requested ones, or Newton fails. */
static int shorten(struct closing *x, const struct pk_closed_orbits *o)
{
    for (size_t k = 1; o->tries && k < x->steps; k++) {
        double most = 0;
        if (x->steps % k || !pk_orbit_advance(x, x->y, x->h, k))
            continue;
        for (size_t i = 0; i < x->d; i++)
            most = fmax(most, fabs(pk_orbit_apart(x, i, x->y, x->end)));
        if (most >= SAME)
            continue;
        x->steps = k;
        if (k >= o->first)
            return pk_orbit_newton(x);
        know(x, x->y);
        return 0;
    }
    return 1;
}

/* Finds all orbits that Newton's method reaches from one start; each one found is deflated. */
static void search_from(struct closing *x, const double *y0, size_t number, const size_t *base,
                        struct pk_closed_orbits *o)
{
    const size_t steps = x->steps;
    for (int more = 1; more && o->count < o->most && x->n_known < MOST_KNOWN;) {
        memcpy(x->y, y0, 2 * x->n * sizeof *y0);
        for (size_t k = 0; k < x->d && number; k++)
            x->y[x->of[k]] = o->middle[x->of[k]] +
                             o->box[x->of[k]] * (2 * halton(number, base[k]) - 1);
        x->h = o->h;
        more = pk_orbit_newton(x) && in_sight(x) && !is_known(x) && shorten(x, o);
        if (more)
            keep(x, o);
        else
            o->failed++;
        x->steps = steps;
        more = more && o->tries;
    }
}

static int open_closing(struct closing *x, size_t n, int free_h)
{
    x->n = n;
    x->of = (size_t *)calloc(2 * n, sizeof *x->of);
    x->turns = (unsigned char *)calloc(2 * n, 1);
    x->y = (double *)calloc(5 * 2 * n + MOST_KNOWN * 2 * n + x->problem->system->n_inputs,
                            sizeof *x->y);
    if (!x->of || !x->turns || !x->y)
        return 0;
    x->end = x->y + 2 * n;
    x->gap = x->end + 2 * n;
    x->other = x->gap + 2 * n;
    x->ahead = x->other + 2 * n;
    x->known = x->ahead + 2 * n;
    x->u = x->known + MOST_KNOWN * 2 * n;
    x->d = pk_closed_unknowns(x->problem, x->asked->middle, x->asked->box, x->of, x->turns);
    const size_t d = x->d;
    if (!d)
        return 1;
    x->J = gsl_matrix_alloc(d, d);
    x->U = gsl_matrix_alloc(d + (size_t)free_h, d);
    x->V = gsl_matrix_alloc(d, d);
    x->singular = gsl_vector_alloc(d);
    x->work = gsl_vector_alloc(d);
    x->right = gsl_vector_alloc(d);
    x->step = gsl_vector_alloc(d + (size_t)free_h);
    return x->J && x->U && x->V && x->singular && x->work && x->right && x->step;
}

static void close_closing(struct closing *x)
{
    gsl_matrix *const matrices[] = {x->J, x->U, x->V};
    gsl_vector *const vectors[] = {x->singular, x->work, x->right, x->step};
    for (size_t k = 0; k < 3; k++)
        if (matrices[k])
            gsl_matrix_free(matrices[k]);
    for (size_t k = 0; k < 4; k++)
        if (vectors[k])
            gsl_vector_free(vectors[k]);
    free(x->of);
    free(x->turns);
    free(x->y);
    pk_integrator_free(&x->it);
}

static void search(struct closing *x, const double *y0, struct pk_closed_orbits *o, size_t *base)
{
    primes(base, x->d);
    for (x->steps = o->first; x->steps <= o->last; x->steps++)
        for (size_t k = 0; k <= o->tries && x->d; k++)
            search_from(x, y0, k, base, o);
}

enum pk_status pk_gsl_orbits(const struct pk_problem *problem, const double *y0,
                             struct pk_closed_orbits *o, double *room)
{
    const size_t n = pk_system_count(problem->system, problem->params);
    const size_t size = pk_integrator_size(problem, o->method);
    struct closing x = {.problem = problem, .asked = o};
    gsl_error_handler_t *handler = gsl_set_error_handler_off();
    void *block = malloc(size);
    size_t *base = (size_t *)calloc(2 * n + 1, sizeof *base);
    enum pk_status status = PK_NO_MEMORY;
    o->count = o->failed = 0;
    for (size_t k = 0; k < o->most; k++) {
        o->list[k].y = room + k * pk_orbit_size(n);
        o->list[k].re = o->list[k].y + PK_CLOSED_STATES * 2 * n;
        o->list[k].im = o->list[k].re + 2 * n;
    }
    if (block && base)
        status =
            pk_integrator_init(&x.it, problem, o->method, o->options, 0, y0, y0 + n, block, size);
    if (status >= 0)
        status = open_closing(&x, n, o->free != 0) ? PK_DONE : PK_NO_MEMORY;
    if (status >= 0 && !in_step(problem, o))
        status = PK_REFUSED;
    if (status >= 0)
        search(&x, y0, o, base);
    o->multipliers = x.d;
    close_closing(&x);
    free(block);
    free(base);
    gsl_set_error_handler(handler);
    return status;
}

/* Limits of the step size on linear equations: the least step size at which a step makes solutions
 * grow. It is sought on a grid, refined at maxima of growth, and bisected. See pk/limits.h. */
#include <pk/limits.h>

#include "../core/internal.h"
#include "../core/tableau.h"

/* The method and the axis of the complex plane; for the tableau of an explicit Runge-Kutta method
 * also the polynomial in y^2 that has the sign of |R(iy)|^2 - 1, with the stability function R. */
struct question {
    const struct pk_method *method;
    enum pk_axis axis;
    int degree; /* degree of the polynomial, or -1 if there is none */
    pk_real c[PK_MOST_STAGES + 1];
    pk_real blind;        /* growth up to this counts as rounding */
    int shears;           /* whether the determinant of the step map is 1 up to rounding */
    pk_real spacing, end; /* grid */
    pk_real near;         /* a maximum of excess() on the grid is refined if it exceeds -near */
    int failed;           /* whether a step failed, so that there is no answer */
};

/* Sets |R(iy)|^2 - 1 in powers of x = y^2; R is the stability function of the method. Powers below
 * the order of the method cancel up to rounding and are dropped; the lowest power of x that is left
 * is divided out, so that the sign is right for small y. */
static void imaginary(struct question *ask, const struct pk_tableau *table)
{
    pk_real r[PK_MOST_STAGES + 1];
    const int s = pk_tableau_polynomial(table, r);
    int first = 0;
    /* terms a and b of R(iy), R(-iy): i^a (-i)^b with a + b = 2 k is (-1)^(k - b) */
    for (int k = 0; k <= s; k++) {
        ask->c[k] = k ? 0 : -1;
        for (int b = 0; b <= 2 * k; b++)
            if (b <= s && 2 * k - b <= s)
                ask->c[k] += (k - b) % 2 ? -r[b] * r[2 * k - b] : r[b] * r[2 * k - b];
    }
    while (first < s && pk_abs(ask->c[first]) < 64 * PK_EPS)
        first++;
    ask->degree = s - first;
    for (int k = 0; k <= ask->degree; k++)
        ask->c[k] = ask->c[k + first];
}

/* Returns a number that is positive if a step of size x makes solutions grow. */
static pk_real excess(struct question *ask, pk_real x)
{
    pk_real map[4], factor, sum = 0;
    if (ask->degree >= 0) {
        for (int k = ask->degree; k >= 0; k--)
            sum = ask->c[k] + x * x * sum;
        return sum;
    }
    if (ask->axis == PK_AXIS_REAL ? pk_method_decay(ask->method, x, &factor) < 0
                                  : pk_method_oscillator(ask->method, x, map) < 0) {
        ask->failed = 1;
        return PK_INFINITY;
    }
    if (ask->axis == PK_AXIS_REAL)
        return pk_abs(factor) - 1 - ask->blind;
    const pk_real determinant = map[0] * map[3] - map[1] * map[2];
    if (ask->shears || pk_abs(determinant - 1) <= 100 * PK_EPS)
        return pk_abs(map[0] + map[3]) - 2 - ask->blind;
    return pk_map_growth(map) - 1 - ask->blind;
}

/* Returns the point of the largest excess between the grid points a and b, by golden sections; the
 * grid point between them has a larger excess than both. */
static pk_real crest(struct question *ask, pk_real a, pk_real b)
{
    const pk_real golden = PK_C(0.618033988749894848204586834365638118);
    pk_real c = b - golden * (b - a), d = a + golden * (b - a);
    pk_real fc = excess(ask, c), fd = excess(ask, d);
    for (int i = 0; i < 30; i++) { /* accurate to 1e-6 of the interval, as maxima are flat */
        if (fc > fd) {
            b = d, d = c, fd = fc;
            c = b - golden * (b - a);
            fc = excess(ask, c);
        } else {
            a = c, c = d, fc = fd;
            d = a + golden * (b - a);
            fd = excess(ask, d);
        }
    }
    return fc > fd ? c : d;
}

/* Bisects between `in` and `out` for the point where growth begins or, if `ends` is set, ends. */
static pk_real edge(struct question *ask, pk_real in, pk_real out, int ends)
{
    for (int i = 0; i < 200 && out - in > 2 * PK_EPS * out; i++) {
        const pk_real middle = in + (out - in) / 2;
        *((excess(ask, middle) > 0) == !ends ? &out : &in) = middle;
    }
    return in + (out - in) / 2;
}

/* Returns the next grid point: spacing is constant up to 64, proportional to x beyond. */
static pk_real after(struct question *ask, pk_real x)
{
    return x < 64 ? x + ask->spacing : x * PK_C(1.1);
}

static void first_growth(struct question *ask, pk_real from, pk_real growth[2])
{
    pk_real last = from, x = from > 0 ? from : ask->spacing * PK_C(1e-3);
    pk_real f_last = excess(ask, x), f = f_last;
    growth[0] = growth[1] = PK_INFINITY;
    if (f > 0)
        growth[0] = from;
    for (pk_real next = after(ask, x); !(growth[0] < PK_INFINITY) && next <= ask->end;
         next = after(ask, x)) {
        const pk_real f_next = excess(ask, next);
        if (f > f_last && f > f_next && !(f_next > 0) && f > -ask->near) {
            /* A short interval of growth may be between grid points. */
            const pk_real top = crest(ask, last, next);
            if (excess(ask, top) > 100 * PK_EPS) {
                growth[0] = edge(ask, last, top, 0);
                growth[1] = edge(ask, top, next, 1);
                return;
            }
        }
        if (f_next > 0)
            growth[0] = edge(ask, x, next, 0);
        last = x, f_last = f;
        x = next, f = f_next;
    }
    for (; growth[0] < PK_INFINITY && x <= ask->end; x = after(ask, x))
        if (!(excess(ask, after(ask, x)) > 0)) {
            growth[1] = edge(ask, x, after(ask, x), 1);
            return;
        }
}

int pk_method_growth(const struct pk_method *method, enum pk_axis axis, pk_real from,
                     pk_real growth[2])
{
    struct question ask = {.method = method, .axis = axis, .degree = -1};
    const struct pk_method *formula = method->formula ? method->formula : method;
    const struct pk_tableau *table = pk_explicit_table(formula);
    const int shears = pk_splitting_table(formula) != NULL, polynomial = table || shears;
    pk_real map[4], factor;
    if (axis == PK_AXIS_IMAGINARY ? pk_method_oscillator(method, 1, map) < 0
                                  : pk_method_decay(method, 1, &factor) < 0)
        return 0;
    if (table && axis == PK_AXIS_IMAGINARY)
        imaginary(&ask, table);
    ask.shears = shears;
    /* An explicit method of s stages is stable nowhere above 2 s, or 2 s^2 on the real axis. */
    /* a fine grid, since the step map of the method boris has narrow poles */
    const int fine = !(formula->traits & PK_IMPLICIT);
    ask.spacing = fine ? PK_C(0.015625) : PK_C(0.125);
    ask.near = fine ? 1 : PK_C(0.1);
    ask.end = polynomial ? 1000 : PK_C(1e4);
    ask.blind = polynomial ? 0 : pk_max(PK_C(1e-10), PK_EPS * 10000);
    first_growth(&ask, from, growth);
    if (ask.failed && growth[0] < PK_INFINITY) { /* a failure where steps grow does not matter */
        ask.failed = 0;
        excess(&ask, growth[0] * (1 + PK_C(1e-6)));
    }
    return !ask.failed;
}

pk_real pk_method_limit(const struct pk_method *method, enum pk_axis axis)
{
    pk_real growth[2];
    return pk_method_growth(method, axis, 0, growth) ? growth[0] : PK_INFINITY - PK_INFINITY;
}

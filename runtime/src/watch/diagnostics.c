/* Drift of constants of the motion, online. The slope comes from Welford's update of means and
 * co-moments, which avoids the cancellation in sums of t^2 and t x. Reference: B. P. Welford,
 * Technometrics 4 (1962) 419; T. F. Chan, G. H. Golub, R. J. LeVeque, Am. Stat. 37 (1983) 242. */
#include <string.h>

#include <pk/diagnostics.h>
#include <pk/keep.h>

#include "../core/internal.h"

#define PK_SQRT2 PK_C(1.41421356237309504880168872420969808)

/* For a constant of the motion X of scale S, rounding errors in units of PK_EPSILON S. EVALUATION
 * is the error of one evaluation of X; WALK is the random walk of X by one rounding per sample. */
#define EVALUATION PK_C(16.0)
#define WALK PK_C(2.0)

/* For the size of the terms of a constant of the motion: DIRECTIONS is the number of random vectors
 * of signs, STEP the relative change of each number along such a vector; below the fraction SHARE
 * of this size, a constant counts as 0. */
enum { DIRECTIONS = 8 };
#define STEP PK_C(1e-4)
#define SHARE PK_C(0.1)

void pk_drift_init(struct pk_drift *drift) { memset(drift, 0, sizeof *drift); }

void pk_drift_update_scaled(struct pk_drift *drift, pk_real t, pk_real x, pk_real scale)
{
    if (drift->samples == 0) {
        drift->first = x;
        drift->start = t;
    }
    const pk_real d = x - drift->first, elapsed = pk_abs(t - drift->start);
    if (!(drift->edge > 0))
        drift->edge = elapsed;
    for (; elapsed > drift->edge && drift->edge > 0; drift->edge *= PK_SQRT2)
        drift->marks[drift->n_marks++ % PK_DRIFT_MARKS] = drift->max;
    drift->samples++;
    /* A NaN must enter a maximum and stay there. The first comparison of each condition is false
     * for a new NaN, which is then stored; the second one for a stored NaN, which stays. */
    if (!(pk_abs(scale) <= drift->scale) && drift->scale >= 0)
        drift->scale = pk_abs(scale);
    if (!(pk_abs(d) <= drift->max) && drift->max >= 0)
        drift->max = pk_abs(d);
    drift->final = d;

    const pk_real part = 1 / (pk_real)drift->samples, dt = t - drift->mean_t;
    drift->mean_t += dt * part;
    drift->mean_x += (d - drift->mean_x) * part;
    drift->var_t += dt * (t - drift->mean_t);
    drift->cov += dt * (d - drift->mean_x);
}

void pk_drift_update(struct pk_drift *drift, pk_real t, pk_real x)
{
    pk_drift_update_scaled(drift, t, x, pk_abs(x));
}

static pk_real scaled(const struct pk_drift *drift, pk_real x)
{
    if (!(x > 0) && !(x < 0) && pk_finite(x))
        return drift->scale - drift->scale; /* 0 if X is always 0; NaN if the scale is not finite */
    return x / drift->scale + (drift->scale - drift->scale);
}

pk_real pk_drift_max(const struct pk_drift *drift) { return scaled(drift, drift->max); }
pk_real pk_drift_final(const struct pk_drift *drift) { return scaled(drift, drift->final); }

pk_real pk_drift_slope(const struct pk_drift *drift)
{
    return drift->var_t > 0 ? scaled(drift, drift->cov / drift->var_t) : 0;
}

/* Returns the slope of ln(largest deviation) over ln t by least squares, at marks first .. last. */
static pk_real exponent_of(const struct pk_drift *drift, unsigned long first, unsigned long last)
{
    const pk_real count = (pk_real)(last - first + 1), middle = (pk_real)(last - first) / 2;
    pk_real xx = 0, xy = 0;
    for (unsigned long k = first; k <= last; k++) {
        const pk_real x = (pk_real)(k - first) - middle;
        xx += x * x;
        xy += x * PK_F(log)(drift->marks[k % PK_DRIFT_MARKS]);
    }
    return count > 1 ? xy / xx / PK_F(log)(PK_SQRT2) : 0;
}

static enum pk_growth named(pk_real exponent)
{
    static const struct {
        pk_real below;
        enum pk_growth growth;
    } table[] = {{PK_C(0.25), PK_GROWTH_BOUNDED},
                 {PK_C(0.75), PK_GROWTH_RANDOM},
                 {PK_C(1.5), PK_GROWTH_LINEAR},
                 {PK_C(2.5), PK_GROWTH_QUADRATIC}};
    for (size_t i = 0; i < sizeof table / sizeof *table; i++)
        if (exponent < table[i].below)
            return table[i].growth;
    return PK_GROWTH_FASTER;
}

enum pk_growth pk_drift_growth(const struct pk_drift *drift, pk_real *exponent, pk_real *spread)
{
    const pk_real max = pk_drift_max(drift), level = PK_EPSILON * EVALUATION;
    pk_real nowhere, e = 0, s = 0;
    enum pk_growth growth;
    const unsigned long n = drift->n_marks;
    unsigned long first = n > PK_DRIFT_MARKS ? n - PK_DRIFT_MARKS : 0;
    /* Marks at the level of round-off are left out, since they follow no law; so are marks that are
     * 0, since they have no logarithm. */
    const pk_real walk = PK_EPSILON * WALK * PK_F(sqrt)((pk_real)drift->samples);
    const pk_real least = max > level + walk ? level * (drift->scale - drift->max) : 0;
    while (first < n && !(drift->marks[first % PK_DRIFT_MARKS] > least))
        first++;
    if (!pk_finite(max)) {
        e = s = max - max;
        growth = PK_GROWTH_NO_NUMBER;
    } else if (!(drift->scale > 0) || (!(max > 0) && !(pk_abs(drift->first) > 0))) {
        growth = PK_GROWTH_ZERO;
    } else if (!(max > 0)) {
        growth = PK_GROWTH_CONSTANT;
    } else if (n < first + 7) {
        growth = max <= level ? PK_GROWTH_ROUND_OFF : PK_GROWTH_SHORT;
    } else {
        e = exponent_of(drift, first, n - 1);
        s = pk_abs(exponent_of(drift, (first + n - 1) / 2, n - 1) -
                   exponent_of(drift, first, (first + n - 1) / 2));
        growth = named(e);
        if (max <= level + walk)
            growth = PK_GROWTH_ROUND_OFF;
    }
    *(exponent ? exponent : &nowhere) = e;
    *(spread ? spread : &nowhere) = s;
    return growth;
}

const char *pk_growth_text(enum pk_growth growth)
{
    static const char *const text[] = {PK_GROWTHS(PK_EACH_TEXT)};
    return (unsigned)growth < PK_GROWTH_COUNT ? text[growth] : "?";
}

/* Returns the number of momenta, or 0 if the system does not tell which momenta are constant. */
static size_t momenta_of(const struct pk_problem *problem)
{
    const struct pk_system *system = problem->system;
    return system->cyclic && system->canonical ? pk_count_of(problem) : 0;
}

static size_t drift_reals(size_t count)
{
    return (count * sizeof(struct pk_drift) + sizeof(pk_real) - 1) / sizeof(pk_real);
}

size_t pk_monitor_size(const struct pk_problem *problem)
{
    const struct pk_system *system = problem->system;
    const size_t n = pk_count_of(problem), constants = momenta_of(problem) + system->n_conserved;
    return (drift_reals(constants) + 5 * n + system->n_inputs + system->n_conserved +
            3 * constants) *
           sizeof(pk_real);
}

enum pk_status pk_monitor_init(struct pk_monitor *monitor, const struct pk_problem *problem,
                               void *block, size_t block_size)
{
    const struct pk_system *system = problem->system;
    const size_t n = momenta_of(problem);
    if (!block || block_size < pk_monitor_size(problem) ||
        (size_t)block % _Alignof(struct pk_drift))
        return PK_BLOCK_TOO_SMALL;
    memset(block, 0, pk_monitor_size(problem));
    monitor->problem = *problem;
    monitor->has_energy = (system->facts & PK_CONSERVATIVE) && system->energy && system->canonical;
    pk_drift_init(&monitor->energy);
    monitor->momenta = (struct pk_drift *)block;
    monitor->conserved = monitor->momenta + n;
    monitor->work = (pk_real *)block + drift_reals(n + system->n_conserved);
    return PK_DONE;
}

static void raise_scale(struct pk_drift *drift, pk_real size)
{
    if (drift->samples && size > drift->scale && pk_finite(size))
        drift->scale = size;
}

/* Evaluates all constants at a state: the momenta, then the values of the kernel `conserve`. */
static void constants(const struct pk_problem *of, pk_real t, const pk_real *q, const pk_real *v,
                      const pk_real *u, pk_real *pdot, pk_real *x)
{
    const size_t momenta = momenta_of(of);
    if (momenta)
        of->system->canonical(of->params, t, q, v, u, x, pdot);
    if (of->system->n_conserved && of->system->conserve)
        of->system->conserve(of->params, t, q, v, u, x + momenta);
}

/* Returns whether a and b are components of one vector: names that differ in a final x, y or z. */
static int same_vector(const char *a, const char *b)
{
    const size_t last = strlen(a) - 1;
    return last > 0 && strlen(b) == last + 1 && strncmp(a, b, last) == 0 &&
           strchr("xyz", a[last]) && strchr("xyz", b[last]);
}

/* Raises the scales S of constants of the motion X. X may be 0, as a component of a vector or as a
 * sum that cancels. So S is at least SHARE of the size of its terms |y_i dX/dy_i|, where y_i are
 * the numbers of the state, and the components of a vector share the largest S. The size is a root
 * mean square over random signs of the changes of y_i; two evaluations per direction give it for
 * any number of y_i. The energy of a system without coordinates, which has no v.p, is treated so
 * too: it is H of a Lagrangian of first degree in the rates. */
static void widen(struct pk_monitor *monitor, pk_real t, const pk_real *q, const pk_real *v,
                  const pk_real *u, pk_real *work)
{
    const struct pk_system *system = monitor->problem.system;
    const void *params = monitor->problem.params;
    const size_t n = pk_system_count(system, params), m = pk_system_coordinates(system, params);
    const size_t count = momenta_of(&monitor->problem) + system->n_conserved;
    pk_real *pdot = work, *y = pdot + n, *a = y + 2 * n, *b = a + count, *sum = b + count;
    pk_real change, energy = 0;
    unsigned long random = 1;
    memset(sum, 0, count * sizeof *sum);
    for (int k = 0; k < DIRECTIONS; k++) {
        const unsigned long begun = random;
        change = 0;
        for (int side = 1; side >= -1; side -= 2) {
            random = begun;
            for (size_t i = 0; i < m + n; i++) {
                const pk_real x = i < m ? q[i] : v[i - m];
                random = (random * 1103515245UL + 12345UL) & 0x7fffffffUL;
                y[i < m ? i : n + i - m] = x +
                                           (pk_real)((random >> 16) & 1 ? side : -side) * STEP * x;
            }
            constants(&monitor->problem, t, y, y + n, u, pdot, side > 0 ? a : b);
            if (monitor->has_energy && m == 0)
                change += (pk_real)side * system->energy(params, t, y, y + n, u);
        }
        energy += change * change;
        for (size_t i = 0; i < count; i++)
            sum[i] += (a[i] - b[i]) * (a[i] - b[i]);
    }
    raise_scale(&monitor->energy, SHARE * PK_F(sqrt)(energy / DIRECTIONS) / (2 * STEP));
    for (size_t i = 0; i < count; i++)
        raise_scale(&monitor->momenta[i], SHARE * PK_F(sqrt)(sum[i] / DIRECTIONS) / (2 * STEP));
    for (size_t i = 0; i < system->n_conserved; i++)
        for (size_t k = 0; k < system->n_conserved; k++)
            if (same_vector(system->conserved[i].name, system->conserved[k].name))
                raise_scale(&monitor->conserved[i], monitor->conserved[k].scale);
}

void pk_monitor_update(struct pk_monitor *monitor, pk_real t, const pk_real *q, const pk_real *v)
{
    const struct pk_problem *problem = &monitor->problem;
    const struct pk_system *system = problem->system;
    const size_t n = pk_count_of(problem);
    pk_real *p = monitor->work, *pdot = p + n, *u = pdot + n, *c = u + system->n_inputs;

    if (system->n_inputs)
        pk_input(problem, t, u);
    if (system->canonical)
        system->canonical(problem->params, t, q, v, u, p, pdot);
    if (monitor->has_energy) {
        const pk_real h = system->energy(problem->params, t, q, v, u);
        const pk_real vp = pk_dot(v, p, pk_coordinates_of(problem));
        pk_drift_update_scaled(&monitor->energy, t, h, pk_abs(vp) + pk_abs(vp - h));
    }
    for (size_t i = 0; i < n; i++)
        if (momenta_of(problem) && system->cyclic[i])
            pk_drift_update(&monitor->momenta[i], t, p[i]);
    if (system->n_conserved && system->conserve) {
        system->conserve(problem->params, t, q, v, u, c);
        for (size_t i = 0; i < system->n_conserved; i++)
            pk_drift_update(&monitor->conserved[i], t, c[i]);
    }
    unsigned long samples = monitor->energy.samples;
    for (size_t i = 0; i < momenta_of(problem) + system->n_conserved; i++)
        samples |= monitor->momenta[i].samples;
    if (samples && (samples & (samples - 1)) == 0) /* if the number of samples is 1, 2, 4, 8, ... */
        widen(monitor, t, q, v, u, c + system->n_conserved);
}

/* Saves or restores a drift. A restored drift is wrong if it has too many marks, or if `edge`, the
 * time of the next mark, cannot grow. */
void pk_drift_keep(struct pk_drift *drift, struct pk_keep *k)
{
    enum { MOST = 1 << 16 };
    PK_KEEP(k, *drift);
    const int grows = drift->edge >= PK_TINY || !(drift->edge < 0 || drift->edge > 0);
    k->wrong |= k->from && (drift->n_marks > MOST || !pk_finite(drift->start) || !grows);
}

void pk_monitor_keep(struct pk_monitor *monitor, struct pk_keep *k)
{
    const struct pk_problem *problem = &monitor->problem;
    const size_t count = momenta_of(problem) + problem->system->n_conserved;
    pk_keep_same(k, count);
    pk_drift_keep(&monitor->energy, k);
    for (size_t i = 0; i < count; i++)
        pk_drift_keep(&monitor->momenta[i], k);
}

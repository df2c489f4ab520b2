/* Many steps of one size, from the start of a system that is compiled as a scene needs it: what it
 * keeps, and how well its state stays on its constraints. argv: a method, the step, steps, and after
 * how many of them to look. -DBENCH_SYSTEM=NAME_system.
 *
 * Prints coordinates, rotations, holonomic rows and rolling rows; then the largest | |Q| - 1 |, the
 * largest residuals of places and of rates beside the sizes of their terms, the drift of the energy
 * (-1: it is not kept) and the power of t with which it grows, the largest drift of a momentum or a
 * claim (-1: there is none), seconds of all steps without the looks, and what is said of the growth.
 */
#define _POSIX_C_SOURCE 200809L

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include <pk/constraint.h>
#include <pk/diagnostics.h>
#include <pk/pk.h>

extern const struct pk_system BENCH_SYSTEM;

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int failed(struct pk_integrator *it)
{
    char why[256];
    pk_integrator_reason(it, why, sizeof why);
    fprintf(stderr, "%s\n", why);
    return 1;
}

static double larger(double a, double b)
{
    return a > b ? a : b;
}

struct look {
    struct pk_monitor monitor;
    void *block;
    size_t size;
    double norm, place, rate;
};

/* 0; 1 where there are no residuals, said. */
static int look(struct look *seen, const struct pk_problem *problem, const struct pk_integrator *it)
{
    struct pk_residuals found;
    pk_monitor_update(&seen->monitor, it->t, it->q, it->v);
    const enum pk_status status = pk_constraint_residuals(problem, it->t, it->q, it->v, &found,
                                                          seen->block, seen->size);
    if (status != PK_DONE) {
        fprintf(stderr, "residuals at t = %g: %s\n", it->t, pk_status_text(status));
        return 1;
    }
    seen->norm = larger(seen->norm, found.norm);
    seen->place = larger(seen->place, found.position_relative);
    seen->rate = larger(seen->rate, found.rate_relative);
    return 0;
}

/* Of the momenta and claims that have a size to be relative to. */
static double others(const struct pk_monitor *monitor)
{
    double largest = -1;
    for (size_t i = 0; i < BENCH_SYSTEM.n_conserved; i++)
        if (monitor->conserved[i].scale > 1e-9)
            largest = larger(largest, pk_drift_max(&monitor->conserved[i]));
    for (size_t i = 0; monitor->momenta && i < BENCH_SYSTEM.n; i++)
        if (BENCH_SYSTEM.cyclic && BENCH_SYSTEM.cyclic[i] && monitor->momenta[i].scale > 1e-9)
            largest = larger(largest, pk_drift_max(&monitor->momenta[i]));
    return largest;
}

int main(int argc, char **argv)
{
    if (argc != 5) return 2;
    const struct pk_system *s = &BENCH_SYSTEM;
    const struct pk_method *method = pk_method_find(argv[1]);
    const double h = strtod(argv[2], NULL);
    const unsigned long steps = strtoul(argv[3], NULL, 10), every = strtoul(argv[4], NULL, 10);
    void *params = calloc(1, s->params_size);
    double *q = calloc(2 * s->n, sizeof *q), spent = 0;
    struct pk_problem problem = {.system = s, .params = params};
    struct pk_options options = pk_options_default();
    struct pk_integrator it;
    struct look seen = {.norm = 0};

    if (!method) return 2;
    s->defaults(params);
    s->start(params, q, q + s->n);
    options.h = h;
    const size_t size = pk_integrator_size(&problem, method);
    if (pk_integrator_init(&it, &problem, method, &options, 0, q, q + s->n, malloc(size), size))
        return failed(&it);
    const size_t watched = pk_monitor_size(&problem);
    if (pk_monitor_init(&seen.monitor, &problem, malloc(watched), watched) != PK_DONE) return 1;
    seen.size = pk_constraint_size(&problem);
    seen.block = malloc(seen.size);
    if (look(&seen, &problem, &it)) return 1;
    for (unsigned long done = 0; done < steps; done += every) {
        const double begin = now();
        if (pk_integrator_to(&it, h * (double)(done + every)) < 0) return failed(&it);
        spent += now() - begin;
        if (look(&seen, &problem, &it)) return 1;
    }
    const struct pk_drift *energy = &seen.monitor.energy;
    const int kept = seen.monitor.has_energy;
    pk_real power = 0;
    const enum pk_growth growth = pk_drift_growth(energy, &power, NULL);
    printf("%zu %zu %zu %zu %g %g %g %g %g %g %g %s\n", s->n - s->n_first_order, s->n_rotations,
           s->constraints.n_holonomic, s->constraints.n - s->constraints.n_holonomic, seen.norm, seen.place, seen.rate,
           kept ? pk_drift_max(energy) : -1, power, others(&seen.monitor), spent,
           kept ? pk_growth_text(growth) : "not kept");
    return 0;
}

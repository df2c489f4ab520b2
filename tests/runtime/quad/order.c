/* Measured orders in __float128, on the pendulum and the double pendulum: slopes within .1 (above
 * order 8, of which fewer steps tell, .25) for methods whose errors reach round-off too soon in
 * double. Prints and returns 1 on a miss.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include <pk/pk.h>

#include "attitude_series.h"
#include "systems.h"

enum { FAILED, MADE, SHORTENED }; /* the last where an iteration could not take the step */

static pk_real block[1 << 15];

enum { MOST = 10 }; /* degrees of freedom */

/* (q, v) at t_end in the given number of steps; adaptive methods made to take just these. */
static int run(const struct pk_system *system, const char *name, int steps, pk_real t_end,
               pk_real *end)
{
    struct test_params params;
    struct pk_integrator it;
    struct pk_problem problem = {.system = system, .params = &params};
    struct pk_options options = pk_options_default();
    pk_real q[MOST], v[MOST];
    system->defaults(&params);
    system->start(&params, q, v);
    options.h = options.h_max = t_end / steps;
    options.rtol = options.atol = 1e10Q;
    options.newton_tol = strcmp(name, "gauss") == 0 || strcmp(name, "radau") == 0 ? 1e-32Q : 0;
    if (pk_integrator_init(&it, &problem, pk_method_find(name), &options, 0, q, v, block,
                           sizeof block) < 0 ||
        pk_integrator_to(&it, t_end) < 0)
        return FAILED;
    if (it.count.steps != (unsigned long)steps)
        return SHORTENED;
    memset(end, 0, system->n * sizeof *q);
    memcpy(end, it.q, (system->n - system->n_first_order) * sizeof *q); /* no integrals of states */
    memcpy(end + system->n, it.v, system->n * sizeof *q);
    return MADE;
}

/* The four or five finest steps whose errors are above those of the reference and of round-off. */
static int check(const struct pk_system *system, const char *name)
{
    const int order = pk_method_find(name)->order;
    pk_real exact[2 * MOST], end[2 * MOST], sx = 0, sy = 0, sxx = 0, sxy = 0;
    const int high = order > 8; /* reaches round-off soon: a longer run has more steps till then */
    const int points = high ? 4 : 5;
    const pk_real t_end = system == &double_pendulum_system ? (high ? 1 : 0.4Q) : high ? 4 : 1;
    int count = 0;
    if (run(system, "gauss8", 500, t_end, exact) != MADE)
        return 1;
    for (int steps = high ? 260 : 400; steps > 4 && count < points; steps = steps * 4 / 5) {
        pk_real e = 0;
        const int made = run(system, name, steps, t_end, end);
        if (made == FAILED)
            return 1;
        for (size_t i = 0; i < 2 * system->n; i++)
            e = fmaxq(e, fabsq(end[i] - exact[i]));
        if (made == SHORTENED || !(e > 1e-30Q))
            continue;
        const pk_real x = logq(1 / (pk_real)steps), y = logq(e);
        sx += x, sy += y, sxx += x * x, sxy += x * y;
        count++;
    }
    if (count < points)
        return 1;
    const double slope = (double)((count * sxy - sx * sy) / (count * sxx - sx * sx));
    const double off = system == &turning_system    ? 0.4 /* dop853's comes down to 8 late */
                       : !high                      ? 0.1
                       : system == &pendulum_system ? 0.15
                                                    : 0.25;
    const int failed = !(fabs(slope - order) < off);
    printf("quad: %-16s %-7s order %d%s %.3f\n", system->name, name, order,
           failed ? " but" : ", measured", slope);
    return failed;
}

/* The exact flow, to this precision's round-off too. */
static int check_exact(void)
{
    pk_real end[4];
    if (run(&oscillator_system, "exponential", 1000, 70, end) != MADE)
        return 1;
    const pk_real error = fabsq(end[0] - (0.7Q * cosq(70) + 0.2Q * sinq(70)));
    printf("quad: %-16s exponential errs by %.1e\n", oscillator_system.name, (double)error);
    return !(error > 0 && error < 1e-32Q);
}

/* Attitudes by small angles, to this precision's round-off. */
static int check_small_angles(void)
{
    pk_real exp_off, dexp_off;
    series_of_attitudes(18, &exp_off, &dexp_off); /* 7/512 */
    printf("quad: small angles, off by %.2g and %.2g eps\n", (double)exp_off, (double)dexp_off);
    return !(exp_off > 0 && exp_off < 4 && dexp_off > 0 && dexp_off < 3);
}

/* Methods on SO(3) and with constraints: order 6 and 8 where M depends on the attitude, with forces
 * of time, and on a constraint that moves. */
static int check_bound(const struct pk_method *m)
{
    int failed = check(&carriage_system, m->name);
    if (m->traits & PK_HOLONOMIC)
        failed |= check(&wire_system, m->name) | check(&jointed_system, m->name);
    return failed;
}

int main(void)
{
    int failed = check_exact() | check_small_angles(), found = 0, with_states = 0;
    for (size_t i = 0; pk_method_at(i); i++) {
        const struct pk_method *m = pk_method_at(i);
        if (m->order < 5)
            continue;
        failed |= check(&pendulum_system, m->name);
        found++;
        if (m->traits & PK_GROUP)
            failed |= check_bound(m);
        if (m->order > 6) {
            failed |= check(&turning_system, m->name);
            with_states++;
        }
        if (m->needs & PK_MASS_CONSTANT) {
            failed |= check(&driven_system, m->name);
            continue;
        }
        if (m->order > 5) /* dopri5's leading error all but cancels here: 4.92 at h = 1/2500 */
            failed |= check(&double_pendulum_system, m->name);
        if (m->traits & PK_IMPLICIT) /* Gauss keeps 2 s with dissipation, forces, explicit time */
            failed |= check(&forced_system, m->name) | check(&relativistic_system, m->name);
    }
    failed |= found < 14 || with_states < 9;
    puts(failed ? "quad: FAILED" : "quad: all orders as claimed");
    return failed;
}

/* Dense output of the adaptive Gauss method: as accurate inside a step as at its ends, also where
 * the step is longer than its iteration could bear.
 */
#include "fixture.h"
#include "core/generic.h"

#include <pk/step/gauss_stages.h>

static struct fixture f;

/* The stages' own polynomial, integrated from the step's start. */
static void stage_polynomial(double t, double *q, double *v)
{
    const size_t n = f.it.n;
    const struct pk_gauss_lanes w = pk_gauss_lanes(&f.it, f.it.n_q, n, f.it.own->work);
    const double h = *w.h, x = (t - f.it.last_t) / h - 1;
    for (size_t i = 0; i < n; i++) {
        const double *c = w.poly + i * PK_GAUSS_S;
        double once = 0, twice = 0, first = 0;
        for (int k = 0; k < PK_GAUSS_S; k++) { /* of x^k, from -1 */
            const double sign = k % 2 ? 1 : -1;
            once += c[k] * (pow(x, k + 1) - sign) / (k + 1);
            first += c[k] * sign / (k + 1);
            twice += c[k] * (pow(x, k + 2) + sign) / ((k + 1) * (k + 2));
        }
        v[i] = w.start[n + i] + h * once;
        q[i] = w.start[i] + h * (x + 1) * w.start[n + i] + h * h * (twice - first * (x + 1));
    }
}

TEST("as accurate as the steps")
{
    static struct fixture e;
    for (double tol = 1e-6; tol > 5e-13; tol /= 1000) {
        double inside = 0, stages = 0, ends = 0;
        fixture_open(&f, &double_pendulum_system, "gauss", tol);
        while (f.it.t < 3) {
            double q0[2], v0[2], q[2], v[2];
            const double t0 = f.it.t;
            memcpy(q0, f.it.q, sizeof q0);
            memcpy(v0, f.it.v, sizeof v0);
            CU_ASSERT_FATAL(pk_integrator_step(&f.it, 10) == PK_DONE);
            const unsigned long before = f.it.count.evaluations;
            for (int k = 1; k <= 4; k++) {
                const double t = k == 4 ? f.it.t : t0 + k * (f.it.t - t0) / 4;
                fixture_exact(&e, &double_pendulum_system, q0, v0, t - t0, 20);
                CU_ASSERT_FATAL(pk_integrator_dense(&f.it, t, q, v) == PK_DONE);
                double *worst = k == 4 ? &ends : &inside;
                *worst = fmax(*worst, fixture_distance(&e, q, v));
                stage_polynomial(t, q, v);
                if (k < 4)
                    stages = fmax(stages, fixture_distance(&e, q, v));
            }
            CU_ASSERT(f.it.count.evaluations > before); /* paid once, however many rows */
            const unsigned long after = f.it.count.evaluations;
            CU_ASSERT(pk_integrator_dense(&f.it, t0, q, v) == PK_DONE);
            CU_ASSERT(q[0] == q0[0] && v[1] == v0[1] && f.it.count.evaluations == after);
        }
        printf("\n    tolerance %.0e: ends %.1e, inside %.1e, stage polynomial %.1e", tol, ends,
               inside, stages);
        CU_ASSERT(inside > 0 && inside < 10 * tol && stages > 30 * inside);
    }
    double q[2], v[2];
    CU_ASSERT(pk_integrator_dense(&f.it, f.it.t + 1, q, v) == PK_BAD_ARGUMENT);
}

enum { MASSES = 400 };

/* q_i'' = q_i+1 - 2 q_i + q_i-1 between walls. */
static int chain_acceleration(ARGS, double *a)
{
    UNUSED;
    for (int i = 0; i < MASSES; i++)
        a[i] = (i + 1 < MASSES ? q[i + 1] : 0) - 2 * q[i] + (i > 0 ? q[i - 1] : 0);
    return 0;
}

/* Two slow modes, which alone are in the start. */
static void chain_exact(double t, double *q, double *v)
{
    const double angle = acos(-1) / (MASSES + 1);
    for (int i = 0; i < MASSES; i++)
        q[i] = v[i] = 0;
    for (int k = 1; k <= 3; k += 2) {
        const double omega = 2 * sin(k * angle / 2);
        for (int i = 0; i < MASSES; i++) {
            q[i] += sin(k * (i + 1) * angle) / k * cos(omega * t);
            v[i] -= sin(k * (i + 1) * angle) / k * omega * sin(omega * t);
        }
    }
}

static double chain_error(double t, const double *q, const double *v)
{
    static double exact_q[MASSES], exact_v[MASSES];
    double worst = 0;
    chain_exact(t, exact_q, exact_v);
    for (int i = 0; i < MASSES; i++)
        worst = fmax(worst, fmax(fabs(q[i] - exact_q[i]), fabs(v[i] - exact_v[i])));
    return worst;
}

/* A long chain oscillates much faster than it moves: h omega is some 30 where a fixed point of the
 * whole step is out of reach. */
TEST("longer steps than it contracts over")
{
    static const struct pk_system system = {.abi = PK_ABI,
                                            .name = "chain",
                                            .facts = PK_SEPARABLE | PK_QUADRATIC | PK_SMOOTH,
                                            .n = MASSES,
                                            .acceleration = chain_acceleration};
    static double block[1 << 17], q[MASSES], v[MASSES], row_q[MASSES], row_v[MASSES];
    const struct pk_problem problem = {.system = &system};
    const struct pk_method *gauss = pk_method_find("gauss");
    struct pk_options options = pk_options_default();
    struct pk_integrator it;
    CU_ASSERT_FATAL(pk_integrator_size(&problem, gauss) <= sizeof block);
    for (double tol = 1e-6; tol > 5e-11; tol /= 100) {
        double longest = 0, ends = 0, inside = 0;
        unsigned long rows = 0;
        options.rtol = options.atol = tol;
        chain_exact(0, q, v);
        CU_ASSERT_FATAL(pk_integrator_init(&it, &problem, gauss, &options, 0, q, v, block,
                                           sizeof block) == PK_DONE);
        while (it.t < 400) {
            CU_ASSERT_FATAL(pk_integrator_step(&it, 400) == PK_DONE);
            longest = fmax(longest, it.t - it.last_t);
            ends = fmax(ends, chain_error(it.t, it.q, it.v));
            for (int k = 1; k < 8; k++) { /* not in order: back to an earlier piece */
                const double t = it.last_t + k * 3 % 8 * (it.t - it.last_t) / 8;
                const enum pk_status status = pk_integrator_dense(&it, t, row_q, row_v);
                CU_ASSERT(status == PK_DONE);
                rows++;
                inside = fmax(inside, status < 0 ? 1 : chain_error(t, row_q, row_v));
            }
        }
        printf("\n    %d masses at %.0e: h omega to %.0f, error at ends %.1e, inside %.1e", MASSES,
               tol, 2 * longest, ends, inside);
        CU_ASSERT(2 * longest > 15 && rows > 40);
        CU_ASSERT(ends > 0 && inside > 0 && inside < 2 * ends + tol);
    }
}

/* Each method that has it: the end of a step is the step's, and inside it errs as its end does, or
 * as the tolerance, of an interpolant of lower order a hundred times; a straight line between both
 * ends does not. */
TEST("every method")
{
    static const struct pk_system *const systems[] = {&pendulum_system,   &double_pendulum_system,
                                                      &kepler_system,     &driven_system,
                                                      &oscillator_system, &relativistic_system};
    static struct fixture e;
    int made = 0;
    for (size_t i = 0; pk_method_at(i); i++) {
        double worst = 0, line = 0, ends = 0;
        const struct pk_method *method = pk_method_at(i);
        CU_ASSERT(!method->dense == !(method->traits & PK_DENSE));
        if (method->traits & PK_JETS) /* tests/runs/test_taylor.py */
            continue;
        for (size_t k = 0; method->dense && k < sizeof systems / sizeof *systems; k++) {
            fixture_set(&f, systems[k]);
            f.options.h = 0.02;
            f.options.rtol = f.options.atol = 1e-7;
            if (fixture_init(&f, method->name) < 0)
                continue;
            for (int step = 0; step < 20; step++) {
                double q0[2], v0[2], q[2], v[2];
                const double t0 = f.it.t;
                memcpy(q0, f.it.q, sizeof q0);
                memcpy(v0, f.it.v, sizeof v0);
                CU_ASSERT_FATAL(pk_integrator_step(&f.it, 5) == PK_DONE);
                fixture_set(&e, systems[k]);
                e.options.rtol = e.options.atol = 1e-13;
                memcpy(e.q0, q0, sizeof q0);
                memcpy(e.v0, v0, sizeof v0);
                fixture_start(&e, "dop853", 0);
                CU_ASSERT_FATAL(pk_integrator_reset(&e.it, t0, q0, v0) == PK_DONE);
                double inside = 0, straight = 0;
                for (int part = 1; part <= 8; part++) {
                    const double t = part == 8 ? f.it.t : t0 + part * (f.it.t - t0) / 8;
                    CU_ASSERT_FATAL(pk_integrator_to(&e.it, t) == PK_DONE);
                    CU_ASSERT_FATAL(pk_integrator_dense(&f.it, t, q, v) == PK_DONE);
                    inside = fmax(inside, part < 8 ? fixture_distance(&e, q, v) : 0);
                    for (size_t n = 0; n < f.it.n; n++) {
                        const double end = fabs(q[n] - f.it.q[n]) + fabs(v[n] - f.it.v[n]);
                        ends = fmax(ends, part == 8 ? end : 0);
                        q[n] = q0[n] + part * (f.it.q[n] - q0[n]) / 8;
                        v[n] = v0[n] + part * (f.it.v[n] - v0[n]) / 8;
                    }
                    straight = fmax(straight, part < 8 ? fixture_distance(&e, q, v) : 0);
                }
                const double bound = 1e-7 + fixture_distance(&e, f.it.q, f.it.v);
                worst = fmax(worst, inside / bound);
                line = fmax(line, straight / bound);
                made++;
            }
        }
        if (method->dense) {
            printf("\n    %s: at ends %.1e, inside %.2g of the bound, a line %.0f", method->name,
                   ends, worst, line);
            const double most = method->dense_order < method->order ? 100 : 3;
            CU_ASSERT(ends < 1e-14 && worst > 0 && worst < most && line > 10 * most);
        }
    }
    CU_ASSERT(made > 200);
}

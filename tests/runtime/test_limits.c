/* Linear limits of the step on q'' = -q: bounded at .999 of the limit, growing at 1.001. The
 * predictions are closed forms: 2, 2, 1.5734019474 for symplectic Euler, Verlet, Yoshida4; 2 sqrt 2
 * for RK4 on the imaginary axis; and h omega < 2, 2 sqrt 3, 4.6443707 for fixed-point iteration of
 * Gauss with 1, 2, 3 stages (spectral radius of h^2 A^2), where Newton has no limit.
 */
#include "fixture.h"

static double growth(const char *method, double h, int steps)
{
    static struct fixture f;
    fixture_set(&f, &oscillator_system);
    f.options.h = h;
    CU_ASSERT_FATAL(fixture_init(&f, method) == PK_DONE);
    for (int i = 0; i < steps; i++)
        if (pk_integrator_step(&f.it, 1e9) < 0)
            return (double)INFINITY;
    return fabs(f.it.q[0]) + fabs(f.it.v[0]);
}

static void stability(void)
{
    static const struct {
        const char *name;
        double limit;
    } row[] = {{"symplectic_euler", 2}, {"verlet", 2}, {"yoshida4", 1.5734019474},
               {"rk4", 2.8284271247}};
    for (int i = 0; i < 4; i++) {
        const double below = growth(row[i].name, 0.999 * row[i].limit, 4000);
        const double above = growth(row[i].name, 1.001 * row[i].limit, 4000);
        printf("\n    %-16s .999: %.3g, 1.001: %.3g", row[i].name, below, above);
        CU_ASSERT(below < 300 && above > 1e6);
        if (i < 3)
            CU_ASSERT(below > 1e-6);
    }
    CU_ASSERT(growth("euler", 0.1, 1000) > 50); /* no limit at all */
    CU_ASSERT(growth("gauss1", 50, 1000) < 60 && growth("gauss4", 50, 1000) < 60);
}

static void exact_invariants(void)
{
    static struct fixture f;
    const double h = 1.9;
    for (int m = 0; m < 2; m++) { /* p^2 + q^2 - h p q, and p^2 + (1 - h^2/4) q^2 */
        fixture_set(&f, &oscillator_system);
        f.options.h = h;
        fixture_init(&f, m ? "verlet" : "symplectic_euler");
        double first = 0, worst = 0, swing = 0;
        for (int i = 0; i <= 1000; i++) {
            const double q = f.it.q[0], p = f.it.v[0];
            const double x = p * p + (m ? (1 - h * h / 4) * q * q : q * q - h * p * q);
            first = i ? first : x;
            worst = fmax(worst, fabs(x - first) / first);
            swing = fmax(swing, fabs(p * p + q * q - f.v0[0] * f.v0[0] - f.q0[0] * f.q0[0]));
            pk_integrator_step(&f.it, 1e9);
        }
        CU_ASSERT(worst < 1e-12 && swing > 0.1);
    }
    /* Explicit Euler multiplies the energy by 1 + h^2 a step: 20959.1556378 in 1000 of .1. */
    fixture_set(&f, &oscillator_system);
    f.options.h = 0.1;
    fixture_init(&f, "euler");
    const double e0 = f.q0[0] * f.q0[0] + f.v0[0] * f.v0[0];
    for (int i = 0; i < 1000; i++)
        pk_integrator_step(&f.it, 1e9);
    const double e = f.it.q[0] * f.it.q[0] + f.it.v[0] * f.it.v[0];
    CU_ASSERT(fabs(e / e0 / 20959.1556378 - 1) < 1e-10);
}

static void fixed_point(void)
{
    static const double limit[] = {2, 3.4641016, 4.6443707};
    static struct fixture f;
    for (int s = 0; s < 3; s++)
        for (int newton = 0; newton < 2; newton++)
            for (int above = 0; above < 2; above++) {
                char name[] = "gauss0";
                name[5] = (char)('1' + s);
                fixture_set(&f, &oscillator_system);
                f.options.h = limit[s] * (above ? 1.001 : 0.999);
                f.options.iteration = newton ? PK_NEWTON : PK_FIXED_POINT;
                f.options.max_iterations = newton ? 0 : 100000;
                CU_ASSERT_FATAL(fixture_init(&f, name) == PK_DONE);
                enum pk_status status = PK_DONE;
                for (int i = 0; i < 20 && status == PK_DONE; i++)
                    status = pk_integrator_step(&f.it, 1e9);
                CU_ASSERT(status == (above && !newton ? PK_NO_CONVERGENCE : PK_DONE));
            }
}

void add_limits(void)
{
    CU_pSuite suite = CU_add_suite("limits", NULL, NULL);
    CU_add_test(suite, "stable at .999, growing at 1.001", stability);
    CU_add_test(suite, "exact invariants", exact_invariants);
    CU_add_test(suite, "fixed-point iteration", fixed_point);
}

/* Linear limits of the step (pk/limits.h). Predictions, closed forms or roots of the polynomials
 * found elsewhere: 2, 2, 1.5734019474, 2.2690579964, 2.7209745386, 2.5326273883 for symplectic
 * Euler, Verlet, Yoshida 4 and 6, Suzuki 4, Kahan-Li 6; on the imaginary axis 0, sqrt 3, 2 sqrt 2,
 * 0.9971890086 for RK2, RK3, RK4, DOPRI5, on the real one 2, 2.5127453266, 2.7852935634 for RK2,
 * RK3, RK4. And what tables say is what steps do: bounded at .999 of a limit, growing at 1.001 as
 * fast as the map does. h omega < 2, 2 sqrt 3, 4.6443707 for fixed-point iteration of Gauss with 1,
 * 2, 3 stages (spectral radius of h^2 A^2), where Newton has no limit.
 */
#include "fixture.h"

TEST("as predicted")
{
    static const struct {
        const char *name;
        double imaginary, real; /* real < 0: has none; splitting: the drag is exact */
    } row[] = {{"euler", 0, 2},
               {"rk2", 0, 2},
               {"rk3", 1.7320508076, 2.5127453266},
               {"rk4", 2.8284271247, 2.7852935634},
               {"dopri5", 0.9971890086, 3.3065678926},
               {"symplectic_euler", 2, INFINITY},
               {"verlet", 2, INFINITY},
               {"adaptive_verlet", 2, -1},
               {"yoshida4", 1.5734019474, INFINITY},
               {"suzuki4", 2.7209745386, INFINITY},
               {"yoshida6", 2.2690579964, INFINITY},
               {"kahan_li6", 2.5326273883, INFINITY},
               {"boris", 2, INFINITY}};
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        const struct pk_method *m = pk_method_find(row[i].name);
        const double imaginary = pk_method_limit(m, PK_AXIS_IMAGINARY);
        const double real = pk_method_limit(m, PK_AXIS_REAL);
        printf("\n    %-16s %.10f %.10f", m->name, imaginary, real);
        CU_ASSERT(fabs(imaginary - row[i].imaginary) < 1e-10);
        CU_ASSERT(row[i].real < 0     ? real != real
                  : row[i].real > 100 ? real > 1e30
                                      : fabs(real - row[i].real) < 1e-10);
    }
    static const char *const unlimited[] = {"gauss1", "gauss4", "gauss8", "gauss"};
    for (size_t i = 0; i < 4; i++)
        for (int axis = 0; axis < 2; axis++)
            CU_ASSERT(pk_method_limit(pk_method_find(unlimited[i]), (enum pk_axis)axis) > 1e30);
    /* Growth narrower than the grid, about a period of two steps, and none after it up to 6.34. */
    double growth[2];
    const struct pk_method *narrow = pk_method_find("blanes_moan6");
    CU_ASSERT(pk_method_growth(narrow, PK_AXIS_IMAGINARY, 0, growth) == 1);
    CU_ASSERT(growth[0] > 3.1414 && growth[0] < acos(-1) && growth[1] > acos(-1) &&
              growth[1] < 3.1424);
    CU_ASSERT(pk_method_growth(narrow, PK_AXIS_IMAGINARY, growth[1] * 1.0001, growth) == 1);
    CU_ASSERT(growth[0] > 6.34 && growth[1] < 6.36);
    const double none = pk_method_limit(pk_gsl_method_find("gsl_rk8pd"), PK_AXIS_IMAGINARY);
    CU_ASSERT(none != none);
}

/* The logarithm of what n steps of y make of the amplitude, per step. */
static double growth(const struct pk_system *system, const struct pk_method *method, double y,
                     unsigned long n)
{
    static struct fixture f;
    fixture_set(&f, system);
    f.options.h = y; /* an adaptive method makes just these */
    f.options.h_max = method->needs & PK_SEPARABLE ? 0 : y; /* adaptive_verlet */
    f.options.rtol = f.options.atol = 1e300;
    fixture_start(&f, method->name, 0);
    for (unsigned long i = 0; i < n; i++)
        if (pk_integrator_step(&f.it, 1e12) < 0)
            return (double)INFINITY;
    CU_ASSERT(f.it.count.steps == n && fabs(f.it.t - y * (double)n) < 1e-8 * f.it.t);
    return log(hypot(f.it.q[0], f.it.v[0]) / hypot(f.q0[0], f.v0[0])) / (double)n;
}

static int drag_acceleration(ARGS, double *a)
{
    UNUSED;
    a[0] = -v[0];
    return 0;
}

static void drag_linear(ARGS, const double *a, double *r_q, double *r_v, double *r_t)
{
    (void)params, (void)t, (void)q, (void)v, (void)u, (void)a;
    r_q[0] = r_t[0] = 0;
    r_v[0] = -1;
}

/* At a limit's two sides, and in the middle of growth that a thousandth above is over again. */
static void step_against_table(enum pk_axis axis)
{
    static struct pk_system drag;
    drag = oscillator_system;
    drag.acceleration = drag_acceleration;
    drag.linear = drag_linear;
    drag.facts = PK_MASS_CONSTANT | PK_QUADRATIC | PK_AUTONOMOUS | PK_LINEAR_DRAG;
    drag.steppers = NULL;
    const struct pk_system *system = axis == PK_AXIS_REAL ? &drag : &oscillator_system;
    int found = 0;
    for (size_t i = 0; pk_method_at(i); i++) {
        const struct pk_method *m = pk_method_at(i);
        double interval[2], map[4] = {0};
        if (!pk_method_growth(m, axis, 0, interval) || interval[0] > 1e30 ||
            (m->traits & PK_IMPLICIT) || m->needs & PK_FAST) /* something is fast here */
            continue;
        found++;
        const double limit = interval[0];
        const double above = interval[1] < 1.001 * limit ? (limit + interval[1]) / 2
                                                         : 1.001 * limit;
        const double y = limit > 0 ? above : 0.1;
        CU_ASSERT((axis == PK_AXIS_REAL ? pk_method_decay(m, y, map)
                                        : pk_method_oscillator(m, y, map)) == PK_DONE);
        const double rate = log(pk_map_growth(map));
        const unsigned long n = rate > 5e-4 ? (unsigned long)(50 / rate) : 100000;
        const double over = growth(system, m, y, n);
        CU_ASSERT(rate > 0 && over * (double)n > 0.04);
        /* v = 0 is reached, and q stays: what is left of a decay is not the rate's. */
        CU_ASSERT(fabs(over / rate - 1) < 0.15);
        printf("\n    %-16s above %.6f: %.3e a step, of the map %.3e", m->name, limit, over, rate);
        if (!(limit > 0))
            continue;
        const double below = growth(system, m, 0.999 * limit, 4000) * 4000;
        printf(", below by %.2g in 4000", below);
        CU_ASSERT(below < log(300));
    }
    CU_ASSERT(found >= (axis == PK_AXIS_REAL ? 6 : 18));
}

TEST("an oscillation: stable at .999, growing at 1.001") { step_against_table(PK_AXIS_IMAGINARY); }
TEST("a decay: stable at .999, growing at 1.001") { step_against_table(PK_AXIS_REAL); }

/* A step's own frequency: 2 asin(y/2) of Verlet, 2 atan(y/2) of the midpoint rule; RK4's damping,
 * |R|^2 = 1 - y^6/72 + y^8/576; a map that is run is that of its table. */
TEST("maps")
{
    const double y = 0.1;
    double map[4], other[4];
    CU_ASSERT(pk_method_oscillator(pk_method_find("verlet"), y, map) == PK_DONE);
    CU_ASSERT(fabs(pk_map_angle(map) / y - 1 - 4.171361e-4) < 1e-10);
    CU_ASSERT(pk_method_oscillator(pk_method_find("gauss1"), y, map) == PK_DONE);
    CU_ASSERT(fabs(pk_map_angle(map) / y - 1 + 8.320856e-4) < 1e-10);
    CU_ASSERT(pk_method_oscillator(pk_method_find("rk4"), 1.3, map) == PK_DONE);
    const double square = pk_map_growth(map) * pk_map_growth(map);
    CU_ASSERT(fabs(square - (1 - pow(1.3, 6) / 72 + pow(1.3, 8) / 576)) < 1e-14 && square < 0.95);
    for (size_t i = 0; pk_method_at(i); i++) {
        struct pk_method own = *pk_method_at(i);
        if (own.formula || pk_method_oscillator(&own, 0.9, map) < 0)
            continue;
        struct fixture f;
        for (int column = 0; column < 2; column++) {
            fixture_set(&f, &oscillator_system);
            f.options.h = f.options.h_max = 0.9;
            f.options.rtol = f.options.atol = 1e10;
            f.q0[0] = column == 0, f.v0[0] = column == 1;
            fixture_start(&f, own.name, 0);
            CU_ASSERT(pk_integrator_step(&f.it, 0.9) == PK_DONE && f.it.t == 0.9);
            other[column] = f.it.q[0], other[2 + column] = f.it.v[0];
        }
        for (int k = 0; k < 4; k++)
            CU_ASSERT(fabs(map[k] - other[k]) < 1e-14);
        CU_ASSERT(fabs(map[0]) > 0.1);
    }
    CU_ASSERT(pk_method_oscillator(pk_method_find("rk4"), 0, map) == PK_BAD_ARGUMENT);
    CU_ASSERT(pk_method_decay(pk_method_find("verlet"), 1, map) == PK_DONE);
    CU_ASSERT(fabs(map[0] - exp(-1)) < 1e-15);
    CU_ASSERT(pk_method_decay(pk_method_find("boris"), 1, map) == PK_DONE);
    CU_ASSERT(fabs(map[0] - 1. / 3) < 1e-15);
    CU_ASSERT(pk_method_decay(pk_method_find("adaptive_verlet"), 1, map) == PK_REFUSED);
}

/* A spring of any stiffness with damping: the midpoint rule is (1 - hA/2)^-1 (1 + hA/2) of
 * A = (0 1; -K -C); Verlet is kick, exact drag, kick. A pole takes no step. */
TEST("springs")
{
    static const double K[] = {2, -1.5, 0}, C[] = {0.3, -0.2, 1};
    const struct pk_method *midpoint = pk_method_find("gauss1");
    double map[4];
    for (int i = 0; i < 3; i++) {
        const double h = 0.4, k = h * K[i] / 2, c = h * C[i] / 2, d = 1 + c + k * h / 2;
        CU_ASSERT_FATAL(pk_method_spring(midpoint, K[i], C[i], h, map) == PK_DONE);
        CU_ASSERT(fabs(map[0] - (1 + c - k * h / 2) / d) < 1e-14);
        CU_ASSERT(fabs(map[1] - h / d) < 1e-14);
        CU_ASSERT(fabs(map[2] + 2 * k / d) < 1e-14);
        CU_ASSERT(fabs(map[3] - (1 - c - k * h / 2) / d) < 1e-14);
    }
    CU_ASSERT_FATAL(pk_method_spring(pk_method_find("verlet"), 1, 0.1, 0.4, map) == PK_DONE);
    const double shrunk = exp(-0.04), drift = (1 - shrunk) / 0.1;
    CU_ASSERT(fabs(map[1] - drift) < 1e-15 && fabs(map[0] - (1 - 0.2 * drift)) < 1e-15);
    CU_ASSERT(fabs(map[3] - (shrunk - 0.2 * drift)) < 1e-15);
    CU_ASSERT(fabs(map[0] * map[3] - map[1] * map[2] - shrunk) < 1e-15);
    CU_ASSERT(pk_method_spring(midpoint, -1, 0, 2.1, map) == PK_AMBIGUOUS_STEP);
    CU_ASSERT(pk_method_spring(midpoint, 1, 0, 0, map) == PK_BAD_ARGUMENT);
}

TEST("exact invariants")
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

TEST("fixed-point iteration")
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
                fixture_start(&f, name, 0);
                enum pk_status status = PK_DONE;
                for (int i = 0; i < 50 && status == PK_DONE; i++)
                    status = pk_integrator_step(&f.it, 1e9);
                CU_ASSERT(status == (above && !newton ? PK_NO_CONVERGENCE : PK_DONE));
                CU_ASSERT(status == PK_DONE ||
                          (says(&f.it, "fixed-point") && says(&f.it, "Newton's")));
            }
}

/* Actions and periods of one degree of freedom against closed forms: the pendulum's by elliptic
 * integrals, Kepler's radius, the oscillator; and what has none.
 */
#include "../../runtime/run/diagnose/motion.h"

#include "elliptic.h"
#include "fixture.h"

static const double PI = 3.14159265358979323846;

static int near(double x, double y, double within) { return fabs(x - y) <= within * fabs(y); }

static struct action found_of(const struct pk_system *system, double q, double v)
{
    static struct fixture f;
    struct action a;
    fixture_set(&f, system);
    const enum pk_status status = action_find(&a, &f.problem, 0, &q, &v, NULL);
    CU_ASSERT((status == PK_DONE) == (a.orbit <= ROTATION));
    return a;
}

static void swings(const struct pk_system *system)
{
    static const double small[] = {1e-150, 1e-9, 1e-4};
    for (int i = 0; i < 3; i++) {
        const struct action a = found_of(system, small[i], 0);
        CU_ASSERT(a.orbit == LIBRATION);
        CU_ASSERT(near(a.period, pendulum_period(small[i]), 2e-14));
        CU_ASSERT(near(a.action, pendulum_action(small[i]), 2e-14));
    }
    for (double amplitude = 0.1; amplitude < 3; amplitude += 0.1) {
        /* From rest at one end, and through the bottom. */
        const double speed = 2 * sin(amplitude / 2);
        const struct action a = found_of(system, -amplitude, 0);
        const struct action b = found_of(system, 0, -speed);
        CU_ASSERT(a.orbit == LIBRATION && b.orbit == LIBRATION);
        CU_ASSERT(near(a.hi, amplitude, 1e-14) && near(b.lo, -amplitude, 1e-13));
        CU_ASSERT(near(a.action, pendulum_action(amplitude), 1e-13));
        CU_ASSERT(near(a.period, pendulum_period(amplitude), 1e-13));
        CU_ASSERT(near(b.action, pendulum_action(amplitude), 1e-13));
        CU_ASSERT(near(b.period, pendulum_period(amplitude), 1e-13));
        CU_ASSERT(a.error < 1e-12 && a.nodes > 32 && a.nodes < 1024);
    }
    /* 179.9 degrees: what rounding makes of the other end is said. */
    const double amplitude = 179.9 / 180 * PI, T = pendulum_period(amplitude);
    const struct action a = found_of(system, amplitude, 0);
    CU_ASSERT(near(a.period, T, 1e-10) && fabs(a.period / T - 1) <= a.error && a.error < 1e-8);
}

/* Published: periods over that of small swings, and of m = .5 the action and the frequency. */
TEST("a swinging pendulum by elliptic integrals")
{
    static const double period[][2] = {
        {90, 1.1803405990}, {170, 2.4393627197}, {179, 3.9010651604}, {179.9, 5.3668671090}};
    swings(&pendulum_system);
    for (int i = 0; i < 4; i++) {
        const struct action a = found_of(&pendulum_system, period[i][0] * PI / 180, 0);
        CU_ASSERT(fabs(a.period / (2 * PI) - period[i][1]) < 6e-10);
    }
    const struct action half = found_of(&pendulum_system, PI / 2, 0);
    CU_ASSERT(fabs(half.action - 1.0787052024) < 6e-11);
    CU_ASSERT(fabs(2 * PI / half.period - .8472130848) < 6e-11);
}

/* Round from anywhere, either way. */
static void turns(const struct pk_system *system, double extra)
{
    for (double above = 0.01; above < 1e3; above *= 3)
        for (int way = -1; way <= 1; way += 2) {
            const double speed = way * sqrt(2 * above + 4);
            const struct action a = found_of(system, 0, speed);
            CU_ASSERT(a.orbit == ROTATION);
            CU_ASSERT(near(a.period, turn_period(above), 1e-13));
            CU_ASSERT(near(a.action - way * extra, turn_action(above), 1e-13));
        }
}

TEST("a turning pendulum") { turns(&pendulum_system, 0); }

/* The same pendulum in another coordinate, its angle is Q = q + sin(q)/2; and with a term b(q) v in
 * L that changes no motion: the action of what turns has its mean. */
static void bent_mass(ARGS, double *M)
{
    UNUSED;
    M[0] = (1 + cos(q[0]) / 2) * (1 + cos(q[0]) / 2);
}

static void bent_gradient(ARGS, double *d)
{
    UNUSED;
    CU_ASSERT_FATAL(!(v[0] < 0 || v[0] > 0)); /* at rest alone it is -dW/dq */
    d[0] = -sin(q[0] + sin(q[0]) / 2) * (1 + cos(q[0]) / 2);
}

static void bent_canonical(ARGS, double *p, double *pdot)
{
    double M;
    bent_mass(params, t, q, v, u, &M);
    bent_gradient(params, t, q, v, u, pdot);
    p[0] = M * v[0] + 0.3 + cos(q[0]) / 5;
}

static struct pk_system bent(void)
{
    struct pk_system system = pendulum_system;
    system.mass = bent_mass;
    system.gradient = bent_gradient;
    system.canonical = bent_canonical;
    return system;
}

TEST("the same in another coordinate")
{
    const struct pk_system system = bent();
    for (double q = 0.2; q < 3; q += 0.2) {
        const double amplitude = q + sin(q) / 2;
        const struct action a = found_of(&system, q, 0);
        if (amplitude < 3) {
            CU_ASSERT(near(a.period, pendulum_period(amplitude), 1e-12));
            CU_ASSERT(near(a.action, pendulum_action(amplitude), 1e-12));
        }
    }
    for (int way = -1; way <= 1; way += 2) {
        /* v = Q'/1.5 at the bottom */
        const struct action a = found_of(&system, 0, way * sqrt(6) / 1.5);
        CU_ASSERT(a.orbit == ROTATION);
        CU_ASSERT(near(a.period, turn_period(1), 1e-13));
        CU_ASSERT(near(a.action, turn_action(1) + way * 0.3, 1e-13));
    }
}

TEST("an oscillator, and Kepler's radius")
{
    /* The oscillator: J = h/omega. */
    const struct action a = found_of(&oscillator_system, 0.7, 0.2);
    CU_ASSERT(near(a.period, 2 * PI, 1e-14) && near(a.action, (0.49 + 0.04) / 2, 1e-14));
    CU_ASSERT(near(a.hi, sqrt(0.53), 1e-14) && near(a.lo, -sqrt(0.53), 1e-14));
    /* Kepler's radius, at h = -1/2 from any place: T = 2 pi, J = 1 - sqrt(.75) (Landau 50). */
    for (double r = 0.55; r < 1.5; r += 0.1) {
        const double v = sqrt(2 / r - 1 - 0.75 / (r * r));
        const struct action k = found_of(&radial_system, r, v);
        CU_ASSERT(near(k.period, 2 * PI, 1e-13) && near(k.action, 1 - sqrt(0.75), 1e-13));
        CU_ASSERT(near(k.lo, 0.5, 1e-13) && near(k.hi, 1.5, 1e-13));
    }
    /* Eccentricity .99995, as far out as 1e4 of the closest distance. */
    const double E = 0.375 / (0.5 * 0.5) - 2, far = sqrt(2 * (-E - 1e-4)), v = far;
    const struct action k = found_of(&radial_system, 0.5, v);
    const double h = v * v / 2 + E, semi = -1 / (2 * h);
    CU_ASSERT(near(k.period, 2 * PI * pow(semi, 1.5), 1e-11));
    CU_ASSERT(near(k.action, sqrt(semi) - sqrt(0.75), 1e-12));
}

TEST("motions that have none")
{
    CU_ASSERT(found_of(&pendulum_system, 0, 0).orbit == EQUILIBRIUM);
    CU_ASSERT(found_of(&pendulum_system, PI, 0).orbit == EQUILIBRIUM);
    CU_ASSERT(found_of(&pendulum_system, 0, 2).orbit == SEPARATRIX);
    CU_ASSERT(found_of(&pendulum_system, 1, 2 * cos(0.5)).orbit == SEPARATRIX);
    CU_ASSERT(found_of(&radial_system, 0.5, 2).orbit == UNBOUNDED);
    CU_ASSERT(found_of(&radial_system, 0.75, 0).orbit == EQUILIBRIUM);
    CU_ASSERT(found_of(&double_pendulum_system, 1, 1).orbit == SEVERAL);
    CU_ASSERT(found_of(&relativistic_system, 1, 0).orbit == NOT_QUADRATIC);
    struct pk_system free_mass = oscillator_system, bare = oscillator_system;
    free_mass.gradient = pushed_system.gradient;
    bare.gradient = NULL;
    CU_ASSERT(found_of(&bare, 1, 0).orbit == NO_KERNELS);
    /* A falling mass, whose force is its input; and without one it is free, on a line. */
    static struct fixture f;
    struct action a;
    const double q = 1, v[] = {0.5, 0}, u[] = {-1, 0};
    fixture_set(&f, &free_mass);
    for (int i = 0; i < 3; i++) {
        CU_ASSERT(action_find(&a, &f.problem, 0, &q, v + i / 2, u + i % 2) == PK_REFUSED);
        CU_ASSERT(a.orbit == UNBOUNDED);
    }
    for (int k = 0; k < ORBIT_COUNT; k++)
        CU_ASSERT(strlen(orbit_text((enum orbit)k)) > 5);
}

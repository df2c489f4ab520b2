/* Equilibria and normal modes against closed forms. Double pendulum, m = l = 1:
 * omega^2 = g (2 -+ sqrt 2) hanging, growth^2 the same upright, and g sqrt 2 for both of the
 * saddles with one rod up. Free and driven systems have none to find.
 */
#include <pk/gsl_equilibria.h>

#include "fixture.h"

enum { MOST = 8 };
static double found_q[MOST * 2], found_v[MOST * 2];
static struct pk_mode modes[4];
static double shapes[4 * 4];
static const double PI = 3.14159265358979323846;

static struct pk_equilibria seek(struct fixture *f, const struct pk_system *system, size_t most)
{
    struct pk_equilibria found = {.most = most, .q = found_q, .v = found_v};
    fixture_set(f, system);
    CU_ASSERT_FATAL(pk_gsl_equilibria(&f->problem, f->q0, f->v0, 100, &found) == PK_DONE);
    return found;
}

static size_t solve(struct fixture *f, size_t k)
{
    size_t count = 0;
    const size_t n = f->problem.system->n;
    CU_ASSERT_FATAL(pk_gsl_modes(&f->problem, found_q + k * n, found_v + k * n, modes, shapes,
                                 &count) == PK_DONE);
    return count;
}

static int near(double x, double y) { return fabs(x - y) <= 1e-12 * fabs(y); }

static void double_pendulum(void)
{
    static struct fixture f;
    static const double place[4][2] = {{0, 0}, {0, 1}, {1, 0}, {1, 1}}; /* half turns, by energy */
    const double g = 9.81;
    const double fast = sqrt(g * (2 + sqrt(2))), slow = sqrt(g * (2 - sqrt(2)));
    const double saddle = sqrt(g * sqrt(2));
    const struct pk_equilibria found = seek(&f, &double_pendulum_system, MOST);
    CU_ASSERT_FATAL(found.count == 4);
    CU_ASSERT(!found.more && found.singular == 0);
    for (int k = 0; k < 4; k++)
        for (int i = 0; i < 2; i++)
            CU_ASSERT(fabs(found_q[2 * k + i] - PI * place[k][i]) < 1e-12);
    CU_ASSERT(fabs(fast - 5.7873512980) < 1e-10 && fabs(slow - 2.3971993979) < 1e-10);
    /* Hanging: the fast mode has the rods against each other, theta2 = -sqrt 2 theta1. */
    CU_ASSERT_FATAL(solve(&f, 0) == 2);
    CU_ASSERT(near(modes[0].frequency, fast) && near(modes[1].frequency, slow));
    CU_ASSERT(!(modes[0].growth > 0) && !(modes[1].growth > 0));
    CU_ASSERT(near(shapes[0], -sqrt(0.5)) && near(shapes[1], 1));
    CU_ASSERT(near(shapes[4], sqrt(0.5)) && near(shapes[5], 1));
    for (size_t k = 1; k <= 2; k++) {
        CU_ASSERT_FATAL(solve(&f, k) == 3);
        CU_ASSERT(near(modes[0].growth, saddle) && near(modes[1].frequency, saddle));
        CU_ASSERT(near(modes[2].growth, -saddle));
    }
    CU_ASSERT_FATAL(solve(&f, 3) == 4);
    CU_ASSERT(near(modes[0].growth, fast) && near(modes[1].growth, -fast));
    CU_ASSERT(near(modes[2].growth, slow) && near(modes[3].growth, -slow));
}

static void few_at_most(void)
{
    static struct fixture f;
    const struct pk_equilibria found = seek(&f, &double_pendulum_system, 3);
    CU_ASSERT(found.count == 3 && found.more);
}

static void one_degree(void)
{
    static struct fixture f;
    struct pk_equilibria found = seek(&f, &pendulum_system, MOST);
    CU_ASSERT_FATAL(found.count == 2);
    CU_ASSERT(fabs(found_q[0]) < 1e-12 && near(found_q[1], PI));
    CU_ASSERT(solve(&f, 0) == 1 && near(modes[0].frequency, sqrt(f.params.g)));
    CU_ASSERT(solve(&f, 1) == 2 && near(modes[0].growth, sqrt(f.params.g)));
    /* From a start three turns on they are the same two places. */
    struct pk_equilibria again = {.most = MOST, .q = found_q, .v = found_v};
    const double turned = f.q0[0] + 6 * PI;
    CU_ASSERT(pk_gsl_equilibria(&f.problem, &turned, f.v0, 0, &again) == PK_DONE);
    CU_ASSERT(again.count == 1 && fabs(found_q[0]) < PI * (1 + 1e-12));
    found = seek(&f, &relativistic_system, MOST); /* M depends on the rate, and is 1 at rest */
    CU_ASSERT_FATAL(found.count == 1);
    CU_ASSERT(solve(&f, 0) == 1 && near(modes[0].frequency, sqrt(f.params.g)));
}

/* Forces that vanish at infinity are no equilibrium, and at a collision neither. */
static void none(void)
{
    static struct fixture f;
    const struct pk_equilibria found = seek(&f, &kepler_system, MOST);
    CU_ASSERT(found.count == 0 && found.failed == 101);
}

static void refused(void)
{
    static struct fixture f;
    struct pk_equilibria found = {.most = MOST, .q = found_q, .v = found_v, .count = 7};
    fixture_set(&f, &forced_system);
    CU_ASSERT(pk_gsl_equilibria(&f.problem, f.q0, f.v0, 100, &found) == PK_REFUSED);
    CU_ASSERT(found.count == 0);
    fixture_set(&f, &pushed_system);
    CU_ASSERT(pk_gsl_equilibria(&f.problem, f.q0, f.v0, 100, &found) == PK_REFUSED);
    /* M = limit - q: where it is negative there are no modes. */
    fixture_set(&f, &folded_system);
    size_t count = 7;
    const double q = f.params.limit + 1, v = 0;
    CU_ASSERT(pk_gsl_modes(&f.problem, &q, &v, modes, shapes, &count) == PK_SINGULAR_MASS);
    CU_ASSERT(count == 0);
}

void add_equilibria(void)
{
    CU_pSuite suite = CU_add_suite("equilibria", NULL, NULL);
    CU_add_test(suite, "double pendulum", double_pendulum);
    CU_add_test(suite, "no more than there is room for", few_at_most);
    CU_add_test(suite, "one degree of freedom", one_degree);
    CU_add_test(suite, "none", none);
    CU_add_test(suite, "refused", refused);
}

/* Equilibria against closed forms; free and driven systems have none to find. Their modes:
 * tests/cli/test_stability_modes.py. */
#include <pk/gsl_equilibria.h>

#include "fixture.h"

static struct fixture f;

enum { MOST = 8 };
static double found_q[MOST * 2], found_v[MOST * 2];
static const double PI = 3.14159265358979323846;

static struct pk_equilibria seek(const struct pk_system *system, size_t most)
{
    struct pk_equilibria found = {.most = most, .q = found_q, .v = found_v};
    fixture_set(&f, system);
    CU_ASSERT_FATAL(pk_gsl_equilibria(&f.problem, f.q0, f.v0, 100, &found) == PK_DONE);
    return found;
}

static int near(double x, double y) { return fabs(x - y) <= 1e-12 * fabs(y); }

TEST("double pendulum")
{
    static const double place[4][2] = {{0, 0}, {0, 1}, {1, 0}, {1, 1}}; /* half turns, by energy */
    const struct pk_equilibria found = seek(&double_pendulum_system, MOST);
    CU_ASSERT_FATAL(found.count == 4);
    CU_ASSERT(!found.more && found.singular == 0);
    for (int k = 0; k < 4; k++)
        for (int i = 0; i < 2; i++)
            CU_ASSERT(fabs(found_q[2 * k + i] - PI * place[k][i]) < 1e-12);
}

TEST("no more than there is room for")
{
    const struct pk_equilibria found = seek(&double_pendulum_system, 3);
    CU_ASSERT(found.count == 3 && found.more);
}

TEST("one degree of freedom")
{
    struct pk_equilibria found = seek(&pendulum_system, MOST);
    CU_ASSERT_FATAL(found.count == 2);
    CU_ASSERT(fabs(found_q[0]) < 1e-12 && near(found_q[1], PI));
    /* From a start three turns on they are the same two places. */
    struct pk_equilibria again = {.most = MOST, .q = found_q, .v = found_v};
    const double turned = f.q0[0] + 6 * PI;
    CU_ASSERT(pk_gsl_equilibria(&f.problem, &turned, f.v0, 0, &again) == PK_DONE);
    CU_ASSERT(again.count == 1 && fabs(found_q[0]) < PI * (1 + 1e-12));
    found = seek(&relativistic_system, MOST); /* M depends on the rate, and is 1 at rest */
    CU_ASSERT_FATAL(found.count == 1);
}

/* Forces that vanish at infinity are no equilibrium, and at a collision neither. */
TEST("none")
{
    const struct pk_equilibria found = seek(&kepler_system, MOST);
    CU_ASSERT(found.count == 0 && found.failed == 101);
}

TEST("refused")
{
    struct pk_equilibria found = {.most = MOST, .q = found_q, .v = found_v, .count = 7};
    fixture_set(&f, &forced_system);
    CU_ASSERT(pk_gsl_equilibria(&f.problem, f.q0, f.v0, 100, &found) == PK_REFUSED);
    CU_ASSERT(found.count == 0);
    fixture_set(&f, &pushed_system);
    CU_ASSERT(pk_gsl_equilibria(&f.problem, f.q0, f.v0, 100, &found) == PK_REFUSED);
}

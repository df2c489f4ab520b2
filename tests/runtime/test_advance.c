/* pk_integrator_steps() over a system's own fused steps: they end where single steps do, and a step
 * that fails is found in few tries.
 */
#include <pk/step/state.h>
#include "fixture.h"

static struct fixture f;

static const struct pk_system *fused_of;
static unsigned long fused_steps; /* made in all, those undone as well */

static void advance(const void *params, int stages, const pk_real *kick, const pk_real *drift,
                    pk_real t, pk_real h, unsigned long steps, pk_real *q, pk_real *v)
{
    pk_real a;
    fused_steps += steps;
    for (unsigned long k = 0; k < steps; k++) {
        pk_real done = 0;
        for (int i = 0; i <= stages; i++) {
            fused_of->acceleration(params, t + ((pk_real)k + done) * h, q, v, NULL, &a);
            v[0] += kick[i] * h * a;
            if (i < stages) {
                q[0] += drift[i] * h * v[0];
                done += drift[i];
            }
        }
    }
}

/* To t_end by steps of 1e-3, at most max_steps (0: any number), fused or one by one. */
static enum pk_status run(struct fixture *one, const struct pk_system *system, const char *method,
                          int fused, unsigned long max_steps, double t_end)
{
    static struct pk_system own;
    own = *system;
    own.families.advance = fused ? advance : NULL;
    fused_of = system;
    fused_steps = 0;
    fixture_set(one, &own);
    one->options.h = 1e-3;
    one->options.max_steps = max_steps;
    fixture_init(one, method);
    return pk_integrator_steps(&one->it, t_end, 0);
}

TEST("as single steps")
{
    static const char *const methods[] = {"symplectic_euler", "verlet", "yoshida4", "kahan_li8",
                                          "blanes_moan6"};
    static struct fixture one, all;
    for (size_t k = 0; k < sizeof methods / sizeof *methods; k++)
        for (double t_end = -3.00025; t_end < 4; t_end += 6.0005) {
            CU_ASSERT(run(&one, &driven_system, methods[k], 0, 0, t_end) == PK_DONE);
            CU_ASSERT(fused_steps == 0 && one.it.t == t_end);
            CU_ASSERT(run(&all, &driven_system, methods[k], 1, 0, t_end) == PK_DONE);
            CU_ASSERT(fused_steps > 2900 && all.it.t == t_end);
            CU_ASSERT(one.it.count.steps == all.it.count.steps);
            /* The acceleration at the end of a step is not kept over a call: once before, once
             * after. */
            const unsigned long again = methods[k][0] == 's' ? 0 : 2;
            CU_ASSERT(all.it.count.evaluations == one.it.count.evaluations + again);
            CU_ASSERT(fixture_distance(&all, one.it.q, one.it.v) < 1e-12);
            CU_ASSERT(fixture_distance(&all, all.q0, all.v0) > 0.1);
        }
}

/* Rows are ten steps apart, up to rounding of the time: no step is left over, none goes back. */
TEST("row after row")
{
    static const double steps[] = {0.01, 0.1, 0.02}, rows[] = {0.1, 0.7, 0.3};
    static const unsigned long each[] = {10, 7, 15};
    static struct pk_system own;
    own = driven_system;
    own.families.advance = advance;
    fused_of = &driven_system;
    for (size_t k = 0; k < 3; k++) {
        fixture_set(&f, &own);
        f.options.h = steps[k];
        fixture_init(&f, "verlet");
        for (unsigned long row = 1; row <= 2000; row++) {
            CU_ASSERT(pk_integrator_steps(&f.it, (double)row * rows[k], 0) == PK_DONE);
            CU_ASSERT(f.it.own->direction > 0 && f.it.t == (double)row * rows[k]);
            CU_ASSERT(f.it.count.steps == each[k] * row);
        }
    }
}

TEST("no more than allowed")
{
    CU_ASSERT(run(&f, &driven_system, "verlet", 1, 700, 3) == PK_TOO_MANY_STEPS);
    CU_ASSERT(f.it.count.steps == 700 && fabs(f.it.t - 0.7) < 1e-12);
}

/* Not a number after t = 1.25: the 1250 valid steps are found by bisection. */
TEST("the step that fails")
{
    static struct fixture one, all;
    CU_ASSERT(run(&one, &broken_system, "verlet", 0, 0, 3) == PK_NOT_FINITE);
    CU_ASSERT(run(&all, &broken_system, "verlet", 1, 0, 3) == PK_NOT_FINITE);
    CU_ASSERT(one.it.t == all.it.t && fabs(all.it.t - 1.25) < 1e-12);
    CU_ASSERT(fixture_distance(&all, one.it.q, one.it.v) < 1e-12);
    CU_ASSERT(fused_steps > 3000 && fused_steps < 60000);
}

/* Forces shorter than a step: adaptive methods see a hill of a thousandth, fixed ones say that they
 * do not. The closed form: the bead turns back about where the hill begins, with its speed. */
#include "fixture.h"

static struct fixture f;

static const double widths[] = {1e-1, 1e-3, 1e-6};

/* Until t, of a bead that starts at x0 with the speed v0. */
static void along(const char *method, double width, double x0, double v0, double t)
{
    fixture_set(&f, &barred_system);
    f.params.limit = width;
    f.q0[0] = x0, f.v0[0] = v0;
    fixture_start(&f, method, 0);
    CU_ASSERT(pk_integrator_to(&f.it, t) == PK_DONE);
}

TEST("a hill turns back or is crossed")
{
    static const char *const methods[] = {"gauss", "dop853",    "dopri5",
                                          "radau", "gsl_rk8pd", "gsl_rkf45"};
    for (size_t m = 0; m < sizeof methods / sizeof *methods; m++)
        for (size_t k = 0; k < sizeof widths / sizeof *widths; k++)
            for (int back = 0; back < 2; back++) { /* by t, and by v */
                along(methods[m], widths[k], 0, back ? -1 : 1, back ? -3 : 3);
                CU_ASSERT(fabs(f.it.v[0] - (back ? 1 : -1)) < 1e-6);
                CU_ASSERT(fabs(f.it.q[0] - (2 * 1.3 - 3)) < 4 * widths[k] + 1e-6);
                CU_ASSERT(f.it.passed_over.count == 0);
                pk_integrator_free(&f.it);
                along(methods[m], widths[k], 0, back ? -2 : 2, back ? -3 : 3);
                CU_ASSERT(fabs(f.it.v[0] - (back ? -2 : 2)) < 1e-6); /* over it */
                CU_ASSERT(fabs(f.it.q[0] - 6) < widths[k] + 1e-6);
                pk_integrator_free(&f.it);
            }
}

TEST("fixed steps say what they pass over")
{
    static const char *const methods[] = {"rk4", "verlet", "gauss4", "yoshida4"};
    for (size_t m = 0; m < sizeof methods / sizeof *methods; m++)
        for (int fine = 0; fine < 2; fine++) {
            CU_ASSERT(fixture_run(&f, &barred_system, methods[m], fine ? 1e-4 : 0.05, 2) ==
                      PK_DONE);
            CU_ASSERT((f.it.passed_over.count == 0) == fine);
            CU_ASSERT(fine ? fabs(f.it.v[0] + 1) < 1e-3 : fabs(f.it.passed_over.t - 1.3) < 0.06);
            pk_integrator_free(&f.it);
        }
}

/* GSL's adaptive steppers, driven as its manual shows: gsl_odeiv2_driver with control_y_new.
 * argv: the stepper.
 */
#include <gsl/gsl_errno.h>
#include <gsl/gsl_odeiv2.h>
#include <math.h>
#include <string.h>

#include "harness.h"
#include BENCH_EQUATIONS

const size_t bench_length = 2 * N;
static gsl_odeiv2_driver *driver;
static const gsl_odeiv2_step_type *type;

static int right_hand_side(double t, const double y[], double dy[], void *nothing)
{
    (void)nothing;
    memcpy(dy, y + N, N * sizeof *y);
    return acceleration(t, y, y + N, dy + N) ? GSL_EBADFUNC : GSL_SUCCESS;
}

static gsl_odeiv2_system gsl_system_ = {right_hand_side, NULL, 2 * N, NULL};

const char *bench_open(int argc, char **argv)
{
    const struct {
        const char *name;
        const gsl_odeiv2_step_type *type;
    } known[] = {{"rk8pd", gsl_odeiv2_step_rk8pd},
                 {"rkf45", gsl_odeiv2_step_rkf45},
                 {"msadams", gsl_odeiv2_step_msadams}};

    gsl_set_error_handler_off();
    for (size_t i = 0; argc > 1 && i < sizeof known / sizeof *known; i++)
        if (!strcmp(known[i].name, argv[1])) type = known[i].type;
    return type ? NULL : "GSL has no such stepper";
}

const char *bench_prepare(double setting, const double *y0, double t_end)
{
    (void)y0;
    if (driver) gsl_odeiv2_driver_free(driver);
    driver = gsl_odeiv2_driver_alloc_y_new(&gsl_system_, type, 1e-3 * t_end, setting, setting);
    return driver ? NULL : "GSL: no driver";
}

const char *bench_integrate(double setting, double *y, double t_end)
{
    double t = 0;

    (void)setting;
    gsl_odeiv2_driver_reset_hstart(driver, 1e-3 * t_end);
    return gsl_odeiv2_driver_apply(driver, &t, t_end, y) == GSL_SUCCESS ? NULL : "GSL failed";
}

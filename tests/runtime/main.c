/* The runtime's tests; CUnit prints its own summary.
 * Every bound below also asserts that what it bounds is not zero, or that a worse
 * method misses it.
 */
#include <pk/step/state.h>
#include <stdlib.h>

#include <CUnit/Basic.h>

#include "fixture.h"

void fixture_set(struct fixture *f, const struct pk_system *system)
{
    memset(f, 0, sizeof *f);
    system->defaults(&f->params);
    system->start(&f->params, f->q0, f->v0);
    f->problem.system = system;
    f->problem.params = &f->params;
    f->options = pk_options_default();
}

struct pk_system free_point(acceleration_function *acceleration)
{
    struct pk_system system = oscillator_system;
    system.acceleration = acceleration;
    system.lanes = NULL;
    system.steppers = NULL;
    system.block_steppers = NULL;
    system.members = NULL;
    return system;
}

struct pk_system guarded_point(acceleration_function *acceleration,
                               const struct pk_singularity *what,
                               void (*singularity)(const void *, pk_real, const pk_real *,
                                                   const pk_real *, const pk_real *, pk_real *))
{
    struct pk_system system = free_point(acceleration);
    system.singularities.n = 1;
    system.singularities.table = what;
    system.singularities.values = singularity;
    return system;
}

int radial_acceleration(const void *p, double t, const double *q, const double *v, const double *u,
                        double *a)
{
    const double J = ((const struct test_params *)p)->limit;
    (void)t, (void)v, (void)u;
    a[0] = J * J / (q[0] * q[0] * q[0]);
    return 0;
}

void first_coordinate(const void *p, double t, const double *q, const double *v, const double *u,
                      double *out)
{
    (void)p, (void)t, (void)v, (void)u;
    out[0] = q[0];
}

enum pk_status fixture_init(struct fixture *f, const char *name)
{
    const struct pk_method *method = pk_method_find(name);
    if (!method)
        method = pk_gsl_method_find(name);
    CU_ASSERT_PTR_NOT_NULL_FATAL(method);
    CU_ASSERT_FATAL(pk_integrator_size(&f->problem, method) <= sizeof f->block);
    return pk_integrator_init(&f->it, &f->problem, method, &f->options, 0, f->q0, f->v0, f->block,
                              pk_integrator_size(&f->problem, method));
}

enum pk_status fixture_run(struct fixture *f, const struct pk_system *system, const char *name,
                           double h, double t_end)
{
    fixture_set(f, system);
    const struct pk_method *method = pk_method_find(name);
    if (!method || method->traits & PK_ADAPTIVE)
        f->options.rtol = f->options.atol = h;
    else
        f->options.h = h;
    const enum pk_status status = fixture_init(f, name);
    return status < 0 ? status : pk_integrator_to(&f->it, t_end);
}

double fixture_distance(const struct fixture *f, const double *q, const double *v)
{
    double d = 0;
    for (size_t i = 0; i < f->it.n; i++)
        d = fmax(d, fmax(fabs(f->it.q[i] - q[i]), fabs(f->it.v[i] - v[i])));
    return d;
}

void fixture_exact(struct fixture *f, const struct pk_system *system, const double *q,
                   const double *v, double t, int steps)
{
    fixture_set(f, system);
    memcpy(f->q0, q, system->n * sizeof *q);
    memcpy(f->v0, v, system->n * sizeof *v);
    f->options.h = t / steps;
    CU_ASSERT_FATAL(fixture_init(f, "gauss8") == PK_DONE);
    CU_ASSERT_FATAL(pk_integrator_to(&f->it, t) == PK_DONE);
}

double fit_slope(const double *x, const double *y, int count)
{
    double mx = 0, my = 0, xx = 0, xy = 0;
    for (int i = 0; i < count; i++) {
        mx += log(x[i]) / count;
        my += log(y[i]) / count;
    }
    for (int i = 0; i < count; i++) {
        xx += (log(x[i]) - mx) * (log(x[i]) - mx);
        xy += (log(x[i]) - mx) * (log(y[i]) - my);
    }
    return xy / xx;
}

const struct pk_method *fixture_method(size_t i)
{
    size_t core = 0;
    while (pk_method_at(core))
        core++;
    return i < core ? pk_method_at(i) : pk_gsl_method_at(i - core);
}

double fixture_order(const struct pk_system *system, const struct pk_method *method, double t_end,
                     double rounding, double (*off)(const struct fixture *, const double *),
                     const double *exact)
{
    enum { FINEST = 5 };
    static struct fixture f;
    double h[60], error[60];
    int count = 0;
    for (double steps = 4; steps < 20000 && count < 60; steps = ceil(steps * 1.25)) {
        fixture_set(&f, system);
        f.options.h = f.options.h_max = t_end / steps;
        if (method->traits & PK_ADAPTIVE) /* a tolerance that accepts everything, a capped step */
            f.options.rtol = f.options.atol = 1e10, f.options.newton_tol = 1e-14;
        const int made = fixture_init(&f, method->name) >= 0 && pk_integrator_to(&f.it, t_end) >= 0;
        const double e = made ? off(&f, exact) : 1;
        pk_integrator_free(&f.it);
        if (!made)
            continue;
        if (e < rounding)
            break;
        h[count] = t_end / steps;
        error[count++] = e;
    }
    CU_ASSERT_FATAL(count >= FINEST);
    return fit_slope(h + count - FINEST, error + count - FINEST, FINEST);
}

/* Which of the two instances of each step this program tests. */
static const char *instance = "";

static void right_instance(void)
{
    const int inlined = strcmp(instance, "inlined") == 0;
    struct fixture f;
    for (size_t i = 0; pk_method_at(i); i++) {
        const struct pk_method *method = pk_method_at(i);
        fixture_set(&f, &oscillator_system);
        f.options.h = 0.1;
        CU_ASSERT(fixture_init(&f, method->name) == PK_DONE);
        const int calls = /* Newton's method, `linear`, `fast`, coefficients through pointers */
            (method->traits & (PK_LINEAR | PK_JACOBIANS | PK_EXACT | PK_GROUP)) != 0 ||
            (method->needs & PK_FAST) != 0;
        CU_ASSERT((f.it.own->step != method->step) == (inlined && !calls));
    }
}

int main(int argc, char **argv)
{
    if (argc > 1)
        instance = argv[1];
    if (CU_initialize_registry() != CUE_SUCCESS)
        return EXIT_FAILURE;
    CU_add_test(CU_add_suite("instance", NULL, NULL), "generic or inlined", right_instance);
    add_tables();
    add_order();
    add_gauss();
    add_dense();
    add_memory();
    add_memory_blocks();
    add_keep();
    if (strcmp(instance, "inlined") != 0) /* its kernels are not called through pointers */
        add_faults();
    add_geometry();
    add_status();
    add_silence();
    add_control();
    add_scale();
    add_marks();
    add_limits();
    add_equilibria();
    add_action();
    add_particles();
    add_diagnostics();
    add_ensemble();
    add_advance();
    add_adaptive_verlet();
    add_linear();
    add_band();
    add_singularity();
    add_singularity_families();
    add_singularity_cause();
    add_after_failure();
    add_events();
    add_events_within();
    add_events_found();
    add_switches();
    add_switch_families();
    add_variation();
    add_chaos();
    add_spectrum();
    add_branch();
    add_implicit();
    add_exponential();
    add_linear_drag();
    add_unread();
    add_subsystems();
    add_least_action();
    add_states();
    add_states_between();
    add_rotation();
    add_rotation_beside();
    add_constraint();
    add_constraint_told();
    add_variational();
    add_variational_end();
    CU_basic_set_mode(CU_BRM_NORMAL);
    if (argc > 2) /* runtime INSTANCE SUITE... */
        for (int i = 2; i < argc; i++)
            CU_basic_run_suite(CU_get_suite(argv[i]));
    else
        CU_basic_run_tests();
    const unsigned failures = CU_get_number_of_failures(), run = CU_get_number_of_tests_run();
    CU_cleanup_registry();
    return failures || run < (argc > 2 ? 1 : 20) ? EXIT_FAILURE : EXIT_SUCCESS;
}

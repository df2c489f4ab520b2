/* The runtime's tests; CUnit prints its own summary.
 * Every bound below also asserts that what it bounds is not zero, or that a worse
 * method misses it.
 */
#include <pk/step/state.h>
#include <stdlib.h>

#include <CUnit/Basic.h>

#include "fixture.h"

const char *const bound_methods[BOUND_METHODS] = {
    "lie_midpoint", "lie_midpoint4", "lie_midpoint6", "rattle", "rattle4",   "rattle6",
    "rk4",          "rkmk4",         "rkmk8",         "gauss2", "gauss4",    "lobatto3",
    "radau5",       "dopri5",        "dop853",        "gauss",  "gsl_rk8pd", "gsl_msadams"};

void fixture_set(struct fixture *f, const struct pk_system *system)
{
    memset(f, 0, offsetof(struct fixture, block));
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
    system.singularities =
        (struct pk_part_singularities){.n = 1, .table = what, .values = singularity};
    return system;
}

int radial_acceleration(ARGS, double *a)
{
    const double J = ((const struct test_params *)params)->limit;
    (void)t, (void)v, (void)u;
    a[0] = J * J / (q[0] * q[0] * q[0]);
    return 0;
}

void first_coordinate(ARGS, double *out)
{
    UNUSED;
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

enum pk_status fixture_begin(struct fixture *f, const char *name, double h)
{
    const struct pk_method *method = pk_method_find(name);
    if (h > 0 && (!method || method->traits & PK_ADAPTIVE))
        f->options.rtol = f->options.atol = h;
    else if (h > 0)
        f->options.h = h;
    return fixture_init(f, name);
}

void fixture_start(struct fixture *f, const char *name, double h)
{
    CU_ASSERT_FATAL(fixture_begin(f, name, h) == PK_DONE);
}

void fixture_open(struct fixture *f, const struct pk_system *system, const char *name, double h)
{
    fixture_set(f, system);
    fixture_start(f, name, h);
}

enum pk_status fixture_run(struct fixture *f, const struct pk_system *system, const char *name,
                           double h, double t_end)
{
    fixture_set(f, system);
    const enum pk_status status = fixture_begin(f, name, h);
    return status < 0 ? status : pk_integrator_to(&f->it, t_end);
}

double fixture_distance(const struct fixture *f, const double *q, const double *v)
{
    const size_t n = f->it.n, shown = n - f->problem.system->n_first_order;
    double d = 0;
    for (size_t i = 0; i < n; i++)
        d = fmax(d, fmax(i < shown ? fabs(f->it.q[i] - q[i]) : 0, fabs(f->it.v[i] - v[i])));
    return d;
}

struct pk_residuals fixture_residuals(const struct fixture *f)
{
    static double room[4096];
    struct pk_residuals found = {0};
    CU_ASSERT(pk_constraint_size(&f->problem) <= sizeof room);
    CU_ASSERT(pk_constraint_residuals(&f->problem, f->it.t, f->it.q, f->it.v, &found, room,
                                      sizeof room) == PK_DONE);
    return found;
}

double fixture_energy(const struct fixture *f)
{
    return f->problem.system->energy(&f->params, f->it.t, f->it.q, f->it.v, NULL);
}

int says(const struct pk_integrator *it, const char *part)
{
    char text[600];
    pk_integrator_reason(it, text, sizeof text);
    if (!strstr(text, part))
        printf("\n    said: %s\n    not: %s", text, part);
    return strstr(text, part) != NULL;
}

void fixture_exact(struct fixture *f, const struct pk_system *system, const double *q,
                   const double *v, double t, int steps)
{
    fixture_set(f, system);
    memcpy(f->q0, q, system->n * sizeof *q);
    memcpy(f->v0, v, system->n * sizeof *v);
    fixture_start(f, "gauss8", t / steps);
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

static double distance(const struct fixture *f, const double *x)
{
    return fixture_distance(f, x, x + f->it.n);
}

double fixture_order_beside(const struct pk_system *system, const struct pk_method *method,
                            double t_end, double rounding, const char *other, int steps)
{
    static struct fixture f;
    double x[2 * FIXTURE_N];
    CU_ASSERT_FATAL(fixture_run(&f, system, other, t_end / steps, t_end) == PK_DONE);
    memcpy(x, f.it.q, f.it.n * sizeof *x);
    memcpy(x + f.it.n, f.it.v, f.it.n * sizeof *x);
    return fixture_order(system, method, t_end, rounding, distance, x);
}

/* Which of the two instances of each step this program tests. */
static const char *instance = "";

TEST("generic or inlined")
{
    const int inlined = strcmp(instance, "inlined") == 0;
    struct fixture f;
    for (size_t i = 0; pk_method_at(i); i++) {
        const struct pk_method *method = pk_method_at(i);
        if (method->traits & PK_JETS) /* tests/runs/test_taylor.py */
            continue;
        fixture_set(&f, &oscillator_system);
        f.options.h = 0.1;
        CU_ASSERT(fixture_init(&f, method->name) == PK_DONE);
        const int
            calls = /* Newton's method, `linear`, `fast`, coefficients, noise: through pointers */
            (method->traits & (PK_LINEAR | PK_JACOBIANS | PK_EXACT | PK_GROUP | PK_NOISE)) != 0 ||
            (method->needs & PK_FAST) != 0;
        CU_ASSERT((f.it.own->step != method->step) == (inlined && !calls));
    }
}

static struct test *first_test, **next_test = &first_test;

void add_test(struct test *test)
{
    *next_test = test;
    next_test = &test->next;
}

int main(int argc, char **argv)
{
    if (argc > 1)
        instance = argv[1];
    if (CU_initialize_registry() != CUE_SUCCESS)
        return EXIT_FAILURE;
    CU_pSuite suite = NULL;
    for (const struct test *test = first_test; test; test = test->next) {
        char name[40];
        sscanf(strrchr(test->file, '/'), "/%39[a-z_]", name);
        if (strcmp(instance, "inlined") == 0 && strcmp(name, "test_faults") == 0)
            continue; /* its kernels are not called through pointers */
        if (!suite || strcmp(suite->pName, name) != 0)
            suite = CU_add_suite(name, NULL, NULL);
        CU_add_test(suite, test->title, test->run);
    }
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
